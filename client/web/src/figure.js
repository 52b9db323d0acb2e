// A chart with its heading, legend and words. It is drawn anew when the width of its place changes.
import { element } from "./element.js";

/**
 * `draw(width)` gives the chart, an SVG element, for a width in pixels; `legend`: [{ name, swatch }],
 * where swatch is a CSS colour, or { colour, shape } with shape "line", "dashed", "dot" or "ring";
 * `note`: what is to be seen.
 */
export function figure({ title, note, legend = [], draw }) {
  const place = element("div", { class: "chart" });
  const made = element("figure", {},
    element("h3", {}, title),
    legend.length > 0 ? element("ul", { class: "legend" }, legend.map(entry)) : null,
    place,
    element("figcaption", {}, note));
  let drawn = 0;
  new ResizeObserver(() => {
    const width = Math.floor(place.clientWidth);
    if (width === drawn || width <= 0) return;
    drawn = width;
    const chart = draw(width);
    chart.setAttribute("role", "img");
    chart.setAttribute("aria-label", title);
    place.replaceChildren(chart);
  }).observe(place);
  return made;
}

function entry({ name, swatch }) {
  const { colour, shape } = typeof swatch === "string" ? { colour: swatch, shape: "box" } : swatch;
  return element("li", {},
    element("span", { class: `swatch ${shape}`, style: `--swatch: ${colour}` }), name);
}

// Where the error is: the same view as it looks and in the colours of its error, and the polygons with
// most of it.
import { element } from "./element.js";
import * as format from "./format.js";
import { section } from "./section.js";
import { table } from "./table.js";

export function errorMap({ pictures, faces = {}, name }) {
  if (!pictures) return "";
  return section("Where the error is", null,
    element("div", { class: "figures" },
      picture(pictures, pictures.solution, "The solution", `${name || "The scene"} as solved, tone-mapped`,
        element("figcaption", {}, "Exposed and tone-mapped.")),
      picture(pictures, pictures.error, "Its estimated error", `The same view; colours show the estimated error, on average ${format.percent(faces.error_mean)} of the mean irradiance`,
        legend(pictures),
        element("figcaption", {}, "Estimated error of each face's irradiance over the mean irradiance "
          + `of all, worst channel. Over the area: mean ${format.percent(faces.error_mean)}, 95 % of it `
          + `below ${format.percent(faces.error_p95)}.`))),
    worstTable(faces.worst_polygons ?? []));
}

function picture({ width, height }, source, title, alt, ...below) {
  return element("figure", {}, element("h3", {}, title),
    element("img", { src: source, width, height, alt }), below);
}

// A bar of the colours with values at even steps of their logarithms.
function legend({ colours, low, high }) {
  const steps = [0, 0.25, 0.5, 0.75, 1].map((share) => low * (high / low) ** share);
  return element("div", { class: "scale" },
    element("div", { class: "ramp", style: `background: linear-gradient(to right, ${colours.join(", ")})` }),
    element("div", { class: "steps" }, steps.map((step) => element("span", {}, format.percent(step)))));
}

function worstTable(polygons) {
  if (polygons.length === 0) return null;
  return table("Polygons of the scene file with the largest shares of the error", [
    { title: "polygon", text: ({ polygon }) => String(polygon) },
    { title: "share of the error", text: ({ share }) => format.percent(share) },
    { title: "mean error", text: ({ mean }) => format.percent(mean) },
    { title: "largest error", text: ({ worst }) => format.percent(worst) },
    { title: "area, squares of the file's unit", text: ({ area }) => format.number(area) },
  ], polygons);
}

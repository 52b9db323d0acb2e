// A part of a page under a heading; left out where it has nothing to show.
import { element } from "./element.js";

/** `note`: words under the heading, or null. */
export function section(title, note, ...children) {
  const shown = children.flat(Infinity).filter((child) => child);
  if (shown.length === 0) return "";
  return element("section", {}, element("h2", {}, title), note ? element("p", { class: "note" }, note) : null, shown);
}

/** Charts side by side where there is room; null where there are none. */
export function figures(...made) {
  const shown = made.filter((one) => one);
  return shown.length > 0 ? element("div", { class: "figures" }, shown) : null;
}

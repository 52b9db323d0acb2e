// A short list of names and values, such as the headline of a page.
import { element } from "./element.js";

/** `facts`: [name, value]; those without a value are left out. */
export function factList(facts) {
  return element("dl", { class: "facts" }, facts
    .filter(([, value]) => value !== null && value !== undefined && value !== "" && value !== "–")
    .map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))));
}

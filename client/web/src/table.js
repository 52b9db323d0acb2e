// Tables with a caption. A table wider than the page scrolls in a box of its own, which the keyboard
// reaches.
import { element } from "./element.js";

/**
 * `columns`: [{ title, text: row => text or node, numeric }], the first is the head of its row.
 * Columns in which no row has anything to say are left out.
 */
export function table(caption, columns, rows) {
  const used = columns.filter(({ text }) => rows.some((row) => !isEmpty(text(row))));
  const align = (column) => (column.numeric === false ? "text" : "numeric");
  const head = element("tr", {}, used.map((column) =>
    element("th", { scope: "col", class: align(column) }, column.title)));
  const body = rows.map((row) => element("tr", {}, used.map((column, i) =>
    i === 0
      ? element("th", { scope: "row", class: align(column) }, column.text(row))
      : element("td", { class: align(column) }, column.text(row)))));
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    element("table", {},
      element("caption", {}, caption), element("thead", {}, head), element("tbody", {}, body)));
}

function isEmpty(text) {
  return text === null || text === undefined || text === "" || text === "–";
}

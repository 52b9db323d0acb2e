// Stacked bars: one bar a category, one colour a part.
import * as Plot from "@observablehq/plot";
import { figure } from "./figure.js";
import { kColours, plot } from "./plot.js";

/**
 * `rows`: [{ category, part, value }]; bars and parts come in the order of their first row. `text`
 * shows a value. With `lying` the bars lie, which leaves room for long names. null without values.
 */
export function stackedBars({ title, note, rows, label, text, lying = false, axis = "" }) {
  const shown = rows.filter(({ value }) => value > 0);
  if (shown.length === 0) return null;
  const parts = [...new Set(shown.map(({ part }) => part))];
  const categories = [...new Set(rows.map(({ category }) => category))];
  const colour = (part) => kColours[parts.indexOf(part) % kColours.length];
  const marks = {
    [lying ? "x" : "y"]: "value",
    [lying ? "y" : "x"]: "category",
    fill: ({ part }) => colour(part),
    order: parts,
    z: "part",
    title: ({ category, part, value }) => `${axis} ${category}, ${part}: ${text(value)}`.trim(),
    tip: true,
    insetTop: lying ? 1 : 0, insetBottom: lying ? 1 : 0,
    insetLeft: lying ? 0 : 1, insetRight: lying ? 0 : 1,
  };
  const values = { label, grid: true, nice: true, ticks: 5, tickFormat: text };
  const bands = { domain: categories, label: axis || null, padding: 0.2, type: "band" };
  return figure({
    title,
    note,
    legend: parts.length > 1 ? parts.map((part) => ({ name: part, swatch: colour(part) })) : [],
    draw: (width) => plot({
      width,
      color: { type: "identity" },
      ...(lying
        ? { x: { ...values, ticks: width < 480 ? 3 : 6 }, y: { ...bands, label: null }, marginLeft: 84, marginRight: 32, marginTop: 8,
            height: 50 + 28 * categories.length }
        : { x: { ...bands, ticks: thinned(categories, width) }, y: values }),
    }, [lying ? Plot.barX(shown, marks) : Plot.barY(shown, marks)]),
  });
}

// As many names as there is room for, the last among them.
function thinned(categories, width) {
  const step = Math.ceil((40 * categories.length) / width);
  const last = categories.length - 1;
  return categories.filter((_, i) => i === last || (i % step === 0 && last - i >= step));
}

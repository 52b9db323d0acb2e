// Several figures over the same axis, as lines with a dot a value.
import * as Plot from "@observablehq/plot";
import { figure } from "./figure.js";
import * as format from "./format.js";
import { kColours, logScale, plot } from "./plot.js";

/**
 * `series`: [{ name, points: [[x, y]], colour, dashed }]; series without points are left out.
 * `x` and `y`: { label, text, tip, log, ticks, from }; `rule`: a y with a { value, name } to be compared with.
 * null where there is nothing to draw.
 */
export function lines({ title, note, series, x, y, rule = null }) {
  const shown = series
    .map((one, i) => ({ colour: kColours[i % kColours.length], ...one, points: usable(one.points, x, y) }))
    .filter(({ points }) => points.length > 0);
  if (shown.length === 0) return null;
  const points = shown.flatMap((one) => one.points);
  const heights = points.map((point) => point[1]).concat(rule ? [rule.value] : []);
  return figure({
    title,
    note,
    legend: (shown.length > 1 || rule ? shown : []).map(({ name, colour, dashed, points: own }) => (
      { name, swatch: { colour, shape: own.length === 1 ? "dot" : dashed ? "dashed" : "line" } }))
      .concat(rule ? [{ name: rule.name, swatch: { colour: "var(--quiet)", shape: "dashed" } }] : []),
    draw: (width) => plot({
      width,
      x: scale(points.map((point) => point[0]), x),
      y: scale(heights, y),
    }, [
      rule ? Plot.ruleY([rule.value], { stroke: "var(--quiet)", strokeDasharray: "5 4", strokeWidth: 1.5 }) : null,
      ...shown.flatMap((one) => marksOf(one, x, y)),
    ]),
  });
}

function usable(points, x, y) {
  const fits = (value, axis) => typeof value === "number" && Number.isFinite(value) && (!axis.log || value > 0);
  return points.filter((point) => fits(point[0], x) && fits(point[1], y));
}

function scale(values, { label, text = format.number, log = false, ticks, from }) {
  if (log) return logScale(values, label, text);
  const low = from ?? Math.min(0, ...values);
  const high = Math.max(...values);
  return { label, grid: true, domain: [low, high > low ? high + 0.05 * (high - low) : low + 1], ticks: ticks ?? 5, tickFormat: text };
}

function marksOf({ name, points, colour, dashed }, x, y) {
  return [
    Plot.line(points, { stroke: colour, strokeWidth: 2, strokeDasharray: dashed ? "5 4" : null }),
    Plot.dot(points, {
      x: "0", y: "1", r: 3.5, fill: colour, tip: true,
      title: ([at, value]) => `${name} ${(y.text ?? format.number)(value)} at ${(x.tip ?? x.text ?? format.number)(at)}`,
    }),
  ];
}

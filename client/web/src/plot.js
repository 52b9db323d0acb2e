// What all charts have in common, over Observable Plot.
import * as Plot from "@observablehq/plot";

/** Colours of series, from style.css, where they change with the colour scheme. */
export const kColours = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10].map((i) => `var(--series-${i})`);

export function plot(options, marks) {
  const { width } = options;
  return Plot.plot({
    height: Math.round(Math.min(360, Math.max(240, 0.6 * width))),
    marginLeft: 56,
    marginBottom: 40,
    marginRight: 16,
    marginTop: 28,
    ...options,
    x: withoutAxis(options.x),
    y: withoutAxis(options.y),
    style: { background: "transparent", color: "var(--text)", fontSize: "12px", overflow: "hidden" },
    marks: [
      Plot.frame({ stroke: "var(--rule)" }),
      ...logAxis(options.x, Plot.gridX, Plot.axisX),
      ...logAxis(options.y, Plot.gridY, Plot.axisY),
      ...marks,
    ],
  });
}

// Plot leaves out labels of logarithmic axes as it sees fit; these get axes that show all they are told.
function withoutAxis(scale) {
  return scale?.type === "log" ? { ...scale, axis: null, grid: false } : scale;
}

function logAxis(scale, grid, axis) {
  return scale?.type === "log"
    ? [grid(scale.ticks), axis(scale.ticks, { label: scale.label, text: scale.tickFormat })]
    : [];
}

/** A logarithmic axis with ticks at 1, 2 and 5 times powers of ten, fewer where there are many. */
export function logScale(values, label, text) {
  const positive = values.filter((value) => value > 0 && Number.isFinite(value));
  const low = Math.min(...positive) / 1.25;
  const high = Math.max(...positive) * 1.25;
  return { type: "log", domain: [low, high], label, grid: true, ticks: logTicks(low, high), tickFormat: text };
}

function logTicks(low, high) {
  const decades = Math.log10(high / low);
  const digits = decades < 1 ? [1, 1.5, 2, 3, 5, 7] : decades < 2.5 ? [1, 2, 5] : [1];
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power) {
    ticks.push(...digits.map((digit) => Number(`${digit}e${power}`)));
  }
  return ticks.filter((tick) => tick >= low && tick <= high);
}

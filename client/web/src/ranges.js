// What was expected, round by round, against what came: a range with its likely value a round, and the
// outcome as a line across.
import * as Plot from "@observablehq/plot";
import { figure } from "./figure.js";
import * as format from "./format.js";
import { logScale, plot } from "./plot.js";

/** `rows`: [{ round, low, likely, high }]; `outcome` may be missing; `text` shows a value, `axisText` one at the axis. null without rows. */
export function ranges({ title, note, rows, outcome, label, text, axisText = text, ticks }) {
  const shown = rows.filter(({ low, likely, high }) => low > 0 && likely >= low && high >= likely);
  if (shown.length === 0) return null;
  const known = outcome > 0;
  const last = Math.max(...shown.map(({ round }) => round));
  return figure({
    title,
    note,
    legend: [
      { name: "expected, four of five between the ends", swatch: { colour: "var(--series-1)", shape: "dot" } },
      ...(known ? [{ name: `came: ${text(outcome)}`, swatch: { colour: "var(--quiet)", shape: "dashed" } }] : []),
    ],
    draw: (width) => plot({
      width,
      x: { label: "after round →", domain: [0.5, last + 0.5],
           ticks: ticks.filter((tick) => tick <= last), tickFormat: format.count, grid: true },
      y: logScale(shown.flatMap(({ low, high }) => [low, high]).concat(known ? [outcome] : []), label, axisText),
    }, [
      known ? Plot.ruleY([outcome], { stroke: "var(--quiet)", strokeDasharray: "5 4", strokeWidth: 1.5 }) : null,
      Plot.ruleX(shown, { x: "round", y1: "low", y2: "high", stroke: "var(--series-1)", strokeWidth: 2, marker: "tick" }),
      Plot.dot(shown, {
        x: "round", y: "likely", r: 4.5, fill: "var(--series-1)", tip: true,
        title: ({ round, low, likely, high }) => `after round ${round}: ${text(likely)}, from ${text(low)} to ${text(high)}`,
      }),
    ]),
  });
}

// The page of `isolux sweep`: what accuracy cost, run by run, and how far estimates are from the truth.
import * as Plot from "@observablehq/plot";
import { element } from "./element.js";
import { factList } from "./facts.js";
import { figure } from "./figure.js";
import * as format from "./format.js";
import { kColours, logScale, plot } from "./plot.js";
import { fitPower } from "./power_fit.js";
import { figures, section } from "./section.js";
import { table } from "./table.js";

/** `data` as docs/report.md describes it; `main` is filled. */
export function sweepPage(main, data) {
  const runs = data.runs ?? [];
  const methods = [...new Set(runs.map((run) => run.method ?? ""))];
  const series = methods.flatMap((method, i) =>
    seriesOf(runs, method, methods.length > 1, kColours[i % kColours.length]));
  const reference = data.reference ?? {};
  main.append(
    element("header", {},
      element("h1", {}, `Sweep of ${data.scene ?? "a scene"}`),
      factList([
        ["runs", format.count(runs.length)],
        ["workers", format.count(data.workers)],
        ["true error against", reference.description],
        ["measured at", reference.points ? `${format.count(reference.points)} points` : null],
        ["error of the reference", reference.error_estimate > 0 ? format.percent(reference.error_estimate) : null],
      ])),
    section("What accuracy costs", null, figures(
      errorFigure(series, "seconds", "Error against time", format.number),
      errorFigure(series, "links", "Error against links", format.shortCount))),
    section("Runs", null, runs.length > 0 ? runTable(runs, methods.length > 1) : null));
}

// The true and the estimated error of one method's runs.
function seriesOf(runs, method, named, colour) {
  const own = runs.filter((run) => (run.method ?? "") === method);
  return [
    { key: "error_true", name: "true error", filled: true },
    { key: "error_estimate", name: "estimated error", filled: false },
  ].map((kind) => ({
    ...kind,
    name: named ? `${method}, ${kind.name}` : kind.name,
    colour,
    runs: own.filter((run) => run[kind.key] > 0),
  })).filter((one) => one.runs.length > 0);
}

function errorFigure(series, key, title, text) {
  const shown = series
    .map((one) => ({ ...one, runs: one.runs.filter((run) => run[key] > 0) }))
    .filter((one) => one.runs.length > 0)
    .map((one) => ({ ...one, fit: fitPower(one.runs.map((run) => [run[key], run[one.key]])) }));
  if (shown.length === 0) return null;
  return figure({
    title,
    note: ["Both axes are logarithmic. ", shown.filter(({ fit }) => fit).map(({ name, fit }, i) =>
      [i === 0 ? "Fitted: " : "; ", `${name} ∝ ${key}`,
        element("sup", {}, fit.exponent.toFixed(2).replace("-", "−"))])],
    legend: shown.map(({ name, colour, filled }) => ({
      name, swatch: { colour, shape: filled ? "dot" : "ring" } })),
    draw: (width) => plot({
      width,
      x: logScale(shown.flatMap(({ runs }) => runs.map((run) => run[key])), `${key} →`, text),
      y: logScale(shown.flatMap((one) => one.runs.map((run) => run[one.key])), "↑ error", format.percent),
    }, shown.flatMap((one) => marksOf(one, key, text))),
  });
}

function marksOf({ key: error, name, colour, filled, runs, fit }, key, text) {
  const xs = runs.map((run) => run[key]);
  const ends = fit ? [Math.min(...xs), Math.max(...xs)].map((x) => [x, fit.at(x)]) : [];
  return [
    Plot.line(ends, { stroke: colour, strokeDasharray: filled ? null : "5 4" }),
    Plot.dot(runs, {
      x: key, y: error, r: 4.5, stroke: colour, strokeWidth: 2, fill: filled ? colour : "var(--page)",
      title: (run) => `${name} ${format.percent(run[error])}, asked ${format.percent(run.accuracy)}, ${text(run[key])} ${key}`,
      tip: true,
    }),
  ];
}

function runTable(runs, severalMethods) {
  return table("Runs, and their estimated error over the true one", [
    { title: "accuracy", text: (run) => format.percent(run.accuracy) },
    { title: "method", text: (run) => (severalMethods ? run.method : null), numeric: false },
    { title: "seconds", text: (run) => format.number(run.seconds) },
    { title: "estimated error", text: (run) => format.percent(run.error_estimate) },
    { title: "true error", text: (run) => format.percent(run.error_true) },
    { title: "estimated / true", text: (run) => format.number(ratioOf(run)) },
    { title: "true RMS", text: (run) => format.percent(run.error_rms) },
    { title: "true 95th percentile", text: (run) => format.percent(run.error_p95) },
    { title: "bias", text: (run) => format.percent(run.error_bias) },
    { title: "rounds", text: (run) => format.count(run.rounds) },
    { title: "links", text: (run) => format.count(run.links) },
    { title: "elements", text: (run) => format.count(run.elements) },
    { title: "rays", text: (run) => format.count(run.rays) },
    { title: "traffic", text: (run) => format.bytes(run.bytes) },
    { title: "ended by", text: (run) => run.ended_by, numeric: false },
  ], runs);
}

function ratioOf(run) {
  return run.ratio ?? (run.error_true > 0 ? run.error_estimate / run.error_true : null);
}

// The page of `isolux report`: what one solve took, what it reached, and where its error is. Every
// part copes with keys that are not there, as files of older versions lack some.
import { element } from "./element.js";
import { errorMap } from "./error_map.js";
import { factList } from "./facts.js";
import * as format from "./format.js";
import { accuracySection } from "./report_accuracy.js";
import { clusterSection, trafficSection } from "./report_cluster.js";
import { forecastSection } from "./report_forecast.js";
import { effectTable, repairTable, roundTable } from "./report_tables.js";
import { cpuSeconds, timeSection } from "./report_time.js";
import { section } from "./section.js";

/** `data` as docs/report.md describes it; `main` is filled. */
export function reportPage(main, data) {
  const rounds = data.rounds ?? [];
  main.append(
    element("header", {}, element("h1", {}, `Report: ${data.name || "a solve"}`), headline(data), doubtList(data)),
    accuracySection(data, rounds),
    forecastSection(data, rounds),
    timeSection(data, rounds),
    clusterSection(rounds),
    trafficSection(data),
    errorMap(data),
    section("What the scene calls for", null, effectTable(data.effects ?? [], {
      cpu_s: cpuSeconds(data, rounds), rays: data.summary?.rays,
    })),
    section("What the importer mended", null, repairTable(data.repairs ?? [])),
    section("All rounds", null, roundTable(rounds)));
}

/** What rules the error, in words; null where nothing does. */
function doubtList({ doubts = [] }) {
  if (doubts.length === 0) return null;
  return element("div", { class: "doubts" }, element("h2", {}, "What rules the estimated error"),
    element("ul", {}, doubts.map((doubt) => element("li", {}, doubt))));
}

function headline({ summary = {}, job, rounds = [], faces = {} }) {
  const last = rounds.at(-1) ?? {};
  return factList([
    ["accuracy asked for", format.percent(summary.accuracy)],
    ["estimated error", format.percent(summary.error_estimate)],
    ["estimated RMS error", last.rms > 0 ? format.percent(last.rms) : null],
    ["95th percentile, local", last.p95 > 0 ? format.percent(last.p95) : null],
    ["time", format.seconds(summary.seconds)],
    ["ended by", summary.error_estimate > summary.accuracy && summary.end_reason === "accuracy reached"
      ? "accuracy reached, before the output was gathered" : summary.end_reason],
    ["rounds", format.count(summary.rounds)],
    ["links", format.count(summary.links)],
    ["elements", format.count(summary.elements)],
    ["faces of the output", format.count(faces.count)],
    ["rays", format.count(summary.rays)],
    ["workers", format.count(summary.workers)],
    ["memory of links and nodes", format.bytes(summary.memory_bytes)],
    ["energy imbalance", format.percent(summary.energy_imbalance)],
    ["area of leaks or missing links", last.leak_area > 0 ? format.percent(last.leak_area) : null],
    ["mean irradiance", faces.mean_irradiance_w_m2 > 0 ? `${format.number(faces.mean_irradiance_w_m2)} W/m²` : null],
    ["solver", summary.solver],
    ["job", job ? `${job.job}, ${job.state}` : null],
    ["scene hash", summary.scene_hash],
  ]);
}

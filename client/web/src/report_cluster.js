// How the work was spread: load and migrations by round, bytes by worker and phase.
import { stackedBars } from "./bars.js";
import { element } from "./element.js";
import * as format from "./format.js";
import { lines } from "./lines.js";
import { ticksOf } from "./report_accuracy.js";
import { figures, section } from "./section.js";
import { table } from "./table.js";

/** Nothing where one worker did it all. */
export function clusterSection(rounds) {
  if (!rounds.some(({ cpu_s }) => Array.isArray(cpu_s) && cpu_s.length > 1)) return "";
  return section("How the work was spread", null, figures(
    lines({
      title: "Load",
      note: "Processor time of the busiest worker over the mean of all, in each round: 1 is even.",
      series: [{ name: "load", points: rounds.map(({ round, load }) => [round, load]) }],
      x: { label: "round →", ticks: ticksOf(rounds), text: format.count, from: 0.5 },
      y: { label: "↑ max / mean", from: 0 },
      rule: { value: 1, name: "even" },
    }),
    stackedBars({
      title: "Migrations",
      note: "Links that moved to another worker after each round.",
      rows: rounds.map(({ round, migrated_links }) => (
        { category: String(round), part: "links", value: migrated_links })),
      label: "↑ links",
      text: format.shortCount,
      axis: "round",
    })));
}

/** Bytes as the coordinator sees them. */
export function trafficSection({ traffic = [], worker_traffic: byWorker = [] }) {
  const rows = byWorker.length > 0 ? byWorker : traffic.map((row) => ({ ...row, worker: "all" }));
  const used = rows.filter((row) => row.bytes_in > 0 || row.bytes_out > 0);
  if (used.length === 0) return "";
  const name = ({ worker }) => (worker === "all" ? "all" : `worker ${worker}`);
  return section("Traffic", "Between coordinator and workers, as the coordinator sees it. A worker "
    + "that was lost and came again counts as another.", figures(
    stackedBars({
      title: "Bytes by phase",
      note: "Over all workers, in to the coordinator and out from it.",
      rows: traffic.flatMap(({ phase, bytes_in, bytes_out }) => [
        { category: phase, part: "in", value: bytes_in }, { category: phase, part: "out", value: bytes_out }]),
      label: "bytes →",
      text: format.bytes,
      lying: true,
    }),
    stackedBars({
      title: "Bytes by worker",
      note: "In and out together, by phase.",
      rows: workerRows(byWorker, name),
      label: "bytes →",
      text: format.bytes,
      lying: true,
    })),
    element("details", {}, element("summary", {}, "Bytes by worker and phase, in numbers"), table("Bytes by worker and phase", [
      { title: "worker", text: name, numeric: false },
      { title: "phase", text: ({ phase }) => phase, numeric: false },
      { title: "in", text: ({ bytes_in }) => format.bytes(bytes_in) },
      { title: "out", text: ({ bytes_out }) => format.bytes(bytes_out) },
    ], used)));
}

// Phases with less than a hundredth of all bytes are one part.
function workerRows(rows, name) {
  const bytes = (row) => row.bytes_in + row.bytes_out;
  const all = rows.reduce((sum, row) => sum + bytes(row), 0);
  const ofPhase = new Map();
  for (const row of rows) ofPhase.set(row.phase, (ofPhase.get(row.phase) ?? 0) + bytes(row));
  const part = ({ phase }) => (ofPhase.get(phase) < 0.01 * all ? "the rest" : phase);
  const sums = new Map();
  for (const row of rows) {
    const key = JSON.stringify([name(row), part(row)]);
    sums.set(key, (sums.get(key) ?? 0) + bytes(row));
  }
  return [...sums].map(([key, value]) => ({ category: JSON.parse(key)[0], part: JSON.parse(key)[1], value }));
}

// Where the time went: by phase of each round, and the CPU of each worker.
import { stackedBars } from "./bars.js";
import * as format from "./format.js";
import { figures, section } from "./section.js";

const kPhases = [
  ["refine_s", "refine"],
  ["exchange_s", "exchange"],
  ["solve_s", "solve"],
  ["snapshot_s", "snapshot"],
  ["balance_s", "balance"],
  ["sample_s", "sample the output"],
];

/** Bars of the rounds and of the gather, and of the workers. */
export function timeSection({ summary = {} }, rounds) {
  return section("Where the time went", null, figures(
    stackedBars({
      title: "Time by phase",
      note: "Wall seconds of each round, and of gathering the output at the end. A phase takes as long "
        + "as its slowest worker.",
      rows: wallRows(summary, rounds),
      label: "↑ seconds",
      text: format.number,
      axis: "round",
    }),
    stackedBars({
      title: "CPU by worker",
      note: "Processor seconds of each worker, in the rounds and in the gather.",
      rows: cpuRows(summary, rounds),
      label: "processor seconds →",
      text: format.number,
      lying: true,
    })));
}

/** Processor seconds of all workers, in the rounds and in the gather. */
export function cpuSeconds({ summary = {} }, rounds) {
  return cpuRows(summary, rounds).reduce((sum, { value }) => sum + value, 0);
}

// What lies between the phases of a round, such as reports on their way, is "other".
function wallRows(summary, rounds) {
  let before = 0;
  const rows = rounds.flatMap((round) => {
    const category = String(round.round);
    const parts = kPhases.map(([key, part]) => ({ category, part, value: round[key] ?? 0 }));
    const known = parts.reduce((sum, { value }) => sum + value, 0);
    parts.push({ category, part: "other", value: Math.max(0, round.seconds - before - known) });
    before = round.seconds;
    return parts;
  });
  return [...rows, { category: "output", part: "gather", value: summary.gather_s ?? 0 }];
}

function cpuRows(summary, rounds) {
  const rows = rounds.flatMap((round) => list(round.cpu_s).map((value, worker) => (
    { category: `worker ${worker + 1}`, part: `round ${round.round}`, value })));
  const gather = list(summary.gather_cpu_s).map((value, worker) => (
    { category: `worker ${worker + 1}`, part: "gather", value }));
  return [...groupEarly(rows, rounds), ...gather];
}

// The last rounds take nearly all the time: those before the last five are one part.
function groupEarly(rows, rounds) {
  const named = new Set(rounds.slice(-5).map(({ round }) => `round ${round}`));
  if (rounds.length <= 6) return rows;
  const early = new Map();
  for (const { category, part, value } of rows) {
    if (!named.has(part)) early.set(category, (early.get(category) ?? 0) + value);
  }
  return [
    ...[...early].map(([category, value]) => ({ category, part: "earlier rounds", value })),
    ...rows.filter(({ part }) => named.has(part)),
  ];
}

function list(value) {
  return value === null || value === undefined ? [] : [value].flat();
}

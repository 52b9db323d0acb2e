// What accuracy cost: error against time, the causes of the error, links and elements.
import * as format from "./format.js";
import { lines } from "./lines.js";
import { figures, section } from "./section.js";

const kCauses = [
  ["spread", "variation of sources"],
  ["visibility", "visibility"],
  ["coupling", "coupling factors"],
  ["solver", "unfinished iteration"],
  ["closure", "rows that do not add up"],
  ["gather", "gathering the output"],
  ["interpolation", "between output points"],
  ["unseen", "light that links missed"],
];

const kRounds = { label: "round →", text: (round) => format.count(round) };
const kError = { label: "↑ error", text: format.percent, log: true };

/** Figures of the rounds, of which each has its error, links and elements. */
export function accuracySection({ summary = {} }, rounds) {
  const against = (x, y) => rounds.map((round) => [round[x], round[y]]);
  const roundAxis = { ...kRounds, ticks: ticksOf(rounds), from: 0.5 };
  return section("What accuracy cost", null, figures(
    lines({
      title: "Error against time",
      note: "Estimated error of the output after each round, over the seconds since the start of the "
        + "job; gathering the output comes on top at the end. Both axes are logarithmic.",
      series: [
        { name: "estimated error", points: against("seconds", "error") },
        { name: "estimated RMS error", points: against("seconds", "rms") },
        { name: "with the output gathered", points: [[summary.seconds, summary.error_estimate]] },
      ],
      x: { label: "seconds →", text: format.number, tip: format.seconds, log: true },
      y: kError,
      rule: summary.accuracy > 0 ? { value: summary.accuracy, name: "asked for" } : null,
    }),
    lines({
      title: "Causes of the error",
      note: "Parts of the estimate by what makes them. They are not added up: it also counts how far "
        + "the solution moved in the round.",
      series: kCauses.map(([key, name]) => ({ name, points: against("round", key) })),
      x: roundAxis,
      y: kError,
    }),
    lines({
      title: "Links and elements",
      note: "At the end of each round, over all workers.",
      series: [
        { name: "links", points: against("round", "links") },
        { name: "elements", points: against("round", "elements") },
        { name: "rays of the round", points: against("round", "rays"), dashed: true },
      ],
      x: roundAxis,
      y: { label: "↑ number", text: format.shortCount, log: true },
    }),
    lines({
      title: "Energy and residual",
      note: "Emitted less absorbed and escaped power, and the residual of the solver, over the emitted power.",
      series: [
        { name: "energy imbalance", points: against("round", "imbalance") },
        { name: "residual", points: against("round", "residual") },
      ],
      x: roundAxis,
      y: { label: "↑ share of the power", text: format.percent, log: true },
    })));
}

/** Rounds as ticks: all of them while there is room. */
export function ticksOf(rounds) {
  const step = Math.ceil(rounds.length / 12);
  return rounds.map(({ round }) => round).filter((_, i) => i % step === 0);
}

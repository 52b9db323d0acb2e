// What each round let expect of the whole run, against what the run took.
import * as format from "./format.js";
import { ranges } from "./ranges.js";
import { ticksOf } from "./report_accuracy.js";
import { figures, section } from "./section.js";

/** `data.forecasts`: [{ round, seconds: { low, likely, high }, links: … }], made after that round. */
export function forecastSection({ forecasts = [], summary = {} }, rounds) {
  const of = (key) => forecasts.map((forecast) => ({ round: forecast.round, ...forecast[key] }));
  const common = { ticks: ticksOf(rounds) };
  return section("What was expected", "From the rounds so far, for the accuracy asked for.", figures(
    ranges({
      ...common,
      title: "Forecast of the time",
      note: "Seconds from the start of the job to the patch file.",
      rows: of("seconds"),
      outcome: summary.seconds,
      label: "↑ seconds",
      text: format.seconds,
      axisText: format.number,
    }),
    ranges({
      ...common,
      title: "Forecast of the links",
      note: "Links of the last round.",
      rows: of("links"),
      outcome: summary.links,
      label: "↑ links",
      text: format.shortCount,
    })));
}

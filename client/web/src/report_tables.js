// The tables of a report: rounds, effects, repairs.
import * as format from "./format.js";
import { table } from "./table.js";

const numeric = (title, key, text) => ({ title, text: (row) => text(row[key]) });
const share = (title, key, whole) => ({ title, text: (row) => format.percent(row[key] / whole) });
const words = (title, text) => ({ title, text, numeric: false });

export function roundTable(rounds) {
  if (rounds.length === 0) return null;
  return table("What each round took and reached", [
    numeric("round", "round", format.count),
    numeric("threshold, W", "epsilon", format.number),
    numeric("error", "error", format.percent),
    numeric("RMS", "rms", format.percent),
    numeric("seconds", "seconds", format.number),
    numeric("links", "links", format.count),
    numeric("elements", "elements", format.count),
    numeric("evaluations", "evaluations", format.count),
    numeric("proved visible", "proved_visible", format.count),
    numeric("proved hidden", "proved_hidden", format.count),
    numeric("rays", "rays", format.count),
    numeric("products", "iterations", format.count),
    numeric("residual", "residual", format.number),
    numeric("imbalance", "imbalance", format.percent),
    numeric("leaks", "leaks", format.count),
    numeric("their area", "leak_area", format.percent),
    numeric("load", "load", format.number),
    numeric("nodes moved", "migrated_nodes", format.count),
    numeric("links moved", "migrated_links", format.count),
    numeric("bytes in", "bytes_in", format.bytes),
    numeric("bytes out", "bytes_out", format.bytes),
    numeric("memory", "memory_bytes", format.bytes),
  ], rounds);
}

/** `cpu_s` and `rays`: of the whole job, which shares are of. */
export function effectTable(effects, { cpu_s, rays }) {
  if (effects.length === 0) return null;
  return table("Effects of light, and what is done about them", [
    words("effect", ({ name }) => name),
    words("present", ({ present }) => (present ? "yes" : "no")),
    numeric("bound on neglecting it", "bound", format.percent),
    numeric("measured", "measured", format.percent),
    numeric("CPU, s", "cpu_s", format.number),
    share("of all CPU", "cpu_s", cpu_s),
    numeric("rays", "rays", format.count),
    share("of all rays", "rays", rays),
    numeric("links", "links", format.count),
    words("decision", ({ decision }) => decision?.replaceAll("-", " ")),
    words("evidence", ({ evidence }) => evidence),
  ], effects);
}

export function repairTable(repairs) {
  if (repairs.length === 0) return null;
  return table("Repairs, with the first place of each", [
    words("what", ({ what }) => what),
    numeric("how often", "count", format.count),
  ], repairs);
}

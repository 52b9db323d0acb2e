// Numbers as people read them. What is missing or is no number shows as a dash.

const kDash = "–";
const known = (value) => typeof value === "number" && Number.isFinite(value);

/** Three significant digits: 0.00123, 12.3, 1,230,000. */
export function number(value) {
  if (!known(value)) return kDash;
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-4 || size >= 1e7)
    ? value.toExponential(2).replace("e+", "e")
    : value.toLocaleString("en", { maximumSignificantDigits: 3 });
  return text.replaceAll("-", "−");
}

/** A share as per cent: 0.0234 is "2.34 %". */
export function percent(share) {
  return known(share) ? `${number(100 * share)} %` : kDash;
}

/** Whole: 1,234,567. */
export function count(value) {
  return known(value) ? Math.round(value).toLocaleString("en") : kDash;
}

export function seconds(value) {
  if (!known(value)) return kDash;
  return value < 120 ? `${number(value)} s` : `${number(value / 60)} min`;
}

/** Powers of 1,000: 1.23 MB. */
export function bytes(value) {
  if (!known(value)) return kDash;
  const units = ["bytes", "kB", "MB", "GB", "TB"];
  let unit = 0;
  for (; value >= 1000 && unit + 1 < units.length; ++unit) value /= 1000;
  return `${number(value)} ${units[unit]}`;
}

/** For an axis: 500, 20 k, 1 M. */
export function shortCount(value) {
  if (!known(value)) return kDash;
  if (value >= 1e9) return `${number(value / 1e9)} G`;
  if (value >= 1e6) return `${number(value / 1e6)} M`;
  return value >= 1e3 ? `${number(value / 1e3)} k` : number(value);
}

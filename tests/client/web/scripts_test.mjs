// The parts of the pages that need no browser.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import * as format from "../../../client/web/src/format.js";
import { fitPower } from "../../../client/web/src/power_fit.js";

test("a power law is found", () => {
  const fit = fitPower([1, 3, 10, 40].map((x) => [x, 5 * x ** -0.75]));
  assert.ok(Math.abs(fit.exponent + 0.75) < 1e-12);
  assert.ok(Math.abs(fit.at(7) - 5 * 7 ** -0.75) < 1e-12);
});

test("scattered points are fitted by least squares of the logarithms", () => {
  // Logarithms to base 10: (0, 0), (1, −1), (2, 0) have slope 0 and mean −1/3.
  const fit = fitPower([[1, 1], [10, 0.1], [100, 1]]);
  assert.ok(Math.abs(fit.exponent) < 1e-12);
  assert.ok(Math.abs(fit.at(50) - 10 ** (-1 / 3)) < 1e-12);
});

test("too few points have no power law", () => {
  assert.equal(fitPower([]), null);
  assert.equal(fitPower([[1, 2]]), null);
  assert.equal(fitPower([[1, 2], [1, 3]]), null);
  assert.equal(fitPower([[1, 2], [0, 3], [2, 0], [-1, 4]]), null);
  assert.equal(fitPower([[6.5, 12], [6.6, 7]]), null);
});

test("numbers have three digits", () => {
  assert.equal(format.number(0.012345), "0.0123");
  assert.equal(format.number(1234567), "1,230,000");
  assert.equal(format.number(0), "0");
  assert.equal(format.number(3.2e9), "3.20e9");
  assert.equal(format.number(2e-7), "2.00e−7");
  assert.equal(format.number(-1.5), "−1.5");
  assert.equal(format.percent(0.02), "2 %");
  assert.equal(format.count(1234567), "1,234,567");
  assert.equal(format.shortCount(1234567), "1.23 M");
  assert.equal(format.shortCount(20000), "20 k");
  assert.equal(format.bytes(999), "999 bytes");
  assert.equal(format.bytes(1234567), "1.23 MB");
  assert.equal(format.seconds(3.256), "3.26 s");
  assert.equal(format.seconds(600), "10 min");
});

test("what is missing is a dash", () => {
  for (const show of [format.number, format.percent, format.count, format.shortCount, format.seconds, format.bytes]) {
    for (const value of [undefined, null, NaN, Infinity, "3"]) assert.equal(show(value), "–");
  }
});

// Relative luminance of "#rrggbb", as WCAG 2.1 defines it.
function luminance(colour) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255)
    .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a, b) {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

test("text and charts stand out from what is behind them, in both colour schemes", () => {
  const style = readFileSync(new URL("../../../client/web/src/style.css", import.meta.url), "utf8");
  const schemes = [...style.matchAll(/:root \{([^}]*)\}/g)].map(([, body]) =>
    Object.fromEntries([...body.matchAll(/--([a-z0-9-]+): (#[0-9a-f]{6});/g)].map(([, name, value]) => [name, value])));
  assert.equal(schemes.length, 2);
  for (const scheme of schemes) {
    for (const back of [scheme.page, scheme.panel]) {
      for (const name of ["text", "quiet"]) assert.ok(contrast(scheme[name], back) >= 4.5, `${name} on ${back}`);
      const series = Object.keys(scheme).filter((name) => name.startsWith("series-"));
      assert.equal(series.length, 10);
      for (const name of series) assert.ok(contrast(scheme[name], back) >= 3, `${name} on ${back}`);
    }
  }
});

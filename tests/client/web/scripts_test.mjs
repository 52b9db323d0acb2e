// The parts of the pages that need no browser.
import assert from "node:assert/strict";
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

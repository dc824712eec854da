import assert from "node:assert/strict";
import { test } from "node:test";
import { bytes, decimalsOf, digits, duration, prefixFor, quantity } from "../../../crates/palpate-live/page/si.js";

test("a quantity has the prefix with which it reads best", () => {
  for (const [value, unit, text] of [
    [0.00123, "m", "1.23 mm"],
    [0.98, "N", "980 mN"],
    [-1.5, "N", "−1.50 N"],
    [0, "J", "0 J"],
    [1e-6, "s", "1.00 µs"],
    [0.9999, "N", "1.00 N"],
    [999.4e-6, "s", "999 µs"],
    [999.6e-6, "s", "1.00 ms"],
    [4000, "Hz", "4.00 kHz"],
    [1e-15, "J", "0.00 pJ"],
    [NaN, "N", "– N"],
  ]) {
    assert.equal(quantity(value, unit), text);
  }
  assert.equal(quantity(0.02, "m", 1), "20 mm");
});

test("digits: three that count, a true minus, no minus before 0, no powers", () => {
  for (const [value, text] of [
    [1.005, "1.00"],
    [12.34, "12.3"],
    [99.96, "100"],
    [123.4, "123"],
    [1234.5, "1235"],
    [-0.98, "−0.98"],
    [-0.0001, "0.00"],
    [0.5, "0.50"],
    [Infinity, "∞"],
    [-Infinity, "−∞"],
  ]) {
    assert.equal(digits(value), text, String(value));
  }
  assert.equal(digits(4001.6, 4), "4002");
});

test("prefixes hold over their whole decades", () => {
  for (let power = -12; power < 12; power += 1) {
    const scaled = (1.5 * 10 ** power) / prefixFor(1.5 * 10 ** power).factor;
    assert.ok(scaled >= 1 && scaled < 1000, `1e${power}: ${scaled}`);
  }
});

test("bytes and durations", () => {
  assert.equal(bytes(999), "999 B");
  assert.equal(bytes(57_100_000), "57.1 MB");
  assert.equal(duration(34.9), "34 s");
  assert.equal(duration(125), "2 min 5 s");
});

test("numbers that are apart by a step have as many decimals as that needs", () => {
  for (const [step, decimals] of [[1, 0], [0.25, 2], [0.1, 1], [20, 0], [2.5, 1], [0.005, 3], [0.30000000000000004, 1]]) {
    assert.equal(decimalsOf(step), decimals, String(step));
  }
});

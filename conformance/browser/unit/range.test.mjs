import assert from "node:assert/strict";
import { test } from "node:test";
import { SteadyRange, roundStep } from "../../../crates/palpate-live/page/range.js";

test("steps are round", () => {
  for (const [size, step] of [[0.11, 0.2], [0.2, 0.2], [3, 5], [2.4, 2.5], [0.00026, 0.0005], [9, 10]]) {
    assert.ok(Math.abs(roundStep(size) - step) < 1e-12 * step, `${size}: ${roundStep(size)}`);
  }
});

test("it holds what is to be seen at all times, and grows at once", () => {
  const range = new SteadyRange({ least: 0.1 });
  let seed = 1;
  for (let k = 0; k < 2000; k += 1) {
    seed = (seed * 48271) % 2147483647;
    const size = 10 ** ((seed % 1000) / 100 - 6);
    const min = (seed % 3) - 1 > 0 ? 0.2 * size : -size;
    range.take(min, size, k * 0.016);
    assert.ok(range.min <= Math.min(min, 0) && range.max >= size, `${min} to ${size} in ${range.min} to ${range.max}`);
    assert.ok(range.min <= 0 && range.max >= 0);
  }
});

test("it shrinks, but not at once", () => {
  const range = new SteadyRange({ least: 0.1 });
  range.take(0, 10, 0);
  assert.equal(range.max, 10);
  range.take(0, 1, 0.1);
  range.take(0, 1, 1.5);
  assert.equal(range.max, 10);
  range.take(0, 1, 1.7);
  assert.equal(range.max, 1);
});

test("nothing, and next to nothing, has a range too", () => {
  const range = new SteadyRange({ least: 1e-4 });
  range.take(Infinity, -Infinity, 0);
  assert.ok(range.max - range.min >= 1e-4);
  range.fit(-1e-18, 1e-18);
  assert.ok(range.max - range.min >= 1e-4 * (1 - 1e-9) && range.min <= -1e-18);
  const anywhere = new SteadyRange({ least: 0.01, zero: false });
  anywhere.fit(5, 5);
  assert.ok(anywhere.min <= 5 && anywhere.max >= 5 && anywhere.min > 4.9);
});

test("far below what counts it is cut", () => {
  const range = new SteadyRange({ least: 1e-4, below: 0.25 });
  range.fit(-0.05, 0.002);
  assert.ok(range.min >= -0.001 && range.max >= 0.002, `${range.min} to ${range.max}`);
});

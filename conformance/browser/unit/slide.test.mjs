import assert from "node:assert/strict";
import { test } from "node:test";
import { slide } from "../../../crates/palpate-live/page/slide.js";

const LIMITS = [[10, 10_000], [0.005, 5], [0, 50], [-10, 10], [20, 4000], [-2, 10]];

test("both ends are reached exactly, and nothing beyond", () => {
  for (const [low, high] of LIMITS) {
    const scale = slide(low, high);
    assert.equal(scale.value(0), low);
    assert.equal(scale.value(1), high);
    assert.equal(scale.place(low), 0);
    assert.equal(scale.place(high), 1);
    for (let k = 0; k <= 1000; k += 1) {
      const value = scale.value(k / 1000);
      assert.ok(value >= low && value <= high, `${low} to ${high}: ${value}`);
    }
  }
});

test("a value stands where it was set", () => {
  for (const [low, high] of LIMITS) {
    const scale = slide(low, high);
    for (const place of [0.2, 0.4, 0.7, 0.95]) {
      const back = scale.place(scale.value(place));
      // Values are rounded to three digits, and 0 has an extended range.
      assert.ok(Math.abs(back - place) < 0.035, `${low} to ${high}: ${place} became ${back}`);
    }
  }
});

test("every decade has the same room", () => {
  const scale = slide(10, 10_000);
  assert.ok(Math.abs(scale.place(100) - 1 / 3) < 1e-12);
  assert.ok(Math.abs(scale.place(1000) - 2 / 3) < 1e-12);
});

test("0 can be found by hand", () => {
  assert.equal(slide(-10, 10).value(0.51), 0);
  assert.equal(slide(0, 50).value(0.005), 0);
  assert.ok(slide(0, 50).value(0.02) > 0);
});

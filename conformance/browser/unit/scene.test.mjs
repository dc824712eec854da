import assert from "node:assert/strict";
import { test } from "node:test";
import { forceText } from "../../../crates/palpate-live/page/scene.js";

const ofTicks = (mean) => forceText({ least: mean - 1, greatest: mean + 1, mean, grouped: false });
const ofGroups = (least, greatest) => forceText({ least, greatest, mean: NaN, grouped: true });

test("of ticks the mean force is told, with a true minus and none before 0", () => {
  assert.equal(ofTicks(1.254), "1.25 N");
  assert.equal(ofTicks(-0.5), "−0.50 N");
  assert.equal(ofTicks(-0.001), "0.00 N");
  assert.equal(ofTicks(-10), "−10.00 N");
});

test("of groups the force is told from least to greatest, as there is no mean of them", () => {
  assert.equal(ofGroups(0, 10), "0 to 10 N");
  assert.equal(ofGroups(-12.4, -0.3), "−12 to 0 N");
  assert.equal(ofGroups(-1.52, 0.21), "−1.5 to 0.2 N");
  assert.equal(ofGroups(-0.981, -0.979), "−0.98 N");
  assert.equal(ofGroups(-0.2, -0.001), "−0.20 to 0.00 N");
  assert.equal(ofGroups(0, 9.97), "0 to 10 N");
  assert.equal(ofGroups(0, 0.997), "0.0 to 1.0 N");
});

test("without a value nothing is told", () => {
  assert.equal(forceText({ least: Infinity, greatest: -Infinity, mean: NaN, grouped: true }), "");
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { Bins } from "../../../crates/palpate-live/page/bins.js";
import { readSamples } from "../../../crates/palpate-live/page/protocol.js";
import { Ring } from "../../../crates/palpate-live/page/ring.js";
import { frameOf } from "./frames.mjs";

function ringOf(times, values, capacity = times.length) {
  const ring = new Ring(1, capacity);
  times.forEach((time, i) => ring.append(readSamples(frameOf({ times: [time], rows: [[values[i]]] }), 1)));
  return ring;
}

function filled(bins, ring, curve) {
  bins.sort(ring);
  return bins.fill(0, curve);
}

const curveOf = (bins) => new Float64Array(2 * bins.largest);

test("of each bin its least and its greatest, in the order in which they came", () => {
  const bins = new Bins(10);
  bins.lay(0, 4, 4);
  const curve = curveOf(bins);
  const ring = ringOf([0.1, 0.2, 0.3, 1.1, 1.5, 1.6, 2.5], [1, 5, 2, 7, -3, 4, 6]);
  const { min, max, spread } = filled(bins, ring, curve);
  assert.deepEqual([...curve.slice(0, 6)], [1, 5, 7, -3, 6, NaN]);
  assert.equal(min, -3);
  assert.equal(max, 7);
  assert.equal(spread, 4 + 10);
  assert.deepEqual([...bins.times.slice(0, 4)], [0.25, 0.75, 1.25, 1.75]);
});

test("no peak is lost, however many rows there are, also across the end of the ring", () => {
  const bins = new Bins(100);
  bins.lay(100, 200, 50);
  const ring = new Ring(1, 70_000);
  for (let k = 0; k < 1000; k += 1) {
    const times = Array.from({ length: 200 }, (_, i) => (k * 200 + i) / 1000);
    ring.append(readSamples(frameOf({ times, rows: times.map((time) => [Math.abs(time - 150.007) < 1e-6 ? 9 : 0]) }), 1));
  }
  const curve = curveOf(bins);
  const { max } = filled(bins, ring, curve);
  assert.equal(max, 9);
  const at = curve.indexOf(9);
  assert.ok(Math.abs(bins.times[at] - 150.007) <= bins.widthS);
});

test("bins stand still while the stretch moves on", () => {
  const bins = new Bins(10);
  bins.lay(0, 4, 4);
  const before = bins.times[2];
  bins.lay(0.4, 4.4, 4);
  assert.equal(bins.times[2], before);
  bins.lay(1.4, 5.4, 4);
  assert.equal(bins.times[0], before);
});

test("a bin without rows is passed over, one with missing values ends the line", () => {
  const bins = new Bins(10);
  bins.lay(0, 4, 4);
  const curve = curveOf(bins);
  filled(bins, ringOf([0.5, 1.5, 3.5], [1, NaN, 2]), curve);
  assert.deepEqual([...curve.slice(0, 8)], [1, NaN, Infinity, NaN, NaN, NaN, 2, NaN]);
});

test("where rows are far apart the line still reaches the edges", () => {
  const bins = new Bins(12);
  bins.lay(2, 3, 10);
  const curve = curveOf(bins);
  const { min, max } = filled(bins, ringOf([0, 4], [0, 8]), curve);
  const drawn = [...curve].map((value, i) => [bins.times[i], value]).filter(([, value]) => value === value && value !== 0);
  assert.equal(drawn.length, 2);
  for (const [time, value] of drawn) {
    assert.ok(Math.abs(value - 2 * time) < 1e-9);
  }
  assert.ok(min >= 4 && max <= 6.3, `${min} to ${max}`);
});

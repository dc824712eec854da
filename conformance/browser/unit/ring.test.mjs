import assert from "node:assert/strict";
import { test } from "node:test";
import { readSamples } from "../../../crates/palpate-live/page/protocol.js";
import { Ring } from "../../../crates/palpate-live/page/ring.js";
import { frameOf } from "./frames.mjs";

const frame = (times) => readSamples(frameOf({ times, rows: times.map((time) => [time, -time]) }), 2);
const times = (ring) => Array.from({ length: ring.length }, (_, row) => ring.timeS[ring.place(row)]);

test("rows stand in order, the oldest go when there is no room", () => {
  const ring = new Ring(2, 5);
  assert.ok(Number.isNaN(ring.firstS) && Number.isNaN(ring.lastS));
  ring.append(frame([1, 2, 3]));
  ring.append(frame([4, 5, 6, 7]));
  assert.deepEqual(times(ring), [3, 4, 5, 6, 7]);
  assert.equal(ring.firstS, 3);
  assert.equal(ring.lastS, 7);
  assert.equal(ring.value(1, 4), -7);
  ring.append(frame([8]));
  assert.deepEqual(times(ring), [4, 5, 6, 7, 8]);
});

test("the row at a time is the last one that is not later", () => {
  const ring = new Ring(2, 4);
  ring.append(frame([1, 2, 3, 4]));
  ring.append(frame([5, 6]));
  assert.equal(ring.rowAt(2.9), -1);
  assert.equal(ring.rowAt(3), 0);
  assert.equal(ring.rowAt(5.5), 2);
  assert.equal(ring.rowAt(100), 3);
  assert.equal(new Ring(1, 3).rowAt(0), -1);
});

test("rows that are being looked at are not let go of", () => {
  const ring = new Ring(2, 4);
  ring.append(frame([1, 2, 3, 4]));
  assert.equal(ring.append(frame([5, 6]), { keepFromS: 3 }), true);
  assert.deepEqual(times(ring), [3, 4, 5, 6]);
  assert.equal(ring.append(frame([7]), { keepFromS: 3 }), false);
  assert.equal(ring.appendGap(7, { keepFromS: 3 }), false);
  assert.deepEqual(times(ring), [3, 4, 5, 6]);
  assert.equal(ring.append(frame([7])), true);
  assert.deepEqual(times(ring), [4, 5, 6, 7]);
  assert.equal(ring.append(frame([1, 2, 3, 4, 5])), false, "a frame that never fits");
});

test("marks: groups, gaps, settings; a copy has them too and stands by itself", () => {
  const ring = new Ring(2, 4);
  ring.append(frame([0, 1, 2]));
  ring.append(frame([3]), { grouped: true, settings: 5 });
  ring.appendGap(3.5);
  ring.append(frame([4]));
  const copy = ring.copy();
  ring.clear();
  assert.equal(ring.length, 0);
  assert.deepEqual(times(copy), [2, 3, 3.5, 4]);
  assert.deepEqual([0, 1, 2, 3].map((row) => copy.isGrouped(row)), [false, true, false, false]);
  assert.deepEqual([0, 1, 2, 3].map((row) => copy.isGap(row)), [false, false, true, false]);
  assert.equal(copy.settings[copy.place(1)], 5);
  assert.ok(Number.isNaN(copy.value(0, 2)));
  assert.equal(copy.value(1, 3), -4);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { isGrouped, kindOf, readSamples, readWorld } from "../../../crates/palpate-live/page/protocol.js";
import { frameOf } from "./frames.mjs";

test("a frame is read: head, times, columns one after the other", () => {
  const bytes = frameOf({ lane: 1, number: 7, run: 3, times: [2.5, 2.501, 2.502], rows: [[1, -1], [2, NaN], [3, -3]] });
  const frame = readSamples(bytes, 2);
  assert.deepEqual(
    { lane: frame.lane, number: frame.number, run: frame.run, rows: frame.rows, startS: frame.startS },
    { lane: 1, number: 7, run: 3, rows: 3, startS: 2.5 },
  );
  assert.ok(Math.abs(frame.startS + frame.afterS[2] - 2.502) < 1e-9);
  assert.deepEqual([...frame.values], [1, 2, 3, -1, NaN, -3]);
});

test("the bytes are those of docs/reference/live-protocol.md, written out", () => {
  const text = "01 00 0100 01000000 02000000 09000000 000000000000f03f 00000000 0000c03f".replaceAll(" ", "");
  const frame = readSamples(new Uint8Array(Buffer.from(text, "hex")).buffer, 1);
  assert.equal(frame.number, 2);
  assert.equal(frame.run, 9);
  assert.equal(frame.startS, 1);
  assert.deepEqual([...frame.values], [1.5]);
});

test("a frame that is not as told is refused, and says how", () => {
  const good = frameOf({ times: [0, 1], rows: [[1], [2]] });
  assert.throws(() => readSamples(good.slice(0, 20), 1), /20 bytes is shorter than its header of 24/);
  assert.throws(() => readSamples(good.slice(0, 36), 1), /2 rows has 36 bytes instead of 40/);
  assert.throws(() => readSamples(good, 14), /1 columns, hello announces 14/);
  assert.throws(() => readSamples(frameOf({ kind: 2, times: [0], rows: [[1]] }), 1), /unknown frame kind 2/);
});

test("rows are ticks up to 1 kHz, groups above", () => {
  assert.equal(isGrouped(0.001), false);
  assert.equal(isGrouped(1 / 1000), false);
  assert.equal(isGrouped(0.02), false);
  assert.equal(isGrouped(0.00025), true);
  assert.equal(isGrouped(1 / 1001), true);
});

test("a world is read: the bytes are those of docs/reference/live-protocol.md, written out", () => {
  const head = "02 01 0000 01000000 05000000 07000000 000000000000e03f 01000000 0000803e 0000003f 0000403f";
  const body = "00004040 0000803f 00000040 00004040 0000803f 00000000 00000000 00000000";
  const contact = "00008040 0000a040 0000c040 0000e040 00000041 00001041";
  const bytes = new Uint8Array(Buffer.from(`${head}${body}${contact}`.replaceAll(" ", ""), "hex")).buffer;
  assert.equal(kindOf(bytes), "world");
  assert.deepEqual(readWorld(bytes), {
    lane: 1,
    number: 5,
    run: 7,
    timeS: 0.5,
    forces: [[0.25, 0.5, 0.75]],
    bodies: [{ body: 3, position: [1, 2, 3], orientation: [1, 0, 0, 0] }],
    contacts: [{ point: [4, 5, 6], force: [7, 8, 9] }],
  });
  assert.throws(() => readWorld(bytes.slice(0, 80)), /1 bodies, 1 contacts and 1 devices has 80 bytes instead of 96/);
  // The force on a second device follows all data of the first.
  const further = `${head.replace("02 01 0000", "02 01 0100")}${body}${contact} 000080bf 000000c0 000040c0`;
  const ofTwo = readWorld(new Uint8Array(Buffer.from(further.replaceAll(" ", ""), "hex")).buffer);
  assert.deepEqual(ofTwo.forces, [[0.25, 0.5, 0.75], [-1, -2, -3]]);
  assert.deepEqual(ofTwo.contacts, [{ point: [4, 5, 6], force: [7, 8, 9] }]);
  assert.throws(() => readWorld(bytes.slice(0, 30)), /30 bytes is shorter than its header of 40/);
});

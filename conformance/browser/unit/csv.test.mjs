import assert from "node:assert/strict";
import { test } from "node:test";
import { field, shortest, table } from "../../../crates/palpate-live/page/csv.js";
import { readSamples } from "../../../crates/palpate-live/page/protocol.js";
import { Ring } from "../../../crates/palpate-live/page/ring.js";
import { frameOf } from "./frames.mjs";
import { parse } from "../tables.mjs";

const frame = (times, rows) => readSamples(frameOf({ times, rows }), 2);

test("a number reads back to the same 32 bits, and is no longer than it must be", () => {
  let seed = 7;
  for (let k = 0; k < 20_000; k += 1) {
    seed = (seed * 48271) % 2147483647;
    const value = Math.fround((seed / 2147483647 - 0.5) * 10 ** ((seed % 40) - 20));
    assert.equal(Math.fround(Number(shortest(value))), value);
  }
  assert.equal(shortest(Math.fround(0.1)), "0.1");
  assert.equal(shortest(Math.fround(-400)), "-400");
  assert.equal(shortest(NaN), "");
});

test("fields with commas and quotes are quoted", () => {
  assert.equal(field("a"), "a");
  assert.equal(field('a "b", c'), '"a ""b"", c"');
});

test("the table has every row of every lane, and says what a row is", () => {
  const first = new Ring(2, 10);
  first.append(frame([0, 0.001], [[0.1, 1], [0.2, NaN]]), { settings: 7 });
  first.appendGap(0.0015);
  first.append(frame([0.002], [[0.3, 3]]), { grouped: true, settings: 8 });
  const second = new Ring(2, 10);
  second.append(frame([0.5], [[-1, -2]]), { settings: 8 });
  const settings = [
    { lanes: [{ method: "basic" }] },
    { lanes: [{ method: "hfcr" }, { method: "coupled" }] },
  ];
  const text = [...table(["a_m", "b_n"], [{ lane: 0, ring: first }, { lane: 1, ring: second }], settings, 7, { title: 'x "y", z' })].join("");
  const { header, rows } = parse(text);
  assert.deepEqual(header, ["lane", "method", "settings", "grouped", "t_s", "a_m", "b_n", "palpate_live_1"]);
  assert.deepEqual(rows.map((row) => row.slice(0, 7)), [
    ["0", "basic", "0", "0", "0", "0.1", "1"],
    ["0", "basic", "0", "0", "0.001", "0.2", ""],
    ["0", "hfcr", "1", "1", "0.002", "0.3", "3"],
    ["1", "coupled", "1", "0", "0.5", "-1", "-2"],
  ]);
  const about = JSON.parse(rows[0][7]);
  assert.equal(about.title, 'x "y", z');
  assert.deepEqual(about.settings, settings);
  assert.match(about.rows, /minimum or maximum/);
  assert.deepEqual(rows.slice(1).map((row) => row[7]), ["", "", ""]);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { aboutBuffer, counted, rate } from "../../../crates/palpate-live/page/status.js";
import { View } from "../../../crates/palpate-live/page/view.js";

const report = (ticks, atS) => ({ lanes: ticks.map((count, lane) => ({ ticks: count, t_s: atS[lane] })) });

test("the rate is ticks by their own time, whatever has come of them here", () => {
  const before = report([100, 50], [1, 1.5]);
  const after = report([300, 1050], [3, 1.75]);
  assert.equal(rate(before, after, 0), 100);
  assert.equal(rate(before, after, 1), 4000);
  assert.ok(Number.isNaN(rate(before, after, 2)));
  assert.ok(Number.isNaN(rate(before, before, 0)));
  assert.ok(Number.isNaN(rate(undefined, after, 0)));
  assert.ok(Number.isNaN(rate(after, before, 0)), "a loop that has begun anew");
});

test("a pause says what has come in since, and when nothing more is kept", () => {
  const view = new View();
  const model = { newestS: 42.9, refusedRows: 0 };
  assert.equal(aboutBuffer(model, view), "");
  view.follow(30, 0.016);
  view.pause();
  assert.match(aboutBuffer(model, view), /^Paused at 30\.00 s; 12 s more received since\. Drag/);
  assert.match(aboutBuffer({ ...model, refusedRows: 3 }, view), /buffer is full/);
});

test("one picture is no pictures", () => {
  assert.deepEqual([0, 1, 2].map((number) => counted(number, "picture")), ["0 pictures", "1 picture", "2 pictures"]);
});

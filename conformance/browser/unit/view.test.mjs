import assert from "node:assert/strict";
import { test } from "node:test";
import { View } from "../../../crates/palpate-live/page/view.js";

test("the edge follows what comes, without the bursts in which it comes", () => {
  const view = new View();
  view.follow(NaN, 0.016);
  assert.equal(view.edgeS, 0);
  view.follow(5, 0.016);
  assert.equal(view.edgeS, 5);
  const frame = 1 / 60;
  const steps = [];
  for (let k = 1; k < 600; k += 1) {
    const before = view.edgeS;
    view.follow(5 + Math.floor((k * frame) / 0.05) * 0.05, frame);
    steps.push(view.edgeS - before);
  }
  assert.ok(Math.min(...steps) > 0.5 * frame && Math.max(...steps) < 1.5 * frame);
  assert.ok(Math.abs(view.edgeS - 15) < 0.1);
});

test("what is paused stands still, and is kept", () => {
  const view = new View();
  view.follow(100, 0.016);
  view.pause();
  view.follow(120, 0.016);
  assert.deepEqual([view.fromS, view.toS], [90, 100]);
  assert.equal(view.keepFromS, 70);
  view.go();
  assert.equal(view.keepFromS, Infinity);
});

test("a zoom stays within what is paused, and there is none while it runs", () => {
  const view = new View();
  view.follow(100, 0.016);
  view.zoomTo(92, 94);
  assert.equal(view.zoom, null);
  view.pause();
  view.zoomTo(94, 92);
  assert.deepEqual([view.fromS, view.toS], [92, 94]);
  view.zoomBy(0.5, 92);
  assert.deepEqual([view.fromS, view.toS], [92, 93]);
  view.moveBy(-10);
  assert.deepEqual([view.fromS, view.toS], [90, 91]);
  view.moveBy(100);
  assert.deepEqual([view.fromS, view.toS], [99, 100]);
  view.zoomTo(99.5, 99.5001);
  assert.deepEqual([view.fromS, view.toS], [99, 100], "too short to be looked at");
  view.zoomBy(100);
  assert.equal(view.zoom, null);
});

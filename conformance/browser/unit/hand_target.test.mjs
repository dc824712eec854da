import assert from "node:assert/strict";
import { test } from "node:test";
import { HandTarget } from "../../../crates/palpate-live/page/hand_target.js";

/** A target, and its sent messages. */
function wished() {
  const sent = [];
  const send = (value) => sent.push(value) > 0;
  return { target: new HandTarget(0.01), sent, send };
}

test("the newest of what is asked for is said, once, and kept until the server says so", () => {
  const { target, sent, send } = wished();
  target.ask([1, 2, 3]);
  target.ask([1, 2, 4]);
  target.frame(5, [0, 0, 0], send);
  target.frame(5.1, [0, 0, 0], send);
  assert.deepEqual(sent, [[1, 2, 4]]);
  assert.deepEqual(target.value, [1, 2, 4]);
  target.frame(5.2, [1, 2, 4 + 1e-12], send);
  assert.equal(target.value, null);
  target.frame(5.3, null, send);
  assert.equal(sent.length, 1);
});

test("what the server does not do counts no longer after a second", () => {
  const { target, send } = wished();
  target.ask([1, 0, 0, 0]);
  target.frame(5, null, send);
  target.frame(5.9, [0, 1, 0, 0], send);
  assert.deepEqual(target.value, [1, 0, 0, 0]);
  target.frame(6.1, [0, 1, 0, 0], send);
  assert.equal(target.value, null);
});

test("what could not be sent is sent later", () => {
  const { target, sent, send } = wished();
  target.ask([1, 2, 3]);
  target.frame(5, null, () => false);
  target.frame(50, null, () => false);
  assert.deepEqual(target.value, [1, 2, 3]);
  target.frame(51, null, send);
  assert.deepEqual(sent, [[1, 2, 3]]);
});

test("what is dropped is not said", () => {
  const { target, sent, send } = wished();
  target.ask([1, 2, 3]);
  target.drop();
  target.frame(5, null, send);
  assert.deepEqual(sent, []);
});

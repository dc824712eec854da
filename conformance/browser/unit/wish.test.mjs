import assert from "node:assert/strict";
import { test } from "node:test";
import { Wish } from "../../../crates/palpate-scope/page/wish.js";

/** A wish, and what it has sent. */
function wished() {
  const sent = [];
  const send = (value) => sent.push(value) > 0;
  return { wish: new Wish(0.01), sent, send };
}

test("the newest of what is asked for is said, once, and kept until the server says so", () => {
  const { wish, sent, send } = wished();
  wish.ask([1, 2, 3]);
  wish.ask([1, 2, 4]);
  wish.frame(5, [0, 0, 0], send);
  wish.frame(5.1, [0, 0, 0], send);
  assert.deepEqual(sent, [[1, 2, 4]]);
  assert.deepEqual(wish.value, [1, 2, 4]);
  wish.frame(5.2, [1, 2, 4 + 1e-12], send);
  assert.equal(wish.value, null);
  wish.frame(5.3, null, send);
  assert.equal(sent.length, 1);
});

test("what the server does not do counts no longer after a second", () => {
  const { wish, send } = wished();
  wish.ask([1, 0, 0, 0]);
  wish.frame(5, null, send);
  wish.frame(5.9, [0, 1, 0, 0], send);
  assert.deepEqual(wish.value, [1, 0, 0, 0]);
  wish.frame(6.1, [0, 1, 0, 0], send);
  assert.equal(wish.value, null);
});

test("what could not be sent is sent later", () => {
  const { wish, sent, send } = wished();
  wish.ask([1, 2, 3]);
  wish.frame(5, null, () => false);
  wish.frame(50, null, () => false);
  assert.deepEqual(wish.value, [1, 2, 3]);
  wish.frame(51, null, send);
  assert.deepEqual(sent, [[1, 2, 3]]);
});

test("what is dropped is not said", () => {
  const { wish, sent, send } = wished();
  wish.ask([1, 2, 3]);
  wish.drop();
  wish.frame(5, null, send);
  assert.deepEqual(sent, []);
});

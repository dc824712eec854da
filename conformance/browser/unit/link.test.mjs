import assert from "node:assert/strict";
import { afterEach, beforeEach, mock, test } from "node:test";
import { Link, waitMs } from "../../../crates/palpate-live/page/link.js";

let made = [];

/** A socket whose other end is the test. */
class FakeSocket extends EventTarget {
  static OPEN = 1;

  constructor(url) {
    super();
    this.url = url;
    this.readyState = 0;
    this.said = [];
    made.push(this);
  }

  send(text) {
    this.said.push(text);
  }

  /** As in a browser, the close event follows later. */
  close() {
    this.readyState = 2;
  }

  accept() {
    this.readyState = 1;
    this.dispatchEvent(new Event("open"));
  }

  tell(data) {
    this.dispatchEvent(Object.assign(new Event("message"), { data }));
  }

  end(reason = "") {
    this.readyState = 3;
    this.dispatchEvent(Object.assign(new Event("close"), { code: 1006, reason }));
  }
}

function linked() {
  const heard = { texts: [], samples: 0, opens: 0, losses: [], wrong: [] };
  const link = new Link("?token=a b", {
    text: (message) => heard.texts.push(message.type),
    samples: () => {
      heard.samples += 1;
    },
    open: () => {
      heard.opens += 1;
    },
    lost: (why, wait) => heard.losses.push([why, wait]),
    wrong: (error) => heard.wrong.push(error),
  });
  return { link, heard };
}

// Time that advances only by the test [ms].
let nowMs = 0;
let waiting = [];

function passMs(passed) {
  const end = nowMs + passed;
  for (;;) {
    const next = waiting.filter(({ atMs }) => atMs <= end).sort((a, b) => a.atMs - b.atMs)[0];
    if (!next) {
      break;
    }
    nowMs = next.atMs;
    if (next.everyMs) {
      next.atMs += next.everyMs;
    } else {
      waiting = waiting.filter((other) => other !== next);
    }
    next.act();
  }
  nowMs = end;
}

function wait(act, ms, everyMs = 0) {
  const one = { act, atMs: nowMs + ms, everyMs };
  waiting.push(one);
  return one;
}

function forget(one) {
  waiting = waiting.filter((other) => other !== one);
}

beforeEach(() => {
  made = [];
  nowMs = 0;
  waiting = [];
  mock.method(globalThis, "setTimeout", (act, ms) => wait(act, ms));
  mock.method(globalThis, "setInterval", (act, ms) => wait(act, ms, ms));
  mock.method(globalThis, "clearTimeout", forget);
  mock.method(globalThis, "clearInterval", forget);
  mock.method(performance, "now", () => nowMs);
  globalThis.WebSocket = FakeSocket;
  globalThis.location = { protocol: "http:", host: "here:1" };
  globalThis.fetch = async () => {
    throw new TypeError("nobody answers");
  };
});

afterEach(() => mock.restoreAll());

test("tried again by hand twice, one connection is left, and each message is heard once", () => {
  const { link, heard } = linked();
  assert.equal(made[0].url, "ws://here:1/live?token=a%20b");
  made[0].accept();
  made[0].end();
  link.open();
  link.open();
  const [, first, second] = made;
  assert.equal(first.readyState, 2, "the earlier one is closed");
  // Both had been accepted before the first was closed.
  first.accept();
  second.accept();
  for (const socket of [first, second]) {
    socket.tell('{"type":"status"}');
    socket.tell(new ArrayBuffer(24));
  }
  assert.deepEqual(heard.texts, ["status"]);
  assert.equal(heard.samples, 1);
  assert.equal(heard.opens, 2);
  first.end();
  assert.equal(heard.losses.length, 1, "the end of the earlier one is no loss");
  link.say({ type: "restart" });
  assert.deepEqual([first, second].map(({ said }) => said.length), [0, 1]);
});

test("a connection that is opened by hand is not opened again when the wait is over", () => {
  const { link, heard } = linked();
  made[0].end();
  assert.deepEqual(heard.losses, [["no answer", waitMs(0)]]);
  link.open();
  made[1].accept();
  passMs(1000);
  assert.equal(made.length, 2);
});

test("it is opened again by itself, later and later; a silent one counts as lost", () => {
  const { heard } = linked();
  for (let tries = 0; tries < 3; tries += 1) {
    made[tries].end();
    passMs(waitMs(tries) - 1);
    assert.equal(made.length, tries + 1);
    passMs(1);
    assert.equal(made.length, tries + 2);
  }
  made[3].accept();
  passMs(4000);
  assert.equal(made[3].readyState, 1);
  passMs(500);
  assert.equal(made[3].readyState, 2);
  assert.deepEqual(heard.losses.at(-1), ["no message for 4 s", waitMs(0)]);
});

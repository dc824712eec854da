import assert from "node:assert/strict";
import { test } from "node:test";
import { Pacer } from "../../../../web/pacer.js";
import { TooSlow } from "../../../../web/slow.js";

/** Turns of 10 ms, in each of which the loop advances by at most `mostS` [s]. */
function run(pacer, turns, mostS) {
  for (let turn = 1; turn <= turns; turn += 1) {
    const untilS = pacer.until(10 * turn);
    pacer.ran(1, Math.min(untilS, pacer.timeS + mostS));
    pacer.worked(5);
  }
  return pacer.report(10 * turns);
}

test("a loop that is fast enough keeps real time", () => {
  const pacer = new Pacer();
  pacer.anew(0, 0);
  const { ratio, busy, ticksPerS, lostS } = run(pacer, 200, 1);
  assert.ok(Math.abs(ratio - 1) < 1e-9, `${ratio}`);
  assert.ok(Math.abs(busy - 0.5) < 1e-9 && Math.abs(ticksPerS - 100) < 1e-9, `${busy} ${ticksPerS}`);
  assert.equal(lostS, 0);
});

test("a loop that is too slow is never asked for more than a quarter of a second, and what it loses is counted", () => {
  const pacer = new Pacer();
  pacer.anew(0, 0);
  const { ratio, lostS } = run(pacer, 400, 0.004);
  assert.ok(Math.abs(ratio - 0.4) < 1e-9, `${ratio}`);
  assert.ok(pacer.until(4000) - pacer.timeS <= 0.25 + 1e-9);
  assert.ok(Math.abs(4 - 1.6 - 0.25 - lostS) < 0.02, `${lostS}`);
});

test("time that is held does not pass", () => {
  const pacer = new Pacer();
  pacer.anew(0, 0);
  run(pacer, 100, 1);
  pacer.hold();
  pacer.goOn(60_000);
  assert.ok(Math.abs(pacer.until(60_010) - 1.01) < 1e-9);
  assert.equal(pacer.report(60_010).lostS, 0);
});

test("too slow is said after several reports in a row, and no more once it keeps up", () => {
  const slow = new TooSlow();
  const bad = { ratio: 0.5, overS: 2 };
  assert.equal(slow.about(bad), null);
  assert.equal(slow.about(bad), null);
  assert.match(slow.about(bad), /too slow .* at 0\.5 of real time/);
  assert.equal(slow.about({ ratio: 1, overS: 2 }), null);
  assert.equal(slow.about(bad), null);
});

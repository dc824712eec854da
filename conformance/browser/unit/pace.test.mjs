import assert from "node:assert/strict";
import { test } from "node:test";
import { Pace, SAY_S, Turns } from "../../../crates/palpate-live/page/pace.js";

/** Returns how many of these frames draw the charts, if a frame with charts takes this long. */
function drawn(frames, withMs, withoutMs = 16.7) {
  const pace = new Pace();
  let lasted = 16.7;
  let count = 0;
  for (let k = 0; k < frames; k += 1) {
    const draws = pace.next(lasted);
    lasted = draws ? withMs : withoutMs;
    count += draws ? 1 : 0;
  }
  return count;
}

test("charts that cost nothing are drawn in every frame", () => {
  assert.equal(drawn(100, 16.7), 100);
});

test("charts that cost several frames leave as many to the scene, but are not forgotten", () => {
  assert.equal(drawn(90, 50), 30);
  assert.ok(drawn(70, 10_000) >= 10);
});

test("however fast the screen is, less is said than the server listens to, and nothing is left out at 60 Hz or 120 Hz", () => {
  const said = (hertz) => {
    const turns = new Turns(SAY_S);
    return Array.from({ length: 10 * hertz }, (_, k) => turns.next(100 + k / hertz)).filter(Boolean).length / 10;
  };
  for (const hertz of [144, 165, 240, 360, 1000]) {
    assert.ok(said(hertz) > 75 && said(hertz) < 170, `${said(hertz)} a second at ${hertz} Hz`);
  }
  assert.deepEqual([60, 120].map(said), [60, 120]);
});

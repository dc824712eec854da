import assert from "node:assert/strict";
import { test } from "node:test";
import { Ring } from "../../../crates/palpate-live/page/ring.js";
import { createdWithin, seenInWords } from "../../../crates/palpate-live/page/seen.js";

/** A model of one rendering whose rows are 1 s apart, with these leaks [J]. */
function modelOf(leaks) {
  const ring = new Ring(1, 100);
  ring.append({ rows: leaks.length, startS: 10, afterS: leaks.map((_, i) => i), values: leaks });
  return { lanes: [{ ring }], column: () => 0 };
}

test("what is created is counted over the last seconds, and over gaps", () => {
  const { createdJ, seconds } = createdWithin(modelOf([0, 1, 2, 4, 8, 16]), 0, 2);
  assert.deepEqual([createdJ, seconds], [12, 2]);
  const gap = createdWithin(modelOf([0, NaN, 2, 4, NaN]), 0, 3);
  assert.deepEqual([gap.createdJ, gap.seconds], [2, 1]);
  const young = createdWithin(modelOf([0, 3]), 0, 5);
  assert.deepEqual([young.createdJ, young.seconds], [3, 1]);
  assert.ok(Number.isNaN(createdWithin(modelOf([]), 0, 5).createdJ));
  assert.ok(Number.isNaN(createdWithin(modelOf([NaN, NaN]), 0, 5).createdJ));
});

test("one sentence says which side creates energy and which takes it away", () => {
  const lane = (method, createdJ, seconds = 5) => ({ method, createdJ, seconds });
  assert.equal(
    seenInWords([lane("basic", 0.174), lane("coupled", 2e-5)]),
    "Left (basic) creates 174 mJ of energy; right (coupled) creates less than 0.1 mJ of energy (last 5 s).",
  );
  assert.equal(
    seenInWords([lane("basic", NaN), lane("coupled", -0.0029, 4.9)]),
    "Left (basic): unknown; right (coupled) dissipates 2.90 mJ of energy (last 5 s).",
  );
  assert.equal(
    seenInWords([lane("basic", -2e-5), lane("coupled", 0)]),
    "Left (basic) dissipates less than 0.1 mJ of energy; right (coupled) creates no energy (last 5 s).",
  );
  assert.equal(seenInWords([lane("hfcr", 0.5, 0.31)]), "hfcr creates 500 mJ of energy (last 0.3 s).");
  assert.equal(seenInWords([lane("hfcr", NaN)]), "");
});

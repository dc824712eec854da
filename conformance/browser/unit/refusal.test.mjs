import assert from "node:assert/strict";
import { test } from "node:test";
import { RATE, limitsInWords, refusalInWords } from "../../../crates/palpate-live/page/refusal.js";

test("a refusal has the label and the unit of its field, and none of the server's keys", () => {
  for (const [text, key, words] of [
    ["stiffness_n_per_m is 1000000000; allowed: 10 to 10000", "stiffness_n_per_m", "Stiffness 1000000000 N/m is outside its range; allowed: 10 to 10000 N/m"],
    ["mass_kg is 0; allowed: 0.005 to 5", "mass_kg", "Mass 0 kg is outside its range; allowed: 0.005 to 5 kg"],
    ["virtual_force_n is -20; allowed: -10 to 10", "virtual_force_n", "Virtual force −20 N is outside its range; allowed: −10 to 10 N"],
    ["period_s is 0.00001; allowed: 0.00025 to 0.05", "period_s", "Period 0.01 ms is outside its range; allowed: 0.25 to 50 ms"],
    ["damping_n_s_per_m is -1; allowed: 0 to 50", "damping_n_s_per_m", "Damping b −1 N s/m is outside its range; allowed: 0 to 50 N s/m"],
    ["position_m is 3; allowed: -1 to 1, or null", "position_m", "Position of the hand 3 m is outside its range; allowed: −1 to 1 m"],
  ]) {
    assert.deepEqual(refusalInWords(text), { key, words });
  }
});

test("a period that was entered as a rate is refused as a rate", () => {
  const { key, words } = refusalInWords("period_s is 0.00001; allowed: 0.00025 to 0.05", RATE);
  assert.equal(key, "period_s");
  assert.equal(words, "Rate 100000 Hz is outside its range; allowed: 20 to 4000 Hz");
});

test("what is about no value is said as the server says it", () => {
  for (const text of ["restarts are too frequent; allowed: 4 per second", "lane is 7; allowed: 0 to 1", ""]) {
    assert.deepEqual(refusalInWords(text), { key: null, words: text });
  }
});

test("limits begin with the smaller one", () => {
  assert.equal(limitsInWords([4000, 20], "Hz"), "20 to 4000 Hz");
  assert.equal(limitsInWords([0.00025, 0.05], "ms", (value) => String(value * 1000)), "0.25 to 50 ms");
});

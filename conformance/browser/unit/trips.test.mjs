import assert from "node:assert/strict";
import { test } from "node:test";
import { tripInWords } from "../../../crates/palpate-scope/page/trips.js";

const OSCILLATES = "held forces created energy: the contact oscillates";

test("a banner names the method that created the energy, and not the one that renders now", () => {
  const same = { method: "basic", trip: OSCILLATES, trip_method: "basic" };
  assert.equal(tripInWords(same, 1), `basic: no force, because ${OSCILLATES}.`);
  const switched = tripInWords({ ...same, method: "coupled" }, 2);
  assert.match(switched, /^Lane 2: no force, because of basic, which rendered before: held forces created energy/);
  assert.match(switched, /coupled renders now; Rearm/);
  assert.doesNotMatch(switched, /^coupled/);
});

test("what the device or the machine has done is no method's fault", () => {
  const lane = { method: "coupled", trip: "the device left its workspace", trip_method: null };
  assert.equal(tripInWords(lane, 1), "Lane 1: no force, because the device left its workspace.");
});

test("where nothing keeps the force away there is no banner", () => {
  assert.equal(tripInWords({ method: "coupled", trip: null, trip_method: null }, 1), null);
  assert.equal(tripInWords(undefined, 2), null);
});

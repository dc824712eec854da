import assert from "node:assert/strict";
import { test } from "node:test";
import { safetyStopInWords } from "../../../crates/palpate-live/page/safety_stops.js";

const OSCILLATES = "held forces created energy: the contact oscillates";

test("a banner names the method that created the energy, and not the one that renders now", () => {
  const same = { method: "basic", safety_stop: OSCILLATES, safety_stop_method: "basic" };
  assert.equal(safetyStopInWords(same, 1), `basic: no force, because ${OSCILLATES}.`);
  const switched = safetyStopInWords({ ...same, method: "coupled" }, 2);
  assert.match(switched, /^Rendering 2: no force, because of the previous method basic: held forces created energy/);
  assert.match(switched, /coupled renders now; Rearm/);
  assert.doesNotMatch(switched, /^coupled/);
});

test("what the device or the machine has done is no method's fault", () => {
  const lane = { method: "coupled", safety_stop: "the device left its workspace", safety_stop_method: null };
  assert.equal(safetyStopInWords(lane, 1), "Rendering 1: no force, because the device left its workspace.");
});

test("where nothing keeps the force away there is no banner", () => {
  assert.equal(safetyStopInWords({ method: "coupled", safety_stop: null, safety_stop_method: null }, 1), null);
  assert.equal(safetyStopInWords(undefined, 2), null);
});

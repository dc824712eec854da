import assert from "node:assert/strict";
import { test } from "node:test";
import { read, written, writtenWorld } from "../../../../web/fragment.js";
import { PRESETS, START } from "../../../../web/presets.js";

test("what a link is written of is read back, for every preset", () => {
  for (const { id, settings } of [{ id: "start", settings: {} }, ...PRESETS]) {
    const all = { ...START, ...settings };
    const back = read(`#${written(all)}`);
    assert.deepEqual(back.faults, [], id);
    assert.deepEqual(back.settings, all, id);
  }
});

test("everything that can be set stands in the link", () => {
  const all = {
    methods: ["hfcr", "coupled"],
    damping_n_s_per_m: [0.5, null],
    stiffness_n_per_m: 1234.5,
    mass_kg: null,
    virtual_force_n: 0.25,
    period_s: 0.004,
    device_mass_kg: 0.5,
    delay_s: 0.003,
    cut_off: true,
    hand_m: null,
  };
  assert.deepEqual(Object.keys(all).sort(), Object.keys(START).sort());
  const back = read(written(all));
  assert.deepEqual(back, { settings: all, world: null, worldMethods: null, faults: [] });
});

test("what is as at the start is left out", () => {
  assert.equal(written(START), "");
  assert.equal(written({ ...START, delay_s: 0.005 }), "delay_s=0.005");
});

test("a world and its methods", () => {
  const { world, worldMethods, faults } = read(writtenWorld("pinch", ["basic", "coupled"]));
  assert.deepEqual({ world, worldMethods, faults }, { world: "pinch", worldMethods: ["basic", "coupled"], faults: [] });
});

test("what is not understood is said, with its name, and the rest counts", () => {
  const { settings, faults } = read("#stiffness_n_per_m=soft&mass_kg=0.2&colour=red&methods=a,b,c&%E0%A4%A");
  assert.equal(settings.stiffness_n_per_m, START.stiffness_n_per_m);
  assert.equal(settings.mass_kg, 0.2);
  assert.deepEqual(settings.methods, START.methods);
  assert.equal(faults.length, 4);
  assert.match(faults[0], /stiffness_n_per_m is “soft”/);
  assert.match(faults[1], /“colour” is not a setting/);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { startLive } from "../program.mjs";
import { visit } from "../visit.mjs";

const fieldText = (name) => document.querySelector(`[data-name="${name}"] input[type="text"]`).value;
const refusal = (name) => document.querySelector(`[data-name="${name}"] .refused`).textContent;
const input = (name) => `[data-name="${name}"] input[type="text"]`;

/** Presses the device into a wall by moving the hand this far into it. */
async function press(open, byM) {
  // A wall has a fixed position. The hand is set through its protocol, which is exact.
  const wall = await open.get(() => palpate.model.newest(0, "object_position_m"));
  await open.get((to) => palpate.link.say({ type: "hand", position_m: to }), wall + byM);
  await open.pass(1.5);
}

/**
 * Returns the force held on the device, once it is nonzero, and the displayed depth of the device. A busy machine
 * misses deadlines, which disables the force for a moment.
 */
async function held(open) {
  const end = Date.now() + 30_000;
  for (;;) {
    const { mean, spread } = await open.over(0, "force_on_device_n", 0.3);
    if (mean < 0 && spread < 0.002) {
      const device = await open.over(0, "device_position_m", 0.3);
      const shown = await open.over(0, "object_position_m", 0.3);
      return { forceN: mean, depthM: device.mean - shown.mean, shownM: shown.mean };
    }
    assert.ok(Date.now() < end, `no force is held: ${mean} N on the mean, ${spread} N from least to greatest`);
    await open.pass(0.1);
  }
}

test("stiffness and mass are set, and the force follows", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.page.click("#wall");
  await open.until("it is a wall", () => palpate.model.state.mass_kg === null);
  await open.enter(input("stiffness_n_per_m"), "1500");
  await open.until("the stiffness is set", () => palpate.model.state.stiffness_n_per_m === 1500);
  const wallM = await open.get(() => palpate.model.newest(0, "object_position_m"));
  await press(open, 0.01);
  const stiff = await held(open);
  await open.enter(input("stiffness_n_per_m"), "500");
  await open.until("the stiffness is set", () => palpate.model.state.stiffness_n_per_m === 500);
  await open.pass(1.5);
  const softer = await held(open);
  for (const [set, { forceN, depthM, shownM }] of [
    [1500, stiff],
    [500, softer],
  ]) {
    assert.ok(Math.abs(-forceN / depthM / set - 1) < 0.02, `${forceN} N at ${depthM} m into ${set} N/m`);
    // After deadlines missed by a busy machine, `coupled` may shift the wall by up to 0.5 mm.
    assert.ok(Math.abs(shownM - wallM) < 0.0007, `the wall is shown at ${shownM} m, and stands at ${wallM} m`);
  }
  // The hand keeps its position and is a spring itself: a softer wall yields more and pushes less.
  assert.ok(softer.depthM > 1.5 * stiff.depthM && softer.forceN > 0.9 * stiff.forceN, `${JSON.stringify({ stiff, softer })}`);
  // A block again, with its previous mass.
  await open.page.click("#wall");
  await open.until("it has its mass again", () => palpate.model.state.mass_kg === 0.1);
  await open.enter(input("mass_kg"), "0,2");
  await open.until("the mass is set", () => palpate.model.state.mass_kg === 0.2);
  await open.page.click("#weight");
  await open.until("the weight is set", () => Math.abs(palpate.model.state.virtual_force_n + 1.962) < 1e-9);
  await open.leave();
  await live.end();
  live.forget();
});

test("a slider sets what a field sets", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.page.focus('[data-name="stiffness_n_per_m"] input[type="range"]');
  await open.page.keyboard.press("End");
  await open.until("the stiffness is at its limit", () => {
    const { state, hello } = palpate.model;
    return state.stiffness_n_per_m === hello.limits.stiffness_n_per_m[1];
  });
  const text = await open.get(fieldText, "stiffness_n_per_m");
  assert.equal(Number(text), await open.get(() => palpate.model.state.stiffness_n_per_m));
  // 0 covers several positions of a slider. Slow key presses move from one to the next, and out of it.
  await open.enter(input("virtual_force_n"), "0");
  await open.until("there is no virtual force", () => palpate.model.state.virtual_force_n === 0);
  const slider = '[data-name="virtual_force_n"] input[type="range"]';
  const at = () => open.get((slider) => Number(document.querySelector(slider).value), slider);
  const middle = await at();
  await open.page.focus(slider);
  await open.page.keyboard.press("ArrowRight");
  // During this time the hand on it keeps control.
  await new Promise((go) => setTimeout(go, 600));
  await open.nextStatus();
  assert.equal(await at(), middle + 1);
  assert.equal(await open.get(() => palpate.model.state.virtual_force_n), 0);
  await open.leave();
  await live.end();
  live.forget();
});

test("rate and period are one thing", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.enter(input("period_s"), "500");
  await open.until("the period is set", () => palpate.model.state.period_s === 0.002);
  assert.equal(await open.get(fieldText, "period"), "2");
  await open.enter(input("period"), "4");
  await open.until("the period is set", () => palpate.model.state.period_s === 0.004);
  assert.equal(await open.get(fieldText, "period_s"), "250");
  // The rows come at that rate.
  await open.pass(1.2);
  const { count } = await open.over(0, "lateness_s", 1);
  await open.nextStatus();
  // A missed deadline has no row.
  const { missed_deadlines: missed } = (await open.nextStatus()).lanes[0];
  assert.ok(count + missed > 240 && count <= 252, `${count} rows in a second, ${missed} deadlines missed`);
  await open.leave();
  await live.end();
  live.forget();
});

test("what the server refuses stands beside its field, which goes back", async () => {
  const live = await startLive("--method", "hfcr");
  const open = await visit(live.url);
  const before = await open.get(fieldText, "stiffness_n_per_m");
  await open.enter(input("stiffness_n_per_m"), "1000000000");
  const said = await open.until("the refusal is shown", refusal, "stiffness_n_per_m");
  assert.equal(said, "Stiffness 1000000000 N/m is outside its range; allowed: 10 to 10000 N/m");
  assert.equal(await open.get(fieldText, "stiffness_n_per_m"), before);
  assert.equal(await open.get(refusal, "mass_kg"), "");
  await open.enter(input("damping-1"), "-1");
  const ofDamping = await open.until("the refusal is shown", refusal, "damping-1");
  assert.equal(ofDamping, "Damping b −1 N s/m is outside its range; allowed: 0 to 50 N s/m");
  // Another input clears the reason.
  assert.equal(await open.get(refusal, "stiffness_n_per_m"), "");
  assert.equal(await open.get(fieldText, "damping-1"), "");
  await open.enter(input("mass_kg"), "heavy");
  assert.equal(await open.until("the refusal is shown", refusal, "mass_kg"), "“heavy” is not a number");
  // 0 Hz has no period.
  const rate = await open.get(fieldText, "period_s");
  await open.enter(input("period_s"), "0");
  assert.equal(await open.until("the refusal is shown", refusal, "period_s"), "“0” is outside its range; allowed: 20 to 4000 Hz");
  assert.equal(await open.get(fieldText, "period_s"), rate);
  // A rate is rejected as a rate, a period as a period, at its input.
  await open.enter(input("period_s"), "100000");
  const ofRate = () => document.querySelector('[data-name="period_s"] .refused').textContent.startsWith("Rate");
  await open.until("the rate is refused", ofRate);
  assert.equal(await open.get(refusal, "period_s"), "Rate 100000 Hz is outside its range; allowed: 20 to 4000 Hz");
  await open.enter(input("period"), "0.01");
  assert.equal(
    await open.until("the period is refused", refusal, "period"),
    "Period 0.01 ms is outside its range; allowed: 0.25 to 50 ms",
  );
  assert.equal(await open.get(refusal, "period_s"), "");
  assert.equal(await open.get(fieldText, "period_s"), rate);
  // A field with a valid value has no mark, and the accepted value clears the reason.
  const marked = () => document.querySelectorAll('[aria-invalid="true"], .field.wrong').length;
  assert.equal(await open.get(marked), 0);
  await open.enter(input("period_s"), rate);
  await open.until("the reason is gone", () => document.querySelector('[data-name="period"] .refused').textContent === "");
  // A valid value clears the reason.
  await open.enter(input("stiffness_n_per_m"), "700");
  await open.until("the stiffness is set", () => palpate.model.state.stiffness_n_per_m === 700);
  await open.until("the reason is gone", () => document.querySelector('[data-name="stiffness_n_per_m"] .refused').textContent === "");
  await open.enter(input("damping-1"), "2");
  await open.until("the damping is set", () => palpate.model.state.lanes[0].damping_n_s_per_m === 2);
  await open.leave();
  await live.end();
  live.forget();
});

test("a refusal stands where one has asked, and nothing shows what was not done", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.enter(input("stiffness_n_per_m"), "700");
  await open.until("the stiffness is set", () => palpate.model.state.stiffness_n_per_m === 700);
  const refusals = () => ["#lanes > .refused", '[data-name="stiffness_n_per_m"] .refused'].map((place) => document.querySelector(place).textContent);
  // This refusal names no field.
  const tooOften = "restarts are too frequent; allowed: 4 per second";
  const refused = (about, text) => open.get((about, text) => palpate.model.take({ type: "refused", about, text }), about, text);
  await open.page.click("#second-lane");
  await open.until("there are two", () => palpate.model.state.lanes.length === 2);
  await refused("set", tooOften);
  assert.deepEqual(await open.get(refusals), [tooOften, ""]);
  await open.enter(input("stiffness_n_per_m"), "800");
  await open.until("the stiffness is set", () => palpate.model.state.stiffness_n_per_m === 800);
  await refused("set", tooOften);
  assert.equal((await open.get(refusals))[1], tooOften);
  // A server that is too busy does not report the type of the rejected message.
  await open.get(() => {
    document.querySelector("#method-1").value = "basic";
    document.querySelector("#wall").checked = true;
  });
  await refused("", "too many requests at once; send this one again");
  assert.deepEqual(await open.get(() => [document.querySelector("#method-1").value, document.querySelector("#wall").checked]), ["coupled", false]);
  await open.leave();
  await live.end();
  live.forget();
});

test("a method that safety stops is shown; another one, rearmed, holds the same wall", async () => {
  const live = await startLive("--method", "basic");
  const open = await visit(live.url);
  const dampingShown = () => !document.querySelector('[data-name="damping-1"]').closest("[hidden]");
  assert.equal(await open.get(dampingShown), false, "basic takes no damping");
  await open.get(() => palpate.link.say({ type: "set", stiffness_n_per_m: 5000, mass_kg: null }));
  await open.until("it is a wall", () => palpate.model.state.mass_kg === null);
  await press(open, -0.01);
  await press(open, 0.01);
  await open.until("it has stopped", () => palpate.model.state.lanes[0].safety_stop !== null);
  const banner = await open.until("the safety stop is shown", () => document.querySelector('[data-about="safety-stop-1"] p')?.textContent);
  assert.match(banner, /basic: no force, because .*oscillates/);
  await open.until("there is no force", () => palpate.model.newest(0, "force_on_device_n") === 0);
  await open.page.select("#method-1", "coupled");
  await open.until("it is coupled", () => palpate.model.state.lanes[0].method === "coupled");
  // The method has changed since the oscillation.
  const says = await open.until("the banner names both", () => {
    const text = document.querySelector('[data-about="safety-stop-1"] p')?.textContent;
    return /coupled renders now/.test(text) && text;
  });
  assert.match(says, /^Rendering 1: no force, because of the previous method basic/);
  await press(open, -0.01);
  await open.page.click('[data-about="safety-stop-1"] button');
  await open.until("it is armed", () => palpate.model.state.lanes[0].safety_stop === null);
  await press(open, 0.01);
  const { forceN } = await held(open);
  assert.ok(forceN < -2, `${forceN} N`);
  assert.equal(await open.get(() => document.querySelector('[data-about="safety-stop-1"]')), null);
  await open.leave();
  await live.end();
  live.forget();
});

test("a second lane is in the same hand, and can be switched off again", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.page.click("#second-lane");
  await open.until("there are two", () => palpate.model.state.lanes.length === 2);
  await open.until("both have curves", () => palpate.model.lanes.every(({ ring }) => ring.length > 30));
  const names = () => [...document.querySelectorAll("#chart-force .lanes th:not([hidden])")].map((head) => head.textContent);
  assert.deepEqual(await open.get(names), ["coupled", "basic"]);
  await open.get(() => palpate.link.say({ type: "hand", position_m: -0.02 }));
  await open.until("both devices follow", () =>
    [0, 1].every((lane) => Math.abs(palpate.model.newest(lane, "device_position_m") + 0.02) < 8e-3),
  );
  await open.page.select("#method-2", "virtual-damper");
  await open.until("it is another", () => palpate.model.state.lanes[1].method === "virtual-damper");
  await open.page.click("#second-lane");
  await open.until("there is one", () => palpate.model.state.lanes.length === 1);
  await open.until("it has left nothing", () => palpate.model.lanes[1].ring.length === 0);
  assert.deepEqual(await open.get(names), ["coupled"]);
  await open.leave();
  await live.end();
  live.forget();
});

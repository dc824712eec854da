import assert from "node:assert/strict";
import { test } from "node:test";
import { Model } from "../../../crates/palpate-live/page/model.js";
import { readSamples } from "../../../crates/palpate-live/page/protocol.js";
import { frameOf } from "./frames.mjs";

const HELLO = {
  type: "hello",
  protocol: 1,
  title: "a scene",
  columns: [{ name: "force_on_device_n", unit: "N" }],
  device: { lanes: 2 },
};

function stateOf(changes = {}) {
  const lane = (method) => ({ method, damping_n_s_per_m: null, running: true, safety_stop: null });
  const base = { stiffness_n_per_m: 400, mass_kg: 0.1, virtual_force_n: -1, period_s: 0.001, recording: null, hand_m: 0 };
  return { type: "state", ...base, lanes: [lane("basic"), lane("coupled")], ...changes };
}

function begun() {
  const model = new Model(100);
  model.take(HELLO);
  model.take(stateOf());
  return model;
}

const frame = (how) => readSamples(frameOf({ rows: how.times.map((time) => [10 * time]), ...how }), 1);
const gaps = (ring) => Array.from({ length: ring.length }, (_, row) => ring.isGap(row)).filter(Boolean).length;

test("rows come in, with what they were rendered with", () => {
  const model = begun();
  model.takeSamples(frame({ times: [0, 0.001] }));
  model.take(stateOf({ period_s: 0.00025 }));
  model.take(stateOf({ period_s: 0.00025, hand_m: 3 }));
  model.takeSamples(frame({ times: [0.002], number: 1 }));
  const [{ ring }] = model.lanes;
  assert.equal(ring.length, 3);
  assert.equal(model.newestS, 0.002);
  assert.ok(Math.abs(model.newest(0, "force_on_device_n") - 0.02) < 1e-8);
  assert.ok(Number.isNaN(model.newest(1, "force_on_device_n")));
  assert.equal(model.settings.length, 2, "a hand that moves is no setting");
  assert.deepEqual([...ring.settings.slice(0, 3)], [0, 0, 1]);
  assert.deepEqual([0, 1, 2].map((row) => ring.isGrouped(row)), [false, false, true]);
});

test("a frame that was dropped is counted, and leaves a gap", () => {
  const model = begun();
  model.takeSamples(frame({ times: [0] }));
  model.takeSamples(frame({ times: [1], number: 3 }));
  assert.equal(model.droppedFrames, 2);
  assert.equal(gaps(model.lanes[0].ring), 1);
  assert.equal(model.lanes[0].ring.timeS[1], 0.5);
});

test("another run begins anew in both lanes, and what is late of the one before is not taken", () => {
  const model = begun();
  let anew = 0;
  model.addEventListener("anew", () => {
    anew += 1;
  });
  model.takeSamples(frame({ times: [5] }));
  model.takeSamples(frame({ times: [5], lane: 1 }));
  assert.equal(anew, 1);
  model.takeSamples(frame({ times: [0], run: 2 }));
  model.takeSamples(frame({ times: [5.1], lane: 1, number: 1 }));
  model.takeSamples(frame({ times: [0.1], run: 2, lane: 1, number: 2 }));
  model.takeSamples(frame({ times: [0.1], run: 2, number: 1 }));
  assert.equal(anew, 2);
  assert.deepEqual(model.lanes.map(({ ring }) => ring.firstS), [0, 0.1]);
});

test("a new connection goes on where it is the same loop, and begins anew where it is another", () => {
  let nowS = 50;
  const model = new Model(100, [() => nowS]);
  const connect = () => {
    model.take(HELLO);
    model.take(stateOf());
  };
  connect();
  model.takeSamples(frame({ times: [5] }));
  nowS = 51.2;
  connect();
  model.takeSamples(frame({ times: [6] }));
  assert.equal(model.lanes[0].ring.length, 3);
  assert.equal(gaps(model.lanes[0].ring), 1);
  assert.equal(model.droppedFrames, 0);
  connect();
  model.takeSamples(frame({ times: [2] }));
  assert.deepEqual(model.lanes[0].ring.lastS, 2, "time has gone back");
  model.takeSamples(frame({ times: [2.1], number: 1 }));
  model.takeSamples(frame({ times: [2.1], lane: 1 }));
  assert.deepEqual(model.lanes.map(({ ring }) => ring.length), [2, 1], "a run of the same number goes on");
  nowS += 10;
  connect();
  model.takeSamples(frame({ times: [8] }));
  assert.equal(model.lanes[0].ring.length, 1, "it has begun since");
  assert.equal(model.lanes[1].ring.length, 0);
});

test("a computer that has slept goes on with the loop that has not", () => {
  let [awakeS, todayS] = [50, 1e9];
  const model = new Model(100, [() => awakeS, () => todayS]);
  const connect = () => {
    model.take(HELLO);
    model.take(stateOf());
  };
  connect();
  model.takeSamples(frame({ times: [5] }));
  awakeS += 2;
  todayS += 600;
  connect();
  model.takeSamples(frame({ times: [605] }));
  assert.equal(model.lanes[0].ring.firstS, 5);
  assert.equal(gaps(model.lanes[0].ring), 1);
  // The system clock was set meanwhile.
  awakeS += 3;
  todayS -= 3600;
  connect();
  model.takeSamples(frame({ times: [608] }));
  assert.equal(model.lanes[0].ring.firstS, 5);
  awakeS += 3;
  todayS += 60;
  connect();
  model.takeSamples(frame({ times: [630] }));
  assert.equal(model.lanes[0].ring.firstS, 630, "by no clock is it the same");
});

test("another scene begins anew, though its run has the number of the one before", () => {
  const model = begun();
  let anew = 0;
  model.addEventListener("anew", () => {
    anew += 1;
  });
  model.takeSamples(frame({ times: [90] }));
  model.takeSamples(frame({ times: [91], number: 2 }));
  model.take({ type: "note", lane: 0, t_s: 90, kind: "stopped", text: "of the one before" });
  model.take(HELLO);
  assert.deepEqual([anew, model.notes.length, model.droppedFrames], [1, 1, 1], "the same again is no other");
  model.take({ ...HELLO, title: "another scene" });
  model.take(stateOf());
  model.takeSamples(frame({ times: [0] }));
  assert.deepEqual([anew, model.notes.length, model.droppedFrames], [2, 0, 0]);
  assert.equal(model.lanes[0].ring.length, 1);
  model.takeSamples(frame({ times: [1], number: 1 }));
  assert.equal(model.lanes[0].ring.length, 2);
  assert.equal(anew, 2);
});

test("a full buffer that is being looked at keeps what it has, and counts what it cannot take", () => {
  const model = new Model(3);
  model.take(HELLO);
  model.take(stateOf());
  model.takeSamples(frame({ times: [0, 1, 2] }));
  model.takeSamples(frame({ times: [3, 4], number: 1 }), 0);
  assert.equal(model.refusedRows, 2);
  assert.equal(model.lanes[0].ring.lastS, 2);
  model.takeSamples(frame({ times: [5], number: 2 }));
  assert.equal(gaps(model.lanes[0].ring), 1);
  assert.equal(model.lanes[0].ring.lastS, 5);
});

test("a lane that is switched off leaves nothing", () => {
  const model = begun();
  model.takeSamples(frame({ times: [1], lane: 1 }));
  model.take(stateOf({ lanes: stateOf().lanes.slice(0, 1) }));
  assert.equal(model.lanes[1].ring.length, 0);
});

test("a spike of one tick in a group is no mean, and the newest group is drawn by what it has always been", () => {
  const model = begun();
  model.take(stateOf({ period_s: 0.00025 }));
  const groups = (times, values, number) => frame({ times, rows: values.map((value) => [value]), number });
  const recent = () => model.recent(0, "force_on_device_n", 0.1);
  // 8 ticks, one of them with 10 N: their mean is 1.25 N, which is unknown here.
  model.takeSamples(groups([0, 0.00175], [0, 10], 0));
  assert.deepEqual(recent(), { least: 0, greatest: 10, mean: NaN, grouped: true, nearest: 0 });
  model.takeSamples(groups([0.002, 0.00375], [-3, -2], 1));
  assert.deepEqual(recent(), { least: -3, greatest: 10, mean: NaN, grouped: true, nearest: -2 });
  model.takeSamples(groups([0.15, 0.151], [-1, 4], 2));
  assert.deepEqual(recent(), { least: -1, greatest: 4, mean: NaN, grouped: true, nearest: 0 }, "the earlier ones are past");
  model.takeSamples(groups([0.3, 0.301], [4, 3], 3));
  assert.equal(recent().nearest, 3);
});

test("of ticks there is a mean, and the newest is drawn", () => {
  const model = begun();
  assert.deepEqual(model.recent(1, "force_on_device_n", 0.1), { least: Infinity, greatest: -Infinity, mean: NaN, grouped: false, nearest: NaN });
  model.takeSamples(frame({ times: [0, 0.05, 0.06, 0.07, 0.125], rows: [[100], [0], [10], [NaN], [2]] }));
  assert.deepEqual(model.recent(0, "force_on_device_n", 0.1), { least: 0, greatest: 10, mean: 4, grouped: false, nearest: 2 });
});

/** The stiffness of each row of a rendering, by the row's number. */
const stiffnesses = (model, { ring }) =>
  Array.from({ length: ring.length }, (_, row) => model.settings[ring.settings[ring.place(row)] - model.settingsFrom].stiffness_n_per_m);

test("settings are kept as long as there are rows of them, and no longer", () => {
  const model = new Model(6);
  model.take(HELLO);
  const set = (stiffness_n_per_m) => model.take(stateOf({ stiffness_n_per_m }));
  for (let k = 0; k < 1000; k += 1) {
    set(k);
  }
  assert.equal(model.settings.length, 1, "nothing was rendered with those before");
  for (let k = 0; k < 200; k += 1) {
    set(1000 + 3 * k);
    set(1001 + 3 * k);
    // Now and then a frame is lost.
    model.takeSamples(frame({ times: [k, k + 0.5], number: k + Math.floor(k / 10) }));
  }
  const [lane] = model.lanes;
  assert.deepEqual(stiffnesses(model, lane), [1592, 1592, 1595, 1595, 1598, 1598]);
  assert.ok(model.settings.length <= 4, `${model.settings.length} kept`);
  // The other rendering keeps the settings of its rows.
  model.takeSamples(frame({ times: [200], lane: 1 }));
  for (let k = 0; k < 20; k += 1) {
    set(2000 + k);
    model.takeSamples(frame({ times: [200 + k], number: 1000 + k }));
  }
  assert.deepEqual(stiffnesses(model, model.lanes[1]), [1598]);
  assert.equal(model.settings.length, 21);
  // There and back before any row arrived: nothing has changed.
  set(1);
  set(2019);
  assert.equal(model.settings.length, 21);
  model.takeSamples(frame({ times: [0], run: 2 }));
  assert.equal(model.settings.length, 1);
  set(3);
  model.takeSamples(frame({ times: [1], run: 2, number: 1 }));
  assert.deepEqual(stiffnesses(model, lane), [2019, 3]);
});

const stopped = (...running) => stateOf({ lanes: stateOf().lanes.map((lane, i) => ({ ...lane, running: running[i] })) });

function heardOf(model) {
  const heard = [];
  model.addEventListener("ended", ({ detail }) => heard.push(detail));
  return heard;
}

test("a loop that is over is said to be so until all lanes run again", () => {
  const model = begun();
  const heard = heardOf(model);
  model.takeSamples(frame({ times: [5] }));
  model.take({ type: "ended", text: "lane 2: the device is lost" });
  model.take(stopped(true, false));
  model.take({ ...stopped(true, false), hand_m: 0.01 });
  model.takeSamples(frame({ times: [5.1], number: 1 }));
  assert.deepEqual(heard, ["lane 2: the device is lost"], "rows of the other lane change nothing");
  model.take(stateOf());
  assert.equal(model.ended, null);
  model.takeSamples(frame({ times: [0], run: 2 }));
  assert.deepEqual(heard, ["lane 2: the device is lost", null]);
});

test("rows of a new run say that it goes on, before any state does; one that has ended, too, stays over", () => {
  const model = begun();
  model.takeSamples(frame({ times: [5] }));
  model.take({ type: "ended", text: "the device is lost" });
  model.takeSamples(frame({ times: [0], run: 2 }));
  assert.equal(model.ended, null);
  model.take({ type: "ended", text: "it is lost again" });
  // Rows of a third run arrive after the message of its end.
  model.takeSamples(frame({ times: [0], run: 3 }));
  model.take(stopped(false, false));
  assert.equal(model.ended, "it is lost again");
});

test("who comes to a loop that is over is told", () => {
  const model = new Model(10);
  const heard = heardOf(model);
  model.take(HELLO);
  model.take(stopped(true, false));
  model.takeSamples(frame({ times: [3] }));
  assert.deepEqual(heard, ["press Restart to start it again"]);
  model.take(HELLO);
  model.take(stateOf());
  assert.equal(model.ended, null);
});

test("a server of another protocol is not taken for one of this", () => {
  assert.throws(() => new Model(3).take({ ...HELLO, protocol: 2 }), /protocol 2, this page 1/);
});

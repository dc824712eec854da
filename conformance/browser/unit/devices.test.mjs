import assert from "node:assert/strict";
import { test } from "node:test";
import { CHARTS } from "../../../crates/palpate-live/page/curves.js";
import { chartsOf, devicesOf, forcesInWords, handsOf } from "../../../crates/palpate-live/page/devices.js";
import { say } from "../../../crates/palpate-live/page/protocol.js";

const tool = (name) => ({ name, shape: {}, position_m: [0, 0, 0], turns: false, orientation: [1, 0, 0, 0] });
const one = { device: { name: "pointer", pointer: true }, world: { tools: [tool("left")] } };
const two = {
  device: one.device,
  further_devices: [{ name: "Inverse3", pointer: false }],
  world: { tools: [tool("left"), tool("right")] },
};

test("the devices are those of hello, each with its tool, its kind and the column of its force", () => {
  assert.deepEqual(devicesOf(one).map(({ force }) => force), ["force_on_device_n"]);
  const parts = devicesOf(two).map(({ name, kind, pointer, force }) => [name, kind, pointer, force]);
  assert.deepEqual(parts, [
    ["left", "pointer", true, "force_on_device_n"],
    ["right", "Inverse3", false, "force_on_device_n right"],
  ]);
});

test("the hands are that of the state, and the further ones", () => {
  assert.deepEqual(handsOf(null), []);
  assert.equal(handsOf({ hand_m: null }).length, 1);
  const state = { hand_m: [1, 2, 3], further_hands: [{ hand_m: [4, 5, 6], hand_orientation: null }] };
  assert.deepEqual(handsOf(state).map(({ hand_m: at }) => at), [[1, 2, 3], [4, 5, 6]]);
});

test("each of several devices has a curve of its force, and one has the chart that it had", () => {
  assert.equal(chartsOf(CHARTS, devicesOf(one)), CHARTS);
  const { title, curves } = chartsOf(CHARTS, devicesOf(two)).find(({ id }) => id === "force");
  assert.equal(title, "Force on each device");
  assert.deepEqual(curves.map(({ name }) => name), ["left", "right"]);
  assert.notDeepEqual(curves[0].dash, curves[1].dash);
});

test("the forces are said by the names of the devices where there are several", () => {
  assert.equal(forcesInWords(["left"], [{ method: "basic", forces: ["1 N"] }]), "Force on the device now: 1 N.");
  const lanes = [{ method: "basic", forces: ["1 N", "2 N"] }, { method: "coupled", forces: ["3 N", "4 N"] }];
  assert.equal(forcesInWords(["left", "right"], lanes.slice(1)), "Force on each device now: left\u00a03\u00a0N, right\u00a04\u00a0N.");
  assert.equal(
    forcesInWords(["left", "right"], lanes),
    "Force on each device now: basic: left 1 N, right 2 N; coupled: left 3 N, right 4 N.".replace(/(left|right) (.) N/g, "$1\u00a0$2\u00a0N"),
  );
});

test("a message names its device where that is not the first", () => {
  assert.deepEqual(say.tool([1, 2, 3]), { type: "tool", position_m: [1, 2, 3] });
  assert.deepEqual(say.tool(null, 1), { type: "tool", device: 1, position_m: null });
  assert.deepEqual(say.turn([1, 0, 0, 0], 2), { type: "turn", device: 2, orientation: [1, 0, 0, 0] });
});

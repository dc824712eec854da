// The page of a world: it draws without a graphics processor, bodies move, and the hand is led in three dimensions.

import assert from "node:assert/strict";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { startLive } from "../program.mjs";
import { visit } from "../visit.mjs";

const BLOCK = fileURLToPath(new URL("../../../experiments/worlds/pushed-block.toml", import.meta.url));

const PLUG = fileURLToPath(new URL("../../../experiments/worlds/plug.toml", import.meta.url));

const toolAt = (lane) => palpate.space.lanes[lane].tools[0].position.toArray();
const blockAt = (lane) => palpate.space.lanes[lane].bodies[0].position.toArray();

/** How many pixels of the canvas differ from its corner: what is drawn at all. */
const drawn = () => {
  const copy = document.createElement("canvas");
  Object.assign(copy, { width: 200, height: 200 });
  const context = copy.getContext("2d");
  context.drawImage(document.querySelector("#space"), 0, 0, 200, 200);
  const { data } = context.getImageData(0, 0, 200, 200);
  let count = 0;
  for (let at = 0; at < data.length; at += 4) {
    count += Math.abs(data[at] - data[0]) + Math.abs(data[at + 1] - data[1]) > 20 ? 1 : 0;
  }
  return count;
};

test("a world is drawn, and a tool that is dragged pushes its block", async () => {
  const live = await startLive(BLOCK, "--method", "coupled", "--priority", "0");
  const open = await visit(live.url);
  await open.until("the block has come", () => palpate.space.lanes.length === 1 && palpate.space.lanes[0].arrows.shown > 0);
  assert.ok((await open.get(drawn)) > 2000, "there is something on the canvas");
  const triangles = await open.get(() => palpate.space.triangles);
  assert.ok(triangles > 100 && triangles < 100_000, `${triangles} triangles`);
  const [blockBefore, toolBefore] = [await open.get(blockAt, 0), await open.get(toolAt, 0)];

  // By keys, into the block: along x.
  await open.page.focus("#space");
  for (let step = 0; step < 12; step += 1) {
    await open.page.keyboard.press("ArrowRight");
  }
  await open.until("the hand was led", (x) => palpate.model.state.hand_m?.[0] > x + 0.01, toolBefore[0]);
  await open.until("the block has moved", (x) => palpate.space.lanes[0].bodies[0].position.x > x + 0.002, blockBefore[0]);
  const [, , blockZ] = await open.get(blockAt, 0);
  assert.ok(Math.abs(blockZ - blockBefore[2]) < 2e-3, "it stays on the table");

  // By the mouse: where the pointer goes the hand goes, in the plane that faces the camera.
  const { mouse } = open.page;
  const corner = await open.get(() => {
    const { x, y } = document.querySelector("#space").getBoundingClientRect();
    return [x, y];
  });
  const [x, y] = await open.get(() => palpate.space.toolOnCanvas());
  const before = await open.get(() => palpate.model.state.hand_m);
  await mouse.move(corner[0] + x, corner[1] + y);
  await mouse.down();
  await mouse.move(corner[0] + x, corner[1] + y - 40, { steps: 5 });
  await mouse.up();
  await open.until("the hand was lifted", (z) => palpate.model.state.hand_m?.[2] > z + 2e-3, before[2]);
  // The wheel leads it away from whoever looks.
  const near = await open.get(() => palpate.model.state.hand_m);
  await mouse.wheel({ deltaY: -300 });
  await open.until(
    "the hand went away",
    (from) => Math.hypot(...palpate.model.state.hand_m.map((x, axis) => x - from[axis])) > 2e-3,
    near,
  );
  await open.page.keyboard.press("Escape");
  await open.until("the hand has let go", () => palpate.model.state.hand_m === null);
  assert.equal(await open.get(() => palpate.model.droppedFrames >= 0), true);
  await open.shot?.("world");
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("the tool of a device of six axes is turned by the mouse and by keys", async () => {
  const live = await startLive(PLUG, "--method", "coupled", "--priority", "0");
  const open = await visit(live.url);
  const turnedAt = () => palpate.space.lanes[0].tools[0].quaternion.toArray();
  await open.until("the world has come", () => palpate.space.lanes.length === 1 && palpate.model.newestS > 0);
  await open.page.focus("#space");
  await open.page.keyboard.press("y");
  await open.until("the hand was turned", () => palpate.model.state.hand_orientation !== null);
  const byKey = await open.get(() => palpate.model.state.hand_orientation);
  for (let step = 0; step < 9; step += 1) {
    await open.page.keyboard.press("y");
  }
  // Ten degrees about y, from where the scene begins.
  await open.until("and on", (y) => palpate.model.state.hand_orientation[2] > y + 0.07, byKey[2]);
  await open.until("the tool turns after it", (y) => palpate.space.lanes[0].tools[0].quaternion.y > y + 0.03, byKey[2]);
  const corner = await open.get(() => {
    const { x, y } = document.querySelector("#space").getBoundingClientRect();
    return [x, y];
  });
  const [x, y] = await open.get(() => palpate.space.toolOnCanvas());
  const before = await open.get(() => palpate.model.state.hand_orientation);
  await open.page.keyboard.down("Control");
  await open.page.mouse.move(corner[0] + x, corner[1] + y);
  await open.page.mouse.down();
  await open.page.mouse.move(corner[0] + x + 60, corner[1] + y, { steps: 5 });
  await open.page.mouse.up();
  await open.page.keyboard.up("Control");
  const isTurned = (from) => {
    const now = palpate.model.state.hand_orientation;
    return Math.abs(now.reduce((sum, part, k) => sum + part * from[k], 0)) < Math.cos(0.15);
  };
  await open.until("the pointer has rolled it", isTurned, before);
  assert.equal((await open.get(turnedAt)).length, 4);
  // A hand that has let go takes hold of the tool again, where and as it is.
  await open.page.focus("#space");
  await open.page.keyboard.press("Escape");
  await open.until("the hand has let go", () => palpate.model.state.hand_m === null);
  await open.page.keyboard.press("x");
  const isTurnedOn = () => {
    const { state } = palpate.model;
    const [w, x, y, z] = state.hand_orientation ?? [1, 0, 0, 0];
    const tool = palpate.space.lanes[0].tools[0].quaternion;
    return state.hand_m !== null && Math.abs(w * tool.w + x * tool.x + y * tool.y + z * tool.z) > Math.cos(0.02);
  };
  await open.until("it turns the tool from there", isTurnedOn);
  await open.page.click("#restart");
  await open.until("it begins as it began", () => palpate.model.state.hand_orientation === null);
  await open.shot?.("six-axes");
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("two methods stand side by side, and begin anew", async () => {
  const live = await startLive(BLOCK, "--method", "basic,coupled", "--priority", "0");
  const open = await visit(live.url);
  await open.until("both lanes have come", () => palpate.space.lanes.length === 2 && palpate.model.newest(1, "force_on_device_n") >= 0);
  const names = await open.get(() => [...document.querySelectorAll("#names span")].map((name) => name.textContent));
  assert.deepEqual(names, ["basic", "coupled"]);
  const run = await open.get(() => palpate.model.run);
  await open.page.click("#restart");
  await open.until("another run", (before) => palpate.model.run !== before, run);
  await open.leave();
  await live.endsWell();
  live.forget();
});

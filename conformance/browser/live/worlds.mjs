// The page of a world: it draws without a graphics processor, bodies move, and the hand moves in three dimensions.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { startLive } from "../program.mjs";
import { visit } from "../visit.mjs";

const BLOCK = fileURLToPath(new URL("../../../experiments/worlds/pushed-block.toml", import.meta.url));

const PLUG = fileURLToPath(new URL("../../../experiments/worlds/plug.toml", import.meta.url));

const toolAt = (lane) => palpate.space.lanes[lane].tools[0].position.toArray();
const blockAt = (lane) => palpate.space.lanes[lane].bodies[0].position.toArray();

/** Whether enough pixels of the canvas differ from its corner. Between two frames it may be empty. */
const isDrawn = () => {
  const copy = document.createElement("canvas");
  Object.assign(copy, { width: 200, height: 200 });
  const context = copy.getContext("2d");
  context.drawImage(document.querySelector("#space"), 0, 0, 200, 200);
  const { data } = context.getImageData(0, 0, 200, 200);
  let count = 0;
  for (let at = 0; at < data.length; at += 4) {
    count += Math.abs(data[at] - data[0]) + Math.abs(data[at + 1] - data[1]) > 20 ? 1 : 0;
  }
  return count > 2000;
};

test("a world is drawn, and a tool that is dragged pushes its block", async () => {
  const live = await startLive(BLOCK, "--method", "coupled", "--priority", "0");
  const open = await visit(live.url);
  await open.until("the block has come", () => palpate.space.lanes.length === 1 && palpate.space.lanes[0].arrows.shown > 0);
  await open.until("the world is on the canvas", isDrawn);
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

  // By the mouse: the hand follows the pointer in the plane that faces the camera.
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
  // The wheel moves it away from the viewer.
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
  // Ten degrees about y, from the start of the scene.
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
  // After its release the hand grasps the tool again, in its present pose.
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

const BALL = `format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
position_m = [0.0, 0.0, 0.075]
tool = { sphere = { radius_m = 0.008 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }
[[body]]
name = "ball"
fixed = true
position_m = [0.0, 0.0, 0.03]
shape = { sphere = { radius_m = 0.03 } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 1000.0
[model]
device_mass_kg = 0.2
[render]
method = "coupled"
`;

/** Returns the brightness of the picture at a position in the world, by the formula of WCAG. */
const brightness = (place) => {
  const { space } = palpate;
  const { canvas, camera } = space;
  space.draw();
  const at = camera.position.clone().set(...place).project(camera);
  const copy = document.createElement("canvas");
  Object.assign(copy, { width: canvas.width, height: canvas.height });
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const [x, y] = [((at.x + 1) / 2) * canvas.width, ((1 - at.y) / 2) * canvas.height];
  const [r, g, b] = [...context.getImageData(Math.round(x), Math.round(y), 1, 1).data].map((byte) => {
    const part = byte / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};

test("a fixed ball stands out from the plane under it, in both schemes", async () => {
  const folder = mkdtempSync(join(tmpdir(), "palpate-ball-"));
  const scene = join(folder, "ball.toml");
  writeFileSync(scene, BALL);
  const live = await startLive(scene, "--priority", "0");
  for (const scheme of ["light", "dark"]) {
    const open = await visit(live.url, { scheme });
    await open.until("the world has come", () => palpate.space.lanes.length === 1 && palpate.model.newestS > 0);
    // Beside it.
    const plane = await open.get(brightness, [0.043, -0.025, 0]);
    // Its centre, and its side away from the light.
    const ball = [await open.get(brightness, [-0.007, -0.012, 0.043]), await open.get(brightness, [-0.012, -0.024, 0.018])];
    const contrasts = ball.map((shade) => (Math.max(shade, plane) + 0.05) / (Math.min(shade, plane) + 0.05));
    const said = contrasts.map((contrast) => contrast.toFixed(2)).join(" and ");
    assert.ok(Math.max(...contrasts) > 1.5, `${scheme}: contrasts of ${said} with the plane`);
    await open.leave();
  }
  await live.endsWell();
  live.forget();
  rmSync(folder, { recursive: true });
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { WIDE } from "../visit.mjs";
import { play } from "./open.mjs";

test("every world of the gallery runs by both methods, and everything in it is a number", async (t) => {
  const { open, leave } = await play("#world=pinch");
  await open.until("it runs", () => palpate.worlds.now?.t_s > 0.1);
  const names = await open.get(() => [...document.querySelectorAll("#gallery button")].map(({ dataset }) => dataset.world));
  assert.ok(names.length >= 5);
  for (const name of names) {
    await open.page.click(`#gallery [data-world="${name}"]`);
    const runs = (name) => palpate.worlds.shown === name && palpate.worlds.now?.t_s > 1 && palpate.worlds.now;
    const now = await open.until(`${name} runs`, runs, name);
    assert.ok((await open.get(() => location.hash)).startsWith(`#world=${name}&`));
    assert.deepEqual(now.lanes.map(({ method }) => method), ["basic", "coupled"]);
    for (const lane of now.lanes) {
      const numbers = JSON.stringify(lane).match(/null|-?\d[\d.e+-]*/g);
      assert.ok(numbers.length > 5 && !numbers.includes("null"), `${name}: ${JSON.stringify(lane)}`);
      assert.equal(lane.refused, 0);
    }
    const pace = await open.get(() => palpate.pace);
    t.diagnostic(`${name}: ${pace.ratio.toFixed(3)} of real time, ${(100 * pace.busy).toFixed(0)} % of a processor`);
  }
  await leave();
});

test("a ball that has fallen off the paddle stops the loop, says so, and comes back by a restart", async () => {
  const { open, leave } = await play("#world=paddle");
  const words = /The loop has stopped: the \w+ of \w+ is 1\d(\.\d+)? m away/;
  await open.until("it is said", (source) => new RegExp(source).test(document.querySelector("#banners").textContent), words.source);
  const flown = await open.get(() => Math.max(...palpate.worlds.now.lanes.map(({ bodies }) => Math.hypot(...bodies[0][0]))));
  assert.ok(flown > 10 && flown < 20, `${flown} m`);
  await open.page.click("#restart");
  await open.until("it begins anew", () => palpate.worlds.now?.t_s < 1 && document.querySelector("#banners").textContent === "");
  await leave();
});

test("two hands pinch the cube and lift it", async () => {
  const { open, leave } = await play("#world=pinch");
  const lead = (left, right) =>
    open.get((places) => places.forEach((to, device) => palpate.link.ask({ type: "lead", device, to })), [left, right]);
  await open.until("it runs", () => palpate.worlds.now?.t_s > 0.1);
  await lead([-0.014, 0, 0.016], [0.014, 0, 0.016]);
  await open.until("both press", () => palpate.worlds.now.lanes.every(({ forces_n }) => Math.abs(forces_n[0][0]) > 1 && Math.abs(forces_n[1][0]) > 1));
  await lead([-0.014, 0, 0.036], [0.014, 0, 0.036]);
  await open.until("the cube is lifted by both methods", () => palpate.worlds.now.lanes.every(({ bodies }) => bodies[0][0][2] > 0.025));
  await open.until("it is said what was created", () => /Left \(basic\) .*; right \(coupled\) /.test(document.querySelector("#world-seen").textContent));
  await leave();
});

test("where there is less room, the views of a world become lower and cover nothing", async () => {
  const { open, leave } = await play("#world=groove-90", { viewport: WIDE });
  await open.until("both are drawn", () => [...document.querySelectorAll("#world-lanes canvas")].filter(({ height }) => height > 400).length === 2);
  await open.page.setViewport({ ...WIDE, height: WIDE.height - 200 });
  await open.until("all of each view is within the frame of the views", () => {
    const { top } = document.querySelector("#world-lanes").nextElementSibling.getBoundingClientRect();
    const views = [...document.querySelectorAll("#world-lanes canvas")].map((canvas) => canvas.getBoundingClientRect());
    return innerHeight < 800 && views.length === 2 && views.every((view) => view.height > 200 && view.bottom <= top + 1);
  });
  await leave();
});

test("a tool is dragged as it is seen, keys move it, and beside it the view turns", async () => {
  const { open, leave } = await play("#world=groove-90");
  await open.until("it runs", () => palpate.worlds.now?.t_s > 0.1);
  const [x, y] = await open.get(() => {
    const { canvas } = palpate.worlds.lanes[0];
    const { left, top } = canvas.getBoundingClientRect();
    const [x, y] = palpate.worlds.camera.frame(canvas).at(palpate.worlds.now.lanes[0].tools_m[0]);
    return [left + x, top + y];
  });
  const target = () => palpate.worlds.now.targets_m[0];
  const start = await open.get(target);
  await open.page.mouse.move(x, y);
  await open.page.mouse.down();
  await open.page.mouse.move(x, y - 40, { steps: 4 });
  await open.page.mouse.up();
  // The loop receives a drag in parts: only the final target shows the effect of the key.
  const settled = () => {
    const { drag, targets, now } = palpate.worlds;
    return !drag && targets[0].every((x, axis) => x === now.targets_m[0][axis]) && now.targets_m[0];
  };
  const lifted = await open.until("the drag has come to the loop", settled);
  assert.ok(lifted[2] > start[2] + 0.001, `led from ${start} to ${lifted}`);
  await open.page.keyboard.press("ArrowDown");
  await open.until("a key moves it", (z) => palpate.worlds.now.targets_m[0][2] < z - 5e-4, lifted[2]);
  const yaw = await open.get(() => palpate.worlds.camera.yaw);
  await open.page.mouse.move(x - 200, y + 150);
  await open.page.mouse.down();
  await open.page.mouse.move(x - 120, y + 150, { steps: 4 });
  await open.page.mouse.up();
  assert.notEqual(await open.get(() => palpate.worlds.camera.yaw), yaw);
  await leave();
});

test("from worlds back to one contact, and both go on", async () => {
  const { open, leave } = await play();
  await open.page.click("#view-worlds");
  await open.until("a world runs", () => palpate.worlds.now?.t_s > 0.2);
  await open.page.click("#view-contact");
  await open.until("the contact runs again", () => !document.querySelector("#contact-view").hidden && palpate.model.newestS > 0.2);
  await leave();
});

// The page of a world with two devices: one mouse moves one of them, the other one, or both.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { startLive } from "../program.mjs";
import { NARROW, visit } from "../visit.mjs";

const PINCH = fileURLToPath(new URL("../../../experiments/worlds/pinch.toml", import.meta.url));
const ARGUMENTS = [PINCH, "--method", "coupled", "--priority", "0"];

/** Saves a picture, if pictures are requested. */
async function picture(open, name) {
  const folder = process.env.PALPATE_SCREENSHOTS;
  if (folder) {
    mkdirSync(folder, { recursive: true });
    await open.page.screenshot({ path: join(folder, `${name}.png`), fullPage: name.endsWith("narrow") });
  }
}

const handAt = (number) => [palpate.model.state, ...palpate.model.state.further_hands][number].hand_m;
const labels = () => [...document.querySelectorAll("#devices label")].map(({ textContent }) => textContent);
const chosen = () => document.querySelector("#devices input:checked").parentElement.textContent;

/** Drags from a tool, or from a free position, by this many pixels. */
async function drag(open, number, [dx, dy]) {
  const [x, y] = await open.get((number) => {
    const box = document.querySelector("#space").getBoundingClientRect();
    const [x, y] = number === null ? [30, 30] : palpate.space.toolOnCanvas(0, number);
    return [box.x + x, box.y + y];
  }, number);
  const { mouse } = open.page;
  await mouse.move(x, y);
  await mouse.down();
  await mouse.move(x + dx, y + dy, { steps: 5 });
  await mouse.up();
}

const apart = (a, b) => Math.hypot(...a.map((x, axis) => x - b[axis]));

/** Waits until the selected hands have moved by more than 2 mm, and checks that the others have not. */
async function moved(open, before, areMoved) {
  for (const [number, isMoved] of areMoved.entries()) {
    if (isMoved) {
      await open.until(
        `hand ${number} has moved`,
        (number, from) => {
          const hand = [palpate.model.state, ...palpate.model.state.further_hands][number].hand_m;
          return Math.hypot(...hand.map((x, axis) => x - from[axis])) > 2e-3;
        },
        number,
        before[number],
      );
    }
  }
  // The request is complete: the drag has ended for the server too.
  await open.until("the hands are where they are to be", () => palpate.hand.hands.every(({ led }) => led.value === null));
  const after = await Promise.all([0, 1].map((number) => open.get(handAt, number)));
  const still = areMoved.map((isMoved, number) => isMoved || apart(after[number], before[number]) < 1e-9);
  assert.deepEqual(still, [true, true], `only the hands that were led move: ${JSON.stringify([before, after])}`);
  return after;
}

test("of two devices the one that is taken hold of moves, then the other one, then both", async () => {
  const live = await startLive(...ARGUMENTS);
  const open = await visit(live.url);
  await open.until("both tools have come", () => palpate.space.lanes[0]?.tools.length === 2 && palpate.model.newestS > 0.1);
  assert.deepEqual(await open.get(labels), ["left", "right", "both"]);
  assert.equal(await open.get(chosen), "left");
  const names = await open.get(() => [...document.querySelectorAll("#tools span")].map((name) => [name.textContent, name.className]));
  assert.deepEqual(names, [["left", "led"], ["right", ""]]);
  let hands = await Promise.all([0, 1].map((number) => open.get(handAt, number)));

  // By the mouse: the grasped tool moves.
  await drag(open, 1, [0, -40]);
  assert.equal(await open.get(chosen), "right");
  hands = await moved(open, hands, [false, true]);
  await open.until("the tool goes after its hand", (z) => palpate.space.lanes[0].tools[1].position.z > z - 2e-3, hands[1][2]);
  await drag(open, 0, [0, -40]);
  assert.equal(await open.get(chosen), "left");
  hands = await moved(open, hands, [true, false]);
  // Next to all tools, the chosen one moves.
  await drag(open, null, [0, 30]);
  hands = await moved(open, hands, [true, false]);

  // By keys, and by the buttons.
  await open.page.focus("#space");
  await open.page.keyboard.press("2");
  assert.equal(await open.get(chosen), "right");
  for (let step = 0; step < 3; step += 1) {
    await open.page.keyboard.press("PageUp");
  }
  hands = await moved(open, hands, [false, true]);
  await open.page.evaluate(() => document.querySelectorAll("#devices input")[2].click());
  assert.equal(await open.get(chosen), "both");
  const between = hands[0].map((x, axis) => x - hands[1][axis]);
  await drag(open, 1, [0, -30]);
  assert.equal(await open.get(chosen), "both");
  hands = await moved(open, hands, [true, true]);
  assert.ok(apart(hands[0].map((x, axis) => x - hands[1][axis]), between) < 1e-9, "both go the same way");

  // Releasing one hand leaves the other hand's hold unchanged.
  await open.page.focus("#space");
  await open.page.keyboard.press("1");
  await open.page.keyboard.press("Escape");
  await open.until("the left one has let go", () => palpate.model.state.hand_m === null);
  assert.deepEqual(await open.get(handAt, 1), hands[1]);
  const run = await open.get(() => palpate.model.run);
  await open.page.click("#restart");
  await open.until("another run", (before) => palpate.model.run !== before, run);
  await open.until("both hands hold", () => palpate.model.state.hand_m !== null);
  assert.deepEqual([await open.get(handAt, 0), await open.get(handAt, 1)], [[-0.0202, 0.0005, 0.016], [0.0202, -0.0003, 0.016]]);
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("two fingers hold the cube, one mouse after the other, and both forces are shown", async () => {
  const live = await startLive(...ARGUMENTS);
  const open = await visit(live.url);
  await open.until("both tools have come", () => palpate.space.lanes[0]?.tools.length === 2 && palpate.model.newestS > 0.1);
  await open.page.focus("#space");
  const press = async (key, times) => {
    for (let time = 0; time < times; time += 1) {
      await open.page.keyboard.press(key);
      await open.pass(0.05);
    }
  };
  // Each finger goes into the cube by 6 mm minus the gap of 0.2 mm, one hand holding while the other moves; then both
  // move up.
  const pinch = async () => {
    await press("1", 1);
    await press("ArrowRight", 6);
    await press("2", 1);
    await press("ArrowLeft", 6);
    const felt = await open.get(() => ({
      left: palpate.model.newest(0, "force_on_device_n"),
      right: palpate.model.newest(0, "force_on_device_n right"),
      arrows: palpate.space.lanes[0].felt.shown,
    }));
    await press("0", 1);
    await press("PageUp", 6);
    const isLifted = await open.get(() => palpate.space.lanes[0].bodies[0].position.z > 0.015 + 0.003);
    const areAlike = felt.left > 0.5 && felt.right > 0.5 && Math.abs(felt.left - felt.right) < 0.3 * (felt.left + felt.right);
    return isLifted && areAlike && felt.arrows === 2;
  };
  // A busy machine sometimes stalls the loop: without a force, the fingers go deep into the cube and kick it away.
  let isHeld = await pinch();
  for (let attempt = 1; attempt < 10 && !isHeld; attempt += 1) {
    const run = await open.get(() => palpate.model.run);
    await open.page.click("#restart");
    await open.until("another run", (before) => palpate.model.run !== before && palpate.model.newestS > 0.1, run);
    await open.page.focus("#space");
    isHeld = await pinch();
  }
  assert.ok(isHeld, "two like forces with an arrow each, and the cube is lifted");
  // Both are beside the cube, and neither is behind it.
  const aside = await open.get(() => [0, 1].map((tool) => palpate.space.toolOnCanvas(0, tool)[0] / palpate.space.canvas.clientWidth));
  assert.ok(aside[0] < 0.4 && aside[1] > 0.6, `${aside}`);
  const legend = await open.get(() => [...document.querySelectorAll("#chart-force .legend tr")].map((row) => row.firstChild.textContent));
  assert.deepEqual(legend.slice(1), ["left", "right"]);
  await open.until("the sentence says both", () =>
    /Force on each device now: left\s[0-9.]+\sN, right\s[0-9.]+\sN\./.test(document.querySelector("#seen").textContent),
  );
  await open.page.click("#pause");
  assert.equal(await open.get(() => palpate.view.paused), true);
  await picture(open, "pinch");
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("a finger chooses on a narrow screen, and two methods each have both tools", async () => {
  const live = await startLive(PINCH, "--method", "basic,coupled", "--priority", "0");
  const open = await visit(live.url, { viewport: NARROW });
  await open.until("both lanes have come", () => palpate.space.lanes.length === 2 && palpate.model.newest(1, "force_on_device_n right") >= 0);
  assert.equal(await open.get(() => document.querySelectorAll("#tools span").length), 4);
  assert.equal(await open.get(() => document.documentElement.scrollWidth <= innerWidth), true, "nothing sticks out");
  await open.page.tap("#devices label:nth-child(2)");
  await open.until("the right one is chosen", () => document.querySelector("#devices input:checked").value === "1");
  await open.until("the sentence says each lane", () => /basic: left\s.*; coupled: left\s.* right/.test(document.querySelector("#seen").textContent));
  await picture(open, "pinch-narrow");
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("beside a device that is not led from the page, the other one is", async () => {
  const devices = ["--device", "left=simulated", "--device", "right=pointer"];
  const live = await startLive(...ARGUMENTS, ...devices);
  const open = await visit(live.url);
  await open.until("both tools have come", () => palpate.space.lanes[0]?.tools.length === 2 && palpate.model.newestS > 0.1);
  const buttons = await open.get(() => [...document.querySelectorAll("#devices input")].map(({ disabled, checked }) => [disabled, checked]));
  assert.deepEqual(buttons, [[true, false], [false, true]]);
  await open.page.focus("#space");
  for (const key of ["1", "0", "ArrowRight", "ArrowRight", "ArrowRight"]) {
    await open.page.keyboard.press(key);
  }
  assert.equal(await open.get(chosen), "right");
  await open.until("the hand was led", () => palpate.model.state.further_hands[0].hand_m[0] > 0.0202 + 2.5e-3);
  assert.equal(await open.get(handAt, 0), null);
  await open.leave();
  await live.endsWell();
  live.forget();
});

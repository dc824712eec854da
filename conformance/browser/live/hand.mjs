import assert from "node:assert/strict";
import { test } from "node:test";
import { startLive } from "../program.mjs";
import { NARROW, visit } from "../visit.mjs";

const handM = () => palpate.model.state.hand_m;
const pxPerM = () => palpate.scene.axis.pxPerM;

/** Waits until the server reports this position of the hand. */
async function handAt(open, positionM) {
  await open.until(`the hand is at ${positionM} m`, (to) => Math.abs(palpate.model.state.hand_m - to) < 1e-4, positionM);
  // The device is in the hand, and nothing else moves it far.
  await open.until(
    "the device has come along",
    (to) => Math.abs(palpate.model.newest(0, "device_position_m") - to) < 8e-3,
    positionM,
  );
}

test("the page loads, keeps its own security policy, and shows curves", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  const policy = open.response.headers()["content-security-policy"];
  assert.match(policy, /default-src 'self'|default-src 'none'/);
  assert.doesNotMatch(policy, /unsafe/);
  assert.equal(await open.get(() => document.querySelector("#title").textContent), "A light block on the device, 100 Hz");
  assert.equal(await open.get(() => document.querySelector("#connection").textContent), "live");
  await open.pass(0.5);
  await open.until("the loop has a row for each lane", () => document.querySelectorAll("#status tbody tr").length === 2);
  const unnamed = await open.get(() =>
    [...document.querySelectorAll("input, select, button, [tabindex], canvas[role]")]
      .filter((element) => !(element.labels?.length || element.getAttribute("aria-label") || element.textContent.trim()))
      .map((element) => element.outerHTML),
  );
  assert.deepEqual(unnamed, [], "everything that can be used has a name");
  await open.leave();
  await live.endsWell();
  live.forget();
});

test("dragging with the mouse moves the hand, which stays where it is let be", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  const { mouse } = open.page;
  const { x, y } = await open.middle("#scene");
  const from = await open.get(handM);
  await mouse.move(x, y);
  await mouse.down();
  // The view eases to the visible range; while the hand is held it does not move.
  const scale = await open.get(pxPerM);
  await mouse.move(x + 20, y - 30, { steps: 6 });
  await handAt(open, from + 30 / scale);
  await mouse.move(x + 20, y + 24, { steps: 6 });
  await mouse.up();
  await handAt(open, from - 24 / scale);
  await mouse.move(x, y - 80, { steps: 3 });
  await open.pass(0.5);
  assert.ok(Math.abs((await open.get(handM)) - (from - 24 / scale)) < 1e-4, "it moves only while it is held");
  // With shift it is ten times finer.
  await open.page.keyboard.down("Shift");
  await mouse.down();
  const fine = await open.get(pxPerM);
  await mouse.move(x, y - 110, { steps: 3 });
  await mouse.up();
  await open.page.keyboard.up("Shift");
  await handAt(open, from - 24 / scale + 3 / fine);
  await open.page.click("#let-go");
  await open.until("the hand has let go", () => palpate.model.state.hand_m === null);
  await open.leave();
  await live.end();
  live.forget();
});

test("dragging with a finger moves the hand, and does not scroll the page", async () => {
  const live = await startLive();
  const open = await visit(live.url, { viewport: NARROW });
  const { touchscreen } = open.page;
  const { x, y } = await open.middle("#scene");
  const from = await open.get(handM);
  await touchscreen.touchStart(x, y);
  const scale = await open.get(pxPerM);
  for (const by of [10, 20, 30, 40]) {
    await touchscreen.touchMove(x, y - by);
  }
  await handAt(open, from + 40 / scale);
  await touchscreen.touchEnd();
  await open.pass(0.3);
  assert.ok(Math.abs((await open.get(handM)) - (from + 40 / scale)) < 1e-4);
  assert.equal(await open.get(() => scrollY), 0);
  await open.leave();
  await live.end();
  live.forget();
});

test("keys move the hand by 1 and 10 mm, to the ends, and let go", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  const { keyboard } = open.page;
  await open.page.focus("#scene");
  const from = await open.get(handM);
  for (let k = 1; k <= 3; k += 1) {
    await keyboard.press("ArrowUp");
    await handAt(open, from + 0.001 * k);
  }
  await keyboard.press("PageDown");
  await handAt(open, from - 0.007);
  await keyboard.press("ArrowDown");
  await handAt(open, from - 0.008);
  const attributes = (names) => names.map((name) => document.querySelector("#scene").getAttribute(name));
  await open.until(
    "it says where the hand is",
    (text) => document.querySelector("#scene").getAttribute("aria-valuetext") === text,
    `${((from - 0.008) * 1000).toFixed(1)} millimetres`,
  );
  await keyboard.press("End");
  const [role, highest] = await open.get(attributes, ["role", "aria-valuemax"]);
  assert.equal(role, "slider");
  await handAt(open, Number(highest) / 1000);
  await keyboard.press("Escape");
  await open.until("the hand has let go", () => palpate.model.state.hand_m === null);
  await open.until("it says so", () => document.querySelector("#scene").getAttribute("aria-valuetext") === "released");
  await open.leave();
  await live.end();
  live.forget();
});

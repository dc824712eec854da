import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { brotliCompressSync } from "node:zlib";
import { FOLDER, created, play } from "./open.mjs";

const MAX_BYTES = 660_000;

/** Selects a preset, and waits until it has run for this many seconds. */
async function preset(open, id, seconds) {
  const before = await open.get(() => palpate.model.run);
  await open.page.click(`#presets [data-preset="${id}"]`);
  const has = (before, to) => palpate.model.run !== before && palpate.model.newestS >= to;
  await open.until(`${seconds} s have passed from the start`, has, before, seconds);
}

test("a light cube at 50 Hz: the plain spring keeps creating energy, coupled rendering does not", async (t) => {
  const { open, leave } = await play();
  await preset(open, "light", 5.2);
  const [basic, coupled] = await created(open, 0.2, 5.2);
  t.diagnostic(`in 5 s basic creates ${(1e3 * basic).toFixed(1)} mJ, coupled ${(1e3 * coupled).toFixed(2)} mJ`);
  assert.ok(basic > 0.05, `${basic} J`);
  assert.ok(coupled < 1e-3, `${coupled} J`);
  assert.equal(await open.get(() => document.querySelector("#presets [aria-pressed=true]").dataset.preset), "light");
  const sentence = await open.until("it is said", () => {
    const text = document.querySelector("#seen").textContent;
    return /last [45] s/.test(text) && text;
  });
  assert.match(sentence, /^Left \(basic\) creates \d+(\.\d+)? mJ of energy; right \(coupled\) (creates no energy|creates less than 0\.1 mJ of energy|dissipates .* of energy)/);
  await leave();
});

test("the other presets do what they say", async (t) => {
  const { open, leave } = await play();
  const over = async (id) => {
    await preset(open, id, 6);
    const [basic, coupled] = await created(open, 1, 6);
    t.diagnostic(`${id}: in 5 s basic creates ${(1e3 * basic).toFixed(2)} mJ, coupled ${(1e3 * coupled).toFixed(2)} mJ`);
    return { basic, coupled };
  };
  const late = await over("late");
  assert.ok(late.basic > 0.1 && late.coupled < 1e-3);
  const wall = await over("wall");
  assert.ok(wall.basic > 0.1 && wall.coupled < 0.1 * wall.basic);
  const fast = await over("fast");
  assert.ok(fast.basic < 1e-3 && fast.coupled < 1e-3);
  await leave();
});

test("a contact that creates energy is cut off where that is asked for, and comes back", async () => {
  // 600 N/m at 50 Hz: the cube jumps ever higher.
  const { open, leave } = await play("#mass_kg=0.05&virtual_force_n=-0.4905&period_s=0.02&cut_off=yes");
  await open.until("it is cut off", () => palpate.model.state.lanes[0].safety_stop !== null);
  assert.match(await open.get(() => document.querySelector("#banners").textContent), /^basic: no force, because /);
  assert.equal(await open.get(() => palpate.model.state.lanes[1].safety_stop), null);
  await open.page.click("#cut-off");
  await open.until("it is not", () => palpate.model.state.lanes[0].safety_stop === null && palpate.model.state.device.cut_off === false);
  await open.until("nothing is said of it", () => document.querySelector("#banners").textContent === "");
  await leave();
});

test("two loops of 1 kHz keep real time", async (t) => {
  const { open, leave } = await play("#period_s=0.001");
  // On a machine that is busy for a moment, a later report counts.
  const pace = await open.until("it keeps real time", () => palpate.pace?.overS >= 1.5 && Math.abs(palpate.pace.ratio - 1) < 0.02 && palpate.pace);
  t.diagnostic(`${pace.ratio.toFixed(4)} of real time, ${pace.ticksPerS.toFixed(0)} ticks per second, ${(100 * pace.busy).toFixed(1)} % of a processor`);
  assert.ok(Math.abs(pace.ticksPerS - 2000) < 60, `${pace.ticksPerS}`);
  assert.match(await open.get(() => document.querySelector("#pace").textContent), /× real time, \d+ ticks per second/);
  await leave();
});

test("Stop stops, a tab that is hidden stands still, and both go on where they stood", async () => {
  const { open, leave } = await play();
  const standing = async () => {
    await open.until("it has stopped", () => palpate.link.isStill);
    const at = await open.get(() => palpate.model.newestS);
    // Long enough to detect a running loop.
    await new Promise((go) => setTimeout(go, 500));
    assert.equal(await open.get(() => palpate.model.newestS), at);
    return at;
  };
  await open.page.click("#stop");
  const stoppedAt = await standing();
  assert.equal(await open.get(() => document.querySelector("#connection").textContent), "stopped");
  await open.page.click("#stop");
  await open.until("it goes on", (from) => palpate.model.newestS > from, stoppedAt);
  const hide = (hidden) =>
    open.get((hidden) => {
      Object.defineProperty(document, "hidden", { configurable: true, value: hidden });
      document.dispatchEvent(new Event("visibilitychange"));
    }, hidden);
  await hide(true);
  const hiddenAt = await standing();
  assert.match(await open.get(() => document.querySelector("#connection").textContent), /hidden/);
  await new Promise((go) => setTimeout(go, 1000));
  const back = await open.get(
    (from) =>
      new Promise((done) => {
        const { model } = palpate;
        const before = performance.now();
        Object.defineProperty(document, "hidden", { configurable: true, value: false });
        document.dispatchEvent(new Event("visibilitychange"));
        const look = () => (model.newestS > from ? done({ stepS: model.newestS - from, passedS: (performance.now() - before) / 1000 }) : setTimeout(look, 1));
        look();
      }),
    hiddenAt,
  );
  assert.ok(back.stepS < back.passedS + 0.1, `time has jumped by ${back.stepS} s within ${back.passedS} s`);
  await leave();
});

test("what flies off stops the loop, and is said", async () => {
  const { open, leave } = await play("#mass_kg=0.005&virtual_force_n=10");
  await open.until("it has stopped", () => document.querySelector("#connection").textContent === "stopped");
  assert.match(await open.get(() => document.querySelector("#banners").textContent), /The loop has stopped: the object of \w+ is .* m away/);
  await leave();
});

test("values outside their range are refused beside their field", async () => {
  const { open, leave } = await play();
  await open.enter('#contact [data-name="stiffness_n_per_m"] input[type="text"]', "1e9");
  await open.until("it is refused", () => /outside its range; allowed: 10 to 10.?000/.test(document.querySelector('#contact [data-name="stiffness_n_per_m"] .refused').textContent));
  await open.enter('#device [data-name="device_mass_kg"] input[type="text"]', "0");
  await open.until("it is refused", () => /allowed: 0.01 to 5/.test(document.querySelector('#device [data-name="device_mass_kg"] .refused').textContent));
  assert.equal(await open.get(() => palpate.model.state.device.mass_kg), 0.25);
  await leave();
});

test("dragging leads the hand, and what it does is rendered", async () => {
  const { open, leave } = await play();
  const { x, y } = await open.middle("#scene");
  await open.page.mouse.move(x, y);
  await open.page.mouse.down();
  await open.page.mouse.move(x, y - 80, { steps: 8 });
  const handM = await open.until("the hand is led", () => palpate.model.state.hand_m > 0.002 && palpate.model.state.hand_m);
  await open.page.mouse.up();
  await open.until("the device follows", (handM) => Math.abs(palpate.model.newest(1, "device_position_m") - handM) < 0.005, handM);
  await leave();
});

test("nothing comes from anywhere else, nothing is missing, and all of it is small", async (t) => {
  const { open, server, leave } = await play("", { wait: true });
  await open.page.click('#view-worlds');
  await open.until("a world runs", () => palpate.worlds.now?.t_s > 0.2);
  const all = await open.get(() => performance.getEntriesByType("resource").map(({ name }) => name));
  assert.ok(all.length > 30 && all.every((name) => name.startsWith(server.url)), all.join(" "));
  const files = [...new Set(server.asked.map((url) => new URL(url, server.url)))].map(({ pathname }) => pathname.slice("/some/where/".length) || "index.html");
  // Files that a browser requests by itself.
  const bytes = [...new Set(files)].map((file) => brotliCompressSync(readFileSync(join(FOLDER, file))).length);
  const sum = bytes.reduce((sum, size) => sum + size, 0);
  t.diagnostic(`${bytes.length} files, ${sum} bytes compressed; first picture ${Math.round(await open.get(() => palpate.counted.firstPictureMs))} ms after the page was asked for`);
  assert.ok(sum < MAX_BYTES, `${sum} bytes`);
  await leave();
});

test("a loop that cannot be loaded is said", async () => {
  const { open, leave } = await play("", {
    wait: false,
    first: () => {
      const Real = Worker;
      globalThis.Worker = class extends Real {
        postMessage(message, ...more) {
          super.postMessage(message.type === "load" ? { ...message, wasm: `${message.wasm}.none` } : message, ...more);
        }
      };
    },
  });
  await open.until("it is said", () => /The loop has ended: the loop cannot be loaded: .* 404/.test(document.querySelector("#banners").textContent));
  await leave(/404/);
});

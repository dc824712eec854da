import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { startLive } from "../program.mjs";
import { NARROW, WIDE, visit } from "../visit.mjs";

const FOLDER = process.env.PALPATE_SCREENSHOTS;

/** Moves the hand up and down, so that the curves change. */
async function knock(open) {
  for (const to of [-0.012, 0.012, -0.012, 0.006]) {
    await open.get((to) => palpate.link.say({ type: "hand", position_m: to }), to);
    await open.pass(0.4);
  }
}

/** Reads and adds many numbers, as a benchmark of the processor's current speed. */
const readManyNumbers = () => {
  const numbers = Float64Array.from({ length: 1_000_000 }, (_, at) => at);
  let sum = 0;
  for (let time = 0; time < 20; time += 1) {
    for (const number of numbers) {
      sum += number;
    }
  }
  return sum;
};

/** Counts the page's drawing operations on its canvases, before its own scripts run. */
const countMarks = () => {
  globalThis.marks = 0;
  const drawing = {
    Path2D: ["moveTo", "lineTo", "rect", "arc"],
    CanvasRenderingContext2D: ["moveTo", "lineTo", "rect", "arc", "fillRect", "strokeRect", "clearRect", "fillText", "strokeText", "drawImage"],
  };
  for (const [owner, names] of Object.entries(drawing)) {
    const { prototype } = globalThis[owner];
    for (const name of names) {
      const draw = prototype[name];
      prototype[name] = function count(...of) {
        globalThis.marks += 1;
        return draw.apply(this, of);
      };
    }
  }
};

/** Milliseconds of the page's thread for the reference. */
async function measure(look, open) {
  const from = await look();
  await open.get(readManyNumbers);
  const to = await look();
  return 1000 * (to.task - from.task);
}

test("two lanes at 4 kHz and 10 s of curves are drawn at a price that leaves room", async (t) => {
  const live = await startLive("--period", "0.00025");
  const open = await visit(live.url, { first: countMarks });
  // Measured in thread time rather than wall time, so that other processes do not count.
  const session = await open.page.createCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  await open.pass(10.2);
  // At most nine ticks form two rows: 8000 rows correspond to 9 s. On a busy machine the loop or the page misses some.
  await open.until("thousands of rows have come of each lane", () => palpate.model.lanes.every(({ ring }) => ring.length > 8000));
  const look = async () => {
    const { metrics } = await session.send("Performance.getMetrics");
    const seconds = Object.fromEntries(metrics.map(({ name, value }) => [name, value]));
    return { task: seconds.TaskDuration, script: seconds.ScriptDuration, ...(await open.get(() => ({ ...palpate.counted, marks, atMs: performance.now() }))) };
  };
  const references = [await measure(look, open)];
  const from = await look();
  await open.until("some pictures more are drawn", (from) => palpate.counted.allFrames >= from + 20, from.allFrames);
  const to = await look();
  references.push(await measure(look, open));
  const reference = (references[0] + references[1]) / 2;
  const pictures = to.allFrames - from.allFrames;
  const each = (key) => (1000 * (to[key] - from[key])) / pictures;
  const perSecond = (1000 * pictures) / (to.atMs - from.atMs);
  const rows = await open.get(() => palpate.model.lanes.map(({ ring }) => ring.length));
  const marks = (to.marks - from.marks) / pictures;
  // A curve in each chart for each rendering.
  const across = await open.get(() =>
    palpate.charts.visible.reduce((sum, { plot }) => sum + palpate.model.lanes.length * plot.clientWidth * devicePixelRatio, 0),
  );
  t.diagnostic(
    `${perSecond.toFixed(1)} pictures per second; each takes ${each("task").toFixed(1)} ms of the processor, ` +
      `${each("script").toFixed(1)} ms of them in scripts; the reference ${reference.toFixed(1)} ms; ${rows.join(" and ")} rows; ` +
      `${marks.toFixed(0)} marks for ${across} pixels across`,
  );
  // The number of marks depends on the pixels, not on the rows: two values per pixel column, of up to two marks each,
  // and 2000 more for axes, labels and the scene.
  assert.ok(marks < 4 * across + 2000, `${marks} marks for ${across} pixels across`);
  // Without a graphics processor, which is the more expensive case. On an idle machine a picture takes 0.06 of the
  // reference, 0.017 of it in scripts. Beside ten jobs on two processors it took 0.4 and 0.15, because caches are
  // shared and one picture shows the rows of two seconds.
  assert.ok(each("task") < reference, `${each("task")} ms, the reference ${reference} ms`);
  assert.ok(each("script") < 0.4 * reference, `${each("script")} ms in scripts, the reference ${reference} ms`);
  await open.leave();
  await live.end();
  live.forget();
});

for (const [name, viewport] of [["wide", WIDE], ["narrow", NARROW]]) {
  for (const scheme of ["light", "dark"]) {
    test(`${name} and ${scheme}: everything fits, and is drawn in the scheme's colours`, async () => {
      const live = await startLive();
      const open = await visit(live.url, { viewport, scheme });
      await knock(open);
      // All of them, in the smallest possible space.
      await open.page.click('#shown [data-chart="position"]');
      await open.page.click("#notes summary");
      const { across, panel, folded, dark } = await open.get(() => ({
        across: document.scrollingElement.scrollWidth - document.documentElement.clientWidth,
        panel: getComputedStyle(document.querySelector("#panel")).backgroundColor,
        folded: !document.querySelector("#panel").open,
        dark: matchMedia("(prefers-color-scheme: dark)").matches,
      }));
      assert.equal(across, 0, "nothing sticks out");
      assert.equal(folded, name === "narrow");
      assert.equal(dark, scheme === "dark");
      const [red] = /\d+/.exec(panel);
      assert.equal(Number(red) < 128, scheme === "dark");
      const empty = await open.get(() =>
        palpate.charts.visible.filter(({ plot }) => plot.clientWidth < 200 || plot.clientHeight < 80).map(({ what }) => what.id),
      );
      assert.deepEqual(empty, [], "every chart has room");
      const cut = await open.get(() =>
        palpate.charts.visible
          .filter(({ root, legend }) => legend.root.lastChild.getBoundingClientRect().bottom > root.getBoundingClientRect().bottom)
          .map(({ what }) => what.id),
      );
      assert.deepEqual(cut, [], "no legend is cut");
      if (FOLDER) {
        mkdirSync(FOLDER, { recursive: true });
        await open.page.screenshot({ path: join(FOLDER, `${name}-${scheme}.png`), fullPage: name === "narrow" });
      }
      await open.leave();
      await live.end();
      live.forget();
    });
  }
}

for (const viewport of [WIDE, { width: 1320, height: 760 }]) {
  test(`${viewport.width} px wide: the scene keeps its scale, whatever text is beside it`, async () => {
    const live = await startLive();
    const open = await visit(live.url, {
      viewport,
      first: () => {
        globalThis.scales = [];
        const look = () => {
          requestAnimationFrame(look);
          const { model, scene } = globalThis.palpate ?? {};
          if (model?.hello && model.state) {
            // A timer runs after layout and painting of the picture.
            setTimeout(() => globalThis.scales.push(scene.axis.pxPerM));
          }
        };
        requestAnimationFrame(look);
      },
    });
    await open.nextStatus();
    await open.until("what is seen is said", () => document.querySelector("#seen").textContent !== "");
    await open.page.click("#record");
    await open.until("it records", () => document.querySelector("#recording").textContent.includes("ticks"));
    await open.page.click("#record");
    await open.until("it has recorded", () => document.querySelector("#recording").textContent.startsWith("Recorded"));
    await open.until("enough pictures", () => globalThis.scales.length > 10);
    const scales = await open.get(() => globalThis.scales);
    assert.ok(scales[0] > 1000, `${scales[0]} px/m`);
    assert.deepEqual([...new Set(scales)], [scales[0]], "px/m");
    await open.leave();
    await live.end();
    live.forget();
  });
}

test("at no width does anything stand beside the window", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.nextStatus();
  // The narrowest and widest width of each layout, and common screen widths.
  for (const width of [481, 600, 899, 900, 1024, 1280, 1319, 1320, 1366, 1440, 1920]) {
    await open.page.setViewport({ width, height: 760 });
    await open.until("it is laid out", (want) => innerWidth === want && document.querySelector("main").offsetWidth > 0, width);
    const beside = await open.get(() =>
      [...document.querySelectorAll("header, main > *, #curves button, #curves [role]")]
        .filter((part) => part.checkVisibility() && part.getBoundingClientRect().right > innerWidth)
        .map((part) => part.id || part.textContent || part.tagName),
    );
    assert.deepEqual(beside, [], `${width} px`);
  }
  await open.leave();
  await live.end();
  live.forget();
});

test("what counts on is not read out again and again", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.page.click("#record");
  await open.until("it records", () => document.querySelector("#recording").textContent.includes("ticks"));
  await open.page.click("#pause");
  await open.until("it is paused", () => document.querySelector("#buffer").textContent !== "");
  const texts = () => ["#recording", "#buffer"].map((place) => document.querySelector(place).textContent);
  const before = await open.get(texts);
  await open.get(() => {
    globalThis.readOut = [];
    const watch = new MutationObserver((changes) => {
      // Collapsed elements are not read out.
      globalThis.readOut.push(...changes.filter(({ target }) => target.checkVisibility()).map(({ target }) => target.textContent));
    });
    for (const region of document.querySelectorAll("[role=status], [role=alert], [aria-live]")) {
      watch.observe(region, { childList: true, characterData: true, subtree: true });
    }
  });
  await open.until("both have counted on", (before) => ["#recording", "#buffer"].every((place, k) => document.querySelector(place).textContent !== before[k]), before);
  assert.deepEqual(await open.get(() => globalThis.readOut), []);
  await open.leave();
  await live.end();
  live.forget();
});

test("who wants less motion gets curves that go on in steps, and the scene at once", async () => {
  const live = await startLive();
  const open = await visit(live.url, { motion: "reduce" });
  await open.get(() => {
    const { charts, scene, counted } = palpate;
    globalThis.drawn = { charts: [], scene: 0, fromFrame: counted.allFrames };
    const [drawCharts, drawScene] = [charts.draw.bind(charts), scene.draw.bind(scene)];
    charts.draw = (nowS, fit) => {
      globalThis.drawn.charts.push({ nowS, fit });
      drawCharts(nowS, fit);
    };
    scene.draw = (...how) => {
      globalThis.drawn.scene += 1;
      drawScene(...how);
    };
  });
  await open.until("curves have gone on", () => globalThis.drawn.charts.length >= 4);
  const { charts, scene, frames } = await open.get(() => ({ ...globalThis.drawn, frames: palpate.counted.allFrames - globalThis.drawn.fromFrame }));
  // Charts with a new range are drawn at once.
  const steps = charts.flatMap(({ nowS, fit }, k) => (k === 0 || fit ? [] : [nowS - charts[k - 1].nowS]));
  assert.ok(steps.every((step) => step >= 0.499), `${steps} s`);
  assert.equal(scene, frames, "the scene is drawn with each frame");
  await open.leave();
  await live.end();
  live.forget();
});

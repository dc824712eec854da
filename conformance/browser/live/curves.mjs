import assert from "node:assert/strict";
import { test } from "node:test";
import { startLive } from "../program.mjs";
import { visit } from "../visit.mjs";

const stretch = () => [palpate.view.fromS, palpate.view.toS];

test("what is paused stands still while more comes in; zoomed by dragging, all by a double click", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.page.click('#spans input[value="2"]');
  await open.pass(2.2);
  await open.page.click("#pause");
  const [from, to] = await open.get(stretch);
  assert.ok(Math.abs(to - from - 2) < 1e-9);
  const rows = await open.get(() => palpate.model.lanes[0].ring.length);
  await open.pass(0.5);
  assert.deepEqual(await open.get(stretch), [from, to]);
  assert.ok((await open.get(() => palpate.model.lanes[0].ring.length)) > rows);
  await open.until("it says so", () => document.querySelector("#buffer").textContent.startsWith("Paused at "));

  const { x, y, width, left } = await open.middle("#chart-energy .u-over");
  const { mouse } = open.page;
  await mouse.move(left + 0.25 * width, y);
  await mouse.down();
  await mouse.move(x, y, { steps: 8 });
  await mouse.up();
  await open.until("it is zoomed", () => palpate.view.zoom !== null);
  const [near, far] = await open.get(stretch);
  assert.ok(Math.abs(near - (from + 0.5)) < 0.03 && Math.abs(far - (from + 1)) < 0.03, `${near} to ${far} of ${from} to ${to}`);
  const scales = () => palpate.charts.visible.map(({ uplot }) => [uplot.scales.x.min, uplot.scales.x.max]);
  await open.until("all charts show it", () =>
    palpate.charts.visible.every(({ uplot }) => uplot.scales.x.min === palpate.view.fromS && uplot.scales.x.max === palpate.view.toS),
  );
  assert.equal((await open.get(scales)).length, 5);
  await mouse.click(x, y, { count: 2 });
  await open.until("all of it is shown", () => palpate.view.zoom === null);
  assert.deepEqual(await open.get(stretch), [from, to]);

  await open.page.focus("#charts");
  await open.page.keyboard.press("+");
  await open.until("keys zoom too", () => palpate.view.zoom !== null);
  await open.page.keyboard.press("0");
  await open.until("all of it is shown", () => palpate.view.zoom === null);

  await open.page.click("#pause");
  await open.until("it goes on", (was) => palpate.view.toS > was + 0.5, to);
  await open.leave();
  await live.end();
  live.forget();
});

test("the cursor is in all charts, and the legends say the values there", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.page.click('#spans input[value="2"]');
  await open.pass(2.2);
  await open.page.click("#pause");
  const { x, y } = await open.middle("#chart-force .u-over");
  await open.page.mouse.move(x - 7, y);
  await open.until("all charts have it", () => palpate.charts.visible.every((chart) => chart.cursorS !== null));
  const messages = await open.until("the legend says the value there", () => {
    const chart = palpate.charts.visible.find(({ what }) => what.id === "penetration");
    const { ring } = palpate.model.lanes[0];
    const value = ring.value(palpate.model.column("penetration_m"), ring.rowAt(chart.cursorS)) / chart.prefix.factor;
    const text = chart.legend.cells[0][0].textContent.replace("−", "-");
    return Math.abs(Number(text) - value) <= 0.006 * Math.max(1, Math.abs(value)) ? { text, value } : null;
  });
  assert.ok(messages.text.length > 0);
  await open.leave();
  await live.end();
  live.forget();
});

test("charts can be hidden and shown; no peak of the force is lost on the way to the screen", async () => {
  const live = await startLive("--method", "basic");
  const open = await visit(live.url);
  await open.page.click('#shown [data-chart="timing"]');
  await open.page.click('#shown [data-chart="position"]');
  const shown = () => palpate.charts.visible.map(({ what }) => what.id);
  assert.deepEqual(await open.get(shown), ["position", "force", "penetration", "energy", "leak"]);
  // A knock by the hand.
  await open.get(() => palpate.link.say({ type: "hand", position_m: -0.03 }));
  await open.pass(0.4);
  await open.get(() => palpate.link.say({ type: "hand", position_m: 0.01 }));
  await open.pass(1);
  await open.page.click("#pause");
  await open.until("the charts show what is paused", () =>
    palpate.charts.visible.every(({ uplot }) => uplot.scales.x.max === palpate.view.toS),
  );
  const { drawn, come } = await open.get(() => {
    const chart = palpate.charts.visible.find(({ what }) => what.id === "force");
    const { ring } = palpate.model.lanes[0];
    const column = palpate.model.column("force_on_device_n");
    let come = 0;
    for (let row = ring.rowAt(palpate.view.fromS) + 1; row <= ring.rowAt(palpate.view.toS); row += 1) {
      come = Math.min(come, ring.value(column, row));
    }
    const drawn = Math.min(...chart.data[1].filter((value) => Number.isFinite(value)));
    return { drawn, come };
  });
  assert.ok(come < -1.5, `the knock gave ${come} N`);
  assert.equal(drawn, come);
  await open.leave();
  await live.end();
  live.forget();
});

import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { countColour, decode } from "../png.mjs";
import { palpate as program, startLive } from "../program.mjs";
import { parse } from "../tables.mjs";
import { visit } from "../visit.mjs";

/** Presses a button that saves a file; returns the file. */
async function saved(open, button, ending) {
  const folder = mkdtempSync(join(tmpdir(), "palpate-saved-"));
  const session = await open.page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", {
    behavior: "allow",
    downloadPath: folder,
    browserContextId: open.context.id,
    eventsEnabled: true,
  });
  const done = new Promise((resolve) => {
    session.on("Browser.downloadProgress", ({ state }) => state === "completed" && resolve());
  });
  await open.page.click(button);
  await done;
  const [name] = readdirSync(folder).filter((file) => file.endsWith(ending));
  assert.match(name, /^palpate-\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d\./);
  const bytes = readFileSync(join(folder, name));
  rmSync(folder, { recursive: true });
  return bytes;
}

test("the table that is saved holds what the buffer holds", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.pass(1);
  await open.page.click("#pause");
  const before = await open.get(() => palpate.model.lanes.map(({ ring }) => ring.length));
  const { header, rows } = parse((await saved(open, "#csv", ".csv")).toString("utf8"));
  const names = await open.get(() => palpate.model.names);
  assert.deepEqual(header, ["lane", "method", "settings", "grouped", "t_s", ...names, "palpate_live_1"]);
  const lanes = [0, 1].map((lane) => rows.filter((row) => row[0] === String(lane)));
  lanes.forEach((lane, i) => {
    assert.ok(lane.length >= before[i], `${lane.length} rows of ${before[i]}`);
    const times = lane.map((row) => Number(row[4]));
    assert.ok(times.every((time, k) => k === 0 || time > times[k - 1]), "times increase");
    assert.ok(lane.every((row) => row[3] === "0"), "at 100 Hz each row is a tick");
  });
  assert.equal(lanes[0][0][1], "basic");
  assert.equal(lanes[1][0][1], "coupled");
  const force = header.indexOf("force_on_device_n");
  const inPage = await open.get(() => {
    const { ring } = palpate.model.lanes[1];
    return [ring.timeS[ring.place(0)], ring.value(palpate.model.column("force_on_device_n"), 0)];
  });
  assert.ok(Math.abs(Number(lanes[1][0][4]) - inPage[0]) < 1e-8);
  assert.equal(Math.fround(Number(lanes[1][0][force])), inPage[1]);
  const about = JSON.parse(rows[0].at(-1));
  assert.equal(about.settings[0].stiffness_n_per_m, await open.get(() => palpate.model.state.stiffness_n_per_m));
  await open.leave();
  await live.end();
  live.forget();
});

test("of a fast loop the table says that its rows are the least and greatest of groups", async () => {
  const live = await startLive("--method", "coupled", "--period", "0.00025");
  const open = await visit(live.url);
  await open.until("rows have come", () => palpate.model.lanes[0].ring.length > 100);
  const { rows } = parse((await saved(open, "#csv", ".csv")).toString("utf8"));
  assert.ok(rows.length > 50 && rows.every((row) => row[3] === "1"));
  assert.match(JSON.parse(rows[0].at(-1)).rows, /minimum or maximum/);
  await open.leave();
  await live.end();
  live.forget();
});

test("the picture that is saved shows scene and curves", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.pass(1.5);
  const picture = decode(await saved(open, "#png", ".png"));
  assert.ok(picture.width > 900 && picture.height > 600, `${picture.width} x ${picture.height}`);
  const colours = await open.get(() => ["--lane-1", "--lane-2", "--panel"].map((name) => getComputedStyle(document.documentElement).getPropertyValue(name)));
  const [first, second, panel] = colours.map((hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  assert.ok(countColour(picture, first) > 500, "the first lane is drawn");
  assert.ok(countColour(picture, second) > 500, "the second lane is drawn");
  const share = countColour(picture, panel, 0) / (picture.width * picture.height);
  assert.ok(share > 0.5 && share < 0.99, `${share} is background`);
  await open.leave();
  await live.end();
  live.forget();
});

test("a recording that is begun and ended here is whole", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.page.click("#record");
  await open.until("it records", () => palpate.model.state.recording !== null);
  await open.until("ticks are written", () => palpate.model.status?.recording?.ticks > 50);
  assert.match(await open.get(() => document.querySelector("#recording").textContent), /^Recording .*\.mcap · .* ticks · 0 lost/);
  assert.equal(await open.get(() => document.querySelector("#record").getAttribute("aria-pressed")), "true");
  const [name] = await open.get(() => palpate.model.state.recording.files);
  await open.page.click("#record");
  await open.until("it records no more", () => palpate.model.state.recording === null);
  assert.match(await open.get(() => document.querySelector("#recording").textContent), /^Recorded .*\.mcap/);
  const path = join(live.folder, name);
  for (let k = 0; k < 600 && !existsSync(path); k += 1) {
    await new Promise((go) => setTimeout(go, 50));
  }
  const { status, stdout, stderr } = program("info", path);
  assert.equal(status, 0, stdout + stderr);
  assert.match(stdout, /whole|complete/);
  await open.leave();
  await live.end();
  live.forget();
});

// The page of `palpate report` as shown and printed by a browser.

import { strict as assert } from "node:assert";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { palpate } from "./program.mjs";
import { closeBrowser, openPage } from "./visit.mjs";

const SCENE = fileURLToPath(new URL("../../experiments/wall.toml", import.meta.url));

let folder;
let page;

function made(...args) {
  const answer = palpate(...args);
  assert.equal(answer.status, 0, answer.stderr);
}

before(() => {
  folder = mkdtempSync(join(tmpdir(), "palpate-report-"));
  const at = (name) => join(folder, name);
  made("run", SCENE, "--record", at("tap.mcap"), "--duration", "0.5", "--fast");
  made("calibrate", "--device", "simulated", "--fast", "--out", at("device.toml"), "--report", at("fit.json"));
  page = at("device.html");
  // All possible content of a page, with a long name; one method, because this test is about looks.
  const sources = ["--device-file", at("device.toml"), "--calibration", at("fit.json")];
  made("report", at("tap.mcap"), ...sources, "--name", "A name ".repeat(20), "--method", "basic", "--out", page);
});

after(() => rmSync(folder, { recursive: true, force: true }));

test("a phone shows everything within its width", async () => {
  const open = await openPage(pathToFileURL(page).href, { width: 390, height: 800 });
  const beyond = await open.evaluate(() => {
    const all = [...document.querySelectorAll("body *:not(svg *)")];
    return all.filter((one) => one.getBoundingClientRect().right > 390.5).map((one) => `${one.tagName}: ${one.textContent.slice(0, 40)}`);
  });
  assert.deepEqual(beyond, []);
  assert.ok((await open.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  assert.equal(await open.evaluate(() => document.querySelectorAll("svg").length), 9);
  await open.close();
});

test("the page is there without a network", async () => {
  const open = await openPage("about:blank", { width: 1100, height: 900 });
  const asked = [];
  await open.setRequestInterception(true);
  open.on("request", (request) => {
    asked.push(request.url());
    request.continue();
  });
  await open.goto(pathToFileURL(page).href);
  assert.deepEqual(asked, [pathToFileURL(page).href]);
  await open.close();
});

test("it prints on two sheets", async () => {
  const open = await openPage(pathToFileURL(page).href, { width: 1100, height: 900 });
  const pdf = Buffer.from(await open.pdf({ preferCSSPageSize: true })).toString("latin1");
  assert.equal(pdf.match(/\/Type\s*\/Page[^s]/g)?.length, 2);
  // The count finds a third one.
  const longer = join(folder, "longer.html");
  const text = readFileSync(page, "utf8");
  writeFileSync(longer, text.replace("</main>", "<p style=\"height: 150mm\"></p><p style=\"height: 150mm\"></p></main>"));
  await open.goto(pathToFileURL(longer).href);
  const more = Buffer.from(await open.pdf({ preferCSSPageSize: true })).toString("latin1");
  assert.ok(more.match(/\/Type\s*\/Page[^s]/g).length > 2);
  await open.close();
});

// A test rather than an after-all hook, which would wait for the browser to end.
test("the browser ends", closeBrowser);

import assert from "node:assert/strict";
import { test } from "node:test";
import { startLive } from "../program.mjs";
import { visit } from "../visit.mjs";

// Messages of the browser itself if the server does not answer.
const NOBODY_ANSWERS = /ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|WebSocket connection|Failed to load resource/;

const banner = () => document.querySelector('[data-about="lost"] p')?.textContent;

test("a server that is gone is missed at once, the curves stay, and the page comes back by itself", async () => {
  const live = await startLive();
  const open = await visit(live.url);
  await open.pass(1.5);
  const before = await open.get(() => palpate.model.lanes[0].ring.length);
  await open.get(() => {
    globalThis.begun = 0;
    globalThis.losses = [];
    palpate.model.addEventListener("anew", () => {
      globalThis.begun += 1;
    });
    const { lost } = palpate.link.heard;
    palpate.link.heard.lost = (why, ...how) => {
      globalThis.losses.push(why);
      lost(why, ...how);
    };
  });
  await live.end("SIGKILL");
  assert.match(await open.until("it is said", banner), /^The server is gone: .* The curves are kept/);
  // The page did not wait for a timeout.
  assert.equal((await open.get(() => globalThis.losses))[0], "the connection was closed");
  assert.ok((await open.get(() => palpate.model.lanes[0].ring.length)) >= before);
  assert.equal(await open.get(() => document.querySelector("#connection").dataset.kind), "lost");
  const again = await startLive("--listen", live.address);
  await open.until("it is back", () => document.querySelector("#connection").dataset.kind === "live");
  await open.until("nothing is missed", () => !document.querySelector('[data-about="lost"]'));
  // Time has restarted: the new curves contain nothing of the previous loop.
  await open.until("it has begun anew", () => globalThis.begun === 1);
  await open.until("curves come", () => palpate.model.lanes.every(({ ring }) => ring.length > 20));
  const { increases, newest } = await open.get(() => {
    const { ring } = palpate.model.lanes[0];
    let increases = true;
    for (let row = 1; row < ring.length; row += 1) {
      increases &&= ring.timeS[ring.place(row)] > ring.timeS[ring.place(row - 1)];
    }
    return { increases, newest: ring.lastS };
  });
  assert.ok(increases);
  await open.until("the charts follow", () => Math.abs(palpate.view.edgeS - palpate.model.newestS) < 0.5);
  assert.ok(newest > 0);
  await open.leave(NOBODY_ANSWERS);
  await again.end();
  again.forget();
  live.forget();
});

test("a restart begins time anew", async () => {
  const live = await startLive("--method", "coupled");
  const open = await visit(live.url);
  await open.pass(2);
  const was = await open.get(() => palpate.model.newestS);
  await open.get(() => palpate.model.addEventListener("anew", () => {
    globalThis.rowsLeft = palpate.model.lanes.map(({ ring }) => ring.length);
  }));
  await open.page.click("#restart");
  assert.ok((await open.until("it has begun anew", () => globalThis.rowsLeft)).every((rows) => rows === 0));
  await open.until("curves come", () => palpate.model.lanes[0].ring.length > 20);
  assert.ok((await open.get(() => palpate.model.lanes[0].ring.firstS)) < was);
  await open.until("the charts follow", () => Math.abs(palpate.view.edgeS - palpate.model.newestS) < 0.5);
  await open.leave();
  await live.end();
  live.forget();
});

test("a loop that is over is said to be", async () => {
  const live = await startLive("--method", "coupled", "--duration", "6");
  const open = await visit(live.url);
  const rows = await open.get(() => palpate.model.lanes[0].ring.length);
  const text = await open.until("it is over", () => document.querySelector('[data-about="ended"] p')?.textContent);
  assert.match(text, /^The loop is over: /);
  assert.notEqual(await open.get(() => document.querySelector("#connection").dataset.kind), "live");
  // The number of rows depends on the time of the visit and on missed deadlines.
  assert.ok(rows > 0 && (await open.get(() => palpate.model.lanes[0].ring.length)) >= rows, "the curves stay");
  // The program ends with its loop.
  await open.leave(NOBODY_ANSWERS);
  await live.end();
  live.forget();
});

test("where others can listen a token is needed, and the page passes it on", async () => {
  const live = await startLive("--listen", "0.0.0.0:0");
  const url = live.url.replace("0.0.0.0", "127.0.0.1");
  assert.match(url, /\?token=[0-9a-f]{16,}$/);
  const open = await visit(url);
  await open.leave();
  const stranger = await visit(url.replace(/\?.*/, ""), { wait: false });
  assert.equal(stranger.response.status(), 401);
  // The browser also requests an icon.
  await stranger.leave(/401|404/);
  await live.end();
  live.forget();
});

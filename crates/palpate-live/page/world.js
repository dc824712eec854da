// Puts the page of a world together.

import { Banners } from "./banners.js";
import { Charts } from "./charts.js";
import { Chooser } from "./chooser.js";
import { CHARTS } from "./curves.js";
import { chartsOf, devicesOf, forcesInWords, handsOf } from "./devices.js";
import { HandInSpace } from "./hand_in_space.js";
import { Link } from "./link.js";
import { Model } from "./model.js";
import { News } from "./news.js";
import { Pace } from "./pace.js";
import { kindOf, readSamples, readWorld, say } from "./protocol.js";
import { createdWithin, seenInWords } from "./seen.js";
import { digits } from "./si.js";
import { Space } from "./space.js";
import { Status } from "./status.js";
import { onThemeChange, readTheme } from "./theme.js";
import { ToolNames } from "./tool_names.js";
import { safetyStopInWords } from "./safety_stops.js";
import { SPANS_S, View } from "./view.js";

const READ_OUT_S = 0.1;
const SENTENCE_S = 0.5;

const place = (id) => document.getElementById(id);

readTheme();
const model = new Model();
const view = new View();
const banners = new Banners(place("banners"));
const news = new News(place, model, banners);
const charts = new Charts(place("charts"), model, view, changed);
charts.shown = new Set(["force", "penetration", "leak", "timing"]);
const status = new Status({ table: place("status"), served: place("served"), recording: place("recording") }, model);
const canvas = place("space");
let space = null;
try {
  space = new Space(canvas);
} catch (error) {
  banners.show("webgl", `This browser cannot draw in three dimensions: ${error.message}. The charts continue.`);
}
let fit = false;
const hand = new HandInSpace(canvas, space, model, (message) => link.say(message));

const chooser = new Chooser(place("choose"), place("devices"), hand);
const toolNames = new ToolNames(place("tools"), space, hand);
let devices = [];

const link = new Link(location.search, {
  open: () => news.found(),
  text: (message) => model.take(message),
  samples(bytes) {
    if (kindOf(bytes) === "world") {
      const world = readWorld(bytes);
      model.takeNumber(world);
      space?.take(world);
    } else {
      model.takeSamples(readSamples(bytes, model.names.length), view.keepFromS);
    }
  },
  lost: (why, waitMs) => news.lost(why, waitMs, () => link.open()),
  wrong: (error) => news.wrong(error),
});

function changed() {
  fit = true;
  place("pause").textContent = view.paused ? "Resume" : "Pause";
  place("pause").setAttribute("aria-pressed", String(view.paused));
  charts.selectable(view.paused);
  charts.redraw();
}

model.addEventListener("hello", ({ detail: { isNew } }) => {
  status.anew();
  if (isNew) {
    const { title, device, world } = model.hello;
    devices = devicesOf(model.hello);
    news.begin(title);
    charts.what = chartsOf(CHARTS, devices);
    charts.build();
    space?.begin(world, device.lanes);
    hand.begin();
    chooser.build();
    toolNames.begin(device.lanes);
    place("let-go").hidden = !hand.isLeadable;
    tellKeys();
  }
});

/** Says what mouse and keys do to the devices that are chosen. */
function tellKeys() {
  const kinds = [...new Set(devices.map(({ kind }) => kind))].join(", ");
  const turning = hand.turns ? " Ctrl, or X, Y and Z (with shift: backwards), turns the hand." : "";
  const last = devices.length;
  const choices = last > 2 ? `1 to ${last} or 0 (all)` : "1, 2 or 0 (both)";
  const areChosen = devices.filter(({ pointer }) => pointer).length > 1;
  const choosing = areChosen ? ` Grab a tool to choose it, or press ${choices}.` : "";
  place("keys").textContent = hand.isLeadable
    ? `Drag to move the hand in the plane of the screen; with shift, or with the wheel, towards you or away.${choosing}${turning} Right button: turn the view. Arrows and page keys move by 1 mm; Escape releases it.`
    : `${kinds}: ${last > 1 ? "these devices are" : "this device is"} not movable from the page. Right button: turn the view.`;
}

hand.addEventListener("chosen", tellKeys);

model.addEventListener("state", () => {
  const { state } = model;
  charts.name();
  status.tell();
  place("names").replaceChildren(
    ...state.lanes.map(({ method }, lane) => {
      const name = document.createElement("span");
      name.className = `lane-${lane + 1}`;
      name.textContent = method;
      return name;
    }),
  );
  [0, 1].forEach((lane) => {
    const rearm = { label: "Rearm", act: () => link.say(say.rearm(lane)) };
    banners.show(`safety-stop-${lane + 1}`, safetyStopInWords(state.lanes[lane], lane + 1), rearm);
  });
  if (space) {
    space.hands = handsOf(state).map(({ hand_m: at }) => at);
  }
});

model.addEventListener("anew", () => {
  hand.drop();
  view.anew();
  status.anew();
  changed();
});
model.addEventListener("status", () => status.take());
model.addEventListener("refused", ({ detail: { text } }) => {
  banners.show("refused", `Refused: ${text}.`, { label: "Close", act: () => banners.show("refused", null) });
});

place("restart").addEventListener("click", () => {
  hand.drop();
  link.say(say.restart());
});
place("let-go").addEventListener("click", () => hand.letGo());
place("pause").addEventListener("click", () => {
  if (view.paused) {
    view.go();
    model.refusedRows = 0;
  } else {
    view.pause();
  }
  changed();
});
place("spans").append(
  ...SPANS_S.map((span) => {
    const input = document.createElement("input");
    input.type = "radio";
    input.name = "span";
    input.value = String(span);
    input.checked = span === view.spanS;
    input.addEventListener("change", () => {
      view.show(span);
      changed();
    });
    const label = document.createElement("label");
    label.append(input, `${span} s`);
    return label;
  }),
);

onThemeChange(() => {
  charts.redraw();
  if (space && model.hello) {
    space.begin(model.hello.world, model.hello.device.lanes);
  }
});

const counted = { frames: 0, allFrames: 0, sinceMs: performance.now(), perSecond: NaN, drawMs: 0, drawMsEach: NaN };
const pace = new Pace();
let lastMs = performance.now();
let readS = -Infinity;
let seenS = -Infinity;

function frame(nowMs) {
  requestAnimationFrame(frame);
  const begun = performance.now();
  const nowS = nowMs / 1000;
  view.follow(model.newestS, (nowMs - lastMs) / 1000);
  const isTurn = pace.next(nowMs - lastMs);
  lastMs = nowMs;
  hand.frame(nowS);
  space?.draw();
  toolNames.draw();
  if (model.hello && (fit || isTurn)) {
    charts.draw(nowS, fit);
    fit = false;
  }
  if (model.hello && nowS - readS >= READ_OUT_S) {
    readS = nowS;
    charts.read();
  }
  if (model.hello && model.state && nowS - seenS >= SENTENCE_S) {
    seenS = nowS;
    const lanes = model.state.lanes.map(({ method }, lane) => ({ method, ...createdWithin(model, lane, view.spanS) }));
    const inWords = (force) => (Number.isNaN(force) ? "–" : `${digits(force, 2)} N`);
    const felt = model.state.lanes.map(({ method }, lane) => ({
      method,
      forces: devices.map(({ force }) => inWords(model.newest(lane, force))),
    }));
    const names = devices.map(({ name }) => name);
    place("seen").textContent = `${seenInWords(lanes)} ${forcesInWords(names, felt)}`.trim();
  }
  counted.frames += 1;
  counted.allFrames += 1;
  counted.drawMs += performance.now() - begun;
  const passed = nowMs - counted.sinceMs;
  if (passed >= 1000) {
    counted.perSecond = (1000 * counted.frames) / passed;
    counted.drawMsEach = counted.drawMs / counted.frames;
    Object.assign(counted, { frames: 0, drawMs: 0, sinceMs: nowMs });
    status.screenRate = counted.perSecond;
    status.serve();
  }
}
requestAnimationFrame(frame);

// To look at from the console, and for tests; nothing here reads it.
globalThis.palpate = { model, view, space, charts, counted, link, hand };

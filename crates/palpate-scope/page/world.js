// Puts the page of a world together.

import { Banners } from "./banners.js";
import { Charts } from "./charts.js";
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
import { tripInWords } from "./trips.js";
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
  banners.show("webgl", `This browser draws nothing in three dimensions: ${error.message}. The charts go on.`);
}
let fit = false;
const hand = new HandInSpace(canvas, space, model, (message) => link.say(message));

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
  place("pause").textContent = view.paused ? "Go on" : "Pause";
  place("pause").setAttribute("aria-pressed", String(view.paused));
  charts.selectable(view.paused);
  charts.redraw();
}

model.addEventListener("hello", ({ detail: { isNew } }) => {
  status.anew();
  if (isNew) {
    const { title, device, world } = model.hello;
    news.begin(title);
    charts.build();
    space?.begin(world, device.lanes);
    place("let-go").hidden = !device.pointer;
    const turning = hand.turns ? " With ctrl, or by X, Y and Z (with shift back), it turns." : "";
    place("keys").textContent = device.pointer
      ? `Drag to move the hand in the plane of the screen; with shift, or by the wheel, to and from you.${turning} Right button: turn the view. Arrows and page keys move by 1 mm; Escape lets go.`
      : `${device.name}: this device is not led from here. Right button: turn the view.`;
  }
});

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
    banners.show(`trip-${lane + 1}`, tripInWords(state.lanes[lane], lane + 1), rearm);
  });
  if (space) {
    space.hand = state.hand_m;
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
    const forces = model.state.lanes.map((_, lane) => model.newest(lane, "force_on_device_n"));
    const felt = forces.map((force) => (Number.isNaN(force) ? "–" : `${digits(force, 2)} N`)).join(", ");
    place("seen").textContent = `${seenInWords(lanes)} Force on the device now: ${felt}.`.trim();
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

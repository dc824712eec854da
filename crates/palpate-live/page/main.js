// Puts the page together.

import { Banners } from "./banners.js";
import { Charts } from "./charts.js";
import { Contact } from "./contact.js";
import { Hand } from "./hand.js";
import { Link } from "./link.js";
import { Methods } from "./methods.js";
import { Model } from "./model.js";
import { News } from "./news.js";
import { Pace, SAY_S, Turns } from "./pace.js";
import { readSamples, say } from "./protocol.js";
import { refusalInWords } from "./refusal.js";
import { Scene } from "./scene.js";
import { createdWithin, seenInWords } from "./seen.js";
import { Status, aboutBuffer } from "./status.js";
import { onThemeChange, readTheme } from "./theme.js";
import { ModelValues } from "./model_values.js";
import { Toolbar } from "./toolbar.js";
import { safetyStopInWords } from "./safety_stops.js";
import { View } from "./view.js";

// Update interval of the charts if the user prefers reduced motion.
const STILL_S = 0.5;
const READ_OUT_S = 0.1;
// A sentence that changes more often is not read.
const SENTENCE_S = 0.5;

const place = (id) => document.getElementById(id);
const still = matchMedia("(prefers-reduced-motion: reduce)");
const wide = matchMedia("(min-width: 900px)");

readTheme();
const model = new Model();
const view = new View();
const banners = new Banners(place("banners"));
const news = new News(place, model, banners);
const scene = new Scene(place("scene"), model);
const charts = new Charts(place("charts"), model, view, changed);
const toolbar = new Toolbar(place, { model, view, scene, charts }, changed);
const status = new Status({ table: place("status"), served: place("served"), recording: place("recording") }, model);

// Of several changes of a value between two messages the last counts.
let pending = null;
/** What was used last: it shows a refusal that names no field. */
let asked = null;
const methods = new Methods(place("lanes"), model, (message) => later(methods, message));
const contact = new Contact(place("contact"), model, (message) => later(contact, message));
const modelValues = new ModelValues(place("modelValues"), model, (message) => later(modelValues, message));
const hand = new Hand(place("scene"), scene, model, send);
let fit = false;

const link = new Link(location.search, {
  open: () => news.found(),
  text: (message) => model.take(message),
  samples: (bytes) => model.takeSamples(readSamples(bytes, model.names.length), view.keepFromS),
  lost: (why, waitMs) => news.lost(why, waitMs, () => link.open()),
  wrong: (error) => news.wrong(error),
});

function send(message) {
  return link.say(message);
}

function later(who, message) {
  asked = who;
  forgive();
  pending = { ...pending, ...message };
}

/** A reason for a refusal stands until something else is entered, else it would stand beside a value that is right. */
function forgive() {
  if (model.hello) {
    contact.forgive();
    modelValues.forgive();
    methods.forgive();
  }
}
place("panel").addEventListener("input", forgive);

/** Another stretch of time is to be seen. */
function changed() {
  fit = true;
  toolbar.take();
  charts.redraw();
}

model.addEventListener("hello", ({ detail: { isNew } }) => {
  status.anew();
  if (isNew) {
    build();
  }
});

/** Makes what depends on what hello has told. */
function build() {
  const { title, device } = model.hello;
  news.begin(title);
  methods.build();
  contact.build();
  modelValues.build();
  charts.build();
  scene.begin();
  toolbar.take();
  place("let-go").hidden = !device.pointer;
  place("keys").textContent = device.pointer
    ? "Drag to move the hand, or use the arrow keys; Escape releases it."
    : `${device.name}: this device cannot be moved from the page.`;
}

model.addEventListener("state", () => {
  const { state } = model;
  methods.take(state);
  contact.take(state);
  modelValues.take(state);
  charts.name();
  place("record").setAttribute("aria-pressed", String(state.recording !== null));
  status.tell();
  [0, 1].forEach((lane) => {
    const rearm = { label: "Rearm", act: () => send(say.rearm(lane)) };
    banners.show(`safety-stop-${lane + 1}`, safetyStopInWords(state.lanes[lane], lane + 1), rearm);
  });
});

model.addEventListener("anew", () => {
  view.anew();
  status.anew();
  changed();
});

model.addEventListener("status", () => status.take());

model.addEventListener("refused", ({ detail: { about, text } }) => {
  if (about !== "set" || !model.state) {
    banners.show("refused", `Refused: ${refusalInWords(text).words}.`, { label: "Close", act: () => banners.show("refused", null) });
  } else if (!contact.refuse(text, asked === contact) && !modelValues.refuse(text, asked === modelValues)) {
    methods.refuse(text);
  }
  if (model.state) {
    // The state has not changed, so the server sends none: replace the displayed request by the state.
    methods.take(model.state);
    contact.take(model.state);
    modelValues.take(model.state);
  }
});

place("record").addEventListener("click", () => send(say.record(model.state?.recording === null)));
place("restart").addEventListener("click", () => send(say.restart()));
place("let-go").addEventListener("click", () => hand.letGo());

onThemeChange(() => charts.redraw());

function fold() {
  place("panel").open = wide.matches;
}
wide.addEventListener("change", fold);
fold();

const counted = { allFrames: 0, frames: 0, sinceMs: performance.now(), drawMs: 0, perSecond: NaN, drawMsEach: NaN };
let lastMs = performance.now();
const pace = new Pace();
let drawnS = -Infinity;
let readS = -Infinity;
let seenS = -Infinity;
const saying = new Turns(SAY_S);

function frame(nowMs) {
  requestAnimationFrame(frame);
  const begun = performance.now();
  const nowS = nowMs / 1000;
  view.follow(model.newestS, (nowMs - lastMs) / 1000);
  const isTurn = pace.next(nowMs - lastMs);
  lastMs = nowMs;
  if (saying.next(nowS)) {
    hand.flush();
    if (pending) {
      send(pending);
      pending = null;
    }
  }
  scene.draw(nowS, still.matches);
  if (model.hello && (fit || (still.matches ? nowS - drawnS >= STILL_S : isTurn))) {
    drawnS = nowS;
    charts.draw(nowS, fit);
    fit = false;
  }
  if (model.hello && nowS - readS >= READ_OUT_S) {
    readS = nowS;
    charts.read();
    hand.describe();
    // It counts seconds: read out each time it would hide all else.
    place("buffer").textContent = aboutBuffer(model, view);
  }
  if (model.hello && model.state && nowS - seenS >= SENTENCE_S) {
    seenS = nowS;
    const lanes = model.state.lanes.map(({ method }, lane) => ({ method, ...createdWithin(model, lane, view.spanS) }));
    place("seen").textContent = seenInWords(lanes);
  }
  counted.allFrames += 1;
  counted.frames += 1;
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
globalThis.palpate = { model, view, scene, charts, counted, link };

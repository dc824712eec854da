// Assembles the playground: the parts of the page of `palpate live`, on a loop in a worker.

import { Banners } from "./page/banners.js";
import { Charts } from "./page/charts.js";
import { Contact } from "./page/contact.js";
import { CHARTS } from "./page/curves.js";
import { Hand } from "./page/hand.js";
import { Methods } from "./page/methods.js";
import { Model } from "./page/model.js";
import { Pace, SAY_S, Turns } from "./page/pace.js";
import { readSamples, say } from "./page/protocol.js";
import { refusalInWords } from "./page/refusal.js";
import { Scene } from "./page/scene.js";
import { createdWithin, seenInWords } from "./page/seen.js";
import { quantity } from "./page/si.js";
import { aboutBuffer } from "./page/status.js";
import { onThemeChange, readTheme } from "./page/theme.js";
import { Toolbar } from "./page/toolbar.js";
import { safetyStopInWords } from "./page/safety_stops.js";
import { View } from "./page/view.js";
import { Device } from "./device.js";
import { read, written, writtenWorld } from "./fragment.js";
import { Loop } from "./loop.js";
import { PRESETS, START, messagesOf, settingsOf } from "./presets.js";
import { TooSlow, paceInWords } from "./slow.js";
import { WorldView } from "./world.js";

// Interval of chart updates for users who prefer reduced motion.
const STILL_S = 0.5;
const READ_OUT_S = 0.1;
const SENTENCE_S = 0.5;
const SPAN_S = 5;
// Distance beyond which an object has flown off and will not return by itself.
const FAR_M = 10;

const place = (id) => document.getElementById(id);
const still = matchMedia("(prefers-reduced-motion: reduce)");
const wide = matchMedia("(min-width: 900px)");

readTheme();
const model = new Model();
const view = new View();
view.show(SPAN_S);
const banners = new Banners(place("banners"));
const scene = new Scene(place("scene"), model);
// Simulated time is never late.
const charts = new Charts(
  place("charts"),
  model,
  view,
  changed,
  CHARTS.filter(({ id }) => id !== "timing"),
);
const toolbar = new Toolbar(place, { model, view, scene, charts }, changed);
const methods = new Methods(place("lanes"), model, (message) => later(methods, message));
const contact = new Contact(place("contact"), model, (message) => later(contact, message));
const device = new Device(place("device"), model, (message) => later(device, message));
const hand = new Hand(place("scene"), scene, model, send);
const worlds = new WorldView(place, { openWorld, lead: (device, to) => loop.ask({ type: "lead", device, to }) });
const slow = new TooSlow();
/** Messages to send with the next frame: the newest message of each type, with all its changes. */
const pending = new Map();
/** The last used input, which shows a refusal without a field. */
let asked = null;
/** "contact" or "world": the current view. */
let seen = null;
/** The link to open once the loop is loaded. */
let wanted = read(location.hash);
/** The last fragment written by the page itself. */
let ownFragment = null;
/** Stopped by the button, or by itself; a hidden tab pauses too. */
let stopped = false;
/** Whether it has stopped because an object has flown off. */
let hasFlown = false;
let fit = false;

const scenes = new Map();
async function sceneNamed(name) {
  if (!scenes.has(name)) {
    const response = await fetch(new URL(`scenes/${name}.toml`, import.meta.url));
    if (!response.ok) {
      throw new Error(`unknown scene “${name}”`);
    }
    scenes.set(name, await response.text());
  }
  return scenes.get(name);
}

const loop = new Loop({
  ready: () => open(wanted),
  text: (message) => model.take(message),
  samples: (bytes) => model.takeSamples(readSamples(bytes, model.names.length), view.keepFromS),
  drawn: (drawn) => worlds.begin(drawn),
  world(now) {
    worlds.take(now);
    watchFarWorld();
  },
  pace(report) {
    place("pace").textContent = paceInWords(report);
    const about = slow.about(report);
    banners.show("slow", about);
    globalThis.palpate.pace = report;
  },
  failed(why) {
    banners.show("failed", `The loop has ended: ${why}. Reload the page.`);
    connection("lost", "ended");
  },
});

function send(message) {
  return loop.say(message);
}

/** Opens the contents of a link. */
async function open(link) {
  wanted = link;
  banners.show("link", link.faults.length > 0 ? `Invalid in the link: ${link.faults.join("; ")}.` : null);
  try {
    if (link.world === null) {
      show("contact");
      const source = await sceneNamed("live");
      loop.ask({ type: "open", scene: source, messages: messagesOf(link.settings) });
      send(say.hand(link.settings.hand_m));
    } else {
      await openWorld(link.world, link.worldMethods ?? ["basic", "coupled"]);
    }
    if (!document.hidden) {
      goOn();
    }
  } catch (error) {
    if (link.world === null) {
      banners.show("link", `${error.message}.`);
    } else {
      open({ ...read(""), faults: [error.message] });
    }
  }
}

async function openWorld(world, methods) {
  const source = await sceneNamed(world);
  show("world");
  banners.show("flown", null);
  if (hasFlown) {
    goOn();
  }
  worlds.chosen = { world, methods };
  tellLink(writtenWorld(world, methods));
  loop.ask({ type: "openWorld", world: source, methods });
}

/** Restarts the loop with these settings. */
function begin(settings) {
  view.anew();
  loop.ask({ type: "begin", messages: messagesOf(settings) });
  send(say.hand(settings.hand_m));
  banners.show("flown", null);
  goOn();
}

function show(what) {
  seen = what;
  place("contact-view").hidden = what !== "contact";
  place("presets").hidden = what !== "contact";
  place("world-view").hidden = what !== "world";
  place("gallery").hidden = what !== "world";
  place("copy").hidden = false;
  place("view-contact").setAttribute("aria-pressed", String(what === "contact"));
  place("view-worlds").setAttribute("aria-pressed", String(what === "world"));
  worlds.isSeen = what === "world";
  slow.forget();
  banners.show("slow", null);
}

/** Writes the link of the current view into the address, without a history entry. */
function tellLink(fragment) {
  if (fragment !== ownFragment) {
    ownFragment = fragment;
    history.replaceState(null, "", fragment === "" ? location.pathname + location.search : `#${fragment}`);
  }
}

function later(who, message) {
  asked = who;
  forgive();
  pending.set(message.type, { ...pending.get(message.type), ...message });
}

/** Clears the reason of a refusal at the next input; otherwise it would remain beside a valid value. */
function forgive() {
  if (model.hello) {
    contact.forgive();
    device.forgive();
    methods.forgive();
  }
}
place("panel").addEventListener("input", forgive);

function connection(kind, text) {
  place("connection").dataset.kind = kind;
  place("connection").textContent = text;
}

function goOn() {
  hasFlown = false;
  stopped = false;
  loop.go();
  slow.forget();
  tellStop();
}

function hold() {
  stopped = true;
  loop.stop();
  tellStop();
}

function tellStop() {
  connection(stopped ? "held" : "live", stopped ? "stopped" : "running");
  place("stop").setAttribute("aria-pressed", String(stopped));
  place("stop").textContent = stopped ? "Resume" : "Stop";
}

/** Updates the view for another time span. */
function changed() {
  fit = true;
  toolbar.take();
  charts.redraw();
}

model.addEventListener("hello", ({ detail: { isNew } }) => {
  if (isNew) {
    methods.build();
    contact.build();
    device.build();
    charts.build();
    scene.begin();
    toolbar.take();
  }
});

model.addEventListener("state", () => {
  const { state } = model;
  methods.take(state);
  contact.take(state);
  device.take(state);
  charts.name();
  if (seen === "contact") {
    tellLink(written(settingsOf(state)));
  }
  markPreset(settingsOf(state));
  [0, 1].forEach((lane) => {
    const rearm = { label: "Rearm", act: () => send(say.rearm(lane)) };
    banners.show(`safety-stop-${lane + 1}`, safetyStopInWords(state.lanes[lane], lane + 1), rearm);
  });
});

model.addEventListener("anew", () => {
  view.anew();
  changed();
});

model.addEventListener("refused", ({ detail: { about, text } }) => {
  if (about === "device" && model.state) {
    device.refuse(text);
  } else if (about !== "set" || !model.state) {
    banners.show("refused", `Refused: ${refusalInWords(text).words}.`, {
      label: "Close",
      act: () => banners.show("refused", null),
    });
  } else if (!contact.refuse(text, asked === contact)) {
    methods.refuse(text);
  }
  if (model.state) {
    methods.take(model.state);
    contact.take(model.state);
    device.take(model.state);
  }
});

/** Marks the preset with the current settings, for any position of the hand. */
function markPreset(settings) {
  const asLink = (some) => written({ ...START, ...some, hand_m: START.hand_m });
  const now = asLink(settings);
  for (const { id, settings: some } of PRESETS) {
    const button = place("presets").querySelector(`[data-preset="${id}"]`);
    button.setAttribute("aria-pressed", String(asLink(some) === now));
  }
}

/** Stops the loop if a body of a world has flown off. */
function watchFarWorld() {
  const far = worlds.far(FAR_M);
  if (far && !stopped) {
    flown(far);
  }
}

/** Stops the loop, and names the object that has flown off. */
function flown({ method, what, at }) {
  hold();
  hasFlown = true;
  const restart = { label: "Restart", act: () => place("restart").click() };
  banners.show("flown", `The loop has stopped: the ${what} of ${method} is ${quantity(Math.abs(at), "m")} away.`, restart);
}

/** Stops the loop, with a message, if an object has flown off: only a restart brings it back. */
function watchFar() {
  const { state } = model;
  const far = state.lanes.flatMap(({ method }, lane) =>
    ["object_position_m", "device_position_m"]
      .map((column) => ({ method, what: column.split("_")[0], at: model.newest(lane, column) }))
      .filter(({ at }) => Math.abs(at) > FAR_M),
  );
  if (far.length > 0 && !stopped) {
    flown(far[0]);
  }
}

place("stop").addEventListener("click", () => (stopped ? goOn() : hold()));
place("restart").addEventListener("click", () => {
  banners.show("flown", null);
  if (seen === "world") {
    openWorld(worlds.chosen.world, worlds.chosen.methods);
  } else {
    send(say.restart());
  }
  goOn();
});
place("copy").addEventListener("click", async () => {
  const button = place("copy");
  try {
    await navigator.clipboard.writeText(location.href);
    button.textContent = "Copied";
  } catch {
    // Without clipboard permission the address bar contains the link.
    button.textContent = "See the address bar";
  }
  setTimeout(() => (button.textContent = "Copy link"), 2000);
});
place("let-go").addEventListener("click", () => hand.letGo());
place("view-contact").addEventListener("click", () => {
  if (seen !== "contact") {
    open(read(""));
  }
});
place("view-worlds").addEventListener("click", () => {
  if (seen !== "world") {
    open({ ...read(""), world: worlds.chosen?.world ?? "pinch", worldMethods: worlds.chosen?.methods ?? null });
  }
});

const label = document.createElement("span");
label.className = "name";
label.textContent = "Break it:";
place("presets").append(
  label,
  ...PRESETS.map(({ id, name, about, settings }) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.preset = id;
    button.textContent = name;
    button.title = about;
    button.addEventListener("click", () => begin({ ...START, ...settings }));
    return button;
  }),
);

addEventListener("hashchange", () => {
  if (location.hash.replace(/^#/, "") !== ownFragment) {
    open(read(location.hash));
  }
});

document.addEventListener("visibilitychange", () => {
  if (document.hidden) {
    loop.stop();
    connection("held", "paused while hidden");
  } else if (!stopped && seen !== null) {
    goOn();
  }
});

onThemeChange(() => charts.redraw());

function fold() {
  place("panel").open = wide.matches;
}
wide.addEventListener("change", fold);
fold();

const counted = { allFrames: 0, firstPictureMs: NaN };
let lastMs = performance.now();
const pace = new Pace();
let drawnS = -Infinity;
let readS = -Infinity;
let seenS = -Infinity;
const saying = new Turns(SAY_S);

function frame(nowMs) {
  requestAnimationFrame(frame);
  const nowS = nowMs / 1000;
  const passedMs = nowMs - lastMs;
  lastMs = nowMs;
  counted.allFrames += 1;
  if (seen === "world") {
    worlds.draw(nowS);
    return;
  }
  if (!stopped) {
    view.follow(model.newestS, passedMs / 1000);
  }
  const isTurn = pace.next(passedMs);
  if (saying.next(nowS)) {
    hand.flush();
    pending.forEach((message) => send(message));
    pending.clear();
  }
  if (!model.hello || !model.state) {
    return;
  }
  scene.draw(nowS, still.matches);
  if (Number.isNaN(counted.firstPictureMs) && model.newestS > 0) {
    counted.firstPictureMs = performance.now();
  }
  if (fit || (still.matches ? nowS - drawnS >= STILL_S : isTurn)) {
    drawnS = nowS;
    charts.draw(nowS, fit);
    fit = false;
  }
  if (nowS - readS >= READ_OUT_S) {
    readS = nowS;
    charts.read();
    hand.describe();
    place("buffer").textContent = aboutBuffer(model, view);
    watchFar();
  }
  if (nowS - seenS >= SENTENCE_S) {
    seenS = nowS;
    const lanes = model.state.lanes.map(({ method }, lane) => ({ method, ...createdWithin(model, lane, view.spanS) }));
    place("seen").textContent = seenInWords(lanes);
  }
}
requestAnimationFrame(frame);

// For the console and for tests; no code here reads it.
globalThis.palpate = { model, view, scene, charts, counted, link: loop, worlds, pace: null };

// Puts the page of a world together.

import { Banners } from "./banners.js";
import { Charts } from "./charts.js";
import { Link } from "./link.js";
import { Model } from "./model.js";
import { News } from "./news.js";
import { Pace, SAY_S, Turns } from "./pace.js";
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
/** How far a key moves the hand [m], and a notch of the wheel. */
const KEY_M = 1e-3;
const NOTCH_M = 1e-3;
/** How far a key turns the hand [rad], and a way on the screen [rad/px]. */
const KEY_RAD = Math.PI / 180;
const PIXEL_RAD = 0.008;

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
/** Where the hand is to be [m], and whether that has not been said yet. */
let wish = null;
let isSaid = true;
/** How the hand is to be turned, w, x, y, z, and whether that has not been said yet. */
let turned = null;
let isTurnSaid = true;

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
    const turning = turns() ? " With ctrl, or by X, Y and Z (with shift back), it turns." : "";
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
  view.anew();
  status.anew();
  changed();
});
model.addEventListener("status", () => status.take());
model.addEventListener("refused", ({ detail: { text } }) => {
  banners.show("refused", `Refused: ${text}.`, { label: "Close", act: () => banners.show("refused", null) });
});

/** Where the hand is to be next: what was wished last, what the server says, or where the tool begins. */
function from() {
  return wish ?? model.state?.hand_m ?? model.hello?.world.tools[0].position_m ?? [0, 0, 0];
}

function lead(to) {
  if (model.hello?.device.pointer) {
    wish = to;
    isSaid = false;
  }
}

/** Whether the hand turns its tool. */
function turns() {
  return Boolean(model.hello?.device.pointer && model.hello.world.tools[0]?.turns);
}

/** How the hand is to be turned next. */
function turnedFrom() {
  return turned ?? model.state?.hand_orientation ?? model.hello?.world.tools[0].orientation ?? [1, 0, 0, 0];
}

function turnTo(orientation) {
  if (turns()) {
    turned = orientation;
    isTurnSaid = false;
  }
}

function letGo() {
  wish = null;
  isSaid = true;
  link.say(say.tool(null));
}

/** What a pointer that is down does: `grip` is what the hand is away from where the pointer is. */
const downs = new Map();

canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("pointerdown", (event) => {
  if (!space || !model.hello) {
    return;
  }
  canvas.setPointerCapture(event.pointerId);
  const at = from();
  const met = space.meet(event.offsetX, event.offsetY, at);
  // Two fingers, or another button, turn the view.
  const isTurning = event.button !== 0 || event.altKey || downs.size > 0;
  downs.set(event.pointerId, { x: event.offsetX, y: event.offsetY, isTurning, grip: met?.map((x, i) => at[i] - x) });
  if (!isTurning) {
    canvas.classList.add("leading");
    lead(at);
  }
});
canvas.addEventListener("pointermove", (event) => {
  const down = downs.get(event.pointerId);
  if (!down) {
    return;
  }
  const [dx, dy] = [event.offsetX - down.x, event.offsetY - down.y];
  Object.assign(down, { x: event.offsetX, y: event.offsetY });
  if (down.isTurning || downs.size > 1) {
    space.turn(-PIXEL_RAD * dx, PIXEL_RAD * dy);
  } else if (event.ctrlKey && turns()) {
    turnTo(space.rolled(turnedFrom(), PIXEL_RAD * dx, PIXEL_RAD * dy));
    const met = space.meet(event.offsetX, event.offsetY, from());
    down.grip = met?.map((x, i) => from()[i] - x);
  } else if (event.shiftKey) {
    lead(space.deeper(from(), (-dy * space.distance) / canvas.clientHeight));
    const met = space.meet(event.offsetX, event.offsetY, from());
    down.grip = met?.map((x, i) => from()[i] - x);
  } else {
    const met = space.meet(event.offsetX, event.offsetY, from());
    if (met && down.grip) {
      lead(met.map((x, i) => x + down.grip[i]));
    }
  }
});
for (const kind of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(kind, (event) => {
    downs.delete(event.pointerId);
    canvas.classList.toggle("leading", downs.size > 0);
  });
}
canvas.addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    if (!space) {
      return;
    }
    const notches = -event.deltaY / 100;
    if (event.ctrlKey || !model.hello?.device.pointer) {
      space.zoom(1.1 ** -notches);
    } else {
      lead(space.deeper(from(), notches * NOTCH_M));
    }
  },
  { passive: false },
);
canvas.addEventListener("keydown", (event) => {
  const step = KEY_M * (event.shiftKey ? 0.1 : 1);
  const by = {
    ArrowLeft: [-step, 0, 0],
    ArrowRight: [step, 0, 0],
    ArrowUp: [0, step, 0],
    ArrowDown: [0, -step, 0],
    PageUp: [0, 0, step],
    PageDown: [0, 0, -step],
  }[event.key];
  if (event.key === "Escape") {
    letGo();
  } else if (event.key === "+" || event.key === "-") {
    space?.zoom(event.key === "+" ? 0.8 : 1.25);
  } else if (turns() && "xyz".includes(event.key.toLowerCase())) {
    const half = (event.shiftKey ? -0.5 : 0.5) * KEY_RAD;
    const about = [0, 1, 2].map((axis) => ("xyz"[axis] === event.key.toLowerCase() ? Math.sin(half) : 0));
    turnTo(product([Math.cos(half), ...about], turnedFrom()));
  } else if (by) {
    event.preventDefault();
    lead(from().map((x, axis) => x + by[axis]));
  }
});

/** The product of two quaternions w, x, y, z. */
function product([a, b, c, d], [w, x, y, z]) {
  return [
    a * w - b * x - c * y - d * z,
    a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x,
    a * z + b * y - c * x + d * w,
  ];
}

place("restart").addEventListener("click", () => {
  wish = null;
  turned = null;
  link.say(say.restart());
});
place("let-go").addEventListener("click", letGo);
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
const saying = new Turns(SAY_S);
const turning = new Turns(SAY_S);
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
  if (!isSaid && wish && saying.next(nowS)) {
    isSaid = link.say(say.tool(wish));
  }
  if (!isTurnSaid && turned && turning.next(nowS)) {
    isTurnSaid = link.say(say.turn(turned));
  }
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
globalThis.palpate = { model, view, space, charts, counted, link, from };

// The view of worlds: the selection, a picture for each method, and the hands.

import { seenInWords } from "./page/seen.js";
import { quantity } from "./page/si.js";
import { Camera, about } from "./camera.js";
import { drawWorld } from "./solids.js";

export const WORLDS = [
  ["pinch", "Pinch a cube"],
  ["pushed-block", "Push a block"],
  ["row", "A row of balls"],
  ["paddle", "A paddle"],
  ["groove-90", "A groove of 90°"],
  ["groove-60-rough", "A rough groove of 60°"],
];
/** The methods whose settings these worlds all contain. */
const METHODS = ["basic", "coupled"];
const SENTENCE_S = 0.5;
const WINDOW_S = 5;
const STEP_M = 0.001;
const LEAP_M = 0.005;
const NEAR_PX = 48;

export class WorldView {
  /** @param {{openWorld: (world: string, methods: string[]) => void, lead: (device: number, to: number[]) => void}} acts */
  constructor(place, acts) {
    this.place = place;
    this.acts = acts;
    this.isSeen = false;
    this.chosen = null;
    this.drawn = null;
    this.now = null;
    this.tool = 0;
    this.lanes = [];
    this.saidS = -Infinity;
    this.camera = new Camera();
    this.build();
  }

  build() {
    const { place } = this;
    const name = document.createElement("span");
    name.className = "name";
    name.textContent = "Worlds:";
    this.buttons = WORLDS.map(([id, title]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.world = id;
      button.textContent = title;
      button.addEventListener("click", () => this.acts.openWorld(id, this.chosen?.methods ?? METHODS));
      return button;
    });
    place("gallery").append(name, ...this.buttons);
    this.selects = [0, 1].map((lane) => {
      const select = place(`world-method-${lane + 1}`);
      select.append(...METHODS.map((method) => new Option(method, method)));
      select.addEventListener("change", () => {
        const methods = this.selects.map(({ value }) => value);
        this.acts.openWorld(this.chosen.world, methods);
      });
      return select;
    });
  }

  /** Stores the objects to draw. */
  begin(drawn) {
    this.drawn = drawn;
    /** World of the drawn objects; the chosen one may still be loading. */
    this.shown = this.chosen?.world ?? null;
    this.now = null;
    this.tool = 0;
    this.history = [];
    this.targets = drawn.tools.map(({ start_m: start }) => [...start]);
    this.camera = new Camera(...about(drawn));
    this.lanes = drawn.methods.map((method, lane) => this.figure(method, lane));
    this.place("world-lanes").replaceChildren(...this.lanes.map(({ root }) => root));
    for (const button of this.buttons) {
      button.setAttribute("aria-pressed", String(button.dataset.world === this.chosen?.world));
    }
    this.selects.forEach((select, lane) => {
      select.value = drawn.methods[lane] ?? "";
    });
    this.place("world-seen").textContent = "";
  }

  figure(method, lane) {
    const root = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const name = document.createElement("b");
    name.className = `lane-${lane + 1}`;
    name.textContent = method;
    const text = document.createElement("span");
    caption.append(name, text);
    const canvas = document.createElement("canvas");
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", `${this.drawn.title}, rendered by ${method}`);
    root.append(caption, canvas);
    const figure = { root, canvas, text, context: canvas.getContext("2d"), lane };
    canvas.addEventListener("pointerdown", (event) => this.down(figure, event));
    canvas.addEventListener("pointermove", (event) => this.move(figure, event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(end, () => (this.drag = null));
    }
    canvas.addEventListener("keydown", (event) => this.key(event));
    return figure;
  }

  /** Stores the positions of all objects. */
  take(now) {
    this.now = now;
    const created = now.lanes.map(({ created_j: joules }) => joules);
    this.history.push({ t: now.t_s, created });
    while (this.history.length > 2 && now.t_s - this.history[1].t > WINDOW_S) {
      this.history.shift();
    }
  }

  /** Returns a body or a tool beyond the distance `most` [m], or null. */
  far(most) {
    for (const { method, bodies, tools_m: tools } of this.now.lanes) {
      const places = [...this.drawn.bodies.map(({ name }, i) => [name, bodies[i][0]]), ...this.drawn.tools.map(({ name }, i) => [name, tools[i]])];
      for (const [what, place] of places) {
        const at = Math.hypot(...place);
        if (at > most) {
          return { method, what, at };
        }
      }
    }
    return null;
  }

  down(figure, event) {
    if (event.button !== 0 || !this.now) {
      return;
    }
    figure.canvas.setPointerCapture(event.pointerId);
    figure.canvas.focus({ preventScroll: true });
    const { tools_m: tools } = this.now.lanes[figure.lane];
    const frame = this.camera.frame(figure.canvas);
    const far = tools.map((tool) => {
      const [x, y] = frame.at(tool);
      return Math.hypot(x - event.offsetX, y - event.offsetY);
    });
    const nearest = far.indexOf(Math.min(...far));
    const isTool = far[nearest] < NEAR_PX && !event.shiftKey;
    if (isTool) {
      this.tool = nearest;
    }
    this.drag = { pointer: event.pointerId, x: event.clientX, y: event.clientY, isTool };
    event.preventDefault();
  }

  move(figure, event) {
    if (!this.drag || event.pointerId !== this.drag.pointer) {
      return;
    }
    const right = event.clientX - this.drag.x;
    const down = event.clientY - this.drag.y;
    Object.assign(this.drag, { x: event.clientX, y: event.clientY });
    if (this.drag.isTool) {
      const { pxPerM } = this.camera.frame(figure.canvas);
      this.lead(right / pxPerM, -down / pxPerM, 0);
    } else {
      this.camera.turn(-0.008 * right, 0.008 * down);
    }
  }

  key(event) {
    const steps = {
      ArrowLeft: [-STEP_M, 0, 0],
      ArrowRight: [STEP_M, 0, 0],
      ArrowUp: [0, STEP_M, 0],
      ArrowDown: [0, -STEP_M, 0],
      PageUp: [0, 0, LEAP_M],
      PageDown: [0, 0, -LEAP_M],
    };
    const step = steps[event.key];
    if (step && !event.ctrlKey && !event.metaKey && !event.altKey) {
      event.preventDefault();
      this.lead(...step);
    } else if (event.key === "Tab" && !event.shiftKey && this.tool + 1 < this.drawn.tools.length) {
      event.preventDefault();
      this.tool += 1;
    }
  }

  /** Moves the hand of the chosen tool to the right, up and away in the view [m]. */
  lead(right, up, away) {
    const before = this.targets[this.tool];
    const to = this.camera.moved(before, right, up, away);
    const { start_m: start } = this.drawn.tools[this.tool];
    // Up to the limits of the loop.
    this.targets[this.tool] = to.map((x, axis) => Math.min(start[axis] + 0.2, Math.max(start[axis] - 0.2, x)));
    this.acts.lead(this.tool, this.targets[this.tool]);
  }

  draw(nowS) {
    if (!this.drawn || !this.now) {
      return;
    }
    this.lanes.forEach((figure, lane) => drawWorld(figure, this, this.now.lanes[lane]));
    if (nowS - this.saidS >= SENTENCE_S) {
      this.saidS = nowS;
      this.tell();
    }
  }

  tell() {
    const { history, now, drawn } = this;
    const [first] = history;
    const last = history.at(-1);
    const lanes = drawn.methods.map((method, lane) => ({
      method,
      createdJ: last.created[lane] - first.created[lane],
      seconds: last.t - first.t,
    }));
    this.place("world-seen").textContent = last.t > first.t ? `${drawn.title}. ${seenInWords(lanes)}` : drawn.title;
    this.lanes.forEach(({ text }, lane) => {
      const { forces_n: forces, refused } = now.lanes[lane];
      const sizes = forces.map((force) => quantity(Math.hypot(...force), "N", 2)).join(", ");
      text.textContent = `${sizes}${refused > 0 ? `, ${refused} samples refused` : ""}`;
    });
  }
}

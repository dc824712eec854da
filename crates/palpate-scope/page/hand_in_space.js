// Leading the hand of a world, and turning it: by dragging in the scene, by the wheel, or by keys.

import { SAY_S } from "./pace.js";
import { say } from "./protocol.js";
import { Wish } from "./wish.js";

/** How far a key moves the hand [m], and a notch of the wheel. */
const KEY_M = 1e-3;
const NOTCH_M = 1e-3;
const FINE = 0.1;
/** How far a key turns the hand [rad], and a way on the screen [rad/px]. */
const KEY_RAD = Math.PI / 180;
const PIXEL_RAD = 0.008;

export class HandInSpace {
  /**
   * @param {HTMLCanvasElement} canvas it is dragged, and has the focus for keys
   * @param {import("./space.js").Space | null} space null where the browser draws nothing in three dimensions
   * @param {import("./model.js").Model} model
   * @param {(message: object) => boolean} send
   */
  constructor(canvas, space, model, send) {
    Object.assign(this, { canvas, space, model, send });
    /** Where it is to be [m]. */
    this.led = new Wish(SAY_S);
    /** How it is to be turned, w, x, y, z. */
    this.turned = new Wish(SAY_S);
    /** What a pointer that is down does: `grip` is what the hand is away from where the pointer is. */
    this.downs = new Map();
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => this.up(event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  get isLeadable() {
    return this.model.hello?.device.pointer === true;
  }

  /** Whether it turns its tool. */
  get turns() {
    return this.isLeadable && this.model.hello.world.tools[0]?.turns === true;
  }

  /** The tool that nobody holds: as it is seen, or else as it began. */
  get tool() {
    const began = this.model.hello?.world.tools[0];
    const { position = began?.position_m ?? [0, 0, 0], orientation = began?.orientation ?? [1, 0, 0, 0] } = this.space?.tool() ?? {};
    return { position, orientation };
  }

  /** Where it is led from: what was asked for last, what the server says, or where the tool is. */
  get fromM() {
    return this.led.value ?? this.model.state?.hand_m ?? this.tool.position;
  }

  /** What it is turned from. */
  get turnedFrom() {
    const { hello, state } = this.model;
    const told = state?.hand_m ? (state.hand_orientation ?? hello.world.tools[0].orientation) : null;
    return this.turned.value ?? told ?? this.tool.orientation;
  }

  lead(toM) {
    if (this.isLeadable) {
      this.led.ask(toM);
    }
  }

  /** Turns the hand, which takes hold of its tool if it had let go. */
  turnTo(orientation) {
    if (!this.turns) {
      return;
    }
    if (!this.model.state?.hand_m) {
      this.lead(this.fromM);
    }
    const length = Math.hypot(...orientation);
    this.turned.ask(orientation.map((part) => part / length));
  }

  /** Nothing that was asked for counts any more. */
  drop() {
    this.led.drop();
    this.turned.drop();
  }

  letGo() {
    this.drop();
    this.send(say.tool(null));
  }

  /** With each frame of the screen, at this time [s]. */
  frame(nowS) {
    const { state } = this.model;
    this.led.frame(nowS, state?.hand_m, (to) => this.send(say.tool(to)));
    this.turned.frame(nowS, state?.hand_orientation, (to) => this.send(say.turn(to)));
  }

  /** What the hand is away from a place on the canvas, in the plane of the screen [m]. */
  gripAt(x, y) {
    const from = this.fromM;
    return this.space.meet(x, y, from)?.map((met, axis) => from[axis] - met);
  }

  down(event) {
    if (!this.space || !this.model.hello) {
      return;
    }
    this.canvas.setPointerCapture(event.pointerId);
    const [x, y] = [event.offsetX, event.offsetY];
    // Two fingers, or another button, turn the view.
    const turnsView = event.button !== 0 || event.altKey || this.downs.size > 0;
    this.downs.set(event.pointerId, { x, y, turnsView, grip: this.gripAt(x, y) });
    if (!turnsView) {
      this.canvas.classList.add("leading");
      this.lead(this.fromM);
    }
  }

  move(event) {
    const down = this.downs.get(event.pointerId);
    if (!down) {
      return;
    }
    const [x, y] = [event.offsetX, event.offsetY];
    const [dx, dy] = [x - down.x, y - down.y];
    Object.assign(down, { x, y });
    if (down.turnsView || this.downs.size > 1) {
      this.space.turn(-PIXEL_RAD * dx, PIXEL_RAD * dy);
    } else if (event.ctrlKey && this.turns) {
      this.turnTo(this.space.rolled(this.turnedFrom, PIXEL_RAD * dx, PIXEL_RAD * dy));
      down.grip = this.gripAt(x, y);
    } else if (event.shiftKey) {
      this.lead(this.space.deeper(this.fromM, (-dy * this.space.distance) / this.canvas.clientHeight));
      down.grip = this.gripAt(x, y);
    } else {
      const met = this.space.meet(x, y, this.fromM);
      if (met && down.grip) {
        this.lead(met.map((part, axis) => part + down.grip[axis]));
      }
    }
  }

  up(event) {
    this.downs.delete(event.pointerId);
    this.canvas.classList.toggle("leading", this.downs.size > 0);
  }

  wheel(event) {
    event.preventDefault();
    if (!this.space) {
      return;
    }
    const notches = -event.deltaY / 100;
    if (event.ctrlKey || !this.isLeadable) {
      this.space.zoom(1.1 ** -notches);
    } else {
      this.lead(this.space.deeper(this.fromM, notches * NOTCH_M));
    }
  }

  key(event) {
    // With these a key is the browser's.
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const step = KEY_M * (event.shiftKey ? FINE : 1);
    const by = {
      ArrowLeft: [-step, 0, 0],
      ArrowRight: [step, 0, 0],
      ArrowUp: [0, step, 0],
      ArrowDown: [0, -step, 0],
      PageUp: [0, 0, step],
      PageDown: [0, 0, -step],
    }[event.key];
    const about = ["x", "y", "z"].indexOf(event.key.toLowerCase());
    if (event.key === "Escape") {
      this.letGo();
    } else if (event.key === "+" || event.key === "-") {
      this.space?.zoom(event.key === "+" ? 0.8 : 1.25);
    } else if (about >= 0 && this.turns) {
      const half = (event.shiftKey ? -0.5 : 0.5) * KEY_RAD;
      const turn = [Math.cos(half), 0, 0, 0];
      turn[1 + about] = Math.sin(half);
      this.turnTo(product(turn, this.turnedFrom));
    } else if (by) {
      event.preventDefault();
      this.lead(this.fromM.map((x, axis) => x + by[axis]));
    }
  }
}

/** The product of two quaternions w, x, y, z. */
function product([a, b, c, d], [w, x, y, z]) {
  return [
    a * w - b * x - c * y - d * z,
    a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x,
    a * z + b * y - c * x + d * w,
  ];
}

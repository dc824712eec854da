// Leading the hands of a world, and turning them: by dragging in the scene, by the wheel, or by keys.

import { devicesOf } from "./devices.js";
import { Led } from "./led.js";

/** How far a key moves the hand [m], and a notch of the wheel. */
const KEY_M = 1e-3;
const NOTCH_M = 1e-3;
const FINE = 0.1;
/** How far a key turns the hand [rad], and a way on the screen [rad/px]. */
const KEY_RAD = Math.PI / 180;
const PIXEL_RAD = 0.008;
/** How far beside a tool a mouse and a finger take hold of it [px]. */
const BESIDE_PX = { mouse: 12, touch: 28 };
/** The choice of all devices. */
export const ALL = "all";

export class HandInSpace extends EventTarget {
  /**
   * @param {HTMLCanvasElement} canvas it is dragged, and has the focus for keys
   * @param {import("./space.js").Space | null} space null where the browser draws nothing in three dimensions
   * @param {import("./model.js").Model} model
   * @param {(message: object) => boolean} send
   */
  constructor(canvas, space, model, send) {
    super();
    Object.assign(this, { canvas, space, model, send });
    /** The hand of each device; none before hello. */
    this.hands = [];
    /** Number of the device that is led, or `ALL`. */
    this.choice = 0;
    /** The hand that follows the pointer itself; others that are led go the same way. */
    this.first = null;
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

  /** Makes the hands: another world has come. */
  begin() {
    this.hands = devicesOf(this.model.hello).map((_, number) => new Led(number, this.model, this.space, this.send));
    this.choose(Math.max(0, this.hands.findIndex(({ isLeadable }) => isLeadable)));
  }

  /** Leads this device from now on, or all of them; a device that is not led from here changes nothing. */
  choose(choice) {
    const chosen = choice === ALL ? this.hands.filter(({ isLeadable }) => isLeadable) : [this.hands[choice]];
    if (chosen.length === 0 || !chosen[0]) {
      return;
    }
    if (!chosen[0].isLeadable && this.isLeadable) {
      return;
    }
    // All of one are that one.
    this.choice = chosen.length === 1 ? chosen[0].number : choice;
    [this.first] = chosen;
    this.dispatchEvent(new Event("chosen"));
  }

  /** The hands that are led. */
  get chosen() {
    return this.choice === ALL ? this.hands.filter(({ isLeadable }) => isLeadable) : this.hands.filter(({ number }) => number === this.choice);
  }

  get isLeadable() {
    return this.hands.some(({ isLeadable }) => isLeadable);
  }

  /** Whether a hand that is led turns its tool. */
  get turns() {
    return this.chosen.some(({ turns }) => turns);
  }

  /** Where the hand that follows the pointer is led from [m]. */
  get fromM() {
    return this.first.fromM;
  }

  /** Leads the hand that follows the pointer to a place, and the others that are chosen by as much. */
  lead(toM) {
    const from = this.fromM;
    for (const hand of this.chosen) {
      hand.lead(hand === this.first ? toM : hand.fromM.map((x, axis) => x + toM[axis] - from[axis]));
    }
  }

  /** Turns each tool that is chosen from how it is. */
  turnEach(turned) {
    for (const hand of this.chosen) {
      hand.turnTo(turned(hand.turnedFrom));
    }
  }

  /** Nothing that was asked for counts any more. */
  drop() {
    this.hands.forEach((hand) => hand.drop());
  }

  letGo() {
    this.chosen.forEach((hand) => hand.letGo());
  }

  /** With each frame of the screen, at this time [s]. */
  frame(nowS) {
    this.hands.forEach((hand) => hand.frame(nowS));
  }

  /** What the hand is away from a place on the canvas, in the plane of the screen [m]. */
  gripAt(x, y) {
    const from = this.fromM;
    return this.space.meet(x, y, from)?.map((met, axis) => from[axis] - met);
  }

  /** The tool at the pointer is the one that is led, or that follows the pointer where all are. */
  takeHold(x, y, pointerType) {
    const at = this.hands.length > 1 ? this.space.toolAt(x, y, BESIDE_PX[pointerType] ?? BESIDE_PX.mouse) : null;
    if (at === null || !this.hands[at].isLeadable) {
      return;
    }
    if (this.choice === ALL) {
      this.first = this.hands[at];
    } else {
      this.choose(at);
    }
  }

  down(event) {
    if (!this.space || !this.first) {
      return;
    }
    this.canvas.setPointerCapture(event.pointerId);
    const [x, y] = [event.offsetX, event.offsetY];
    // Two fingers, or another button, turn the view.
    const turnsView = event.button !== 0 || event.altKey || this.downs.size > 0;
    if (!turnsView) {
      this.takeHold(x, y, event.pointerType);
    }
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
      this.turnEach((from) => this.space.rolled(from, PIXEL_RAD * dx, PIXEL_RAD * dy));
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
    if (!this.space || !this.first) {
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
    if (event.ctrlKey || event.metaKey || event.altKey || !this.first) {
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
      this.turnEach((from) => product(turn, from));
    } else if (this.hands.length > 1 && /^[0-9]$/.test(event.key)) {
      this.choose(event.key === "0" ? ALL : Number(event.key) - 1);
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

// Leading the hand: by dragging anywhere in the scene, or by keys.

import { REACH_M, say } from "./protocol.js";

const FINE = 0.1;
const STEP_M = 0.001;
const LEAP_M = 0.01;

export class Hand {
  /**
   * @param {HTMLElement} place the slider: it is dragged, and has the focus for keys
   * @param {import("./scene.js").Scene} scene
   * @param {import("./model.js").Model} model
   * @param {(message: object) => boolean} send
   */
  constructor(place, scene, model, send) {
    this.place = place;
    this.scene = scene;
    this.model = model;
    this.send = send;
    this.pointer = null;
    /** What is to be told with the next frame of the screen; undefined if nothing. */
    this.pending = undefined;
    place.addEventListener("pointerdown", (event) => this.down(event));
    place.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      place.addEventListener(end, (event) => this.up(event));
    }
    place.addEventListener("keydown", (event) => this.key(event));
  }

  get isLeadable() {
    return this.model.hello?.device.pointer === true;
  }

  /** Where the hand is led from: where it wants to be, or where the device is. */
  get fromM() {
    const device = this.model.newest(0, "device_position_m");
    return this.scene.handM ?? (Number.isFinite(device) ? device : this.scene.axis.lowM);
  }

  down(event) {
    if (!this.isLeadable || event.button !== 0 || this.pointer !== null) {
      return;
    }
    this.pointer = event.pointerId;
    this.place.setPointerCapture(event.pointerId);
    this.place.focus({ preventScroll: true });
    this.place.classList.add("held");
    this.lastY = event.clientY;
    this.lead(this.fromM);
    event.preventDefault();
  }

  move(event) {
    if (event.pointerId !== this.pointer) {
      return;
    }
    const slow = event.shiftKey ? FINE : 1;
    const byM = ((this.lastY - event.clientY) * slow) / this.scene.axis.pxPerM;
    this.lastY = event.clientY;
    this.lead(this.scene.ledM + byM);
  }

  up(event) {
    if (event.pointerId !== this.pointer) {
      return;
    }
    this.pointer = null;
    this.place.classList.remove("held");
    // The hand stays; what the server says of it counts again.
    this.flush();
    this.scene.ledM = null;
  }

  lead(toM) {
    const there = this.within(toM);
    this.scene.ledM = there;
    this.pending = there;
  }

  /** The nearest place to which the hand can be led: a device that is let go may be seen far beyond. */
  within(toM) {
    return Math.min(REACH_M, Math.max(-REACH_M, this.scene.axis.within(toM)));
  }

  letGo() {
    this.pointer = null;
    this.place.classList.remove("held");
    this.scene.ledM = null;
    this.pending = null;
  }

  key(event) {
    if (!this.isLeadable || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const { axis } = this.scene;
    const step = event.shiftKey ? STEP_M * FINE : STEP_M;
    const to = {
      ArrowUp: () => this.keyM + step,
      ArrowRight: () => this.keyM + step,
      ArrowDown: () => this.keyM - step,
      ArrowLeft: () => this.keyM - step,
      PageUp: () => this.keyM + LEAP_M,
      PageDown: () => this.keyM - LEAP_M,
      Home: () => axis.lowM,
      End: () => axis.highM,
    }[event.key];
    if (to) {
      event.preventDefault();
      // Earlier key presses are already on their way, although the server has not confirmed them.
      this.keyedM = this.within(to());
      this.keyedAtMs = event.timeStamp;
      this.pending = this.keyedM;
    } else if (event.key === "Escape") {
      event.preventDefault();
      this.keyedM = undefined;
      this.letGo();
    }
  }

  get keyM() {
    const isFresh = this.keyedM !== undefined && performance.now() - this.keyedAtMs < 500;
    return isFresh ? this.keyedM : this.fromM;
  }

  /** Tells the server, at most once for every frame of the screen. */
  flush() {
    if (this.pending !== undefined) {
      this.send(say.hand(this.pending));
      this.pending = undefined;
    }
  }

  /** Keeps what assistive technology reads true. */
  describe() {
    const { axis } = this.scene;
    const at = this.scene.handM;
    attribute(this.place, "aria-disabled", String(!this.isLeadable));
    attribute(this.place, "aria-valuemin", millimetres(this.within(axis.lowM)));
    attribute(this.place, "aria-valuemax", millimetres(this.within(axis.highM)));
    attribute(this.place, "aria-valuenow", millimetres(at ?? this.fromM));
    attribute(this.place, "aria-valuetext", at === null ? "released" : `${millimetres(at)} millimetres`);
  }
}

function attribute(place, name, value) {
  if (place.getAttribute(name) !== value) {
    place.setAttribute(name, value);
  }
}

function millimetres(metres) {
  return (metres * 1000).toFixed(1);
}

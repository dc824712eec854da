// The hand of one device of a world: where it is to be, and how it is to be turned.

import { devicesOf, handsOf } from "./devices.js";
import { SAY_S } from "./pace.js";
import { say } from "./protocol.js";
import { HandTarget } from "./hand_target.js";

export class Led {
  /**
   * @param {number} number of the device, from 0
   * @param {import("./model.js").Model} model that has heard hello
   * @param {import("./space.js").Space | null} space null where the browser draws nothing in three dimensions
   * @param {(message: object) => boolean} send
   */
  constructor(number, model, space, send) {
    Object.assign(this, { number, model, space, send });
    const devices = devicesOf(model.hello);
    const { name, pointer, turns, began } = devices[number];
    this.name = name;
    this.isLeadable = pointer;
    /** Whether it turns its tool. */
    this.turns = pointer && turns;
    this.began = began;
    // The server listens to a number of messages a second, of all hands together.
    const everyS = SAY_S * Math.max(1, devices.filter((device) => device.pointer).length);
    /** Where it is to be [m]. */
    this.led = new HandTarget(everyS);
    /** How it is to be turned, w, x, y, z. */
    this.turned = new HandTarget(everyS);
  }

  /** What the server says of it. */
  get reported() {
    return handsOf(this.model.state)[this.number] ?? {};
  }

  /** The tool that nobody holds: as it is seen, or else as it began. */
  get tool() {
    const { position = this.began.position, orientation = this.began.orientation } = this.space?.tool(this.number) ?? {};
    return { position, orientation };
  }

  /** Where it is led from: what was asked for last, what the server says, or where the tool is. */
  get fromM() {
    return this.led.value ?? this.reported.hand_m ?? this.tool.position;
  }

  /** What it is turned from. */
  get turnedFrom() {
    const { hand_m: place, hand_orientation: orientation } = this.reported;
    const reported = place ? (orientation ?? this.began.orientation) : null;
    return this.turned.value ?? reported ?? this.tool.orientation;
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
    if (!this.reported.hand_m) {
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
    this.send(say.tool(null, this.number));
  }

  /** With each frame of the screen, at this time [s]. */
  frame(nowS) {
    const { hand_m: place, hand_orientation: orientation } = this.reported;
    this.led.frame(nowS, place, (to) => this.send(say.tool(to, this.number)));
    this.turned.frame(nowS, orientation, (to) => this.send(say.turn(to, this.number)));
  }
}

// Requested target of the hand, until the server confirms it.

import { Turns } from "./pace.js";

/** So long after it was said, what the server says counts again: somebody else may lead the hand [s]. */
const KEPT_S = 1;
/** Numbers that differ by less are the same. */
const SAME = 1e-9;

export class HandTarget {
  /** @param {number} everyS how long after the last it is said at least [s] */
  constructor(everyS) {
    this.turns = new Turns(everyS);
    /** The numbers that were asked for; null if nothing is. */
    this.value = null;
    this.saidS = null;
  }

  /** @param {number[]} value */
  ask(value) {
    this.value = value;
    this.saidS = null;
  }

  drop() {
    this.value = null;
  }

  /**
   * With each frame of the screen, at this time [s].
   *
   * @param {number} nowS
   * @param {number[] | null | undefined} reported target of the hand according to the server
   * @param {(value: number[]) => boolean} send whether it was sent
   */
  frame(nowS, reported, send) {
    if (!this.value) {
      return;
    }
    if (this.saidS === null) {
      if (this.turns.next(nowS) && send(this.value)) {
        this.saidS = nowS;
      }
      return;
    }
    const isSo = reported?.length === this.value.length && reported.every((part, k) => Math.abs(part - this.value[k]) <= SAME);
    if (isSo || nowS - this.saidS >= KEPT_S) {
      this.drop();
    }
  }
}

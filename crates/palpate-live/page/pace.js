// Pacing of work on screen frames. The charts are drawn in every frame if that is cheap. Otherwise the scene and the
// hand have priority, and the charts skip frames.

const MAX_LEFT_OUT = 6;
const FRAME_MS = 1000 / 60;

export class Pace {
  constructor() {
    this.leftOut = 0;
    this.leaveOut = 0;
    this.drewLast = false;
  }

  /** With each frame: whether the charts are drawn in it, given how long the one before has lasted [ms]. */
  next(lastedMs) {
    if (this.drewLast) {
      // A frame that took three times as long as it should leaves two to the scene.
      const wanted = Math.max(0, Math.min(MAX_LEFT_OUT, Math.round(lastedMs / FRAME_MS) - 1));
      this.leaveOut = wanted;
      this.leftOut = 0;
    }
    this.drewLast = this.leftOut >= this.leaveOut;
    this.leftOut += 1;
    return this.drewLast;
  }
}

/** The server listens to 200 messages a second: of a faster screen each frame would make the hand late, and ever later. */
export const SAY_S = 0.0065;

/** Something that is done with a frame, but for frames that come too soon after the last with which it was. */
export class Turns {
  /** @param {number} everyS how long after the last at least [s] */
  constructor(everyS) {
    this.everyS = everyS;
    this.lastS = -Infinity;
  }

  /** With each frame, at this time [s]: whether it is done now. */
  next(nowS) {
    const isTurn = nowS - this.lastS >= this.everyS;
    if (isTurn) {
      this.lastS = nowS;
    }
    return isTurn;
  }
}

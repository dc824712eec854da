// Which stretch of time the charts show.

/** The stretches that one can choose [s]. */
export const SPANS_S = [2, 5, 10, 30];
const LONGEST_S = Math.max(...SPANS_S);
const SMALLEST_S = 1e-3;

export class View {
  constructor() {
    this.spanS = 10;
    this.paused = false;
    /** A stretch within what is paused, or null for all of it. */
    this.zoom = null;
    /** The newest instant that is shown [s]. */
    this.edgeS = 0;
  }

  /** Time has begun anew. */
  anew() {
    this.edgeS = 0;
    this.paused = false;
    this.zoom = null;
  }

  /** Lets the edge follow the newest row smoothly: frames come in bursts, time does not. */
  follow(newestS, passedS) {
    if (this.paused || Number.isNaN(newestS)) {
      return;
    }
    const next = this.edgeS + passedS;
    const behind = newestS - next;
    this.edgeS = Math.abs(behind) > 0.25 ? newestS : next + 0.08 * behind;
  }

  pause() {
    this.paused = true;
  }

  go() {
    this.paused = false;
    this.zoom = null;
  }

  show(spanS) {
    this.spanS = spanS;
    this.zoom = null;
  }

  /** What is to be shown, and what must be kept for it [s]. */
  get fromS() {
    return this.zoom ? this.zoom.fromS : this.edgeS - this.spanS;
  }

  get toS() {
    return this.zoom ? this.zoom.toS : this.edgeS;
  }

  get keepFromS() {
    return this.paused ? this.edgeS - LONGEST_S : Infinity;
  }

  /** Looks closer at a stretch of what is paused. */
  zoomTo(fromS, toS) {
    if (!this.paused) {
      return;
    }
    const low = Math.max(this.edgeS - this.spanS, Math.min(fromS, toS));
    const high = Math.min(this.edgeS, Math.max(fromS, toS));
    if (high - low >= SMALLEST_S) {
      this.zoom = low <= this.edgeS - this.spanS && high >= this.edgeS ? null : { fromS: low, toS: high };
    }
  }

  /** Makes the stretch this many times as long, about one of its instants. */
  zoomBy(factor, aboutS = (this.fromS + this.toS) / 2) {
    this.zoomTo(aboutS + (this.fromS - aboutS) * factor, aboutS + (this.toS - aboutS) * factor);
  }

  /** Moves by a part of the stretch, as far as there is something. */
  moveBy(part) {
    if (!this.zoom) {
      return;
    }
    const length = this.toS - this.fromS;
    const low = Math.max(this.edgeS - this.spanS, Math.min(this.fromS + part * length, this.edgeS - length));
    this.zoomTo(low, low + length);
  }

  all() {
    this.zoom = null;
  }
}

// The contact's axis on the screen: which part of it is seen, and where a position stands.

import { roundStep } from "./range.js";

// Margin of the axis beyond the visible data, as a fraction of it.
const MARGIN = 0.08;

export class Axis {
  /** @param {[number, number]} view what is seen at first [m] */
  constructor(view) {
    this.home = view;
    [this.lowM, this.highM] = view;
    this.topPx = 0;
    this.bottomPx = 1;
  }

  lay(topPx, bottomPx) {
    this.topPx = topPx;
    this.bottomPx = bottomPx;
  }

  get pxPerM() {
    return (this.bottomPx - this.topPx) / (this.highM - this.lowM);
  }

  /** Height on the screen of a position; greater positions are higher up. */
  y(positionM) {
    return this.bottomPx - (positionM - this.lowM) * this.pxPerM;
  }

  /** Widens the view to these positions [m], or goes back to the first view when they fit; a part of the way if eased. */
  include(positions, part) {
    let [low, high] = this.home;
    for (const position of positions) {
      if (Number.isFinite(position)) {
        low = Math.min(low, position);
        high = Math.max(high, position);
      }
    }
    const margin = MARGIN * (high - low);
    low = low < this.home[0] ? low - margin : low;
    high = high > this.home[1] ? high + margin : high;
    this.lowM += part * (low - this.lowM);
    this.highM += part * (high - this.highM);
  }

  within(positionM) {
    return Math.min(this.highM, Math.max(this.lowM, positionM));
  }

  /** Round positions about this far apart on the screen, from below. */
  marks(apartPx) {
    const step = roundStep(apartPx / this.pxPerM);
    const marks = [];
    for (let k = Math.ceil(this.lowM / step); k * step <= this.highM; k += 1) {
      marks.push(k * step);
    }
    return marks;
  }
}

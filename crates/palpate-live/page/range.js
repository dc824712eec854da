// The range of an axis: round ends, and no flicker. It grows at once, and shrinks only after a while.

const PATIENCE_S = 1.5;

/** The least of 1, 2, 2.5 and 5 times a power of ten that is not below this size. */
export function roundStep(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  for (const step of [1, 2, 2.5, 5, 10]) {
    if (step * power >= size * (1 - 1e-9)) {
      return step * power;
    }
  }
  return 10 * power;
}

export class SteadyRange {
  /**
   * @param {{least: number, zero?: boolean, below?: number}} how `least`: the smallest range; `zero`: 0 is always in it;
   *     `below`: largest negative part of the range, as a fraction of the positive part
   */
  constructor({ least, zero = true, below = Infinity }) {
    this.how = { least, zero, below };
    this.min = zero ? 0 : -least / 2;
    this.max = zero ? least : least / 2;
    this.tooWideSince = null;
  }

  /** Takes what is to be seen, at this time [s]; nothing where min > max. */
  take(min, max, nowS) {
    const wanted = this.wanted(min, max);
    const grows = wanted.min < this.min || wanted.max > this.max;
    const muchSmaller = wanted.max - wanted.min < 0.6 * (this.max - this.min);
    if (grows) {
      this.tooWideSince = null;
      const both = this.wanted(Math.min(min, muchSmaller ? min : this.min), Math.max(max, muchSmaller ? max : this.max));
      this.set(muchSmaller ? wanted : both);
    } else if (!muchSmaller) {
      this.tooWideSince = null;
    } else if (this.tooWideSince === null) {
      this.tooWideSince = nowS;
    } else if (nowS - this.tooWideSince > PATIENCE_S) {
      this.tooWideSince = null;
      this.set(wanted);
    }
  }

  /** Fits at once, as after a zoom. */
  fit(min, max) {
    this.tooWideSince = null;
    this.set(this.wanted(min, max));
  }

  set({ min, max }) {
    this.min = min;
    this.max = max;
  }

  wanted(min, max) {
    const { least, zero, below } = this.how;
    let low = min <= max ? min : 0;
    let high = min <= max ? max : 0;
    if (zero) {
      low = Math.min(low, 0);
      high = Math.max(high, 0);
    }
    if (below < Infinity) {
      low = Math.max(low, -below * Math.max(high, least));
    }
    if (high - low < least) {
      const missing = least - (high - low);
      low -= zero && low === 0 ? 0 : zero && high === 0 ? missing : missing / 2;
      high = low + least;
    }
    const step = roundStep((high - low) / 5);
    return { min: Math.floor(low / step + 1e-9) * step, max: Math.ceil(high / step - 1e-9) * step };
  }
}

// Bins of rows for drawing. Each bin of time has its minimum and maximum, so no peak is lost at any number of pixels.
// Bins start at multiples of their width, so a scrolling curve does not shimmer.

/** In a binned curve: nothing falls into this place, the line goes on to the next. */
export const EMPTY = NaN;
/** In a binned curve: here values are missing, the line ends. */
export const BREAK = Infinity;

export class Bins {
  /** @param {number} largest how many bins there can be */
  constructor(largest) {
    this.largest = largest;
    this.count = 0;
    this.widthS = 1;
    this.firstBin = 0;
    this.allTimes = new Float64Array(2 * largest);
    this.times = this.allTimes;
    /** Of what was binned last; `spread`: greatest less least, summed over the bins. */
    this.bounds = { min: Infinity, max: -Infinity, spread: 0 };
    /** The row that each bin begins with, and after the last one the row that is beyond. */
    this.starts = new Int32Array(largest + 1);
    this.ring = null;
  }

  /** Lays bins over a stretch of time [s]: `count` of them within it, and those that its ends cut. */
  lay(fromS, toS, count) {
    const wanted = Math.max(1, Math.min(Math.floor(count), this.largest - 2));
    this.widthS = (toS - fromS) / wanted;
    this.firstBin = Math.floor(fromS / this.widthS);
    const bins = Math.min(wanted + 2, Math.floor(toS / this.widthS) - this.firstBin + 1);
    if (bins !== this.count) {
      this.count = bins;
      this.times = this.allTimes.subarray(0, 2 * bins);
    }
    for (let k = 0; k < bins; k += 1) {
      this.times[2 * k] = (this.firstBin + k + 0.25) * this.widthS;
      this.times[2 * k + 1] = (this.firstBin + k + 0.75) * this.widthS;
    }
  }

  /** Sorts the rows of a ring into the bins that were laid; its columns can be filled in then. */
  sort(ring) {
    const { starts, firstBin, widthS, count } = this;
    this.ring = ring;
    let row = ring.rowAt(firstBin * widthS) + 1;
    let bin = 0;
    starts[0] = row;
    for (let at = ring.place(row); row < ring.length; row += 1) {
      const next = Math.floor(ring.timeS[at] / widthS) - firstBin;
      while (bin < next && bin < count) {
        bin += 1;
        starts[bin] = row;
      }
      if (bin === count) {
        return;
      }
      at = at + 1 < ring.capacity ? at + 1 : 0;
    }
    starts.fill(row, bin + 1, count + 1);
  }

  /**
   * Bins a column of the ring that was sorted in: into `curve`, two places a bin, in the order in which least and
   * greatest came.
   *
   * @returns {{min: number, max: number, spread: number}} the bounds; the same object each time
   */
  fill(column, curve) {
    const { bounds, starts, ring, count } = this;
    const values = ring.columns[column];
    bounds.min = Infinity;
    bounds.max = -Infinity;
    bounds.spread = 0;
    curve.fill(EMPTY, 0, 2 * count);
    let at = ring.place(starts[0]);
    for (let bin = 0; bin < count; bin += 1) {
      const rows = starts[bin + 1] - starts[bin];
      if (rows === 0) {
        continue;
      }
      let least = Infinity;
      let greatest = -Infinity;
      let leastFirst = true;
      for (let i = 0; i < rows; i += 1) {
        const value = values[at];
        at = at + 1 < ring.capacity ? at + 1 : 0;
        // Both are true of the first value; no comparison is true of a missing one.
        if (value < least) {
          least = value;
          leastFirst = false;
        }
        if (value > greatest) {
          greatest = value;
          leastFirst = true;
        }
      }
      if (least > greatest) {
        curve[2 * bin] = BREAK;
        continue;
      }
      curve[2 * bin] = leastFirst ? least : greatest;
      if (least < greatest) {
        curve[2 * bin + 1] = leastFirst ? greatest : least;
        bounds.spread += greatest - least;
      }
      this.bound(least);
      this.bound(greatest);
    }
    this.reach(column, starts[0] - 1, curve, 0);
    this.reach(column, starts[count] - 1, curve, 2 * count - 2);
    return bounds;
  }

  bound(value) {
    const { bounds } = this;
    if (value < bounds.min) {
      bounds.min = value;
    }
    if (value > bounds.max) {
      bounds.max = value;
    }
  }

  /** Where rows are further apart than bins are wide, lets the line reach the edge: on the way from row to row. */
  reach(column, row, curve, place) {
    const { ring } = this;
    if (curve[place] === curve[place] || row < 0 || row + 1 >= ring.length) {
      return;
    }
    const before = ring.place(row);
    const after = ring.place(row + 1);
    const part = (this.times[place] - ring.timeS[before]) / (ring.timeS[after] - ring.timeS[before]);
    const values = ring.columns[column];
    const value = values[before] + part * (values[after] - values[before]);
    if (part >= 0 && part <= 1 && value === value) {
      curve[place] = value;
      this.bound(value);
    }
  }
}

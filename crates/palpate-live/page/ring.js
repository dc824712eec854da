// The rows of one lane: as many as fit, in typed arrays that are made once.

const GROUPED = 1;
const GAP = 2;

export class Ring {
  /**
   * @param {number} columns
   * @param {number} capacity rows
   */
  constructor(columns, capacity) {
    this.capacity = capacity;
    this.timeS = new Float64Array(capacity);
    this.columns = Array.from({ length: columns }, () => new Float32Array(capacity));
    this.marks = new Uint8Array(capacity);
    /** Of each row, which of the settings it was rendered with: a number that its user gives a meaning; it never decreases. */
    this.settings = new Uint32Array(capacity);
    this.clear();
  }

  clear() {
    this.first = 0;
    this.length = 0;
  }

  /** Where the row stands in the arrays; row 0 is the oldest. */
  place(row) {
    const at = this.first + row;
    return at < this.capacity ? at : at - this.capacity;
  }

  /** Time of the oldest row [s]; NaN without rows. */
  get firstS() {
    return this.length ? this.timeS[this.first] : NaN;
  }

  /** Time of the newest row [s]; NaN without rows. */
  get lastS() {
    return this.length ? this.timeS[this.place(this.length - 1)] : NaN;
  }

  isGrouped(row) {
    return (this.marks[this.place(row)] & GROUPED) !== 0;
  }

  isGap(row) {
    return (this.marks[this.place(row)] & GAP) !== 0;
  }

  /**
   * Adds the rows of a frame, and discards the oldest rows if there is no space.
   *
   * @param frame as `readSamples` gives it
   * @param {{grouped?: boolean, settings?: number, keepFromS?: number}} how rows from `keepFromS` on are kept
   * @returns {boolean} false if that leaves no room; nothing was added then
   */
  append(frame, { grouped = false, settings = 0, keepFromS = Infinity } = {}) {
    if (frame.rows > this.capacity || !this.makeRoom(frame.rows, keepFromS)) {
      return false;
    }
    const mark = grouped ? GROUPED : 0;
    for (let i = 0; i < frame.rows; i += 1) {
      const at = this.place(this.length);
      this.timeS[at] = frame.startS + frame.afterS[i];
      this.marks[at] = mark;
      this.settings[at] = settings;
      for (let c = 0; c < this.columns.length; c += 1) {
        this.columns[c][at] = frame.values[c * frame.rows + i];
      }
      this.length += 1;
    }
    return true;
  }

  /** Adds a row without values at this time: something is missing there, and a curve must not run across. */
  appendGap(timeS, { settings = 0, keepFromS = Infinity } = {}) {
    if (!this.makeRoom(1, keepFromS)) {
      return false;
    }
    const at = this.place(this.length);
    this.timeS[at] = timeS;
    this.marks[at] = GAP;
    this.settings[at] = settings;
    for (const column of this.columns) {
      column[at] = NaN;
    }
    this.length += 1;
    return true;
  }

  makeRoom(rows, keepFromS) {
    const over = this.length + rows - this.capacity;
    if (over <= 0) {
      return true;
    }
    if (this.timeS[this.place(over - 1)] >= keepFromS) {
      return false;
    }
    this.first = this.place(over);
    this.length -= over;
    return true;
  }

  /** The same rows, on their own from now on. */
  copy() {
    const other = new Ring(this.columns.length, this.length);
    const part = (of, into) => {
      const end = Math.min(this.first + this.length, this.capacity);
      into.set(of.subarray(this.first, end));
      into.set(of.subarray(0, this.length - (end - this.first)), end - this.first);
    };
    part(this.timeS, other.timeS);
    part(this.marks, other.marks);
    part(this.settings, other.settings);
    this.columns.forEach((column, c) => part(column, other.columns[c]));
    other.length = this.length;
    return other;
  }

  /** The last row at or before this time; -1 if there is none. */
  rowAt(timeS) {
    let low = 0;
    let high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.timeS[this.place(middle)] <= timeS) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low - 1;
  }

  /** Value of a column in a row. */
  value(column, row) {
    return this.columns[column][this.place(row)];
  }
}

// State of the loop on the page: the server's messages, and the received rows.

import { PROTOCOL, isGrouped } from "./protocol.js";
import { Ring } from "./ring.js";

/** How many rows of a lane are kept: 200 s at the 1000 rows per second that a fast loop sends. */
export const CAPACITY = 200_000;
const NOTES = 200;
// By how much the time of a loop may differ from the clock here, over a connection that was lost [s].
const CLOCKS_APART_S = 1;
// In some browsers the first clock stops while the computer sleeps; the second may be adjusted.
const CLOCKS = [() => performance.now() / 1000, () => Date.now() / 1000];
// Of a loop that was over before this page came.
const NOT_RUNNING = "press Restart to start it again";

export class Model extends EventTarget {
  /** @param {number} capacity rows of a lane @param {(() => number)[]} clocks seconds */
  constructor(capacity = CAPACITY, clocks = CLOCKS) {
    super();
    this.capacity = capacity;
    this.clocks = clocks;
    this.hello = null;
    this.state = null;
    this.status = null;
    /** What rows were rendered with; they hold the number of theirs, and the first here has the number `settingsFrom`. */
    this.settings = [];
    this.settingsFrom = 0;
    this.lanes = [];
    this.notes = [];
    this.run = null;
    this.retiredRun = null;
    /** Frames that the server dropped because this client was slow. */
    this.droppedFrames = 0;
    /** Rows that came while the buffer was full of what a pause keeps. */
    this.refusedRows = 0;
    this.recordedFiles = [];
    /** Why the loop is over; null while it runs. */
    this.ended = null;
    this.lastEnd = NOT_RUNNING;
  }

  tell(kind, detail = null) {
    this.dispatchEvent(Object.assign(new Event(kind), { detail }));
  }

  /** Takes a text message. */
  take(message) {
    switch (message.type) {
      case "hello":
        this.takeHello(message);
        break;
      case "state":
        this.takeState(message);
        break;
      case "status":
        this.status = message;
        this.tell("status");
        break;
      case "note":
        this.notes.push(message);
        this.notes.splice(0, this.notes.length - NOTES);
        this.tell("note", message);
        break;
      case "refused":
        this.tell("refused", message);
        break;
      case "ended":
        this.lastEnd = message.text;
        this.takeEnd(message.text);
        break;
      default:
        // A newer server may say more.
        break;
    }
  }

  takeHello(hello) {
    if (hello.protocol !== PROTOCOL) {
      throw new RangeError(`the server has protocol ${hello.protocol}, this page ${PROTOCOL}: reload the page`);
    }
    const isNew = JSON.stringify(hello) !== JSON.stringify(this.hello);
    this.hello = hello;
    this.lastEnd = NOT_RUNNING;
    this.takeEnd(null);
    if (isNew) {
      // Another loop, even with the same run number: discard the data of the previous one.
      this.run = null;
      this.notes = [];
      this.recordedFiles = [];
      this.droppedFrames = 0;
      const names = hello.columns.map((column) => column.name);
      this.names = names;
      this.lanes = Array.from({ length: hello.device.lanes }, () => ({
        ring: new Ring(names.length, this.capacity),
        next: 0,
        fresh: true,
        reconnected: true,
        heardAtS: this.clocks.map(() => 0),
      }));
    }
    for (const lane of this.lanes) {
      lane.next = 0;
      lane.fresh = true;
      lane.reconnected = true;
    }
    this.retiredRun = null;
    this.tell("hello", { isNew });
  }

  takeState(state) {
    const lanesBefore = this.state?.lanes.length ?? 0;
    if (state.recording) {
      this.recordedFiles = state.recording.files;
    }
    this.state = state;
    this.takeSettings(settingsOf(state));
    if (state.lanes.length < lanesBefore) {
      this.lanes.slice(state.lanes.length).forEach((lane) => lane.ring.clear());
    }
    this.takeEnd(this.isRunning ? null : this.lastEnd);
    this.tell("state");
  }

  /** Keeps what has changed, and of what was before no more than rows are left of: a slider changes it with every frame. */
  takeSettings(settings) {
    const text = JSON.stringify(settings);
    const isLast = () => text === JSON.stringify(this.settings.at(-1));
    if (isLast()) {
      return;
    }
    let oldest = Infinity;
    let newest = -Infinity;
    for (const { ring } of this.lanes) {
      if (ring.length > 0) {
        oldest = Math.min(oldest, ring.settings[ring.place(0)]);
        newest = Math.max(newest, ring.settings[ring.place(ring.length - 1)]);
      }
    }
    this.settings.splice(Math.max(0, newest + 1 - this.settingsFrom));
    if (this.settings.length > 0) {
      this.settings.splice(0, oldest - this.settingsFrom);
      this.settingsFrom = oldest;
    }
    if (!isLast()) {
      this.settings.push(settings);
    }
  }

  /** Whether all lanes ran when the state was told. */
  get isRunning() {
    return this.state.lanes.every(({ running }) => running);
  }

  takeEnd(text) {
    if (text !== this.ended) {
      this.ended = text;
      this.tell("ended", text);
    }
  }

  column(name) {
    return this.names.indexOf(name);
  }

  /** Takes a frame of samples. `keepFromS`: rows from then on are being looked at. */
  takeSamples(frame, keepFromS = Infinity) {
    const lane = this.lanes[frame.lane];
    if (!lane || !this.state || frame.rows === 0 || frame.run === this.retiredRun) {
      return;
    }
    const nowS = this.clocks.map((clock) => clock());
    if (frame.run !== this.run || (lane.reconnected && !goesOn(lane, frame, nowS))) {
      this.beginAnew(frame.run);
    }
    lane.reconnected = false;
    lane.heardAtS = nowS;
    const missing = frame.number > lane.next ? frame.number - lane.next : 0;
    const apart = lane.ring.length > 0 && (missing > 0 || lane.fresh);
    this.droppedFrames += missing;
    lane.next = frame.number + 1;
    lane.fresh = false;
    const settings = this.settingsFrom + this.settings.length - 1;
    if (apart) {
      lane.ring.appendGap((lane.ring.lastS + frame.startS) / 2, { settings, keepFromS });
    }
    const kept = lane.ring.append(frame, { grouped: isGrouped(this.state.period_s), settings, keepFromS });
    if (!kept) {
      this.refusedRows += frame.rows;
      lane.fresh = true;
    }
  }

  /** Takes the number of a frame that holds no rows: frames of all kinds are counted together. */
  takeNumber({ lane, number, run }) {
    const at = this.lanes[lane];
    if (at && run === this.run) {
      this.droppedFrames += Math.max(0, number - at.next);
      at.next = number + 1;
    }
  }

  beginAnew(run) {
    if (this.isRunning) {
      // It had ended and begun between two states. If the new one has ended, too, the next state says so again.
      this.takeEnd(null);
    }
    this.retiredRun = run === this.run ? null : this.run;
    this.run = run;
    this.refusedRows = 0;
    this.settingsFrom += this.settings.length - 1;
    this.settings.splice(0, this.settings.length - 1);
    for (const lane of this.lanes) {
      lane.ring.clear();
    }
    this.tell("anew");
  }

  /** Time of the newest row of any lane [s]; NaN without rows. */
  get newestS() {
    let newest = NaN;
    for (const { ring } of this.lanes) {
      if (!(ring.lastS <= newest) && ring.length > 0) {
        newest = ring.lastS;
      }
    }
    return newest;
  }

  /**
   * Range and mean of a column of a rendering over the last seconds. Grouped rows have no mean: minimum and maximum are
   * only bounds of the values in between. NaN and an empty range if there is no value.
   *
   * @returns {{least: number, greatest: number, mean: number, grouped: boolean, nearest: number}} `nearest`: the newest
   *     value; of the newest group, that of its two which is nearer to 0, or 0 if it lies between
   */
  recent(lane, name, seconds) {
    const { ring } = this.lanes[lane];
    const values = ring.columns[this.column(name)];
    let least = Infinity;
    let greatest = -Infinity;
    let sum = 0;
    let count = 0;
    for (let row = ring.length - 1; row >= 0; row -= 1) {
      const at = ring.place(row);
      if (ring.lastS - ring.timeS[at] > seconds) {
        break;
      }
      const value = values[at];
      if (value === value) {
        least = Math.min(least, value);
        greatest = Math.max(greatest, value);
        sum += value;
        count += 1;
      }
    }
    const grouped = ring.length > 1 && ring.isGrouped(ring.length - 1);
    const newest = this.newest(lane, name);
    const other = grouped ? ring.value(this.column(name), ring.length - 2) : newest;
    return {
      least,
      greatest,
      mean: grouped || count === 0 ? NaN : sum / count,
      grouped,
      nearest: newest * other <= 0 ? 0 : Math.abs(other) < Math.abs(newest) ? other : newest,
    };
  }

  /** The newest value of a column of a lane; NaN where there is none. */
  newest(lane, name) {
    const ring = this.lanes[lane]?.ring;
    return ring?.length ? ring.value(this.column(name), ring.length - 1) : NaN;
  }
}

/**
 * Whether a frame over a new connection is of the loop before: another one has begun at another instant, so its time is
 * not where that of the one before would be by now, by any clock here, though its run may have the same number.
 */
function goesOn({ ring, heardAtS }, frame, nowS) {
  const passedS = frame.startS - ring.lastS;
  const fits = (now, clock) => Math.abs(passedS - (now - heardAtS[clock])) < CLOCKS_APART_S;
  return ring.length === 0 || (passedS >= 0 && nowS.some(fits));
}

function settingsOf({ lanes, ...state }) {
  const { stiffness_n_per_m, mass_kg, virtual_force_n, period_s } = state;
  const { model_device_mass_kg, model_delay_s, model_lag_s, model_gain } = state;
  return {
    stiffness_n_per_m,
    mass_kg,
    virtual_force_n,
    period_s,
    model_device_mass_kg,
    model_delay_s,
    model_lag_s,
    model_gain,
    lanes: lanes.map(({ method, damping_n_s_per_m }) => ({ method, damping_n_s_per_m })),
  };
}

// Target time of a loop in simulated time, and whether it keeps up with real time.

// Largest lag behind real time. A loop that is further behind continues from its own time, and the difference counts as
// lost.
const MAX_BEHIND_S = 0.25;
// Time span of a report.
const WINDOW_MS = 2000;

export class Pacer {
  constructor() {
    this.anew(0, 0);
    this.hold();
  }

  /** Starts the run at this time of its own [s]. */
  anew(nowMs, timeS) {
    this.originMs = nowMs - 1000 * timeS;
    this.timeS = timeS;
    this.held = false;
    this.forget(nowMs);
  }

  forget(nowMs) {
    this.marks = [{ nowMs, timeS: this.timeS, ticks: 0, workedMs: 0 }];
    this.ticks = 0;
    this.workedMs = 0;
    this.lostS = 0;
  }

  /** Pauses the time. */
  hold() {
    this.held = true;
  }

  /** Resumes the time. */
  goOn(nowMs) {
    this.held = false;
    this.originMs = nowMs - 1000 * this.timeS;
    this.forget(nowMs);
  }

  /** Target time of the loop's run [s]. */
  until(nowMs) {
    const wanted = (nowMs - this.originMs) / 1000;
    const behind = wanted - this.timeS;
    if (behind > MAX_BEHIND_S) {
      const lost = behind - MAX_BEHIND_S;
      this.originMs += 1000 * lost;
      this.lostS += lost;
      return wanted - lost;
    }
    return wanted;
  }

  /** Records the number of ticks and the reached time [s]. */
  ran(ticks, timeS) {
    this.ticks += ticks;
    this.timeS = timeS;
  }

  /** Records the time for which the thread was busy. */
  worked(ms) {
    this.workedMs += ms;
  }

  /**
   * Returns the performance over the last seconds.
   *
   * @returns {{ratio: number, busy: number, ticksPerS: number, lostS: number, overS: number}} `ratio`: simulated over
   *     real time; `busy`: fraction of time in which the thread worked; `lostS`: lost time since the start or last resume
   */
  report(nowMs) {
    const { marks, timeS, ticks, workedMs, lostS } = this;
    const [first] = marks;
    const overMs = nowMs - first.nowMs;
    marks.push({ nowMs, timeS, ticks, workedMs });
    while (marks.length > 2 && nowMs - marks[1].nowMs >= WINDOW_MS) {
      marks.shift();
    }
    return {
      ratio: (1000 * (timeS - first.timeS)) / overMs,
      busy: (workedMs - first.workedMs) / overMs,
      ticksPerS: (1000 * (ticks - first.ticks)) / overMs,
      lostS,
      overS: overMs / 1000,
    };
  }
}

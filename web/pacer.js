// How far a loop in simulated time is to be, and whether it keeps up with real time.

// A loop that is further behind than this does not catch up: it goes on from where it is, and the time is counted as lost.
const MOST_BEHIND_S = 0.25;
// Of how long a report speaks.
const WINDOW_MS = 2000;

export class Pacer {
  constructor() {
    this.anew(0, 0);
    this.hold();
  }

  /** The run begins at this time of its own [s]. */
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

  /** Time stands still. */
  hold() {
    this.held = true;
  }

  /** Time goes on where it stood. */
  goOn(nowMs) {
    this.held = false;
    this.originMs = nowMs - 1000 * this.timeS;
    this.forget(nowMs);
  }

  /** Up to which time of its own the loop should have run by now [s]. */
  until(nowMs) {
    const wanted = (nowMs - this.originMs) / 1000;
    const behind = wanted - this.timeS;
    if (behind > MOST_BEHIND_S) {
      const lost = behind - MOST_BEHIND_S;
      this.originMs += 1000 * lost;
      this.lostS += lost;
      return wanted - lost;
    }
    return wanted;
  }

  /** It has made so many ticks, and reached this time [s]. */
  ran(ticks, timeS) {
    this.ticks += ticks;
    this.timeS = timeS;
  }

  /** That has kept the thread busy for so long. */
  worked(ms) {
    this.workedMs += ms;
  }

  /**
   * How it went over the last seconds.
   *
   * @returns {{ratio: number, busy: number, ticksPerS: number, lostS: number, overS: number}} `ratio`: simulated over
   *     real time; `busy`: part of the time in which the thread worked; `lostS`: what it has not caught up, since it goes
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

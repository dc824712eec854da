// Message about a loop that does not keep up with real time.

import { digits } from "./page/si.js";

const ENOUGH = 0.97;
// Short slowdowns are not reported: a browser occasionally compiles and collects garbage.
const FOR_S = 1.5;
const REPORTS = 3;

export class TooSlow {
  constructor() {
    this.slow = 0;
  }

  forget() {
    this.slow = 0;
  }

  /** Message for a report of the loop's pace; null if it keeps up. */
  about({ ratio, overS }) {
    this.slow = ratio < ENOUGH && overS >= FOR_S ? this.slow + 1 : 0;
    if (this.slow < REPORTS) {
      return null;
    }
    return (
      `This machine is too slow for these settings: simulated time runs at ${digits(ratio, 2)} of real time. ` +
      "The display is slower than real time, but computed for the rate that is set. Use a lower rate or one method."
    );
  }
}

export function paceInWords({ ratio, busy, ticksPerS }) {
  const percent = `${Math.max(1, Math.round(100 * busy))} % of a processor`;
  return `${digits(ratio, 3)} × real time, ${Math.round(ticksPerS)} ticks per second, ${percent}`;
}

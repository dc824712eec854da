// One-sentence summary: the energy that each method has generated within the last seconds.

import { digits, quantity } from "./si.js";

// Less is rounded: about a millijoule can be felt.
const MIN_J = 1e-4;
// Below this there is nothing but rounding.
const NONE_J = 1e-12;
const PLACES = ["Left", "right"];

/**
 * The energy that a lane's held force has created within the last seconds.
 *
 * @returns {{createdJ: number, seconds: number}} `createdJ` is NaN where it is not known; `seconds` may be fewer than
 *     asked for, where the lane has not run as long
 */
export function createdWithin(model, lane, seconds) {
  const { ring } = model.lanes[lane];
  const column = model.column("leak_held_j");
  const values = (row) => ring.value(column, row);
  let newest = ring.length - 1;
  while (newest > 0 && Number.isNaN(values(newest))) {
    newest -= 1;
  }
  let oldest = Math.max(0, ring.rowAt(ring.lastS - seconds));
  while (oldest < newest && Number.isNaN(values(oldest))) {
    oldest += 1;
  }
  if (newest <= oldest) {
    return { createdJ: NaN, seconds: 0 };
  }
  const passedS = ring.timeS[ring.place(newest)] - ring.timeS[ring.place(oldest)];
  return { createdJ: values(newest) - values(oldest), seconds: passedS };
}

/** @param {{method: string, createdJ: number, seconds: number}[]} lanes */
export function seenInWords(lanes) {
  const known = lanes.filter(({ createdJ }) => !Number.isNaN(createdJ));
  if (known.length === 0) {
    return "";
  }
  const longest = Math.max(...known.map((lane) => lane.seconds));
  const seconds = longest < 1 ? longest.toFixed(1) : String(Math.round(longest));
  const parts = lanes.map(({ method, createdJ }, i) => {
    const name = lanes.length > 1 ? `${PLACES[i]} (${method})` : method;
    if (Number.isNaN(createdJ)) {
      return `${name}: unknown`;
    }
    if (Math.abs(createdJ) < NONE_J) {
      return `${name} creates no energy`;
    }
    if (Math.abs(createdJ) < MIN_J) {
      return `${name} ${createdJ > 0 ? "creates" : "dissipates"} less than 0.1 mJ of energy`;
    }
    const size = quantity(Math.abs(createdJ), "J");
    return createdJ > 0 ? `${name} creates ${size} of energy` : `${name} dissipates ${size} of energy`;
  });
  return `${parts.join("; ")} (last ${seconds} s).`;
}

// What the server says in binary frames, and what is said to it. docs/scope.md has the protocol.

/** The version of the protocol that this page speaks. */
export const PROTOCOL = 1;

/** How far from 0 the hand can be led [m]. */
export const REACH_M = 1;

const HEADER_BYTES = 24;
const SAMPLES = 1;

/**
 * Reads a frame of samples. The arrays are views of the frame's own bytes: every machine that has a browser today
 * keeps the lowest byte first, as the frames do.
 *
 * @param {ArrayBuffer} bytes
 * @param {number} columns how many `hello` has told of
 * @returns {{lane: number, number: number, run: number, rows: number, startS: number, afterS: Float32Array,
 *     values: Float32Array}} `values` holds the columns one after the other, `rows` each
 */
export function readSamples(bytes, columns) {
  if (bytes.byteLength < HEADER_BYTES) {
    throw new RangeError(`a frame of ${bytes.byteLength} bytes is shorter than its header of ${HEADER_BYTES}`);
  }
  const head = new DataView(bytes);
  const kind = head.getUint8(0);
  if (kind !== SAMPLES) {
    throw new RangeError(`a frame of kind ${kind} is not known; ${SAMPLES} is samples`);
  }
  const told = head.getUint16(2, true);
  if (told !== columns) {
    throw new RangeError(`a frame has ${told} columns, hello has told of ${columns}`);
  }
  const rows = head.getUint32(4, true);
  const wanted = HEADER_BYTES + 4 * rows * (1 + columns);
  if (bytes.byteLength !== wanted) {
    throw new RangeError(`a frame of ${rows} rows has ${bytes.byteLength} bytes instead of ${wanted}`);
  }
  return {
    lane: head.getUint8(1),
    number: head.getUint32(8, true),
    run: head.getUint32(12, true),
    rows,
    startS: head.getFloat64(16, true),
    afterS: new Float32Array(bytes, HEADER_BYTES, rows),
    values: new Float32Array(bytes, HEADER_BYTES + 4 * rows, rows * columns),
  };
}

/** Whether rows of a loop with this period hold ticks, or the least and greatest of groups of them. */
export function isGrouped(periodS) {
  return periodS < 0.001 * (1 - 1e-9);
}

/** The messages to the server. */
export const say = {
  hand: (positionM) => ({ type: "hand", position_m: positionM }),
  set: (changes) => ({ type: "set", ...changes }),
  restart: () => ({ type: "restart" }),
  rearm: (lane) => ({ type: "rearm", lane }),
  record: (on) => ({ type: "record", on }),
};

// Binary frames of the server, and messages to the server; docs/reference/live-protocol.md describes the protocol.

/** The version of the protocol that this page speaks. */
export const PROTOCOL = 1;

/** How far from 0 the hand can be led [m]. */
export const REACH_M = 1;

const HEADER_BYTES = 24;
const SAMPLES = 1;
const WORLD = 2;
const WORLD_HEADER_BYTES = 40;
const BODY_FLOATS = 8;
const CONTACT_FLOATS = 6;
const FORCE_FLOATS = 3;

/** What a binary frame holds: "samples", "world", or undefined where it is not known. */
export function kindOf(bytes) {
  return { [SAMPLES]: "samples", [WORLD]: "world" }[new DataView(bytes).getUint8(0)];
}

/**
 * Reads a frame of a world: where its bodies are, and the forces on its devices and of its contacts.
 *
 * @param {ArrayBuffer} bytes
 * @returns {{lane: number, number: number, run: number, timeS: number, forces: number[][],
 *     bodies: {body: number, position: number[], orientation: number[]}[],
 *     contacts: {point: number[], force: number[]}[]}} in metres, newtons and quaternions w, x, y, z
 */
export function readWorld(bytes) {
  if (bytes.byteLength < WORLD_HEADER_BYTES) {
    throw new RangeError(`a world of ${bytes.byteLength} bytes is shorter than its header of ${WORLD_HEADER_BYTES}`);
  }
  const head = new DataView(bytes);
  const bodies = head.getUint32(4, true);
  const contacts = head.getUint32(24, true);
  const further = head.getUint16(2, true);
  const behind = BODY_FLOATS * bodies + CONTACT_FLOATS * contacts;
  const wanted = WORLD_HEADER_BYTES + 4 * (behind + FORCE_FLOATS * further);
  if (bytes.byteLength !== wanted) {
    const parts = `${bodies} bodies, ${contacts} contacts and ${1 + further} devices`;
    throw new RangeError(`a world of ${parts} has ${bytes.byteLength} bytes instead of ${wanted}`);
  }
  const floats = new Float32Array(bytes, WORLD_HEADER_BYTES);
  const part = (from, length) => Array.from(floats.subarray(from, from + length));
  return {
    lane: head.getUint8(1),
    number: head.getUint32(8, true),
    run: head.getUint32(12, true),
    timeS: head.getFloat64(16, true),
    forces: [
      [28, 32, 36].map((at) => head.getFloat32(at, true)),
      ...Array.from({ length: further }, (_, n) => part(behind + FORCE_FLOATS * n, FORCE_FLOATS)),
    ],
    bodies: Array.from({ length: bodies }, (_, n) => ({
      body: floats[BODY_FLOATS * n],
      position: part(BODY_FLOATS * n + 1, 3),
      orientation: part(BODY_FLOATS * n + 4, 4),
    })),
    contacts: Array.from({ length: contacts }, (_, n) => ({
      point: part(BODY_FLOATS * bodies + CONTACT_FLOATS * n, 3),
      force: part(BODY_FLOATS * bodies + CONTACT_FLOATS * n + 3, 3),
    })),
  };
}

/**
 * Reads a frame of samples. The arrays are views of the frame's own bytes: every machine that has a browser today
 * keeps the lowest byte first, as the frames do.
 *
 * @param {ArrayBuffer} bytes
 * @param {number} columns number of columns in `hello`
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
    throw new RangeError(`unknown frame kind ${kind}; ${SAMPLES} is samples`);
  }
  const announced = head.getUint16(2, true);
  if (announced !== columns) {
    throw new RangeError(`a frame has ${announced} columns, hello announces ${columns}`);
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

/** A device is named where it is not the first. */
const of = (device) => (device === 0 ? {} : { device });

/** The messages to the server. */
export const say = {
  hand: (positionM) => ({ type: "hand", position_m: positionM }),
  tool: (positionM, device = 0) => ({ type: "tool", ...of(device), position_m: positionM }),
  turn: (orientation, device = 0) => ({ type: "turn", ...of(device), orientation }),
  set: (changes) => ({ type: "set", ...changes }),
  restart: () => ({ type: "restart" }),
  rearm: (lane) => ({ type: "rearm", lane }),
  record: (on) => ({ type: "record", on }),
};

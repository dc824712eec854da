// The devices of a world: what the server says of the first, and of the further ones where there are several.

import { DASHES } from "./curves.js";

const FORCE = "force_on_device_n";
/** Keeps a name, its number and the unit in one line. */
const NO_BREAK = "\u00a0";

/**
 * The devices of a world, in their order.
 *
 * @param {object} hello
 * @returns {{name: string, kind: string, pointer: boolean, turns: boolean, began: {position: number[], orientation: number[]},
 *     force: string}[]} `name`: of its tool; `force`: the column of the force on it
 */
export function devicesOf({ device, further_devices = [], world }) {
  return [device, ...further_devices].map(({ name: kind, pointer }, number) => {
    const { name, turns, position_m, orientation } = world.tools[number];
    const began = { position: position_m, orientation };
    return { name, kind, pointer, turns, began, force: number === 0 ? FORCE : `${FORCE} ${name}` };
  });
}

/**
 * Target of each hand [m] and its target orientation, w, x, y, z; null after a release, or for the initial orientation.
 *
 * @param {object | null} state
 * @returns {{hand_m: number[] | null, hand_orientation: number[] | null}[]}
 */
export function handsOf(state) {
  return state ? [state, ...(state.further_hands ?? [])] : [];
}

/** The charts of a world with these devices: of several, each has a curve of its force. */
export function chartsOf(charts, devices) {
  if (devices.length < 2) {
    return charts;
  }
  const curves = devices.map(({ name, force }, number) => ({ column: force, name, dash: DASHES[number % DASHES.length] }));
  return charts.map((chart) => (chart.id === "force" ? { ...chart, title: "Force on each device", curves } : chart));
}

/**
 * The force on each device, in words.
 *
 * @param {string[]} names of the devices
 * @param {{method: string, forces: string[]}[]} lanes with a force for each device, in words
 */
export function forcesInWords(names, lanes) {
  if (names.length < 2) {
    return `Force on the device now: ${lanes.map(({ forces }) => forces[0]).join(", ")}.`;
  }
  const each = lanes.map(({ method, forces }) => {
    const parts = forces.map((force, number) => `${names[number]} ${force}`.replaceAll(" ", NO_BREAK)).join(", ");
    return lanes.length > 1 ? `${method}: ${parts}` : parts;
  });
  return `Force on each device now: ${each.join("; ")}.`;
}

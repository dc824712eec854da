// Error messages of the server in the words of the page: the server names values by the keys of its messages.

import { plain } from "./si.js";

const QUANTITIES = {
  stiffness_n_per_m: { label: "Stiffness", unit: "N/m" },
  mass_kg: { label: "Mass", unit: "kg" },
  virtual_force_n: { label: "Virtual force", unit: "N" },
  period_s: { label: "Period", unit: "ms", shown: (value) => value * 1000 },
  damping_n_s_per_m: { label: "Damping b", unit: "N s/m" },
  delay_s: { label: "Delay", unit: "ms", shown: (value) => value * 1000 },
  model_device_mass_kg: { label: "Device mass", unit: "kg" },
  model_delay_s: { label: "Delay", unit: "ms", shown: (value) => value * 1000 },
  model_lag_s: { label: "Lag", unit: "ms", shown: (value) => value * 1000 },
  model_gain: { label: "Gain", unit: "" },
  position_m: { label: "Position of the hand", unit: "m" },
};

/** A period as the rate that somebody has entered. */
export const RATE = { label: "Rate", unit: "Hz", shown: (value) => 1 / value };

const OUTSIDE = /^(\w+) is (\S+); allowed: (\S+) to ([^\s,]+)/;

/** The limits of a value, the smaller first: "20 to 4000 Hz". */
export function limitsInWords(limits, unit, write = plain) {
  const [least, most] = [...limits].sort((a, b) => a - b);
  return `${write(least)} to ${write(most)} ${unit}`;
}

/**
 * The key of a refusal, and its text with the label and unit of the field in place of the server's keys. A text without
 * a limited value is returned unchanged.
 *
 * @param {string} text @param {object} periodAs `RATE`: a period that is refused was entered as a rate
 */
export function refusalInWords(text, periodAs = QUANTITIES.period_s) {
  const [, key, given, low, high] = OUTSIDE.exec(text) ?? [];
  const quantity = key === "period_s" ? periodAs : QUANTITIES[key];
  if (!quantity) {
    return { key: null, words: text };
  }
  const { label, unit, shown = (value) => value } = quantity;
  const limits = [low, high].map((limit) => shown(Number(limit)));
  return { key, words: `${label} ${plain(shown(Number(given)))} ${unit} is outside its range; allowed: ${limitsInWords(limits, unit)}` };
}

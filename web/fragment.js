// Settings as the end of a link: after `#`, each key with its unit and its value. Initial values are left out.

import { START } from "./presets.js";

const NONE = "default";
const WALL = "wall";
const FREE = "free";

const numbers = ["stiffness_n_per_m", "virtual_force_n", "period_s", "device_mass_kg", "delay_s"];

/** @returns {string} without the `#` */
export function written(settings) {
  const parts = [];
  const add = (key, text) => parts.push(`${key}=${text}`);
  const differs = (key) => JSON.stringify(settings[key]) !== JSON.stringify(START[key]);
  if (differs("methods")) {
    add("methods", settings.methods.join(","));
  }
  if (settings.damping_n_s_per_m.some((damping) => damping !== null)) {
    add("damping_n_s_per_m", settings.damping_n_s_per_m.map((damping) => damping ?? NONE).join(","));
  }
  numbers.filter(differs).forEach((key) => add(key, String(settings[key])));
  if (differs("mass_kg")) {
    add("mass_kg", settings.mass_kg ?? WALL);
  }
  if (differs("hand_m")) {
    add("hand_m", settings.hand_m === null ? FREE : String(Number(settings.hand_m.toPrecision(4))));
  }
  if (settings.cut_off) {
    add("cut_off", "yes");
  }
  return parts.join("&");
}

/** @returns {string} of a world and its methods */
export function writtenWorld(world, methods) {
  return `world=${world}&methods=${methods.join(",")}`;
}

/**
 * Reads the end of a link. Invalid parts are left out and reported.
 *
 * @param {string} text with or without its `#`
 * @returns {{settings: object, world: string | null, worldMethods: string[] | null, faults: string[]}}
 */
export function read(text) {
  const settings = structuredClone(START);
  const faults = [];
  let world = null;
  let methods = null;
  const number = (key, value) => {
    const is = value === "" ? NaN : Number(value);
    if (Number.isFinite(is)) {
      return is;
    }
    faults.push(`${key} is “${value}”, and has to be a number`);
    return undefined;
  };
  const keep = (key, value) => {
    if (value !== undefined) {
      settings[key] = value;
    }
  };
  for (const part of text.replace(/^#/, "").split("&").filter(Boolean)) {
    const [key, value = ""] = part.split(/=(.*)/s).map(decoded);
    if (numbers.includes(key)) {
      keep(key, number(key, value));
    } else if (key === "methods") {
      methods = value.split(",");
      if (methods.length > 2 || methods.some((name) => !/^[a-z0-9-]+$/.test(name))) {
        faults.push(`methods is “${value}”, and has to be one or two names separated by a comma`);
        methods = null;
      }
    } else if (key === "damping_n_s_per_m") {
      const dampings = value.split(",").map((one) => (one === NONE ? null : number(key, one)));
      if (!dampings.includes(undefined)) {
        settings.damping_n_s_per_m = dampings;
      }
    } else if (key === "mass_kg") {
      keep(key, value === WALL ? null : number(key, value));
    } else if (key === "hand_m") {
      keep(key, value === FREE ? null : number(key, value));
    } else if (key === "cut_off") {
      settings.cut_off = value === "yes";
    } else if (key === "world") {
      world = value;
    } else {
      faults.push(`“${key}” is not a setting`);
    }
  }
  if (world === null && methods) {
    settings.methods = methods;
  }
  return { settings, world, worldMethods: world === null ? null : methods, faults };
}

function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

// Fields of the device's model values; they do not change the device.

import { Field, number } from "./field.js";
import { say } from "./protocol.js";
import { refusalInWords } from "./refusal.js";
import { plain } from "./si.js";

/** A time, said in seconds and shown in milliseconds. */
const IN_MS = {
  unit: "ms",
  write: (value) => plain(value * 1000),
  read: (text) => {
    const value = number(text);
    return value === null ? null : value / 1000;
  },
};

const SHOWN = {
  model_device_mass_kg: { label: "Device mass", unit: "kg" },
  model_delay_s: { label: "Delay", ...IN_MS },
  model_lag_s: { label: "Lag", ...IN_MS },
  model_gain: { label: "Gain", unit: "" },
};

const MEANS = {
  model_device_mass_kg: "Device mass that the renderer assumes",
  model_delay_s: "Time from a sample to the beginning of its force",
  model_lag_s: "Time constant of the actuator, a first-order lag after the delay",
  model_gain: "Delivered over commanded force",
};

export class ModelValues {
  /**
   * @param {HTMLElement} root
   * @param {import("./model.js").Model} model
   * @param {(message: object) => void} send
   */
  constructor(root, model, send) {
    this.root = root;
    this.model = model;
    this.send = send;
    this.last = null;
  }

  /** Makes the fields: hello tells their limits. */
  build() {
    const { limits } = this.model.hello;
    const field = ([key, how]) => {
      const made = new Field({ ...how, limits: limits[key], set: (value) => this.set({ [key]: value }) });
      made.root.dataset.name = key;
      made.label.title = MEANS[key];
      return [key, made];
    };
    this.fields = Object.fromEntries(Object.entries(SHOWN).map(field));
    const roots = Object.values(this.fields).map(({ root }) => root);
    this.root.replaceChildren(this.root.querySelector("legend"), ...roots);
  }

  set(change) {
    this.last = Object.keys(change)[0];
    this.send(say.set(change));
  }

  /** Takes over the state. */
  take(state) {
    Object.entries(this.fields).forEach(([key, field]) => field.take(state[key]));
  }

  /** Shows beside its field what the server refused; false if it is about none of these. `wasUsed`: these were used last. */
  refuse(text, wasUsed) {
    const { key: named, words } = refusalInWords(text);
    const key = named in this.fields ? named : named === null && wasUsed ? this.last : null;
    if (!key) {
      return false;
    }
    this.fields[key].refuse(words);
    this.take(this.model.state);
    return true;
  }

  /** Takes every reason for a refusal away. */
  forgive() {
    Object.values(this.fields).forEach((field) => field.refuse(""));
  }
}

// The fields of the virtual device: its true values, not only the renderer's model values.

import { Field, number } from "./page/field.js";
import { refusalInWords } from "./page/refusal.js";
import { plain } from "./page/si.js";

const MASS_KG = [0.01, 5];
const DELAY_S = [0, 0.02];

export class Device {
  /** @param {(message: object) => void} send */
  constructor(root, model, send) {
    Object.assign(this, { root, model, send });
  }

  build() {
    this.mass = new Field({ label: "Mass", unit: "kg", limits: MASS_KG, set: (value) => this.set({ mass_kg: value }) });
    this.delay = new Field({
      label: "Delay",
      unit: "ms",
      limits: DELAY_S,
      write: (value) => plain(value * 1000),
      read: (text) => {
        const value = number(text);
        return value === null ? null : value / 1000;
      },
      set: (value) => this.set({ delay_s: value }),
    });
    this.mass.root.dataset.name = "device_mass_kg";
    this.delay.root.dataset.name = "delay_s";
    this.cut = document.createElement("input");
    this.cut.type = "checkbox";
    this.cut.id = "cut-off";
    this.cut.addEventListener("change", () => this.set({ cut_off: this.cut.checked }));
    const label = document.createElement("label");
    label.className = "check";
    label.append(this.cut, "cut off a contact that creates energy");
    label.title = "As palpate live does, because a real device would shake the hand";
    this.root.replaceChildren(this.root.querySelector("legend"), this.mass.root, this.delay.root, label);
  }

  set(change) {
    this.last = "mass_kg" in change ? this.mass : this.delay;
    this.send({ type: "device", ...this.model.state.device, ...change });
  }

  take({ device }) {
    this.mass.take(device.mass_kg);
    this.delay.take(device.delay_s);
    this.cut.checked = device.cut_off;
  }

  refuse(text) {
    this.last?.refuse(refusalInWords(text).words);
    this.take(this.model.state);
  }

  forgive() {
    this.mass.refuse("");
    this.delay.refuse("");
  }
}

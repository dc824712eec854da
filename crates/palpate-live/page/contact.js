// Fields of the contact and of the rendering rate.

import { Field, number } from "./field.js";
import { say } from "./protocol.js";
import { RATE, refusalInWords } from "./refusal.js";
import { plain } from "./si.js";

const GRAVITY = 9.81;

export class Contact {
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
    const inverse = (pair) => [1 / pair[1], 1 / pair[0]];
    const set = (key) => (value) => this.set({ [key]: value });
    this.fields = {
      stiffness_n_per_m: new Field({
        label: "Stiffness",
        unit: "N/m",
        limits: limits.stiffness_n_per_m,
        set: set("stiffness_n_per_m"),
      }),
      mass_kg: new Field({
        label: "Mass",
        unit: "kg",
        limits: limits.mass_kg,
        set: set("mass_kg"),
      }),
      virtual_force_n: new Field({
        label: "Virtual force",
        unit: "N",
        limits: limits.virtual_force_n,
        set: set("virtual_force_n"),
      }),
      period_s: new Field({
        label: "Rate",
        unit: "Hz",
        limits: inverse(limits.period_s),
        // The server knows periods: what is a round number there may be none here.
        says: (rate) => 1 / rate,
        set: (value) => this.setPeriod(value, this.fields.period_s),
      }),
    };
    this.period = new Field({
      label: "Period",
      unit: "ms",
      slides: false,
      limits: limits.period_s,
      write: (value) => plain(value * 1000),
      read: (text) => {
        const value = number(text);
        return value === null ? null : value / 1000;
      },
      set: (value) => this.setPeriod(value, this.period),
    });
    this.periodFrom = this.fields.period_s;
    this.wall = document.createElement("input");
    this.wall.type = "checkbox";
    this.wall.id = "wall";
    const wallLabel = document.createElement("label");
    wallLabel.className = "check";
    wallLabel.append(this.wall, "wall");
    this.wall.addEventListener("change", () => {
      this.set({ mass_kg: this.wall.checked ? null : (this.massBefore ?? Math.min(limits.mass_kg[1], 0.1)) });
    });
    this.weight = document.createElement("button");
    this.weight.type = "button";
    this.weight.id = "weight";
    this.weight.className = "small";
    this.weight.textContent = "weight";
    this.weight.title = "Weight of the mass, towards the device";
    this.weight.addEventListener("click", () => {
      const { mass_kg: mass } = this.model.state;
      this.set({ virtual_force_n: Number((-this.model.hello.side * mass * GRAVITY).toPrecision(6)) });
    });
    this.fields.mass_kg.root.append(wallLabel);
    this.fields.virtual_force_n.root.append(this.weight);
    const { stiffness_n_per_m, mass_kg, virtual_force_n, period_s } = this.fields;
    for (const [name, field] of Object.entries({ ...this.fields, period: this.period })) {
      field.root.dataset.name = name;
    }
    this.root.replaceChildren(
      this.root.querySelector("legend"),
      ...[stiffness_n_per_m, mass_kg, virtual_force_n, period_s, this.period].map((field) => field.root),
    );
  }

  setPeriod(value, field) {
    this.periodFrom = field;
    this.set({ period_s: value });
  }

  set(change) {
    this.last = Object.keys(change)[0];
    this.send(say.set(change));
  }

  /** Takes over the state. */
  take(state) {
    const { stiffness_n_per_m, mass_kg, virtual_force_n, period_s } = this.fields;
    this.massBefore = state.mass_kg ?? this.massBefore;
    stiffness_n_per_m.take(state.stiffness_n_per_m);
    mass_kg.take(state.mass_kg);
    mass_kg.disable(state.mass_kg === null);
    this.wall.checked = state.mass_kg === null;
    this.weight.disabled = state.mass_kg === null;
    virtual_force_n.take(state.virtual_force_n);
    period_s.take(1 / state.period_s);
    this.period.take(state.period_s);
  }

  /** Shows beside its field what the server refused; false if it is about none of these. `wasUsed`: these were used last. */
  refuse(text, wasUsed) {
    const { key: named, words } = refusalInWords(text, this.periodFrom === this.period ? undefined : RATE);
    const key = named in this.fields ? named : named === null && wasUsed ? this.last : null;
    if (!key) {
      return false;
    }
    const field = key === "period_s" ? this.periodFrom : this.fields[key];
    field.refuse(words);
    this.take(this.model.state);
    return true;
  }

  /** Takes every reason for a refusal away: something else is asked for. */
  forgive() {
    Object.values(this.fields).forEach((field) => field.refuse(""));
    this.period.refuse("");
  }
}

// Which method renders in each lane, and its damping.

import { Field } from "./field.js";
import { say } from "./protocol.js";
import { refusalInWords } from "./refusal.js";

const SECOND_LANE = ["basic", "hfcr"];

export class Methods {
  /**
   * @param {HTMLElement} root
   * @param {import("./model.js").Model} model
   * @param {(message: object) => void} send
   */
  constructor(root, model, send) {
    this.root = root;
    this.model = model;
    this.send = send;
  }

  /** Makes the fields: hello tells methods and lanes. */
  build() {
    const { device } = this.model.hello;
    this.lanes = Array.from({ length: device.lanes }, (_, lane) => this.buildLane(lane));
    this.refusal = document.createElement("p");
    this.refusal.className = "refused";
    this.refusal.setAttribute("role", "alert");
    this.both = null;
    if (device.lanes > 1) {
      this.both = document.createElement("input");
      this.both.type = "checkbox";
      this.both.id = "second-lane";
      this.both.title = "A second rendering, in the same hand";
      this.both.setAttribute("aria-label", "Second rendering, in the same hand");
      this.both.addEventListener("change", () => this.toggle());
      this.lanes[1].head.append(this.both);
    }
    this.root.replaceChildren(this.root.querySelector("legend"), ...this.lanes.map(({ root }) => root), this.refusal);
  }

  buildLane(lane) {
    const { methods, limits } = this.model.hello;
    const root = document.createElement("div");
    root.className = `lane lane-${lane + 1}`;
    const label = document.createElement("label");
    label.htmlFor = `method-${lane + 1}`;
    label.textContent = `Rendering ${lane + 1}`;
    const select = document.createElement("select");
    select.id = `method-${lane + 1}`;
    select.append(
      ...methods.map(({ name, title }) => {
        const option = document.createElement("option");
        option.value = name;
        option.textContent = name;
        option.title = title;
        return option;
      }),
    );
    const about = document.createElement("p");
    about.className = "about";
    const damping = new Field({
      label: "Damping b",
      unit: "N s/m",
      limits: limits.damping_n_s_per_m,
      empty: "default",
      set: (value) => this.change(lane, { damping_n_s_per_m: value }),
    });
    damping.root.dataset.name = `damping-${lane + 1}`;
    select.addEventListener("change", () => this.change(lane, { method: select.value, damping_n_s_per_m: null }));
    const head = document.createElement("div");
    head.className = "head";
    head.append(label);
    root.append(head, select, about, damping.root);
    return { root, head, select, about, damping };
  }

  get chosen() {
    return this.model.state.lanes.map(({ method, damping_n_s_per_m }) => ({ method, damping_n_s_per_m }));
  }

  change(lane, change) {
    this.last = lane;
    const lanes = this.chosen;
    lanes[lane] = { ...lanes[lane], ...change };
    this.send(say.set({ lanes }));
  }

  toggle() {
    const [first] = this.chosen;
    const names = this.model.hello.methods.map(({ name }) => name);
    const other = this.otherBefore ?? {
      method: [...SECOND_LANE, ...names].find((name) => name !== first.method && names.includes(name)) ?? first.method,
      damping_n_s_per_m: null,
    };
    this.send(say.set({ lanes: this.both.checked ? [first, other] : [first] }));
  }

  /** Takes over the state. */
  take(state) {
    if (this.both) {
      this.both.checked = state.lanes.length > 1;
    }
    this.otherBefore = this.chosen[1] ?? this.otherBefore;
    this.lanes.forEach(({ root, select, about, damping }, lane) => {
      const choice = state.lanes[lane];
      root.classList.toggle("off", !choice);
      select.disabled = !choice;
      if (!choice) {
        about.textContent = "off; the second rendering of the same hand";
        damping.root.hidden = true;
        return;
      }
      const method = this.model.hello.methods.find(({ name }) => name === choice.method);
      select.value = choice.method;
      about.textContent = method?.title ?? "";
      damping.root.hidden = !method?.damping;
      damping.take(choice.damping_n_s_per_m);
    });
  }

  /** Shows beside its field what the server refused. */
  refuse(text) {
    const lane = this.lanes[this.last];
    const { key, words } = refusalInWords(text);
    if (key === "damping_n_s_per_m" && lane && !lane.damping.root.hidden) {
      lane.damping.refuse(words);
    } else {
      this.refusal.textContent = words;
    }
    this.take(this.model.state);
  }

  /** Takes every reason for a refusal away: something else is asked for. */
  forgive() {
    this.refusal.textContent = "";
    this.lanes.forEach(({ damping }) => damping.refuse(""));
  }
}

// A value that can be set: a number and a slider, and beside them what the server refused.

import { limitsInWords } from "./refusal.js";
import { plain } from "./si.js";
import { slide } from "./slide.js";

const STEPS = 1000;
// So long after the last touch of the slider it does not follow what the server says: it would fight the hand on it.
const BUSY_MS = 400;

let made = 0;

export class Field {
  /**
   * @param {{label: string, unit: string, limits: [number, number], write?: (value: number) => string,
   *     read?: (text: string) => number | null, empty?: string, slides?: boolean,
   *     says?: (value: number) => number, set: (said: number | null) => void}} how
   *     `write` and `read`: conversions between the value and its text; `empty`: label of an allowed empty text (null);
   *     `says`: the value that is sent to the server
   */
  constructor({ label, unit, limits, empty, set, slides = true, write = plain, read = number, says = itself }) {
    made += 1;
    const id = `field-${made}`;
    this.how = { limits, set, write, read, empty, says };
    this.scale = slide(...limits);
    this.current = null;
    this.busyUntil = 0;
    this.root = document.createElement("div");
    this.root.className = "field";
    this.label = document.createElement("label");
    this.label.htmlFor = id;
    this.label.textContent = label;
    this.slider = document.createElement("input");
    this.slider.type = "range";
    this.slider.min = "0";
    this.slider.max = String(STEPS);
    this.slider.setAttribute("aria-label", `${label}, slider`);
    this.input = document.createElement("input");
    this.input.id = id;
    this.input.type = "text";
    this.input.inputMode = "decimal";
    this.input.autocomplete = "off";
    this.input.placeholder = empty ?? "";
    this.input.setAttribute("aria-describedby", `${id}-refused`);
    this.unit = document.createElement("span");
    this.unit.className = "unit";
    this.unit.textContent = unit;
    this.refusal = document.createElement("p");
    this.refusal.className = "refused";
    this.refusal.id = `${id}-refused`;
    this.refusal.setAttribute("role", "alert");
    this.slider.hidden = !slides;
    this.root.append(this.label, this.slider, this.input, this.unit, this.refusal);
    this.slider.addEventListener("input", () => this.slid());
    this.input.addEventListener("change", () => this.entered());
    this.input.addEventListener("input", () => this.refuse(""));
    this.input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") {
        this.refuse("");
        this.write();
      }
    });
  }

  slid() {
    const value = this.scale.value(Number(this.slider.value) / STEPS);
    this.busyUntil = performance.now() + BUSY_MS;
    clearTimeout(this.later);
    this.later = setTimeout(() => this.place(), BUSY_MS + 20);
    this.refuse("");
    this.input.value = this.how.write(value);
    this.say(value);
    this.how.set(this.how.says(value));
  }

  entered() {
    const text = this.input.value.trim();
    this.refuse("");
    if (text === "" && this.how.empty !== undefined) {
      this.how.set(null);
      return;
    }
    const value = this.how.read(text);
    if (value === null || !Number.isFinite(value)) {
      this.refuse(text === "" ? "enter a number" : `“${text}” is not a number`);
      return;
    }
    const said = this.how.says(value);
    if (!Number.isFinite(said)) {
      // A rate of 0 would be a message without a period, which the server has nothing against.
      const { limits, write } = this.how;
      this.refuse(`“${text}” is outside its range; allowed: ${limitsInWords(limits, this.unit.textContent, write)}`);
      return;
    }
    this.how.set(said);
  }

  /** Takes over what the server says it is. */
  take(value) {
    const changed = value !== this.current;
    this.current = value;
    if (changed) {
      this.refuse("");
    }
    this.place(changed);
  }

  write() {
    if (performance.now() >= this.busyUntil) {
      this.input.value = this.current === null ? "" : this.how.write(this.current);
    }
  }

  place(changed = true) {
    if (performance.now() >= this.busyUntil) {
      // Do not overwrite text that is being typed.
      if (changed || document.activeElement !== this.input) {
        this.write();
      }
      // Keep a slider position that already maps to this value: several positions map to 0, and keys must move past
      // them.
      if (this.current === null || this.scale.value(Number(this.slider.value) / STEPS) !== this.current) {
        this.slider.value = String(Math.round(STEPS * (this.current === null ? 0 : this.scale.place(this.current))));
      }
      this.say(this.current);
    }
  }

  say(value) {
    const text = value === null ? (this.how.empty ?? "") : `${this.how.write(value)} ${this.unit.textContent}`;
    this.slider.setAttribute("aria-valuetext", text);
  }

  /**
   * Shows the reason for a rejected value and restores the current one; an empty text removes the reason. The field
   * then shows a valid value, so it is not marked as invalid.
   */
  refuse(text) {
    this.refusal.textContent = text;
    if (text) {
      this.busyUntil = 0;
      this.place();
    }
  }

  disable(yes) {
    this.root.classList.toggle("off", yes);
    this.slider.disabled = yes;
    this.input.disabled = yes;
  }
}

function itself(value) {
  return value;
}

/** Reads a number, also with a true minus or a comma; null if it is none. */
export function number(text) {
  const value = Number(text.replace(/[−–]/g, "-").replace(",", "."));
  return text === "" || Number.isNaN(value) ? null : value;
}

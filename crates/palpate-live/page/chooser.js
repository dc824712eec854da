// Which device the mouse moves, where a world has several: a button for each, and one for all.

import { ALL } from "./hand_in_space.js";

export class Chooser {
  /**
   * @param {HTMLElement} root hidden where there is nothing to choose
   * @param {HTMLElement} group where the buttons stand
   * @param {import("./hand_in_space.js").HandInSpace} hand
   */
  constructor(root, group, hand) {
    Object.assign(this, { root, group, hand });
    hand.addEventListener("chosen", () => this.show());
  }

  /** Makes the buttons: another world has come. */
  build() {
    const { hands } = this.hand;
    this.root.hidden = hands.length < 2 || !hands.some(({ isLeadable }) => isLeadable);
    const each = hands.map(({ name, isLeadable, number }) => this.button(number, name, isLeadable));
    const leadable = hands.filter(({ isLeadable }) => isLeadable).length;
    const all = leadable > 1 ? [this.button(ALL, leadable === 2 && hands.length === 2 ? "both" : "all", true)] : [];
    this.group.replaceChildren(...each, ...all);
    this.show();
  }

  button(choice, text, isEnabled) {
    const input = document.createElement("input");
    input.type = "radio";
    input.name = "device";
    input.value = String(choice);
    input.disabled = !isEnabled;
    input.addEventListener("change", () => this.hand.choose(choice));
    const label = document.createElement("label");
    label.title = isEnabled ? `key ${choice === ALL ? 0 : choice + 1}` : "this device cannot be moved from the page";
    label.append(input, text);
    return label;
  }

  show() {
    for (const input of this.group.querySelectorAll("input")) {
      input.checked = input.value === String(this.hand.choice);
    }
  }
}

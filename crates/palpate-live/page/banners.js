// Banners for urgent events: lost server, ended loop, disabled force.

export class Banners {
  constructor(root) {
    this.root = root;
    this.shown = new Map();
  }

  /**
   * Shows a banner, or takes it away where there is no text.
   *
   * @param {string} about which one
   * @param {string | null} text
   * @param {{label: string, act: () => void} | null} action a button in it
   */
  show(about, text, action = null) {
    const before = this.shown.get(about);
    if (before && before.text === text) {
      return;
    }
    before?.place.remove();
    this.shown.delete(about);
    if (text === null) {
      return;
    }
    const place = document.createElement("div");
    place.className = "banner";
    place.dataset.about = about;
    const words = document.createElement("p");
    words.textContent = text;
    place.append(words);
    if (action) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = action.label;
      button.addEventListener("click", action.act);
      place.append(button);
    }
    this.root.append(place);
    this.shown.set(about, { text, place });
  }
}

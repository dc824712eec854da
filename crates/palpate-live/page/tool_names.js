// Labels of several tools; tools moved by the mouse are highlighted.

/** How far below a tool its name stands [px]. */
const BELOW_PX = 4;

export class ToolNames {
  /**
   * @param {HTMLElement} root lies over the canvas
   * @param {import("./space.js").Space | null} space
   * @param {import("./hand_in_space.js").HandInSpace} hand
   */
  constructor(root, space, hand) {
    Object.assign(this, { root, space, hand });
    this.names = [];
  }

  /** Makes the names: another world has come. One tool needs none. */
  begin(lanes) {
    const { hands } = this.hand;
    const several = this.space && hands.length > 1 ? hands : [];
    this.names = Array.from({ length: lanes }, (_, lane) =>
      several.map(({ name, number }) => {
        const place = document.createElement("span");
        place.textContent = name;
        return { place, lane, number };
      }),
    ).flat();
    this.root.replaceChildren(...this.names.map(({ place }) => place));
  }

  /** With each frame of the screen, when the space was drawn. */
  draw() {
    const chosen = new Set(this.hand.chosen.filter(({ isLeadable }) => isLeadable).map(({ number }) => number));
    for (const { place, lane, number } of this.names) {
      const [x, y] = this.space.toolOnCanvas(lane, number) ?? [0, 0];
      place.classList.toggle("led", chosen.has(number));
      place.style.transform = `translate(${x.toFixed(1)}px, ${(y + this.space.toolPixels(number) + BELOW_PX).toFixed(1)}px) translateX(-50%)`;
    }
  }
}

// All charts, with one time axis, one cursor and one zoom.

import { Bins } from "./bins.js";
import { Chart } from "./chart.js";
import { CHARTS } from "./curves.js";

const MAX_BINS = 1600;
const CURSOR = "palpate";
const SHOWN_AT_FIRST = ["force", "penetration", "energy", "leak", "timing"];

export class Charts {
  /**
   * @param {HTMLElement} root
   * @param {import("./model.js").Model} model
   * @param {import("./view.js").View} view
   * @param {() => void} onZoom called when what is shown has been changed here
   * @param {typeof CHARTS} what which charts there are
   */
  constructor(root, model, view, onZoom, what = CHARTS) {
    this.what = what;
    this.root = root;
    this.model = model;
    this.view = view;
    this.onZoom = onZoom;
    this.bins = new Bins(MAX_BINS);
    this.bins.lay(0, 1, 1);
    this.charts = [];
    this.shown = new Set(SHOWN_AT_FIRST);
    /** A cursor moved by keys [s]. */
    this.keyCursorS = null;
    this.drawnFrom = NaN;
    this.drawnTo = NaN;
    new ResizeObserver(() => this.layOut()).observe(root);
    root.addEventListener("keydown", (event) => this.key(event));
    root.addEventListener("pointermove", () => {
      this.keyCursorS = null;
    });
  }

  /** Makes the charts: hello tells which columns there are, and how many lanes. */
  build() {
    this.charts.forEach((chart) => chart.uplot.destroy());
    const { model, view } = this;
    this.charts = this.what.map((what) => {
      const curves = what.curves.filter(({ column }) => model.column(column) >= 0);
      return { ...what, curves };
    })
      .filter(({ curves }) => curves.length > 0)
      .map(
        (what) =>
          new Chart(what, this.bins, {
            lanes: model.lanes.length,
            columns: what.curves.map(({ column }) => model.column(column)),
            sync: CURSOR,
            onSelect: (fromS, toS) => {
              view.zoomTo(fromS, toS);
              this.onZoom();
            },
            onReset: () => {
              view.all();
              this.onZoom();
            },
          }),
      );
    this.root.replaceChildren(...this.charts.map((chart) => chart.root));
    this.show(this.shown);
    this.name();
  }

  show(shown) {
    this.shown = shown;
    for (const chart of this.charts) {
      chart.root.hidden = !shown.has(chart.what.id);
    }
    const visible = this.visible;
    visible.forEach((chart, i) => chart.showTimes(i === visible.length - 1));
    this.layOut();
    this.redraw();
  }

  get visible() {
    return this.charts.filter((chart) => !chart.root.hidden);
  }

  /** Takes over the names of the lanes' methods. */
  name() {
    const names = (this.model.state?.lanes ?? []).map(({ method }) => method);
    for (const chart of this.charts) {
      chart.legend.name(names);
    }
    this.redraw();
  }

  layOut() {
    for (const chart of this.visible) {
      chart.size(chart.plot.clientWidth, chart.plot.clientHeight);
    }
    this.redraw();
  }

  selectable(yes) {
    this.charts.forEach((chart) => chart.selectable(yes));
    this.root.classList.toggle("selectable", yes);
  }

  /** Lets the next frame draw, even if nothing has moved. */
  redraw() {
    this.drawnTo = NaN;
  }

  /** Draws what the view shows, if that has changed. */
  draw(nowS, fit) {
    const [first] = this.visible;
    if (!first || !this.model.state) {
      return;
    }
    const { fromS, toS } = this.view;
    const rings = this.rings;
    if (fromS !== this.drawnFrom || toS !== this.drawnTo || fit) {
      this.drawnFrom = fromS;
      this.drawnTo = toS;
      this.bins.lay(fromS, toS, first.pixels);
      this.visible.forEach((chart) => chart.begin());
      rings.forEach((ring, lane) => {
        this.bins.sort(ring);
        this.visible.forEach((chart) => chart.fill(lane));
      });
      this.visible.forEach((chart) => chart.draw(fromS, toS, nowS, fit));
      this.placeKeyCursor();
    }
  }

  /** Says the values at the cursor, or the newest. */
  read() {
    const rings = this.rings;
    for (const chart of this.visible) {
      chart.read(rings, chart.cursorS ?? (this.view.paused ? this.view.toS : null));
    }
  }

  get rings() {
    return this.model.lanes.slice(0, this.model.state?.lanes.length ?? 0).map(({ ring }) => ring);
  }

  placeKeyCursor() {
    const [first] = this.visible;
    if (this.keyCursorS !== null && first) {
      const left = first.uplot.valToPos(this.keyCursorS, "x");
      first.uplot.setCursor({ left, top: 1 }, false);
      first.uplot.cursor.event = null;
      for (const chart of this.visible.slice(1)) {
        chart.uplot.setCursor({ left, top: 1 }, false);
      }
    }
  }

  key(event) {
    const { view } = this;
    const length = view.toS - view.fromS;
    const step = (event.shiftKey ? 0.1 : 0.01) * length;
    const at = this.keyCursorS ?? this.visible[0]?.cursorS ?? (view.fromS + view.toS) / 2;
    const moves = {
      ArrowLeft: () => this.moveCursor(Math.max(view.fromS, at - step)),
      ArrowRight: () => this.moveCursor(Math.min(view.toS, at + step)),
      PageUp: () => view.moveBy(-0.5),
      PageDown: () => view.moveBy(0.5),
      "+": () => view.zoomBy(0.5, at),
      "=": () => view.zoomBy(0.5, at),
      "-": () => view.zoomBy(2, at),
      0: () => view.all(),
      Escape: () => view.all(),
    };
    const move = event.ctrlKey || event.metaKey || event.altKey ? null : moves[event.key];
    if (move) {
      event.preventDefault();
      move();
      this.onZoom();
    }
  }

  moveCursor(toS) {
    this.keyCursorS = toS;
    this.placeKeyCursor();
  }
}

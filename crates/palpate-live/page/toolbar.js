// Toolbar above the charts: pause, visible time, zoom, chart selection, exports.

import { savePicture, saveTable } from "./save.js";
import { SPANS_S } from "./view.js";

export class Toolbar {
  /**
   * @param {(id: string) => HTMLElement} place
   * @param {() => void} onChange called when another stretch of time is to be drawn
   */
  constructor(place, { model, view, scene, charts }, onChange) {
    this.place = place;
    this.view = view;
    this.onChange = onChange;
    this.charts = charts;
    place("pause").addEventListener("click", () => {
      if (view.paused) {
        view.go();
        model.refusedRows = 0;
      } else {
        view.pause();
      }
      onChange();
    });
    this.spans = SPANS_S.map((span) => this.choice(span));
    place("spans").append(...this.spans.map(({ label }) => label));
    place("zoom-in").addEventListener("click", () => this.zoom(0.5));
    place("zoom-out").addEventListener("click", () => this.zoom(2));
    place("zoom-all").addEventListener("click", () => {
      view.all();
      onChange();
    });
    place("shown").append(...charts.what.map(({ id, chip, title }) => this.chip(id, chip, title)));
    place("csv").addEventListener("click", () => saveTable(model));
    place("png").addEventListener("click", () => savePicture(model, view, scene, charts));
  }

  zoom(factor) {
    this.view.zoomBy(factor);
    this.onChange();
  }

  choice(span) {
    const input = document.createElement("input");
    input.type = "radio";
    input.name = "span";
    input.value = String(span);
    input.addEventListener("change", () => {
      this.view.show(span);
      this.onChange();
    });
    const label = document.createElement("label");
    label.append(input, `${span} s`);
    return { label, input, span };
  }

  chip(id, text, title) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.title = title;
    button.dataset.chart = id;
    button.setAttribute("aria-pressed", String(this.charts.shown.has(id)));
    button.addEventListener("click", () => {
      const shown = new Set(this.charts.shown);
      if (!shown.delete(id)) {
        shown.add(id);
      }
      button.setAttribute("aria-pressed", String(shown.has(id)));
      this.charts.show(shown);
      this.onChange();
    });
    return button;
  }

  /** Shows what the view is. */
  take() {
    const { view, place } = this;
    const pause = place("pause");
    pause.textContent = view.paused ? "Resume" : "Pause";
    pause.setAttribute("aria-pressed", String(view.paused));
    place("zooms").hidden = !view.paused;
    this.charts.selectable(view.paused);
    for (const { input, span } of this.spans) {
      input.checked = span === view.spanS;
    }
  }
}

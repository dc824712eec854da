// One chart: a uPlot with binned curves of every lane, and its legend, which is also its read-out.

import uPlot from "./vendor/uplot/uPlot.js";
import { EMPTY } from "./bins.js";
import { Ink } from "./ink.js";
import { SteadyRange } from "./range.js";
import { decimalsOf, digits, prefixFor } from "./si.js";
import { theme } from "./theme.js";

const AXIS_WIDTH = 46;
const TIME_HEIGHT = 24;

export class Chart {
  /**
   * @param {object} what one of `CHARTS`
   * @param {import("./bins.js").Bins} bins shared by all charts
   * @param {{lanes: number, columns: number[], sync: string, onSelect: (fromS: number, toS: number) => void,
   *     onReset: () => void}} how
   */
  constructor(what, bins, { lanes, columns, sync, onSelect, onReset }) {
    this.what = what;
    this.bins = bins;
    this.columns = columns;
    this.range = new SteadyRange(what.range);
    this.prefix = prefixFor(this.range.max);
    /** The lanes in the order in which they are drawn: the one that covers most comes first. */
    this.order = Array.from({ length: lanes }, (_, lane) => lane);
    this.spreads = new Float64Array(lanes);
    this.lanesFilled = lanes;
    this.ink = new Ink(lanes * columns.length, bins.largest);
    this.min = Infinity;
    this.max = -Infinity;
    this.store = Array.from({ length: lanes * columns.length }, () => new Float64Array(2 * bins.largest).fill(EMPTY));
    this.data = [bins.times, ...this.store.map((curve) => curve.subarray(0, bins.times.length))];
    this.root = document.createElement("section");
    this.root.className = "chart";
    this.root.id = `chart-${what.id}`;
    this.root.setAttribute("aria-label", what.title);
    this.plot = document.createElement("div");
    this.plot.className = "plot";
    this.legend = new Legend(what, lanes);
    this.root.append(this.legend.root, this.plot);
    this.uplot = new uPlot(this.options({ lanes, sync, onSelect, onReset }), this.data, this.plot);
  }

  options({ lanes, sync, onSelect, onReset }) {
    const text = () => theme.quiet;
    const axis = {
      stroke: text,
      font: `11px ${theme.font}`,
      grid: { stroke: () => theme.grid, width: 1 },
      ticks: { show: false },
    };
    const curves = [];
    for (let slot = 0; slot < lanes; slot += 1) {
      for (const { dash } of this.what.curves) {
        curves.push({
          scale: "y",
          auto: false,
          stroke: () => theme.lanes[this.order[slot]],
          width: 1.5,
          dash,
          cap: "butt",
          paths: this.ink.paths,
          points: { show: false },
        });
      }
    }
    return {
      width: 300,
      height: 120,
      padding: [9, 8, 2, 0],
      legend: { show: false },
      scales: { x: { time: false, auto: false, range: asSet }, y: { auto: false, range: asSet } },
      series: [{}, ...curves],
      axes: [
        { ...axis, size: TIME_HEIGHT, gap: 3, space: 60, values: (_, at) => timeTexts(at) },
        { ...axis, size: AXIS_WIDTH, gap: 4, space: 26, values: (_, at) => this.valueTexts(at) },
      ],
      cursor: {
        y: false,
        points: { show: false },
        sync: { key: sync, setSeries: false },
        drag: { x: true, y: false, setScale: false, dist: 4 },
        bind: { dblclick: () => onReset },
      },
      hooks: {
        drawAxes: [drawZero],
        drawSeries: [this.ink.draw],
        setSelect: [
          (u) => {
            const { left, width } = u.select;
            if (width > 0 && u.cursor.event?.type === "mouseup") {
              onSelect(u.posToVal(left, "x"), u.posToVal(left + width, "x"));
            }
            if (width > 0) {
              u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            }
          },
        ],
      },
    };
  }

  valueTexts(at) {
    const step = at.length > 1 ? (at[1] - at[0]) / this.prefix.factor : 1;
    const decimals = decimalsOf(step);
    return at.map((value) => minus((value / this.prefix.factor).toFixed(decimals)));
  }

  /** Width of the plot itself in CSS pixels. */
  get pixels() {
    return this.uplot.over.clientWidth;
  }

  size(width, height) {
    if (width > 0 && height > 0 && (width !== this.uplot.width || height !== this.uplot.height)) {
      this.uplot.setSize({ width, height });
    }
  }

  /** Whether dragging selects. */
  selectable(yes) {
    this.uplot.cursor.drag.x = yes;
    this.uplot.cursor.drag.setScale = false;
  }

  /** The time axis has its numbers on the lowest chart only. */
  showTimes(show) {
    const [axis] = this.uplot.axes;
    if (this.timesShown !== show) {
      this.timesShown = show;
      axis.size = () => (show ? TIME_HEIGHT : 4);
      axis.values = (_, at) => (show ? timeTexts(at) : at.map(() => ""));
    }
  }

  /** Before curves are filled in: decides which lane is drawn first. */
  begin() {
    this.sort();
    this.min = Infinity;
    this.max = -Infinity;
    if (this.spreads.length > this.lanesFilled) {
      this.store.forEach((curve) => curve.fill(EMPTY));
    }
    this.lanesFilled = 0;
  }

  /** Fills in the curves of a lane, whose rows have been sorted into the bins. */
  fill(lane) {
    const { bins, columns, store } = this;
    const slot = this.order.indexOf(lane) * columns.length;
    columns.forEach((column, i) => {
      const { min, max, spread } = bins.fill(column, store[slot + i]);
      this.spreads[lane] += spread;
      this.min = Math.min(this.min, min);
      this.max = Math.max(this.max, max);
    });
    this.lanesFilled += 1;
  }

  /** Draws the stretch that the bins are laid over, once its curves are filled in. */
  draw(fromS, toS, nowS, fit) {
    const { bins, store } = this;
    if (this.data[0] !== bins.times) {
      this.data = [bins.times, ...store.map((curve) => curve.subarray(0, bins.times.length))];
    }
    if (fit) {
      this.range.fit(this.min, this.max);
    } else {
      this.range.take(this.min, this.max, nowS);
    }
    this.prefix = prefixFor(Math.max(Math.abs(this.range.min), Math.abs(this.range.max)));
    this.legend.unit(`${this.prefix.sign}${this.what.unit}`);
    this.uplot.batch(() => {
      this.uplot.setData(this.data, false);
      this.uplot.setScale("x", { min: fromS, max: toS });
      this.uplot.setScale("y", { min: this.range.min, max: this.range.max });
    });
  }

  /** Lets a curve that buzzes not hide one that does not. */
  sort() {
    const [first, second] = this.order;
    if (second !== undefined && this.spreads[second] > 1.3 * this.spreads[first]) {
      this.order.reverse();
    }
    this.spreads.fill(0);
  }

  /** Where the cursor stands [s]; null if it does not. */
  get cursorS() {
    const { left } = this.uplot.cursor;
    return left >= 0 ? this.uplot.posToVal(left, "x") : null;
  }

  /** Says the values at a time [s], or the newest. */
  read(rings, atS) {
    for (let lane = 0; lane < rings.length; lane += 1) {
      const ring = rings[lane];
      const row = atS === null ? ring.length - 1 : ring.rowAt(atS);
      this.columns.forEach((column, curve) => {
        const value = row < 0 ? NaN : ring.value(column, row);
        this.legend.value(lane, curve, digits(value / this.prefix.factor));
      });
    }
  }
}

class Legend {
  constructor(what, lanes) {
    this.root = document.createElement("div");
    this.root.className = "legend";
    const title = document.createElement("h3");
    title.textContent = what.title;
    this.unitPlace = document.createElement("span");
    this.unitPlace.className = "unit";
    title.append(" ", this.unitPlace);
    const table = document.createElement("table");
    const body = table.createTBody();
    const head = body.insertRow();
    head.className = "lanes";
    head.append(document.createElement("td"));
    this.heads = Array.from({ length: lanes }, (_, lane) => {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.className = `lane-${lane + 1}`;
      head.append(cell);
      return cell;
    });
    this.cells = Array.from({ length: lanes }, () => []);
    for (const { name, dash } of what.curves) {
      const row = body.insertRow();
      const label = document.createElement("th");
      label.scope = "row";
      label.append(sample(dash), name);
      row.append(label);
      for (let lane = 0; lane < lanes; lane += 1) {
        this.cells[lane].push(row.insertCell());
      }
    }
    this.root.append(title, table);
  }

  unit(text) {
    set(this.unitPlace, text);
  }

  value(lane, curve, text) {
    set(this.cells[lane][curve], text);
  }

  /** Names the lanes; those without a name are not shown. */
  name(names) {
    this.heads.forEach((head, lane) => {
      set(head, names[lane] ?? "");
      head.title = names[lane] ?? "";
      for (const cell of [head, ...this.cells[lane]]) {
        cell.hidden = lane >= names.length;
      }
    });
  }
}

/** The line of 0 is a little stronger than the others. */
function drawZero(u) {
  const { min, max } = u.scales.y;
  if (min >= 0 || max <= 0) {
    return;
  }
  const y = Math.round(u.valToPos(0, "y", true)) + 0.5;
  u.ctx.strokeStyle = theme.rule;
  u.ctx.lineWidth = devicePixelRatio;
  u.ctx.setLineDash([]);
  u.ctx.beginPath();
  u.ctx.moveTo(u.bbox.left, y);
  u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
  u.ctx.stroke();
}

/** A short line as the curve has it. */
function sample(dash) {
  const space = "http://www.w3.org/2000/svg";
  const picture = document.createElementNS(space, "svg");
  picture.setAttribute("viewBox", "0 0 24 8");
  picture.setAttribute("aria-hidden", "true");
  const line = document.createElementNS(space, "path");
  line.setAttribute("d", "M0 4H24");
  if (dash.length) {
    line.setAttribute("stroke-dasharray", dash.join(" "));
  }
  picture.append(line);
  return picture;
}

/** The ends of an axis are those that were set. */
function asSet(_, min, max) {
  return min < max ? [min, max] : [0, 1];
}

function set(place, text) {
  if (place.textContent !== text) {
    place.textContent = text;
  }
}

function timeTexts(at) {
  const step = at.length > 1 ? at[1] - at[0] : 1;
  const decimals = decimalsOf(step);
  // Before 0 there was no time.
  return at.map((value, i) => (value < 0 ? "" : value.toFixed(decimals) + (i === at.length - 1 ? " s" : "")));
}

function minus(text) {
  return /^-0(\.0*)?$/.test(text) ? text.slice(1) : text.replace("-", "−");
}

// Drawing of binned curves. Single-point bins form a line. Bins with a range form a filled bar from minimum to maximum:
// a line that goes up and down in every pixel costs a browser many times as much and looks the same.

import { BREAK } from "./bins.js";

/** A band is higher than this many times the width of the line. */
const BAND = 2;

/** What draws the curves of one chart: a path builder for uPlot, and a hook for after it. */
export class Ink {
  /** @param {number} curves @param {number} bins the most there can be */
  constructor(curves, bins) {
    this.bars = Array.from({ length: curves }, () => ({ count: 0, places: new Float32Array(3 * bins) }));
    this.paths = (u, series) => this.line(u, series);
    this.draw = (u, series) => this.drawBars(u, series);
  }

  /** The line of a curve; takes down its bars. Places without a value are passed over, where values are missing it ends. */
  line(u, series) {
    const [times] = u.data;
    const values = u.data[series];
    const { left, top, width, height } = u.bbox;
    const { x, y } = u.scales;
    const perSecond = width / (x.max - x.min);
    const perUnit = height / (y.max - y.min);
    const bottom = top + height;
    const high = BAND * u.series[series].width * devicePixelRatio;
    const bars = this.bars[series - 1];
    const stroke = new Path2D();
    bars.count = 0;
    let drawing = false;
    // The band that the line has just left: from where to where.
    let upper = Infinity;
    let lower = -Infinity;
    for (let i = 0; i < values.length; i += 2) {
      const first = values[i];
      if (first !== first) {
        continue;
      }
      if (first === BREAK) {
        drawing = false;
        lower = -Infinity;
        continue;
      }
      const last = values[i + 1];
      const toX = left + (times[i] - x.min) * perSecond;
      const firstY = bottom - (first - y.min) * perUnit;
      const lastY = last === last ? bottom - (last - y.min) * perUnit : firstY;
      const from = Math.min(firstY, lastY);
      const to = Math.max(firstY, lastY);
      const isBand = to - from > high;
      const touches = from <= lower && to >= upper;
      if (!drawing || (isBand && touches)) {
        stroke.moveTo(toX, firstY);
      } else {
        stroke.lineTo(toX, firstY);
      }
      if (isBand) {
        bars.places.set([toX, from, to], 3 * bars.count);
        bars.count += 1;
        upper = from;
        lower = to;
        stroke.moveTo(toX, lastY);
      } else {
        if (lastY !== firstY) {
          stroke.lineTo(toX, lastY);
        }
        lower = -Infinity;
        upper = Infinity;
      }
      drawing = true;
    }
    bars.width = perSecond * (times[2] - times[0] || 0);
    return { stroke, fill: null, clip: null, band: null, gaps: null, flags: 0 };
  }

  drawBars(u, series) {
    const bars = this.bars[series - 1];
    if (!bars || bars.count === 0) {
      return;
    }
    const { ctx, bbox } = u;
    const bottom = bbox.top + bbox.height;
    const right = bbox.left + bbox.width;
    ctx.fillStyle = u.series[series].stroke(u, series);
    // As wide as the line where bins are narrower: one goes over into the other, and no seams shine through.
    const end = (u.series[series].width * devicePixelRatio) / 2;
    const half = Math.max(bars.width / 2, end);
    for (let k = 0; k < bars.count; k += 1) {
      const from = Math.max(bbox.left, bars.places[3 * k] - half);
      const to = Math.min(right, bars.places[3 * k] + half);
      const top = Math.max(bbox.top, bars.places[3 * k + 1] - end);
      const tall = Math.min(bottom, bars.places[3 * k + 2] + end) - top;
      if (to > from && tall > 0) {
        ctx.fillRect(from, top, to - from, tall);
      }
    }
  }
}

// The picture of the contact: device, hand, object and force of every lane along one upright axis.

import { Axis } from "./axis.js";
import { roundStep } from "./range.js";
import { quantity } from "./si.js";
import { theme } from "./theme.js";

const TOP_PX = 64;
const BOTTOM_PX = 38;
const LEFT_PX = 44;
const LONGEST_ARROW_PX = 90;
const RECENT_S = 0.1;
const TEXT_EVERY_S = 0.125;

export class Scene {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import("./model.js").Model} model
   */
  constructor(canvas, model) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.model = model;
    this.axis = new Axis([0, 1]);
    /** Where the hand is being led by this page [m]; null if it is not. */
    this.ledM = null;
    this.forceForFull = 1;
    this.saidAtS = -Infinity;
    this.said = [];
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  resize() {
    const ratio = devicePixelRatio;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.axis.lay(TOP_PX, this.height - BOTTOM_PX);
  }

  /** Takes over what hello tells of the axis. */
  begin() {
    const { view_m: view, device } = this.model.hello;
    this.axis = new Axis(view);
    this.axis.lay(TOP_PX, this.height - BOTTOM_PX);
    this.forceForFull = device.largest_force_n ? Math.min(device.largest_force_n, 2) : 2;
  }

  /** Where the hand wants to be [m]; null if nobody leads it. */
  get handM() {
    return this.ledM ?? this.model.state?.hand_m ?? null;
  }

  /** What a lane looks like now. */
  look(lane) {
    const { model } = this;
    return {
      device: model.newest(lane, "device_position_m"),
      object: model.newest(lane, "object_position_m"),
      penetration: model.newest(lane, "penetration_m"),
      force: model.recent(lane, "force_on_device_n", RECENT_S),
    };
  }

  draw(nowS, still) {
    const { model, context, width, height } = this;
    if (!model.hello || !model.state || !width) {
      return;
    }
    const ratio = this.canvas.width / width;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const lanes = model.state.lanes.length;
    const looks = Array.from({ length: lanes }, (_, lane) => this.look(lane));
    if (this.ledM === null) {
      this.axis.include([this.handM ?? NaN, ...looks.map((look) => look.device)], still ? 1 : 0.12);
    }
    this.scaleForce(looks);
    this.drawAxis();
    if (nowS - this.saidAtS > TEXT_EVERY_S || this.said.length !== lanes) {
      this.saidAtS = nowS;
      this.said = looks.map((look) => ({
        force: forceText(look.force),
        depth: look.penetration > 0 ? quantity(look.penetration, "m", look.force.grouped ? 2 : 3) : "apart",
        depthPx: look.force.grouped ? 112 : 84,
      }));
    }
    const each = (width - LEFT_PX) / lanes;
    looks.forEach((look, lane) => {
      context.save();
      context.beginPath();
      context.rect(LEFT_PX + lane * each, 0, each, height);
      context.clip();
      this.drawLane(lane, look, LEFT_PX + lane * each, each);
      context.restore();
    });
    this.drawScales();
  }

  /** Lets the longest arrow fit; comes back slowly. */
  scaleForce(looks) {
    let largest = 0;
    for (const { force: { least, greatest } } of looks) {
      if (least <= greatest) {
        largest = Math.max(largest, Math.abs(least), Math.abs(greatest));
      }
    }
    const wanted = roundStep(Math.max(largest, 0.5));
    if (wanted > this.forceForFull) {
      this.forceForFull = wanted;
      this.lowSince = null;
    } else if (wanted < 0.5 * this.forceForFull) {
      this.lowSince ??= performance.now();
      if (performance.now() - this.lowSince > 3000) {
        this.forceForFull = wanted;
        this.lowSince = null;
      }
    } else {
      this.lowSince = null;
    }
  }

  get pxPerN() {
    return LONGEST_ARROW_PX / this.forceForFull;
  }

  drawAxis() {
    const { context, axis, width } = this;
    context.font = `11px ${theme.font}`;
    context.textBaseline = "middle";
    context.textAlign = "right";
    context.lineWidth = 1;
    for (const mark of axis.marks(34)) {
      const y = Math.round(axis.y(mark)) + 0.5;
      if (y < axis.topPx - 1 || y > axis.bottomPx + 1) {
        continue;
      }
      context.strokeStyle = theme.grid;
      line(context, LEFT_PX, y, width, y);
      context.fillStyle = theme.quiet;
      context.fillText(minus(trimmed(mark * 1000)), LEFT_PX - 8, y);
    }
    context.fillStyle = theme.quiet;
    context.fillText("mm", LEFT_PX - 8, axis.topPx - 20);
  }

  drawLane(lane, look, left, width) {
    const { context, axis, model } = this;
    const side = model.hello.side;
    const colour = theme.lanes[lane];
    const middle = left + width / 2 - 10;
    const size = Math.max(0.72, Math.min(1.5, width / 150));
    const hand = this.handM;
    if (hand !== null && !(Math.abs(axis.y(hand) - axis.y(look.device)) < 2)) {
      drawHand(context, middle, axis.y(hand), axis.y(look.device), side, size);
    }
    const objectY = axis.y(look.object);
    this.drawObject(middle, objectY, side, size, width);
    if (look.device === look.device) {
      drawHandle(context, middle, axis.y(look.device), side, size, colour);
      if (look.penetration > 0) {
        drawOverlap(context, middle, axis.y(look.device), objectY, size, colour);
      }
      this.drawForce(middle + 46 * size, axis.y(look.device), look.force, colour);
    }
    this.drawBeyond(middle, look.object, objectY);
    this.drawHead(lane, left, width, colour);
  }

  /** Which method this is, and what it does: always at the same place, to be read while it moves. */
  drawHead(lane, left, width, colour) {
    const { context, axis, model } = this;
    const { method, safety_stop } = model.state.lanes[lane];
    const { force, depth, depthPx } = this.said[lane];
    context.fillStyle = theme.panel;
    context.fillRect(left + (lane > 0 ? 1 : 0), 0, width, axis.topPx - 12);
    if (lane > 0) {
      context.strokeStyle = theme.rule;
      context.lineWidth = 1;
      line(context, left + 0.5, 12, left + 0.5, axis.bottomPx + 8);
    }
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.fillStyle = colour;
    dot(context, left + 16, 19.5, 4.5);
    context.fillStyle = theme.ink;
    context.font = `600 13px ${theme.font}`;
    context.fillText(method, left + 27, 24, width - 32);
    context.font = `12px ${theme.font}`;
    if (safety_stop) {
      context.fillStyle = theme.alarm;
      context.fillText("force cut off", left + 27, 42, width - 32);
      return;
    }
    context.fillText(force, left + 27, 42, depthPx - 30);
    context.fillStyle = theme.quiet;
    context.fillText(depth, left + depthPx, 42, width - depthPx - 4);
  }

  drawObject(middle, y, side, size, width) {
    const { context, axis, model } = this;
    if (Number.isNaN(y)) {
      return;
    }
    const mass = model.state.mass_kg;
    const half = mass === null ? width : 34 * size;
    const tall = mass === null ? 2000 : 36 * size;
    const top = side > 0 ? y - tall : y;
    context.fillStyle = theme.solid;
    context.strokeStyle = theme.ink;
    context.lineWidth = 1.25;
    if (mass === null) {
      context.fillRect(middle - half, top, 2 * half, tall);
      hatch(context, middle - half, side > 0 ? Math.max(top, 0) : y, 2 * half, side > 0 ? y : axis.bottomPx + 40);
      line(context, middle - half, y, middle + half, y);
    } else {
      context.beginPath();
      context.roundRect(middle - half, top, 2 * half, tall, 3);
      context.fill();
      context.stroke();
    }
    context.fillStyle = theme.ink;
    context.font = `12px ${theme.font}`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const text = mass === null ? "wall" : quantity(mass * 1000, "g");
    // Beyond a block: within it, the device would cover the words.
    const textY = mass === null ? y - side * 16 : y - side * (tall + 10);
    if (mass === null) {
      const wide = context.measureText(text).width + 12;
      context.fillStyle = theme.solid;
      context.fillRect(middle - wide / 2, textY - 9, wide, 18);
      context.fillStyle = theme.ink;
    }
    context.fillText(text, middle, textY);
  }

  /** Says how far away an object is that is not seen. */
  drawBeyond(middle, position, y) {
    const { context, axis, model } = this;
    const above = y < axis.topPx - 4;
    if (model.state.mass_kg === null || !(above || y > axis.bottomPx + 4)) {
      return;
    }
    const at = above ? axis.topPx + 6 : axis.bottomPx - 6;
    const tip = above ? -6 : 6;
    context.fillStyle = theme.quiet;
    context.beginPath();
    context.moveTo(middle, at + tip);
    context.lineTo(middle - 5, at);
    context.lineTo(middle + 5, at);
    context.fill();
    context.font = `11px ${theme.font}`;
    context.textAlign = "center";
    context.fillText(`object at ${quantity(position, "m")}`, middle, at - 2 * tip);
  }

  drawForce(x, y, { least, greatest, nearest }, colour) {
    const { context, pxPerN } = this;
    context.fillStyle = colour;
    if (greatest - least > 0.01 * this.forceForFull) {
      // Range of the recent force, which makes a buzzing contact visible.
      context.globalAlpha = 0.22;
      const from = y - greatest * pxPerN;
      context.fillRect(x - 5, from, 10, (greatest - least) * pxPerN);
      context.globalAlpha = 1;
    }
    arrow(context, x, y, y - nearest * pxPerN);
  }

  drawScales() {
    const { context, axis, height } = this;
    const metres = barFor(70 / axis.pxPerM);
    const newtons = barFor(70 / this.pxPerN);
    const y = height - 14.5;
    let x = LEFT_PX;
    for (const [length, text] of [
      [metres * axis.pxPerM, roundQuantity(metres, "m")],
      [newtons * this.pxPerN, roundQuantity(newtons, "N")],
    ]) {
      context.strokeStyle = theme.quiet;
      context.lineWidth = 1;
      line(context, x + 0.5, y, x + length, y);
      line(context, x + 0.5, y - 3, x + 0.5, y + 3);
      line(context, x + length, y - 3, x + length, y + 3);
      context.font = `11px ${theme.font}`;
      context.textAlign = "left";
      context.textBaseline = "middle";
      context.fillStyle = theme.quiet;
      context.fillText(text, x + length + 7, y + 0.5);
      x += length + 7 + context.measureText(text).width + 24;
    }
  }
}

/** The force of a moment: its mean, or where rows are groups from least to greatest, in two digits of the larger. */
export function forceText({ least, greatest, mean, grouped }) {
  const fixed = (value, decimals) => minus(value.toFixed(decimals).replace(/^-(0\.?0*)$/, "$1"));
  if (!(least <= greatest)) {
    return "";
  }
  if (!grouped) {
    return `${fixed(mean, 2)} N`;
  }
  const largest = Math.max(Math.abs(least), Math.abs(greatest));
  const decimals = largest < 0.995 ? 2 : largest < 9.95 ? 1 : 0;
  const [low, high] = [least, greatest].map((value) => fixed(value, decimals));
  return low === high ? `${low} N` : `${low} to ${high} N`;
}

/** The greatest of 1, 2 and 5 times a power of ten that is not above this size. */
function barFor(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return power * (size >= 5 * power ? 5 : size >= 2 * power ? 2 : 1);
}

/** Without digits that say nothing: 10 mm, not 10.0 mm. */
function roundQuantity(value, unit) {
  return quantity(value, unit, 1);
}

function trimmed(value) {
  return String(Number(value.toPrecision(6)));
}

function minus(text) {
  return text.replace("-", "−");
}

function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

function dot(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

function handlePath(context, x, y, side, size) {
  const flip = (from, tall) => (side > 0 ? y + from * size : y - (from + tall) * size);
  context.beginPath();
  context.roundRect(x - 26 * size, flip(0, 6), 52 * size, 6 * size, 2);
  context.rect(x - 4 * size, flip(6, 12), 8 * size, 12 * size);
  context.roundRect(x - 15 * size, flip(18, 26), 30 * size, 26 * size, 9 * size);
}

function drawHandle(context, x, y, side, size, colour) {
  handlePath(context, x, y, side, size);
  context.fillStyle = colour;
  context.fill();
}

function drawHand(context, x, y, deviceY, side, size) {
  context.save();
  context.strokeStyle = theme.quiet;
  context.lineWidth = 1.25;
  context.setLineDash([4, 3]);
  handlePath(context, x, y, side, size);
  context.stroke();
  if (deviceY === deviceY && Math.abs(deviceY - y) > 3) {
    // What pulls: from the hand's grip to the device's.
    const grip = side * 31 * size;
    context.setLineDash([]);
    line(context, x, y + grip, x, deviceY + grip);
  }
  if (Math.abs(deviceY - y) > 30 || deviceY !== deviceY) {
    context.fillStyle = theme.quiet;
    context.font = `11px ${theme.font}`;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText("hand", x - 21 * size, y + side * 31 * size);
  }
  context.restore();
}

function drawOverlap(context, x, deviceY, objectY, size, colour) {
  const top = Math.min(deviceY, objectY);
  const tall = Math.abs(deviceY - objectY);
  context.save();
  context.globalAlpha = 0.35;
  context.fillStyle = colour;
  context.fillRect(x - 34 * size, top, 68 * size, tall);
  context.restore();
}

function hatch(context, left, top, width, bottom) {
  context.save();
  context.beginPath();
  context.rect(left, top, width, bottom - top);
  context.clip();
  context.strokeStyle = theme.quiet;
  context.globalAlpha = 0.3;
  context.lineWidth = 1;
  context.beginPath();
  const tall = bottom - top;
  for (let x = left - tall; x < left + width; x += 9) {
    context.moveTo(x, bottom);
    context.lineTo(x + tall, top);
  }
  context.stroke();
  context.restore();
}

function arrow(context, x, from, to) {
  const length = to - from;
  if (Math.abs(length) < 1) {
    dot(context, x, from, 2);
    return;
  }
  const head = Math.min(9, Math.abs(length)) * Math.sign(length);
  context.fillRect(x - 1.5, Math.min(from, to - head), 3, Math.abs(length - head));
  context.beginPath();
  context.moveTo(x, to);
  context.lineTo(x - 5.5, to - head);
  context.lineTo(x + 5.5, to - head);
  context.fill();
}

// Draws a world by its solids seen from far away: the outline of each, and its edges.

import { dot, turned } from "./camera.js";
import { theme } from "./page/theme.js";

const ROUND = 28;
const PLANE_LINES = 6;
const POINT_PX = 4;
const ARROW_PX_PER_N = 26;
const LONGEST_ARROW_PX = 90;

/** @param {{canvas: HTMLCanvasElement, context: CanvasRenderingContext2D, lane: number}} figure */
export function drawWorld({ canvas, context, lane }, { drawn, camera, targets, tool: chosen }, now) {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const frame = camera.frame(canvas);
  const colour = theme.lanes[lane];
  drawn.bodies.forEach((body, i) => {
    if (body.shape.kind === "half_space") {
      drawPlane(context, frame, camera, body, now.bodies[i]);
    }
  });
  const things = [];
  drawn.bodies.forEach((body, i) => {
    if (body.shape.kind !== "half_space") {
      const [position, orientation] = now.bodies[i];
      things.push({ depth: frame.depth(position), draw: () => drawBody(context, frame, body, position, orientation) });
    }
  });
  now.tools_m.forEach((position, i) => {
    const { radius_m: radius } = drawn.tools[i];
    things.push({ depth: frame.depth(position), draw: () => drawTool(context, frame, position, radius, colour) });
  });
  things.sort((a, b) => b.depth - a.depth).forEach(({ draw }) => draw());
  // Annotations are drawn last, or a body would hide them.
  for (const [place, force] of now.contacts) {
    drawArrow(context, frame, place, force, theme.quiet);
  }
  now.tools_m.forEach((position, i) => {
    drawHand(context, frame, position, targets[i], i === chosen);
    drawArrow(context, frame, position, now.forces_n[i], colour);
  });
  drawScale(context, frame);
}

function path(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
}

/** Convex hull of points. */
export function outline(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const hull = [];
    for (const p of list) {
      while (hull.length > 1) {
        const [a, b] = hull.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) {
          break;
        }
        hull.pop();
      }
      hull.push(p);
    }
    return hull.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

function circle(radius, at) {
  return Array.from({ length: ROUND + 1 }, (_, k) => {
    const angle = (2 * Math.PI * k) / ROUND;
    return [radius * Math.cos(angle), radius * Math.sin(angle), at];
  });
}

/** Points that span a shape, and its edges as lines, in its own axes. */
function edges(shape) {
  if (shape.kind === "box") {
    const [a, b, c] = shape.half_extents_m;
    const face = (z) => [[-a, -b, z], [a, -b, z], [a, b, z], [-a, b, z], [-a, -b, z]];
    const upright = [[-a, -b], [a, -b], [a, b], [-a, b]].map(([x, y]) => [[x, y, -c], [x, y, c]]);
    return [face(-c), face(c), ...upright];
  }
  if (shape.kind === "cylinder") {
    return [circle(shape.radius_m, -shape.half_length_m), circle(shape.radius_m, shape.half_length_m)];
  }
  return [];
}

function drawBody(context, frame, { shape, name }, position, orientation) {
  const world = (place) => turned(orientation, place).map((x, i) => x + position[i]);
  context.fillStyle = theme.solid;
  context.strokeStyle = theme.ink;
  context.lineWidth = 1.25;
  if (shape.kind === "sphere" || shape.kind === "capsule") {
    const radius = shape.radius_m * frame.pxPerM;
    const along = shape.kind === "capsule" ? shape.half_length_m : 0;
    const ends = [-along, along].map((z) => frame.at(world([0, 0, z])));
    const points = ends.flatMap(([x, y]) => circle(radius, 0).map(([dx, dy]) => [x + dx, y + dy]));
    path(context, outline(points));
    context.closePath();
    context.fill();
    context.stroke();
    // A circle about its centre, which shows its rotation: only the front half.
    for (const flip of [(p) => p, ([x, y]) => [x, 0, y]]) {
      front(context, frame, circle(shape.radius_m, 0).map(flip), world, position);
    }
  } else {
    const lines = edges(shape).map((line) => line.map(world));
    path(context, outline(lines.flat().map(frame.at)));
    context.closePath();
    context.fill();
    context.stroke();
    for (const line of lines) {
      // An edge is visible if it is not behind the centre, which suffices for convex shapes.
      const isFront = line.every((place) => frame.depth(place) <= frame.depth(position) + 1e-4);
      context.globalAlpha = isFront ? 1 : 0.18;
      path(context, line.map(frame.at));
      context.stroke();
      context.globalAlpha = 1;
    }
  }
  const [x, y] = frame.at(position);
  context.fillStyle = theme.ink;
  context.font = `11px ${theme.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(name, x, y);
}

function front(context, frame, line, world, centre) {
  const middle = frame.depth(centre);
  context.save();
  context.globalAlpha = 0.35;
  context.beginPath();
  let draws = false;
  for (const place of line.map(world)) {
    const [x, y] = frame.at(place);
    const isFront = frame.depth(place) <= middle;
    if (isFront && draws) {
      context.lineTo(x, y);
    } else {
      context.moveTo(x, y);
    }
    draws = isFront;
  }
  context.stroke();
  context.restore();
}

/** A patch of the surface of a half space, around the visible objects. */
function drawPlane(context, frame, camera, { shape, name }, [position, orientation]) {
  const normal = turned(orientation, shape.normal);
  const offset = shape.offset_m + dot(normal, position);
  const away = dot(normal, camera.centre) - offset;
  const middle = camera.centre.map((x, i) => x - away * normal[i]);
  const helper = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const u = unit(cross(normal, helper));
  const v = cross(normal, u);
  const reach = 0.62 * camera.size;
  const at = (a, b) => frame.at(middle.map((x, i) => x + a * u[i] + b * v[i]));
  context.fillStyle = theme.solid;
  context.strokeStyle = theme.rule;
  context.lineWidth = 1;
  context.globalAlpha = 0.55;
  path(context, [at(-reach, -reach), at(reach, -reach), at(reach, reach), at(-reach, reach)]);
  context.closePath();
  context.fill();
  context.globalAlpha = 1;
  for (let k = 0; k <= PLANE_LINES; k += 1) {
    const a = reach * ((2 * k) / PLANE_LINES - 1);
    path(context, [at(a, -reach), at(a, reach)]);
    context.stroke();
    path(context, [at(-reach, a), at(reach, a)]);
    context.stroke();
  }
  const [x, y] = at(reach, reach);
  context.fillStyle = theme.quiet;
  context.font = `11px ${theme.font}`;
  context.textAlign = "center";
  context.fillText(name, x, y);
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(v) {
  const length = Math.hypot(...v);
  return v.map((x) => x / length);
}

function drawTool(context, frame, position, radius, colour) {
  const [x, y] = frame.at(position);
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y, Math.max(POINT_PX, radius * frame.pxPerM), 0, 2 * Math.PI);
  context.fill();
}

/** Target position of the hand, and the line along which it pulls. */
function drawHand(context, frame, position, target, isChosen) {
  const [x, y] = frame.at(position);
  const [tx, ty] = frame.at(target);
  context.save();
  context.strokeStyle = isChosen ? theme.ink : theme.quiet;
  context.lineWidth = isChosen ? 1.5 : 1;
  context.setLineDash([4, 3]);
  context.beginPath();
  context.arc(tx, ty, 11, 0, 2 * Math.PI);
  context.moveTo(x, y);
  context.lineTo(tx, ty);
  context.stroke();
  context.restore();
}

function drawArrow(context, frame, place, force, colour) {
  const [x, y] = frame.at(place);
  const along = [dot(force, frame.axes.right), -dot(force, frame.axes.up)];
  const size = Math.hypot(...along);
  const px = Math.min(LONGEST_ARROW_PX, ARROW_PX_PER_N * size);
  if (px < 3) {
    return;
  }
  const [dx, dy] = along.map((x) => x / size);
  const head = Math.min(8, px);
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = 2;
  path(context, [[x, y], [x + dx * (px - head), y + dy * (px - head)]]);
  context.stroke();
  const [bx, by] = [x + dx * (px - head), y + dy * (px - head)];
  path(context, [[x + dx * px, y + dy * px], [bx - dy * 4, by + dx * 4], [bx + dy * 4, by - dx * 4]]);
  context.fill();
}

function drawScale(context, { pxPerM, height }) {
  const cm = pxPerM / 100;
  context.strokeStyle = theme.quiet;
  context.fillStyle = theme.quiet;
  context.lineWidth = 1;
  const y = height - 14.5;
  path(context, [[14, y], [14 + cm, y]]);
  context.stroke();
  context.font = `11px ${theme.font}`;
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.fillText("1 cm", 14 + cm + 6, y);
}

// Projection of the world to the screen: seen from far away, turned about the upright axis z and tilted.

const TILT = [-1.5, 1.5];
const PART_OF_SCREEN = 0.8;

export class Camera {
  /** @param {number[]} centre of the view [m] @param {number} size width of the view [m] */
  constructor(centre = [0, 0, 0], size = 0.1) {
    this.centre = centre;
    this.size = size;
    this.yaw = -0.35;
    this.tilt = 0.3;
  }

  turn(yaw, tilt) {
    this.yaw += yaw;
    this.tilt = Math.min(TILT[1], Math.max(TILT[0], this.tilt + tilt));
  }

  /** Unit vectors to the right, up and away in the view. */
  get axes() {
    const [cy, sy, ct, st] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.tilt), Math.sin(this.tilt)];
    return {
      right: [cy, sy, 0],
      up: [-sy * st, cy * st, ct],
      away: [-sy * ct, cy * ct, -st],
    };
  }

  /** A position moved to the right, up and away [m]. */
  moved(from, right, up, away) {
    const { axes } = this;
    return from.map((x, i) => x + right * axes.right[i] + up * axes.up[i] + away * axes.away[i]);
  }

  /** Projection of world positions to a canvas, in CSS pixels. */
  frame(canvas) {
    const { axes, centre, size } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const pxPerM = (PART_OF_SCREEN * Math.min(width, height)) / size;
    const from = (place) => place.map((x, i) => x - centre[i]);
    return {
      pxPerM,
      width,
      height,
      at(place) {
        const rel = from(place);
        return [width / 2 + pxPerM * dot(rel, axes.right), height / 2 - pxPerM * dot(rel, axes.up)];
      },
      depth: (place) => dot(from(place), axes.away),
      axes,
    };
  }
}

export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** Turns a vector by a unit quaternion [w, x, y, z]. */
export function turned([w, x, y, z], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [
    v[0] + w * t[0] + y * t[2] - z * t[1],
    v[1] + w * t[1] + z * t[0] - x * t[2],
    v[2] + w * t[2] + x * t[1] - y * t[0],
  ];
}

/** Centre [m] and size [m] of the moving objects of a world. */
export function about({ tools, bodies }) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const include = (place, reach) => {
    for (let axis = 0; axis < 3; axis += 1) {
      low[axis] = Math.min(low[axis], place[axis] - reach);
      high[axis] = Math.max(high[axis], place[axis] + reach);
    }
  };
  tools.forEach(({ start_m: start, radius_m: radius }) => include(start, Math.max(radius, 0.01)));
  bodies.forEach(({ shape, position_m: position }) => {
    const reach = reachOf(shape);
    if (reach !== null) {
      include(position, reach);
    }
  });
  const centre = low.map((x, axis) => (x + high[axis]) / 2);
  const size = Math.max(0.04, ...low.map((x, axis) => high[axis] - x));
  return [centre, 1.15 * size];
}

/** Radius of a ball about a shape's centre that contains it [m]; null if there is none. */
export function reachOf(shape) {
  switch (shape.kind) {
    case "sphere":
      return shape.radius_m;
    case "box":
      return Math.hypot(...shape.half_extents_m);
    case "capsule":
      return shape.half_length_m + shape.radius_m;
    case "cylinder":
      return Math.hypot(shape.half_length_m, shape.radius_m);
    default:
      return null;
  }
}

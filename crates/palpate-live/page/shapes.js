// Shapes of a world as something to draw, each about its own middle.

import {
  BackSide,
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  CylinderGeometry,
  EdgesGeometry,
  FrontSide,
  GreaterDepth,
  GridHelper,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Plane,
  PlaneGeometry,
  SphereGeometry,
  Vector3,
} from "./vendor/three/three.js";
import { theme } from "./theme.js";

const UP = new Vector3(0, 0, 1);
/** How much of a tool shows through what stands before it. */
const SHOWS_THROUGH = 0.3;
/** How much a surface covers of what is behind it, for who looks from outside and from within its body. */
const COVERS_OUTSIDE = 0.55;
const COVERS_WITHIN = 0.1;
const SEGMENTS = 32;

/** How far a shape reaches from its middle [m]. */
export function extent(shape) {
  const [[kind, keys]] = Object.entries(shape);
  switch (kind) {
    case "box":
      return 0.5 * Math.hypot(...keys.size_m);
    case "capsule":
    case "cylinder":
      return keys.radius_m + 0.5 * keys.length_m;
    case "spheres":
      return Math.max(...keys.map(({ centre_m, radius_m }) => Math.hypot(...centre_m) + radius_m), 0.005);
    case "mesh":
      return Math.sqrt(corners(keys).reduce((most, [x, y, z]) => Math.max(most, x * x + y * y + z * z), 0));
    default:
      return keys.radius_m ?? 0.005;
  }
}

/** A shape as something to draw, with its edges where it has some. */
export function solid(shape, colour, isFixed) {
  const [[kind, keys]] = Object.entries(shape);
  if (kind === "half_space") {
    return surface(keys, colour);
  }
  const material = new MeshLambertMaterial({ color: colour });
  const group = new Group();
  if (kind === "spheres") {
    const rods = new LineBasicMaterial({ color: colour });
    for (const { centre_m, radius_m } of keys) {
      const ball = solid({ sphere: { radius_m } }, colour, isFixed);
      const centre = new Vector3(...centre_m);
      ball.position.copy(centre);
      // What holds it is seen, and touches nothing.
      group.add(ball, new LineSegments(new BufferGeometry().setFromPoints([new Vector3(), centre]), rods));
    }
    return group;
  }
  const geometry = {
    // A point is drawn as a small ball.
    sphere: () => new SphereGeometry(keys.radius_m || 0.002, SEGMENTS, SEGMENTS / 2),
    box: () => new BoxGeometry(...keys.size_m),
    capsule: () => new CapsuleGeometry(keys.radius_m, keys.length_m, 8, SEGMENTS).rotateX(Math.PI / 2),
    cylinder: () => new CylinderGeometry(keys.radius_m, keys.radius_m, keys.length_m, SEGMENTS).rotateX(Math.PI / 2),
    mesh: () => triangles(keys),
  }[kind]();
  group.add(new Mesh(geometry, material));
  const edges = new LineBasicMaterial({ color: theme.quiet });
  // A mesh that was made coarser has edges that the surface has not.
  if (kind === "box" || kind === "cylinder" || (kind === "mesh" && !keys.coarse)) {
    group.add(new LineSegments(new EdgesGeometry(geometry, 30), edges));
  } else if (kind === "sphere" && keys.radius_m && !isFixed) {
    // A ball that turns shows it.
    group.add(new LineSegments(rings(keys.radius_m * 1.002), edges));
  }
  return group;
}

/** What of a solid is behind something else, as it shows through. */
export function hidden(solid, colour) {
  const material = new MeshLambertMaterial({
    color: colour,
    transparent: true,
    opacity: SHOWS_THROUGH,
    depthFunc: GreaterDepth,
    depthWrite: false,
  });
  const group = new Group();
  solid.traverse((part) => {
    if (part.isMesh) {
      const shown = new Mesh(part.geometry, material);
      part.updateMatrix();
      shown.applyMatrix4(part.parent === solid ? part.matrix : part.parent.matrix.clone().multiply(part.matrix));
      group.add(shown);
    }
  });
  return group;
}

/** The corners of a mesh [m]. */
function corners({ vertices_m: flat }) {
  return Array.from({ length: flat.length / 3 }, (_, k) => flat.slice(3 * k, 3 * k + 3));
}

/** The triangles of a mesh, each with corners of its own: a facet is flat. */
function triangles(keys) {
  const places = corners(keys);
  const flat = new Float32Array(keys.faces.flatMap((face) => face.flatMap((corner) => places[corner])));
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(flat, 3));
  geometry.computeVertexNormals();
  return geometry;
}

/** Two great circles of a ball. */
function rings(radius) {
  const points = [];
  for (let k = 0; k < 48; k += 1) {
    for (const end of [k, k + 1]) {
      const [c, s] = [Math.cos((end * Math.PI) / 24), Math.sin((end * Math.PI) / 24)];
      points.push([c * radius, 0, s * radius]);
    }
  }
  const turned = points.map(([x, , z]) => [0, x, z]);
  const flat = new Float32Array([...points, ...turned].flat());
  return new BufferGeometry().setAttribute("position", new BufferAttribute(flat, 3));
}

/** The surface of a half-space, with a grid, as a square of the size that `fit` is told, less what is within other half-spaces. */
function surface({ normal, offset_m }, colour) {
  const group = new Group();
  const inner = new Group();
  const n = new Vector3(...normal);
  group.add(inner);
  group.userData.outside = () => {
    group.updateMatrixWorld();
    return new Plane(n.clone(), -offset_m).applyMatrix4(group.matrixWorld);
  };
  group.userData.fit = (centre, size, clippingPlanes) => {
    inner.clear();
    // In the axes of its body, as the normal is.
    group.updateMatrixWorld();
    const middle = group.worldToLocal(centre.clone());
    const geometry = new PlaneGeometry(size, size);
    for (const [side, opacity] of [[FrontSide, COVERS_OUTSIDE], [BackSide, COVERS_WITHIN]]) {
      const look = { color: colour, transparent: true, opacity, side, depthWrite: false, clippingPlanes };
      inner.add(new Mesh(geometry, new MeshLambertMaterial(look)));
    }
    const grid = new GridHelper(size, 10, theme.rule, theme.rule).rotateX(Math.PI / 2);
    grid.material.clippingPlanes = clippingPlanes;
    inner.add(grid);
    inner.quaternion.setFromUnitVectors(UP, n);
    // The foot of the world's middle on the surface.
    inner.position.copy(middle).addScaledVector(n, offset_m - n.dot(middle));
  };
  return group;
}

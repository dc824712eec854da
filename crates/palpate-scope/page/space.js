// A world in three dimensions: its shapes, where they are, and the forces of its contacts. z is up, as in a scene file.

import {
  AmbientLight,
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  EdgesGeometry,
  GridHelper,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Plane,
  PlaneGeometry,
  Quaternion,
  Raycaster,
  Scene,
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "./vendor/three/three.js";
import { theme } from "./theme.js";

/** How long the arrow of a force is [m/N], for a world of a tenth of a metre. */
const ARROW_M_PER_N = 0.02;
const MOST_ARROWS = 65;
const UP = new Vector3(0, 0, 1);
const SEGMENTS = 32;
/** Where the camera stands about the z axis at first [rad]. */
const AZIMUTH = -2.1;
/** Width over height of a view below which the camera goes further away, so that nothing is cut off at its sides. */
const NARROW = 0.65;
const BODY = "#c58b3b";

export class Space {
  /** @param {HTMLCanvasElement} canvas @throws where the browser has no WebGL */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.camera = new PerspectiveCamera(35, 1, 1e-3, 100);
    this.camera.up.copy(UP);
    this.lanes = [];
    this.centre = new Vector3();
    this.reach = 0.1;
    this.azimuth = AZIMUTH;
    this.elevation = 0.45;
    this.distance = 0.4;
    /** Where each hand wants to be [m]; null where it lets go. */
    this.hands = [];
    new ResizeObserver(() => this.layOut()).observe(canvas.parentElement);
  }

  /** Makes the shapes anew: `world` as hello tells it. */
  begin(world, lanes) {
    const isNew = this.world !== world;
    this.world = world;
    this.lanes = Array.from({ length: lanes }, (_, lane) => new LaneScene(world, lane));
    const places = [...world.tools, ...world.bodies.filter(({ shape }) => !("half_space" in shape))];
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = low.clone().negate();
    for (const { position_m, shape } of places) {
      const around = extent(shape);
      const at = new Vector3(...position_m);
      low.min(at.clone().subScalar(around));
      high.max(at.clone().addScalar(around));
    }
    this.centre.copy(low).add(high).multiplyScalar(0.5);
    // Of the sphere around the middle that has all of it.
    const reaches = places.map(({ position_m, shape }) => this.centre.distanceTo(new Vector3(...position_m)) + extent(shape));
    this.reach = Math.max(0.02, ...reaches);
    // With room to move about.
    this.distance = 5 * this.reach;
    if (isNew) {
      this.azimuth = across(world.tools);
    }
    for (const lane of this.lanes) {
      lane.fit(this.centre, this.reach);
    }
    this.layOut();
  }

  get triangles() {
    return this.renderer.info.render.triangles;
  }

  layOut() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth > 0 && clientHeight > 0) {
      this.renderer.setSize(clientWidth, clientHeight, false);
      this.camera.aspect = clientWidth / Math.max(1, this.lanes.length) / clientHeight;
      this.camera.updateProjectionMatrix();
    }
  }

  /** How far from the world's middle the camera is [m]. */
  get awayM() {
    return this.distance * Math.max(1, NARROW / this.camera.aspect);
  }

  place() {
    const { awayM } = this;
    const flat = Math.cos(this.elevation) * awayM;
    this.camera.position
      .set(flat * Math.cos(this.azimuth), flat * Math.sin(this.azimuth), Math.sin(this.elevation) * awayM)
      .add(this.centre);
    this.camera.lookAt(this.centre);
    this.camera.updateMatrixWorld();
  }

  /** Takes a frame of a world. */
  take(frame) {
    this.lanes[frame.lane]?.take(frame);
  }

  draw() {
    this.place();
    const { renderer } = this;
    const { clientWidth, clientHeight } = this.canvas;
    const width = clientWidth / Math.max(1, this.lanes.length);
    renderer.setScissorTest(true);
    this.lanes.forEach((lane, number) => {
      lane.showHands(this.hands);
      renderer.setViewport(number * width, 0, width, clientHeight);
      renderer.setScissor(number * width, 0, width, clientHeight);
      renderer.setClearColor(new Color(theme.panel));
      renderer.render(lane.scene, this.camera);
    });
  }

  /** The ray of a place on the canvas, in pixels from its corner. */
  ray(x, y) {
    const width = this.canvas.clientWidth / Math.max(1, this.lanes.length);
    const within = ((x % width) + width) % width;
    const at = new Vector2((2 * within) / width - 1, 1 - (2 * y) / this.canvas.clientHeight);
    this.place();
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /** Where the ray of a place meets the plane through `through` that faces the camera [m]; null if it does not. */
  meet(x, y, through) {
    const facing = this.camera.getWorldDirection(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(facing, new Vector3(...through));
    const met = this.ray(x, y).intersectPlane(plane, new Vector3());
    return met ? met.toArray() : null;
  }

  /** A step away from whoever looks [m], from `from`. */
  deeper(from, metres) {
    const facing = this.camera.getWorldDirection(new Vector3());
    return new Vector3(...from).addScaledVector(facing, metres).toArray();
  }

  /**
   * An orientation w, x, y, z turned on about the axes of the picture: `right` and `down` in radians, as one rolls a ball under
   * a finger.
   */
  rolled([w, x, y, z], right, down) {
    this.place();
    const [across, up] = [new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(across, up, new Vector3());
    const by = new Quaternion().setFromAxisAngle(up, right);
    by.premultiply(new Quaternion().setFromAxisAngle(across, down));
    const turned = by.multiply(new Quaternion(x, y, z, w));
    return [turned.w, turned.x, turned.y, turned.z];
  }

  turn(byAzimuth, byElevation) {
    this.azimuth += byAzimuth;
    this.elevation = Math.max(-0.2, Math.min(1.5, this.elevation + byElevation));
  }

  zoom(factor) {
    this.distance = Math.max(1.2 * this.reach, Math.min(40 * this.reach, this.distance * factor));
  }

  /** Where a tool of the first lane is [m] and how it is turned, w, x, y, z; both undefined until that is known. */
  tool(number = 0) {
    const tool = this.lanes[0]?.tools[number];
    const [x, y, z, w] = tool?.quaternion.toArray() ?? [];
    return tool ? { position: tool.position.toArray(), orientation: [w, x, y, z] } : {};
  }

  /** Where the newest picture shows a tool, on the canvas in pixels. */
  toolOnCanvas(lane = 0, number = 0) {
    const tool = this.lanes[lane]?.tools[number]?.position;
    if (!tool) {
      return null;
    }
    this.place();
    const width = this.canvas.clientWidth / this.lanes.length;
    const at = tool.clone().project(this.camera);
    return [((at.x + 1) / 2 + lane) * width, ((1 - at.y) / 2) * this.canvas.clientHeight];
  }

  /** How large a tool looks: from its middle to its rim in pixels. */
  toolPixels(number) {
    const metres = extent(this.world.tools[number].shape);
    const height = 2 * this.awayM * Math.tan((this.camera.fov * Math.PI) / 360);
    return (metres / height) * this.canvas.clientHeight;
  }

  /** The tool that is seen at a place on the canvas, or no more than so many pixels beside it; null if none is. */
  toolAt(x, y, slackPx) {
    const lane = Math.floor((x / this.canvas.clientWidth) * this.lanes.length);
    let nearest = null;
    this.world.tools.forEach((_, number) => {
      const at = this.toolOnCanvas(lane, number);
      const beside = at ? Math.hypot(at[0] - x, at[1] - y) - this.toolPixels(number) : Infinity;
      if (beside <= (nearest?.beside ?? slackPx)) {
        nearest = { number, beside };
      }
    });
    return nearest?.number ?? null;
  }
}

/** What one lane shows. */
class LaneScene {
  constructor(world, lane) {
    this.scene = new Scene();
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-1, -2, 3);
    this.scene.add(new AmbientLight(0xffffff, 1.4), sun);
    this.bodies = world.bodies.map((body) => {
      const colour = body.fixed ? theme.solid : BODY;
      const mesh = solid(body.shape, colour, body.fixed);
      mesh.position.set(...body.position_m);
      const [w, x, y, z] = body.orientation;
      mesh.quaternion.set(x, y, z, w);
      this.scene.add(mesh);
      return mesh;
    });
    // What the world meets in the device's place.
    this.tools = world.tools.map((tool) => {
      const mesh = solid(tool.shape, theme.lanes[lane], false);
      mesh.position.set(...tool.position_m);
      const [w, x, y, z] = tool.orientation;
      mesh.quaternion.set(x, y, z, w);
      this.scene.add(mesh);
      return mesh;
    });
    const target = new EdgesGeometry(new SphereGeometry(1, 12, 8), 1);
    this.targets = world.tools.map(() => {
      const ball = new LineSegments(target, new LineBasicMaterial({ color: theme.quiet }));
      ball.visible = false;
      this.scene.add(ball);
      return ball;
    });
    this.arrows = new Arrows(theme.alarm);
    this.felt = new Arrows(theme.lanes[lane]);
    this.scene.add(this.arrows.group, this.felt.group);
  }

  fit(centre, reach) {
    for (const mesh of this.bodies) {
      mesh.userData.fit?.(centre, reach);
    }
    this.targets.forEach((target) => target.scale.setScalar(0.05 * reach));
    this.arrows.metresPerNewton = (ARROW_M_PER_N * reach) / 0.05;
    this.felt.metresPerNewton = this.arrows.metresPerNewton;
    this.arrows.thickness = 0.012 * reach;
    this.felt.thickness = 0.02 * reach;
  }

  showHands(hands) {
    this.targets.forEach((target, number) => {
      const hand = hands[number] ?? null;
      target.visible = hand !== null;
      if (hand) {
        target.position.set(...hand);
      }
    });
  }

  take({ bodies, contacts, forces }) {
    for (const { body, position, orientation } of bodies) {
      const mesh = body < this.bodies.length ? this.bodies[body] : this.tools[body - this.bodies.length];
      if (mesh) {
        const [w, x, y, z] = orientation;
        mesh.position.set(...position);
        mesh.quaternion.set(x, y, z, w);
      }
    }
    this.arrows.show(contacts);
    this.felt.show(this.tools.map(({ position }, number) => ({ point: position.toArray(), force: forces[number] })));
  }
}

/** Arrows for forces, made once. */
class Arrows {
  constructor(colour) {
    this.group = new Group();
    this.metresPerNewton = ARROW_M_PER_N;
    this.thickness = 1e-3;
    // One unit long along y, from 0.
    const shaft = new CylinderGeometry(0.5, 0.5, 1, 8).translate(0, 0.5, 0);
    const head = new CylinderGeometry(0, 1.6, 4, 12).translate(0, 2, 0);
    const material = new MeshLambertMaterial({ color: colour });
    this.arrows = Array.from({ length: MOST_ARROWS }, () => {
      const arrow = { shaft: new Mesh(shaft, material), head: new Mesh(head, material) };
      arrow.shaft.visible = false;
      arrow.head.visible = false;
      this.group.add(arrow.shaft, arrow.head);
      return arrow;
    });
    this.along = new Vector3();
    this.turned = new Quaternion();
  }

  show(forces) {
    this.shown = 0;
    this.arrows.forEach(({ shaft, head }, number) => {
      const { point, force } = forces[number] ?? {};
      const length = force ? Math.hypot(...force) * this.metresPerNewton : 0;
      const isSeen = length > 0.2 * this.thickness;
      shaft.visible = isSeen;
      head.visible = isSeen;
      if (isSeen) {
        this.shown += 1;
        this.along.set(...force).normalize();
        this.turned.setFromUnitVectors(new Vector3(0, 1, 0), this.along);
        for (const mesh of [shaft, head]) {
          mesh.position.set(...point);
          mesh.quaternion.copy(this.turned);
        }
        shaft.scale.set(this.thickness, length, this.thickness);
        head.position.addScaledVector(this.along, length);
        head.scale.setScalar(this.thickness);
      }
    });
  }
}

/**
 * From where one looks at tools at first, an angle about z [rad]: several stand beside each other, so that the body between two
 * of them hides none.
 */
export function across(tools) {
  const [first, last] = [tools[0], tools.at(-1)].map((tool) => tool?.position_m ?? [0, 0, 0]);
  const [x, y, z] = [0, 1, 2].map((axis) => last[axis] - first[axis]);
  if (Math.hypot(x, y) <= 0.5 * Math.abs(z) || Math.hypot(x, y) === 0) {
    return AZIMUTH;
  }
  const sides = [-Math.PI / 2, Math.PI / 2].map((quarter) => Math.atan2(y, x) + quarter);
  const nearness = (angle) => Math.cos(angle - AZIMUTH);
  return nearness(sides[0]) >= nearness(sides[1]) ? sides[0] : sides[1];
}

/** How far a shape reaches from its middle [m]. */
function extent(shape) {
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
function solid(shape, colour, isFixed) {
  const [[kind, keys]] = Object.entries(shape);
  if (kind === "half_space") {
    return surface(keys, colour);
  }
  const material = new MeshLambertMaterial({ color: colour });
  const group = new Group();
  if (kind === "spheres") {
    for (const { centre_m, radius_m } of keys) {
      const ball = solid({ sphere: { radius_m } }, colour, isFixed);
      ball.position.set(...centre_m);
      group.add(ball);
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

/** The surface of a half-space, as far as the world reaches, with a grid. */
function surface({ normal, offset_m }, colour) {
  const group = new Group();
  const inner = new Group();
  group.add(inner);
  group.userData.fit = (centre, reach) => {
    inner.clear();
    // In the axes of its body, as the normal is.
    group.updateMatrixWorld();
    const middle = group.worldToLocal(centre.clone());
    const n = new Vector3(...normal);
    const size = 5 * reach;
    const material = new MeshLambertMaterial({ color: colour, transparent: true, opacity: 0.55, side: 2, depthWrite: false });
    const plane = new Mesh(new PlaneGeometry(size, size), material);
    plane.quaternion.setFromUnitVectors(UP, n);
    const grid = new GridHelper(size, 10, theme.rule, theme.rule);
    grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), n);
    inner.add(plane, grid);
    // The foot of the world's middle on the surface.
    inner.position.copy(middle).addScaledVector(n, offset_m - n.dot(middle));
  };
  return group;
}

// A world in three dimensions: its shapes, where they are, and the forces of its contacts. z is up, as in a scene file.

import {
  AmbientLight,
  Color,
  CylinderGeometry,
  DirectionalLight,
  EdgesGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Plane,
  Quaternion,
  Raycaster,
  Scene,
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "./vendor/three/three.js";
import { extent, hidden, solid } from "./shapes.js";
import { theme } from "./theme.js";

/** How long the arrow of a force is [m/N], for a world of a tenth of a metre. */
const ARROW_M_PER_N = 0.02;
const MAX_ARROWS = 65;
/** An arrow is no longer than this many times the world's reach: it would leave the picture. */
const LONGEST_ARROW = 1.2;
/** Sides of the squares that stand for surfaces without an end, in reaches of the world: several close in what they hold. */
const ONE_SURFACE = 5;
const OF_SEVERAL = 3;
const UP = new Vector3(0, 0, 1);
/** Where the camera stands about the z axis at first [rad]. */
const AZIMUTH = -2.1;
/** Width over height of a view below which the camera goes further away, so that nothing is cut off at its sides. */
const NARROW = 0.65;
/** A surface is seen from outside where its normal is this much towards the eye. */
const SEEN_FROM_OUTSIDE = 0.1;
const BODY = "#c58b3b";

export class Space {
  /** @param {HTMLCanvasElement} canvas @throws where the browser has no WebGL */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.localClippingEnabled = true;
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
      this.azimuth = outside(world.bodies, across(world.tools), this.elevation);
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
      const rests = "half_space" in body.shape ? theme.solid : theme.fixed;
      const colour = body.fixed ? rests : BODY;
      const mesh = solid(body.shape, colour, body.fixed);
      mesh.position.set(...body.position_m);
      const [w, x, y, z] = body.orientation;
      mesh.quaternion.set(x, y, z, w);
      this.scene.add(mesh);
      return mesh;
    });
    // Proxies of the devices.
    this.tools = world.tools.map((tool) => {
      const mesh = solid(tool.shape, theme.lanes[lane], false);
      mesh.position.set(...tool.position_m);
      const [w, x, y, z] = tool.orientation;
      mesh.quaternion.set(x, y, z, w);
      mesh.add(hidden(mesh, theme.lanes[lane]));
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
    const surfaces = this.bodies.filter(({ userData }) => userData.fit);
    const size = (surfaces.length > 1 ? OF_SEVERAL : ONE_SURFACE) * reach;
    const outsides = surfaces.map(({ userData }) => userData.outside());
    surfaces.forEach(({ userData }, number) => userData.fit(centre, size, outsides.filter((_, other) => other !== number)));
    this.targets.forEach((target) => target.scale.setScalar(0.05 * reach));
    this.arrows.metresPerNewton = (ARROW_M_PER_N * reach) / 0.05;
    this.felt.metresPerNewton = this.arrows.metresPerNewton;
    this.arrows.longest = LONGEST_ARROW * reach;
    this.felt.longest = this.arrows.longest;
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
    this.longest = Infinity;
    this.thickness = 1e-3;
    // One unit long along y, from 0.
    const shaft = new CylinderGeometry(0.5, 0.5, 1, 8).translate(0, 0.5, 0);
    const head = new CylinderGeometry(0, 1.6, 4, 12).translate(0, 2, 0);
    const material = new MeshLambertMaterial({ color: colour });
    this.arrows = Array.from({ length: MAX_ARROWS }, () => {
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
      const length = force ? Math.min(Math.hypot(...force) * this.metresPerNewton, this.longest) : 0;
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
 * Initial view direction for several tools, an angle about z [rad]: the tools appear next to each other, so a body
 * between two of them does not hide either.
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

/**
 * The angle about z nearest to one [rad] from where one looks at as many surfaces as can be from outside, as into a groove along
 * its walls.
 */
export function outside(bodies, azimuth, elevation) {
  const normals = bodies
    .filter(({ shape }) => "half_space" in shape)
    .map(({ shape, orientation: [w, x, y, z] }) => new Vector3(...shape.half_space.normal).applyQuaternion(new Quaternion(x, y, z, w)));
  const seen = (angle) => {
    const to = new Vector3(Math.cos(angle), Math.sin(angle), Math.tan(elevation)).normalize();
    return normals.filter((normal) => normal.dot(to) > SEEN_FROM_OUTSIDE).length;
  };
  let best = azimuth;
  for (let step = 1; step <= 36; step += 1) {
    for (const angle of [azimuth + (step * Math.PI) / 36, azimuth - (step * Math.PI) / 36]) {
      if (seen(angle) > seen(best)) {
        best = angle;
      }
    }
  }
  return best;
}

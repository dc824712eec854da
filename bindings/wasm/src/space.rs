//! A world in simulated time, by one or two methods, with hands that the page moves.

use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::world::as_evaluated;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::world::{PlantParams, WorldPlant};
use palpate_world::{Motion, Sample, Shape, Vector, WorldRenderer, WorldState};
use serde::Serialize;

/// Largest number of renderings: two methods side by side.
const LANES: usize = 2;
/// Stiffness `[N/m]` and damping `[N s/m]` of the hand, equal to those of the pointer's hand of `palpate live`.
const HAND: (f64, f64) = (400.0, 20.0);
/// Largest distance of a hand's target from its start along each axis `[m]`.
const REACH: f64 = 0.2;
/// Largest number of ticks per call and rendering.
const MAX_TICKS: u32 = 2000;
/// Largest norm of the force on a device `[N]`.
const LARGEST_FORCE: f64 = 20.0;

/// A running world, once per method, all with the same hands.
pub struct Space {
    scene: WorldScene,
    /// Target positions of the hands `[m]`.
    targets: Vec<Vector>,
    lanes: Vec<SpaceLane>,
}

struct SpaceLane {
    method: String,
    renderer: WorldRenderer,
    state: WorldState,
    plant: WorldPlant,
    /// Force on each tool at the last sample `[N]`.
    forces: Vec<Vector>,
    /// Number of samples that the renderer rejected.
    refused: u64,
}

/// Objects to draw.
#[derive(Serialize)]
struct Drawn<'a> {
    title: &'a str,
    period_s: f64,
    methods: Vec<&'a str>,
    tools: Vec<DrawnTool<'a>>,
    bodies: Vec<DrawnBody<'a>>,
}

#[derive(Serialize)]
struct DrawnTool<'a> {
    name: &'a str,
    radius_m: f64,
    start_m: Vector,
}

#[derive(Serialize)]
struct DrawnBody<'a> {
    name: &'a str,
    fixed: bool,
    shape: DrawnShape,
    position_m: Vector,
    orientation: [f64; 4],
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum DrawnShape {
    Sphere { radius_m: f64 },
    HalfSpace { normal: Vector, offset_m: f64 },
    Box { half_extents_m: Vector },
    Capsule { radius_m: f64, half_length_m: f64 },
    Cylinder { radius_m: f64, half_length_m: f64 },
}

/// Current poses, forces and contacts.
#[derive(Serialize)]
struct Now<'a> {
    t_s: f64,
    targets_m: &'a [Vector],
    lanes: Vec<LaneNow<'a>>,
}

#[derive(Serialize)]
struct LaneNow<'a> {
    method: &'a str,
    /// True positions of the devices `[m]`.
    tools_m: Vec<Vector>,
    /// Forces on the devices `[N]`.
    forces_n: &'a [Vector],
    /// Positions `[m]` and orientations of the bodies, in the world's order.
    bodies: Vec<([f64; 3], [f64; 4])>,
    /// Contact points of bodies and tools `[m]`, and their forces `[N]`.
    contacts: Vec<([f64; 3], [f64; 3])>,
    /// Generated energy: energy given to the hands beyond the contacts' work `[J]`.
    created_j: f64,
    /// Number of samples that the renderer rejected.
    refused: u64,
}

impl Space {
    /// Opens a world with one rendering per method. Each hand holds its device in its initial position.
    ///
    /// # Errors
    /// A fault of the text, with line and column; a shape that cannot be drawn; a loop with delay, lag or another gain.
    pub fn open(source: &str, methods: &[&str]) -> Result<Self, String> {
        let file = WorldFile::parse("world", source).map_err(|errors| errors.to_string())?;
        let mut scene = file.scene;
        if !(1..=LANES).contains(&methods.len()) {
            return Err(format!("{} methods; allowed: 1 or 2", methods.len()));
        }
        let timing = &scene.timing;
        if !timing.is_perfect() || timing.actuator != ActuatorParams::default() {
            return Err(
                "this page supports only worlds without delay, lag, jitter and drops, and with a gain of 1"
                    .into(),
            );
        }
        if !scene.loop_params().actuation.hold.is_constant() {
            return Err(
                "this page supports only constant forces, and loop.hold is \"line\"; set loop.hold = \"constant\", or \
                 evaluate lines with palpate simulate"
                    .into(),
            );
        }
        if scene.devices.iter().any(|device| device.turning.is_some()) {
            return Err(
                "this page does not support devices of six axes, and this world has one".into(),
            );
        }
        scene.settle_limits([None; 2], [LARGEST_FORCE, f64::INFINITY]);
        for device in &mut scene.devices {
            let hand = &mut device.hand;
            (hand.stiffness, hand.damping) = HAND;
            hand.force = [0.0; 3];
            hand.rest = device.position;
            hand.tremor.amplitude = 0.0;
            hand.swing = None;
            hand.release = None;
            // The pull of a hand is held like a force of the motors, whose limit the renderer has.
            device.drivetrain.largest_force = f64::INFINITY;
        }
        let lanes = methods
            .iter()
            .map(|method| SpaceLane::start(&scene, method))
            .collect::<Result<_, _>>()?;
        let space = Self {
            targets: scene.devices.iter().map(|device| device.position).collect(),
            scene,
            lanes,
        };
        space.bodies()?;
        Ok(space)
    }

    /// Sets the target position of a device's hand `[m]`.
    ///
    /// # Errors
    /// The device does not exist, or the position is too far away.
    pub fn lead(&mut self, device: u32, to: Vector) -> Result<(), String> {
        let devices = self.scene.devices.len();
        let place = usize::try_from(device)
            .ok()
            .filter(|place| *place < devices);
        let Some(place) = place else {
            return Err(format!("device is {device}; allowed: 0 to {}", devices - 1));
        };
        let start = self.scene.devices[place].position;
        for ((axis, to), start) in ["x", "y", "z"].iter().zip(to).zip(start) {
            let (least, most) = (start - REACH, start + REACH);
            if !(least..=most).contains(&to) {
                return Err(format!("{axis} is {to} m; allowed: {least} to {most}"));
            }
        }
        self.targets[place] = to;
        Ok(())
    }

    /// Advances all renderings to this time `[s]`, within the limit of one call, and returns the number of ticks.
    pub fn advance(&mut self, until: f64) -> u32 {
        let starts: Vec<_> = self.scene.devices.iter().map(|d| d.position).collect();
        let pulls: Vec<Vector> = self
            .targets
            .iter()
            .zip(starts)
            .map(|(to, from)| std::array::from_fn(|axis| HAND.0 * (to[axis] - from[axis])))
            .collect();
        let lanes = self.lanes.iter_mut();
        lanes.map(|lane| lane.advance(until, &pulls)).sum()
    }

    fn bodies(&self) -> Result<Vec<DrawnBody<'_>>, String> {
        let bodies = self.scene.world.bodies.iter();
        bodies
            .map(|body| {
                Ok(DrawnBody {
                    name: &body.name,
                    fixed: body.motion == Motion::Fixed,
                    shape: drawn(&body.shape).ok_or_else(|| {
                        format!(
                            "body {:?} has a shape that this page cannot draw",
                            body.name
                        )
                    })?,
                    position_m: body.position,
                    orientation: body.orientation,
                })
            })
            .collect()
    }

    /// Returns the objects to draw as JSON.
    #[must_use]
    pub fn drawn(&self) -> String {
        let tools = self.scene.world.tools.iter().zip(&self.scene.devices);
        let drawn = Drawn {
            title: &self.scene.title,
            period_s: self.scene.timing.period,
            methods: self.lanes.iter().map(|lane| &*lane.method).collect(),
            tools: tools
                .map(|(tool, device)| DrawnTool {
                    name: &tool.name,
                    radius_m: match tool.shape {
                        Shape::Sphere { radius } => radius,
                        _ => 0.0,
                    },
                    start_m: device.position,
                })
                .collect(),
            // The shapes were checked when the world was opened.
            bodies: self.bodies().unwrap_or_default(),
        };
        serde_json::to_string(&drawn).unwrap_or_default()
    }

    /// Returns the current state as JSON.
    #[must_use]
    pub fn now(&self) -> String {
        let now = Now {
            t_s: self.lanes.first().map_or(0.0, |lane| lane.plant.time()),
            targets_m: &self.targets,
            lanes: self.lanes.iter().map(SpaceLane::now).collect(),
        };
        serde_json::to_string(&now).unwrap_or_default()
    }
}

impl SpaceLane {
    fn start(scene: &WorldScene, method: &str) -> Result<Self, String> {
        let renderer = scene.renderer(method);
        let renderer = renderer.map_err(|errors| errors.to_string())?;
        let params = PlantParams {
            period: scene.timing.period,
            actuator: ActuatorParams::default(),
            seed: scene.timing.imperfections.seed,
        };
        Ok(Self {
            method: method.to_owned(),
            state: renderer.start(),
            renderer,
            plant: WorldPlant::new(&as_evaluated(scene), params)
                .map_err(|error| error.to_string())?,
            forces: vec![[0.0; 3]; scene.devices.len()],
            refused: 0,
        })
    }

    /// Advances the world. `pulls` are the forces of the hands due to their target offsets from the start `[N]`: a
    /// hand's spring is linear, so a shift of its rest position is an added force, held from tick to tick.
    fn advance(&mut self, until: f64, pulls: &[Vector]) -> u32 {
        let mut made = 0;
        while self.plant.time() <= until && made < MAX_TICKS {
            let measured = self.plant.measure();
            let output = self.renderer.step(&mut self.state, &Sample::at(&measured));
            self.refused += u64::from(output.fault.is_some());
            self.forces.copy_from_slice(output.forces);
            let forces = self.forces.iter().zip(pulls);
            let held: Vec<Vector> = forces
                .map(|(force, pull)| std::array::from_fn(|axis| force[axis] + pull[axis]))
                .collect();
            self.plant.hold(&held);
            self.plant.forget_delivered();
            made += 1;
        }
        made
    }

    fn now(&self) -> LaneNow<'_> {
        let touching = self.state.contacts().iter();
        LaneNow {
            method: &self.method,
            tools_m: self.plant.positions(),
            forces_n: &self.forces,
            bodies: self
                .state
                .bodies()
                .iter()
                .map(|body| (body.position, body.orientation))
                .collect(),
            contacts: touching
                .filter(|contact| contact.penetration > 0.0)
                .map(|contact| (contact.point, contact.force))
                .collect(),
            created_j: self.state.ledger().created(),
            refused: self.refused,
        }
    }
}

fn drawn(shape: &Shape) -> Option<DrawnShape> {
    Some(match *shape {
        Shape::Sphere { radius } => DrawnShape::Sphere { radius_m: radius },
        Shape::HalfSpace { normal, offset } => DrawnShape::HalfSpace {
            normal,
            offset_m: offset,
        },
        Shape::Box { half_extents } => DrawnShape::Box {
            half_extents_m: half_extents,
        },
        Shape::Capsule {
            radius,
            half_length,
        } => DrawnShape::Capsule {
            radius_m: radius,
            half_length_m: half_length,
        },
        Shape::Cylinder {
            radius,
            half_length,
        } => DrawnShape::Cylinder {
            radius_m: radius,
            half_length_m: half_length,
        },
        // Shapes of later versions are reported when a world is opened.
        #[allow(unreachable_patterns)]
        _ => return None,
    })
}

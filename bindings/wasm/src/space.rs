//! A world in simulated time, by one or two methods, with a hand that a page leads.

use palpate_scene::world::{WorldFile, WorldScene};
use palpate_sim::world::as_judged;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::world::{PlantParams, WorldPlant};
use palpate_world::{Motion, Sample, Shape, Vector, WorldRenderer, WorldState};
use serde::Serialize;

/// Most lanes: two methods beside each other.
const LANES: usize = 2;
/// Stiffness of the hand that is led `[N/m]`, and its damping `[N s/m]`: that of the pointer's hand of `palpate live`.
const HAND: (f64, f64) = (400.0, 20.0);
/// How far from its start a hand is led along each axis `[m]`.
const REACH: f64 = 0.2;
/// Most ticks of one call and lane.
const MOST_TICKS: u32 = 2000;
/// Largest force on a device, as a length `[N]`.
const LARGEST_FORCE: f64 = 20.0;

/// A world that runs, once for each method, all in the same hands.
pub struct Space {
    scene: WorldScene,
    /// Where the hands want to be `[m]`.
    targets: Vec<Vector>,
    lanes: Vec<SpaceLane>,
}

struct SpaceLane {
    method: String,
    renderer: WorldRenderer,
    state: WorldState,
    plant: WorldPlant,
    /// Force on each tool by the last sample `[N]`.
    forces: Vec<Vector>,
    /// Samples that the renderer refused.
    refused: u64,
}

/// What there is to draw.
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

/// Where everything is.
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
    /// Where bodies and tools touch `[m]`, and the force there `[N]`.
    contacts: Vec<([f64; 3], [f64; 3])>,
    /// Energy that held forces have given to the hands beyond the contacts' work `[J]`.
    created_j: f64,
    /// Samples that the renderer refused.
    refused: u64,
}

impl Space {
    /// Opens a world, with a lane for each method. Each hand holds its device where the world has it at the start.
    ///
    /// # Errors
    /// What is wrong with the text, with line and column; a shape that is not drawn; a loop that is no plain one.
    pub fn open(source: &str, methods: &[&str]) -> Result<Self, String> {
        let file = WorldFile::parse("world", source).map_err(|errors| errors.to_string())?;
        let mut scene = file.scene;
        if !(1..=LANES).contains(&methods.len()) {
            return Err(format!("{} methods; allowed: 1 or 2", methods.len()));
        }
        let actuator = scene.timing.actuator;
        if actuator.delay != 0.0 || actuator.lag != 0.0 || actuator.gain != 1.0 {
            return Err(
                "the hand of this page leads worlds without delay and lag, and with a gain of 1"
                    .into(),
            );
        }
        if scene.devices.iter().any(|device| device.turning.is_some()) {
            return Err(
                "the hand of this page turns no tool, and this world has a device of six axes"
                    .into(),
            );
        }
        for device in &mut scene.devices {
            let hand = &mut device.hand;
            (hand.stiffness, hand.damping) = HAND;
            hand.force = [0.0; 3];
            hand.rest = device.position;
            hand.tremor.amplitude = 0.0;
        }
        scene.render.force_limit.get_or_insert(LARGEST_FORCE);
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

    /// Leads the hand of a device to a place `[m]`.
    ///
    /// # Errors
    /// There is no such device, or the place is too far away.
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

    /// Ticks all lanes up to this time `[s]`, as far as one call goes; the number of ticks.
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
                        format!("body {:?} has a shape that is not drawn here", body.name)
                    })?,
                    position_m: body.position,
                    orientation: body.orientation,
                })
            })
            .collect()
    }

    /// What there is to draw, as JSON.
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
            // Looked at when it was opened.
            bodies: self.bodies().unwrap_or_default(),
        };
        serde_json::to_string(&drawn).unwrap_or_default()
    }

    /// Where everything is, as JSON.
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
        let renderer = scene.renderer(method).map_err(|errors| {
            let errors: Vec<_> = errors.iter().map(ToString::to_string).collect();
            errors.join("; ")
        })?;
        let params = PlantParams {
            period: scene.timing.period,
            delay: 0.0,
            actuator: ActuatorParams::default(),
        };
        Ok(Self {
            method: method.to_owned(),
            state: renderer.start(),
            renderer,
            plant: WorldPlant::new(&as_judged(scene), params).map_err(|error| error.to_string())?,
            forces: vec![[0.0; 3]; scene.devices.len()],
            refused: 0,
        })
    }

    /// Ticks; `pulls`: what each hand pulls with because it wants to be elsewhere than at the start `[N]`. Its spring is
    /// linear, so to move where it rests is to add a force, held from tick to tick.
    fn advance(&mut self, until: f64, pulls: &[Vector]) -> u32 {
        let mut made = 0;
        while self.plant.time() <= until && made < MOST_TICKS {
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
            created_j: self.state.books().created(),
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
        // Later shapes are said so, when a world is opened.
        #[allow(unreachable_patterns)]
        _ => return None,
    })
}

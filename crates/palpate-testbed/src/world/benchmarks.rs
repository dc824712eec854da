//! The benchmark scenes of worlds: a groove, a pushed block, a paddle, a pinch, a row of balls, a stack of boxes,
//! joints, and meshes.
//!
//! All have a hand of 60 N/m and 1.5 N s/m, unequal masses along the axes, sensors of 2 µm, and a material damping
//! in every contact: without it contacts ring for ever, and after a while an error of force is one of phase. Each
//! duration ends before the ideal's motion depends on how it is computed.

mod jointed;
mod stack;

use std::sync::Arc;

pub use jointed::{button, drawer, lever};
pub use stack::stack;

use super::hand::WorldHand;
use super::mesh::{TriangleMesh, gallery};
use super::scene::{
    ContactLaw, FreeMotion, Member, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldScene,
};

/// Number of starts of a benchmark.
pub const STARTS: usize = 21;

/// g `[m/s²]`
const GRAVITY: f64 = 9.81;

/// A scene to compare renderings in.
#[derive(Debug, Clone, PartialEq)]
pub struct Benchmark {
    /// Short name, that of its file.
    pub name: String,
    /// Description.
    pub title: String,
    /// The scene, with the middle one of its starts.
    pub scene: WorldScene,
    /// Period of the loop `[s]`.
    pub period: f64,
    /// Length of the window `[s]`.
    pub duration: f64,
    /// Offset of the first device between the middle and the first start; the last start has the opposite offset `[m]`.
    pub spread: Vector,
}

impl Benchmark {
    /// The scene with start `number` of [`STARTS`]; number 10 is in the middle.
    #[must_use]
    pub fn start(&self, number: usize) -> WorldScene {
        let middle = (STARTS / 2) as f64;
        let share = 1.0 - number as f64 / middle;
        let mut scene = self.scene.clone();
        for (position, spread) in scene.devices[0].position.iter_mut().zip(self.spread) {
            *position += share * spread;
        }
        scene
    }

    /// Intervals of the window.
    #[must_use]
    pub fn intervals(&self) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
        )]
        let intervals = (self.duration / self.period).round() as usize;
        intervals
    }
}

/// All benchmarks.
#[must_use]
pub fn benchmarks() -> Vec<Benchmark> {
    let grooves = [60.0, 90.0, 120.0]
        .into_iter()
        .flat_map(|degrees| [groove(degrees, 0.0), groove(degrees, 0.3)]);
    grooves
        .chain([pushed_block(), paddle(), pinch(), row(), stack()])
        .chain([drawer(), lever(), button()])
        .chain([bumpy(33), bumpy(91), shaft(), pocket()])
        .collect()
}

/// W1: a point is dropped and pressed into a groove of an opening angle `[°]` along y.
///
/// Two normals at once, and a corner.
#[must_use]
pub fn groove(degrees: f64, friction: f64) -> Benchmark {
    let half = 0.5 * degrees.to_radians();
    let wall = |name: &str, side: f64| WorldBody {
        name: name.into(),
        ..fixed(Shape::HalfSpace {
            normal: [-side * half.cos(), 0.0, half.sin()],
            offset: 0.0,
        })
    };
    let smooth = ContactLaw::spring(STIFFNESS).damped(3.0);
    let law = if friction > 0.0 {
        smooth.rough(friction, 0.5 * STIFFNESS)
    } else {
        smooth
    };
    let mut tool = device("tool", [0.002, 0.0, 0.02], 0.0);
    tool.hand.force = [0.2, 0.3, -1.5];
    tool.hand.rest = [0.0, 0.01, 0.01];
    let rough = if friction > 0.0 { "-rough" } else { "" };
    Benchmark {
        name: format!("groove-{degrees:.0}{rough}"),
        title: format!(
            "A point is pressed into a groove of {degrees:.0} degrees, friction {friction}"
        ),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![wall("right", 1.0), wall("left", -1.0)],
            pairs: (0..2)
                .map(|wall| pair(Member::Device(0), Member::Body(wall), law))
                .collect(),
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.0, 0.0, 0.001],
    }
}

/// W2: a tool pushes a block of 50 g over a table, a little off its middle, so that the block turns.
///
/// The object is between the tool and the table, and it sticks and slips.
#[must_use]
pub fn pushed_block() -> Benchmark {
    let half_extents = [0.02, 0.02, 0.01];
    let shape = Shape::Box { half_extents };
    let weight = 0.05 * GRAVITY;
    let on_table = ContactLaw::spring(8000.0).damped(8.0).rough(0.4, 4000.0);
    let by_tool = ContactLaw::spring(STIFFNESS)
        .damped(2.0)
        .rough(0.4, 0.5 * STIFFNESS);
    let mut tool = device("tool", [-0.0265, 0.003, 0.01], 0.005);
    tool.hand.force = [0.4, 0.0, 0.0];
    tool.hand.rest = [0.0, 0.003, 0.01];
    Benchmark {
        name: "pushed-block".into(),
        title: "A tool pushes a block of 50 g over a table".into(),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![
                WorldBody {
                    name: "block".into(),
                    position: [0.0, 0.0, 0.01 - weight / 8000.0],
                    motion: Some(FreeMotion::new(&shape, 0.05).pulled_by([0.0, 0.0, -weight])),
                    ..fixed(shape)
                },
                table(),
            ],
            pairs: vec![
                pair(Member::Device(0), Member::Body(0), by_tool),
                pair(Member::Body(0), Member::Body(1), on_table),
            ],
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.001, 0.0, 0.0],
    }
}

/// W3: a ball of 100 g falls on a round paddle and bounces off it, a little to the side each time.
///
/// Impacts at a normal that turns.
#[must_use]
pub fn paddle() -> Benchmark {
    let shape = Shape::Sphere { radius: 0.02 };
    let weight = 0.1 * GRAVITY;
    let law = ContactLaw::spring(STIFFNESS)
        .damped(2.0)
        .rough(0.3, 0.5 * STIFFNESS);
    let mut tool = device("paddle", [0.0, 0.0, 0.0], 0.04);
    tool.hand.force = [0.0, 0.0, 1.0];
    Benchmark {
        name: "paddle".into(),
        title: "A ball of 100 g bounces on a round paddle".into(),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![WorldBody {
                name: "ball".into(),
                position: [0.002, -0.001, 0.075],
                motion: Some(FreeMotion::new(&shape, 0.1).pulled_by([0.0, 0.0, -weight])),
                ..fixed(shape)
            }],
            pairs: vec![pair(Member::Device(0), Member::Body(0), law)],
        },
        period: PERIOD,
        duration: 0.4,
        spread: [0.0, 0.0, 0.001],
    }
}

/// W4: two fingers pinch a cube of 50 g on a table and lift it.
///
/// Two devices, friction that holds, a light object.
#[must_use]
pub fn pinch() -> Benchmark {
    let shape = Shape::Box {
        half_extents: [0.015; 3],
    };
    let weight = 0.05 * GRAVITY;
    let by_finger = ContactLaw::spring(STIFFNESS)
        .damped(2.0)
        .rough(0.8, 0.5 * STIFFNESS);
    let on_table = ContactLaw::spring(8000.0).damped(8.0).rough(0.5, 4000.0);
    let finger = |name: &str, side: f64, y: f64| {
        let mut finger = device(name, [side * 0.0202, y, 0.016], 0.005);
        // More than about 1.2 N would buckle the grip: F over half of its length against the hand's 60 N/m.
        finger.hand.force = [-side * 0.55, 0.0, 0.5];
        finger.hand.rest = [side * 0.015, y, 0.016];
        finger
    };
    Benchmark {
        name: "pinch".into(),
        title: "Two fingers pinch a cube of 50 g and lift it".into(),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![finger("left", -1.0, 0.0005), finger("right", 1.0, -0.0003)],
            bodies: vec![
                WorldBody {
                    name: "cube".into(),
                    position: [0.0, 0.0, 0.015 - weight / 8000.0],
                    motion: Some(FreeMotion::new(&shape, 0.05).pulled_by([0.0, 0.0, -weight])),
                    ..fixed(shape)
                },
                table(),
            ],
            pairs: vec![
                pair(Member::Device(0), Member::Body(0), by_finger),
                pair(Member::Device(1), Member::Body(0), by_finger),
                pair(Member::Body(0), Member::Body(1), on_table),
            ],
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.0002, 0.0, 0.0],
    }
}

/// W5: a tool pushes the first of three balls in a row before a wall.
///
/// Waves through several contacts.
#[must_use]
pub fn row() -> Benchmark {
    let shape = Shape::Sphere { radius: 0.02 };
    let law = ContactLaw::spring(STIFFNESS).damped(2.0);
    let ball = |number: usize, y: f64, z: f64| WorldBody {
        name: format!("ball-{}", number + 1),
        position: [0.041 * number as f64, y, z],
        motion: Some(FreeMotion::new(&shape, 0.05)),
        ..fixed(shape.clone())
    };
    let mut tool = device("tool", [-0.04, 0.0, 0.0], 0.01);
    tool.hand.force = [0.5, 0.0, 0.0];
    tool.hand.rest = [0.0, 0.0, 0.0];
    let wall = WorldBody {
        name: "wall".into(),
        ..fixed(Shape::HalfSpace {
            normal: [-1.0, 0.0, 0.0],
            offset: -0.103,
        })
    };
    let bodies = [Member::Device(0)]
        .into_iter()
        .chain((0..4).map(Member::Body))
        .collect::<Vec<_>>();
    Benchmark {
        name: "row".into(),
        title: "A tool pushes a row of three balls of 50 g against a wall".into(),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![
                ball(0, 0.0003, 0.0),
                ball(1, -0.0002, 0.0002),
                ball(2, 0.0, -0.0003),
                wall,
            ],
            pairs: bodies
                .windows(2)
                .map(|two| pair(two[0], two[1], law))
                .collect(),
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.001, 0.0, 0.0],
    }
}

/// W6: a sphere slides over a sphere with bumps and hollows of 12 cells² triangles.
///
/// Covers convex and concave edges and corners of triangles.
#[must_use]
pub fn bumpy(cells: u32) -> Benchmark {
    let triangles = gallery::bumpy_sphere(0.04, 0.001, 12.0, cells);
    let count = triangles.1.len();
    let mut tool = device("tool", [0.012, 0.005, 0.0445], 0.004);
    tool.hand.force = [0.0, 0.0, -1.0];
    tool.hand.rest = [-0.012, -0.006, 0.04];
    on_mesh(
        format!("bumpy-{}k", (count + 500) / 1000),
        format!("A sphere slides over bumps of {count} triangles"),
        tool,
        ("bumps", triangles, [1.0, 0.0, 0.0, 0.0]),
        STIFFNESS,
    )
}

/// W6: a sphere slides along a horizontal stepped shaft, down a step and into its corner.
///
/// Covers round and sharp edges, both convex and concave.
#[must_use]
pub fn shaft() -> Benchmark {
    let profile = [
        [0.0, -0.03],
        [0.015, -0.03],
        [0.015, 0.0],
        [0.012, 0.0],
        [0.012, 0.02],
        [0.0, 0.02],
    ];
    let mut tool = device("tool", [-0.006, 0.002, 0.0185], 0.003);
    tool.hand.force = [0.4, 0.0, -1.0];
    tool.hand.rest = [0.006, 0.001, 0.016];
    // The z axis of the profile along x.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    on_mesh(
        "shaft".into(),
        "A sphere slides along a stepped shaft".into(),
        tool,
        (
            "shaft",
            // Every number is right: there are triangles.
            gallery::revolved(&profile, 96, 0.002).unwrap_or_default(),
            [half, 0.0, half, 0.0],
        ),
        STIFFNESS,
    )
}

/// W9: a probe of 2 mm is led around in a pocket 8 mm wide, pressed against its wall of 0.5 mm more deeply than that.
///
/// Narrow, thin walls.
#[must_use]
pub fn pocket() -> Benchmark {
    let profile = [
        [0.0, -0.01],
        [0.0045, -0.01],
        [0.0045, 0.0],
        [0.004, 0.0],
        [0.004, -0.009],
        [0.0, -0.009],
    ];
    let mut tool = device("probe", [0.0015, 0.0, -0.006], 0.001);
    tool.hand.force = [1.3, 0.4, -0.5];
    tool.hand.rest = [0.002, 0.002, -0.006];
    on_mesh(
        "pocket".into(),
        "A probe is pressed against the thin wall of a pocket".into(),
        tool,
        (
            "pocket",
            gallery::revolved(&profile, 64, 0.0005).unwrap_or_default(),
            [1.0, 0.0, 0.0, 0.0],
        ),
        1500.0,
    )
}

fn on_mesh(
    name: String,
    title: String,
    tool: WorldDevice,
    (body, (vertices, faces), orientation): (&str, gallery::Triangles, [f64; 4]),
    stiffness: f64,
) -> Benchmark {
    // The gallery makes meshes only; a scene without its body would be refused.
    let mesh = TriangleMesh::new(&vertices, &faces).ok();
    Benchmark {
        name,
        title,
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: mesh
                .map(|mesh| WorldBody {
                    name: body.into(),
                    orientation,
                    ..fixed(Shape::Mesh(Arc::new(mesh)))
                })
                .into_iter()
                .collect(),
            pairs: vec![pair(
                Member::Device(0),
                Member::Body(0),
                ContactLaw::spring(stiffness)
                    .damped(3.0)
                    .rough(0.3, 0.5 * stiffness),
            )],
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.0, 0.001, 0.0],
    }
}

/// K of the tools' contacts `[N/m]`.
const STIFFNESS: f64 = 4000.0;
const PERIOD: f64 = 0.001;

fn device(name: &str, position: Vector, tool_radius: f64) -> WorldDevice {
    WorldDevice {
        name: name.into(),
        own_axes: None,
        mass_table: None,
        drivetrain: crate::world::Drivetrain::default(),
        mass: [0.1, 0.16, 0.25],
        position,
        velocity: [0.0; 3],
        tool: Tool::sphere(tool_radius),
        turning: None,
        hand: WorldHand {
            stiffness: 60.0,
            damping: 1.5,
            rest: position,
            ..WorldHand::default()
        },
        quantum: [2e-6; 3],
    }
}

fn fixed(shape: Shape) -> WorldBody {
    WorldBody {
        name: String::new(),
        shape,
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        motion: None,
    }
}

fn table() -> WorldBody {
    WorldBody {
        name: "table".into(),
        ..fixed(Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        })
    }
}

fn pair(one: Member, other: Member, law: ContactLaw) -> Pair {
    Pair {
        between: [one, other],
        law,
    }
}

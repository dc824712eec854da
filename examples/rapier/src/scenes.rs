//! Scenes for evaluating the contacts of an engine: those of `python -m palpate.engines.table`.

use palpate_testbed::world::{
    ContactLaw, FreeMotion, Member, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldHand,
    WorldScene,
};

/// Mass of the body `[kg]`.
pub const BODY_MASS: f64 = 0.1;
/// Half of the body's size `[m]`.
pub const HALF: f64 = 0.02;
/// Mass of the device along its axes `[kg]`.
pub const DEVICE_MASS: Vector = [0.1, 0.16, 0.25];
/// g `[m/s^2]`.
pub const GRAVITY: f64 = 9.81;
/// Window `[s]`.
pub const DURATION: f64 = 0.4;
/// Periods `[s]`, each with a stiffness `[N/m]`.
pub const RATES: [(f64, f64); 3] = [(0.01, 400.0), (0.004, 1500.0), (0.001, 4000.0)];

/// A scene for the reference solution, with the parameters for building it in an engine.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    /// Scene of the reference solution.
    pub evaluated: WorldScene,
    /// Whether the body is a box of the half-extent [`HALF`], and not a sphere of that radius.
    pub is_box: bool,
    /// Initial position of the body `[m]`.
    pub place: Vector,
    /// Stiffness `[N/m]` and damping `[N s/m]` of the body on the floor, the plane z = 0, where there is a floor.
    pub floor: Option<(f64, f64)>,
    /// Radius of the tool `[m]`.
    pub tool_radius: f64,
    /// Initial position of the tool `[m]`.
    pub start: Vector,
    /// Stiffness of tool and body `[N/m]`.
    pub stiffness: f64,
    /// Period of the loop `[s]`.
    pub period: f64,
}

/// The scenes at a period `[s]`, with this stiffness of the tool's contact `[N/m]`.
#[must_use]
pub fn scenes(period: f64, stiffness: f64) -> Vec<Scene> {
    let floor_stiffness = 2.0 * stiffness;
    let floor = Some((floor_stiffness, 0.3 * (floor_stiffness * BODY_MASS).sqrt()));
    let resting = HALF - GRAVITY * BODY_MASS / floor_stiffness;
    let on_floor = |name, is_box| Scene {
        name,
        is_box,
        place: [0.0, 0.0, resting],
        floor,
        tool_radius: 0.01,
        start: [0.003, 0.001, resting + 0.032],
        evaluated: WorldScene::default(),
        stiffness,
        period,
    };
    let ball = Scene {
        place: [0.002, -0.001, 0.075],
        floor: None,
        tool_radius: 0.04,
        start: [0.0; 3],
        ..on_floor("ball", false)
    };
    [
        ball,
        on_floor("ball on floor", false),
        on_floor("box on floor", true),
    ]
    .map(|scene| Scene {
        evaluated: evaluated(&scene),
        ..scene
    })
    .into()
}

/// Returns the scene for the reference solution.
fn evaluated(scene: &Scene) -> WorldScene {
    let shape = if scene.is_box {
        Shape::Box {
            half_extents: [HALF; 3],
        }
    } else {
        Shape::Sphere { radius: HALF }
    };
    let fixed = |name: &str, shape| WorldBody {
        name: name.to_owned(),
        shape,
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        motion: None,
    };
    let weight = [0.0, 0.0, -GRAVITY * BODY_MASS];
    let mut bodies = vec![WorldBody {
        position: scene.place,
        motion: Some(FreeMotion::new(&shape, BODY_MASS).pulled_by(weight)),
        ..fixed("body", shape)
    }];
    let mut pairs = vec![Pair {
        between: [Member::Device(0), Member::Body(0)],
        law: ContactLaw::spring(scene.stiffness),
    }];
    if let Some((stiffness, damping)) = scene.floor {
        let plane = Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        };
        bodies.push(fixed("floor", plane));
        pairs.push(Pair {
            between: [Member::Body(0), Member::Body(1)],
            law: ContactLaw::spring(stiffness).damped(damping),
        });
    }
    let hand_force = if scene.floor.is_some() { -2.0 } else { 1.0 };
    WorldScene {
        devices: vec![WorldDevice {
            name: "tool".to_owned(),
            own_axes: None,
            mass_table: None,
            drivetrain: palpate_testbed::world::Drivetrain::default(),
            mass: DEVICE_MASS,
            position: scene.start,
            velocity: [0.0; 3],
            tool: Tool::sphere(scene.tool_radius),
            turning: None,
            hand: WorldHand {
                force: [0.0, 0.0, hand_force],
                stiffness: 60.0,
                damping: 1.5,
                rest: scene.start,
                ..WorldHand::default()
            },
            quantum: [0.0; 3],
        }],
        bodies,
        pairs,
        joints: Vec::new(),
        fields: Vec::new(),
    }
}

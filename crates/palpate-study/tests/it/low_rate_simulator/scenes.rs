//! Scenes with their ideals.

use std::sync::Arc;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::mesh::TriangleMesh;
use palpate_testbed::world::mesh::gallery::bumpy_sphere;
use palpate_testbed::world::{
    CheckedIdeal, ContactLaw, FreeMotion, Member, Pair, Shape, Tool, WorldBody, WorldDevice,
    WorldEvaluation, WorldHand, WorldIdeal, WorldScene,
};

use crate::low_rate_simulator::facets::Facets;
use crate::low_rate_simulator::vector::Vector;

pub const PERIOD: f64 = 0.001;
pub const DEVICE_MASS: Vector = [0.1, 0.16, 0.25];
pub const BODY_MASS: f64 = 0.1;
pub const HALF: f64 = 0.02;
pub const TOOL: f64 = 0.01;
pub const GRAVITY: f64 = 9.81;
pub const STIFFNESS: f64 = 1500.0;
pub const FLOOR: f64 = 3000.0;

/// Body that the tool touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// A ball of this radius that moves.
    Ball(f64),
    /// A cube of this half side that moves.
    Cube(f64),
    /// A ball of this radius that is fixed.
    Hill(f64),
    /// A fixed mesh: a ball with bumps.
    Bumps,
}

#[derive(Clone, Debug)]
pub struct Scene {
    pub name: &'static str,
    pub mesh: Option<Arc<Facets>>,
    pub body: Body,
    pub place: Vector,
    /// Stiffness, damping and friction of the floor, the plane z = 0.
    pub floor: Option<(f64, f64, f64)>,
    /// Friction of tool and body.
    pub friction: f64,
    pub start: Vector,
    pub evaluated: WorldScene,
}

fn damping() -> f64 {
    0.3 * (FLOOR * BODY_MASS).sqrt()
}

impl Scene {
    fn new(
        name: &'static str,
        (body, place): (Body, Vector),
        (floor, friction): (Option<(f64, f64, f64)>, f64),
        (start, rest, force): (Vector, Vector, Vector),
        tool: f64,
    ) -> Self {
        let (shape, moves) = match body {
            Body::Ball(radius) => (Shape::Sphere { radius }, true),
            Body::Hill(radius) => (Shape::Sphere { radius }, false),
            Body::Bumps => {
                let (vertices, faces) = bumps();
                let mesh = TriangleMesh::new(&vertices, &faces).unwrap();
                (Shape::Mesh(Arc::new(mesh)), false)
            }
            Body::Cube(half) => (
                Shape::Box {
                    half_extents: [half; 3],
                },
                true,
            ),
        };
        let weight = [0.0, 0.0, -GRAVITY * BODY_MASS];
        let moving =
            |shape: &Shape| moves.then(|| FreeMotion::new(shape, BODY_MASS).pulled_by(weight));
        let fixed = |name: &str, shape| WorldBody {
            name: name.to_owned(),
            shape,
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            motion: None,
        };
        let mut bodies = vec![WorldBody {
            position: place,
            motion: moving(&shape),
            ..fixed("body", shape)
        }];
        let rough = |law: ContactLaw, friction: f64| law.rough(friction, law.stiffness);
        let mut pairs = vec![Pair {
            between: [Member::Device(0), Member::Body(0)],
            law: rough(ContactLaw::spring(STIFFNESS), friction),
        }];
        if let Some((stiffness, damping, friction)) = floor {
            let plane = Shape::HalfSpace {
                normal: [0.0, 0.0, 1.0],
                offset: 0.0,
            };
            bodies.push(fixed("floor", plane));
            pairs.push(Pair {
                between: [Member::Body(0), Member::Body(1)],
                law: rough(ContactLaw::spring(stiffness).damped(damping), friction),
            });
        }
        let evaluated = WorldScene {
            devices: vec![WorldDevice {
                name: "tool".to_owned(),
                own_axes: None,
                mass_table: None,
                drivetrain: palpate_testbed::world::Drivetrain::default(),
                mass: DEVICE_MASS,
                position: start,
                velocity: [0.0; 3],
                tool: Tool::sphere(tool),
                turning: None,
                hand: WorldHand {
                    force,
                    stiffness: 60.0,
                    damping: 1.5,
                    rest,
                    ..WorldHand::default()
                },
                quantum: [0.0; 3],
            }],
            bodies,
            pairs,
            joints: Vec::new(),
            fields: Vec::new(),
        };
        let mesh = (body == Body::Bumps).then(|| {
            let (vertices, faces) = bumps();
            Arc::new(Facets::new(&vertices, &faces))
        });
        Self {
            name,
            mesh,
            body,
            place,
            floor,
            friction,
            start,
            evaluated,
        }
    }

    pub fn tool(&self) -> f64 {
        if self.name == "ball" { 0.04 } else { TOOL }
    }
}

/// A ball of 50 mm with bumps of 1 mm, of 13068 triangles.
fn bumps() -> (Vec<Vector>, Vec<[u32; 3]>) {
    bumpy_sphere(0.05, 0.001, 5.0, 33)
}

/// A ball that is juggled; the same on a floor that is pressed; a cube that is pushed over a table; a hill and bumps
/// that are slid over.
pub fn scenes() -> Vec<Scene> {
    let on_floor = HALF - GRAVITY * BODY_MASS / FLOOR;
    let ball = (Body::Ball(HALF), [0.002, -0.001, 0.075]);
    let resting = (Body::Ball(HALF), [0.0, 0.0, on_floor]);
    let cube = (Body::Cube(HALF), [0.0, 0.0, on_floor]);
    let above = [0.003, 0.001, on_floor + 0.032];
    let beside = [-0.035, 0.001, 0.018];
    let hill = (Body::Hill(0.1), [0.0, 0.0, -0.1]);
    let slope = [-0.03, 0.0, 0.012];
    let bumps = (Body::Bumps, [0.0, 0.0, -0.05]);
    let side = [-0.02, 0.004, 0.012];
    vec![
        Scene::new(
            "ball",
            ball,
            (None, 0.0),
            ([0.0; 3], [0.0; 3], [0.0, 0.0, 1.0]),
            0.04,
        ),
        Scene::new(
            "ball on floor",
            resting,
            (Some((FLOOR, damping(), 0.0)), 0.0),
            (above, above, [0.0, 0.0, -2.0]),
            TOOL,
        ),
        Scene::new(
            "cube pushed",
            cube,
            (Some((FLOOR, damping(), 0.4)), 0.0),
            (beside, [0.03, 0.001, 0.018], [0.5, 0.0, 0.0]),
            TOOL,
        ),
        Scene::new(
            "hill",
            hill,
            (None, 0.3),
            (slope, [0.05, 0.0, 0.0], [0.0, 0.0, -2.0]),
            TOOL,
        ),
        Scene::new(
            "bumps",
            bumps,
            (None, 0.2),
            (side, [0.03, 0.004, 0.0], [0.0, 0.0, -2.0]),
            TOOL,
        ),
    ]
}

/// A scene with its ideal.
pub struct Bench {
    pub scene: Scene,
    ideal: WorldIdeal,
}

pub const SAMPLES: usize = 400;

impl Bench {
    pub fn new(scene: Scene) -> Self {
        let grid = Grid::even(0.0, PERIOD, SAMPLES);
        let checked = CheckedIdeal::new(&scene.evaluated, grid).unwrap();
        assert_eq!(checked.chaotic_from, None, "{}", scene.name);
        Self {
            scene,
            ideal: checked.ideal,
        }
    }

    /// E in percent.
    pub fn error(&self, held: Vec<Vector>) -> f64 {
        let evaluated = WorldEvaluation::new(&self.scene.evaluated, &self.ideal, &[held]).unwrap();
        evaluated.sum.unwrap().mean_force_error
    }
}

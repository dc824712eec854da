//! Sub-step error with an engine's bodies: comparison with the same contacts in very fine sub-steps.

use palpate_world::engine::{
    BodyNow, BodyWrench, EngineBody, EngineRenderer, PlacedShape, Stepping,
};
use palpate_world::{
    ContactLaw, CoupledParams, IDENTITY, Prior, Sample, Shape, SubSteps, Tool, Vector, WorldLoop,
};

const DEVICE: Vector = [0.1, 0.16, 0.25];
const STEPS: u32 = 4;

/// A point moved by a hand force, and a body that does not rotate.
struct Scene {
    name: &'static str,
    shape: Shape,
    law: ContactLaw,
    /// Mass of the body `[kg]`; `None`: fixed.
    mass: Option<f64>,
    /// Acceleration of the body by its weight `[m/s^2]`.
    weight: f64,
    /// Start of the tool: position and velocity `[m]`, `[m/s]`.
    starts: [Vector; 2],
    hand: Vector,
    period: f64,
    /// Largest allowed E `[%]`.
    allowed: f64,
}

fn scenes() -> [Scene; 4] {
    let ball = Shape::Sphere { radius: 0.025 };
    let cube = Shape::Box {
        half_extents: [0.02, 0.02, 0.02],
    };
    let hard = ContactLaw::spring(4000.0);
    let soft = ContactLaw::spring(400.0);
    [
        Scene {
            name: "a ball that is juggled, 1 ms",
            shape: ball.clone(),
            law: hard.with_damping(3.0).with_friction(0.4),
            mass: Some(0.06),
            weight: -9.81,
            starts: [[-0.002, 0.001, -0.035], [0.0; 3]],
            hand: [0.05, 0.0, 0.8],
            period: 0.001,
            allowed: 0.04,
        },
        Scene {
            name: "the same, 10 ms",
            shape: ball,
            law: soft.with_damping(1.0).with_friction(0.4),
            mass: Some(0.06),
            weight: -9.81,
            starts: [[-0.002, 0.001, -0.035], [0.0; 3]],
            hand: [0.05, 0.0, 0.8],
            period: 0.01,
            allowed: 0.012,
        },
        Scene {
            name: "a cube that is slid over, across an edge",
            shape: cube.clone(),
            law: hard.with_damping(3.0).with_friction(0.2),
            mass: None,
            weight: 0.0,
            starts: [[-0.010, 0.001, 0.0215], [0.3, 0.0, 0.0]],
            hand: [1.5, 0.1, -6.0],
            period: 0.001,
            allowed: 0.02,
        },
        Scene {
            name: "a cube that is pushed away, 4 ms",
            shape: cube,
            law: hard.with_damping(3.0).with_friction(0.4),
            mass: Some(0.2),
            weight: 0.0,
            starts: [[-0.021, 0.001, 0.015], [0.1, 0.0, 0.05]],
            hand: [0.5, 0.1, 0.4],
            period: 0.004,
            allowed: 0.016,
        },
    ]
}

struct Run {
    forces: Vec<Vector>,
    /// Number of sub-steps in each tick, sorted.
    sub_steps: Vec<u32>,
    unrefined: u32,
}

fn run(scene: &Scene, sub_steps: SubSteps) -> Run {
    let body = EngineBody {
        name: "body".into(),
        shapes: vec![PlacedShape {
            shape: scene.shape.clone(),
            position: [0.0; 3],
            orientation: IDENTITY,
        }],
        law: scene.law,
    };
    let tool = Tool::new("tool", Shape::Sphere { radius: 0.0 });
    let loop_params = WorldLoop {
        sub_steps,
        ..WorldLoop::new(scene.period)
    };
    let params = CoupledParams::new(vec![DEVICE]).with_prior(Prior::of_a_known_mass());
    let stepping = Stepping::MeanVelocity;
    let renderer = EngineRenderer::new(&[tool], &[body], stepping, loop_params, params).unwrap();
    let mut state = renderer.start();
    let mut now = BodyNow::fixed([0.0; 3]);
    if let Some(mass) = scene.mass {
        now.acceleration[2] = scene.weight;
        for axis in 0..3 {
            now.mobility[axis][axis] = 1.0 / mass;
        }
    }
    let [mut position, mut velocity] = scene.starts;
    let (h, mut time) = (scene.period / f64::from(STEPS), 0.0);
    let mut run = Run {
        forces: Vec::new(),
        sub_steps: Vec::new(),
        unrefined: 0,
    };
    while time < 0.3 {
        time += scene.period;
        renderer.sample(&mut state, &Sample::at(&[position]));
        let mut wrenches = [BodyWrench::default()];
        for _ in 0..STEPS {
            renderer.advance(&mut state, h, &[now], &mut wrenches);
            for axis in 0..3 {
                let pushed = now.mobility[axis][axis] * wrenches[0].force[axis];
                let a = now.acceleration[axis] + pushed;
                now.position[axis] += h * (now.velocity[axis] + 0.5 * h * a);
                now.velocity[axis] += h * a;
            }
        }
        let output = renderer.hold(&mut state);
        assert_eq!(output.fault, None);
        run.forces.push(output.forces[0]);
        run.sub_steps.push(output.effort.sub_steps);
        run.unrefined += output.effort.unrefined;
        for axis in 0..3 {
            let a = (scene.hand[axis] + run.forces[run.forces.len() - 1][axis]) / DEVICE[axis];
            position[axis] += scene.period * (velocity[axis] + 0.5 * scene.period * a);
            velocity[axis] += scene.period * a;
        }
    }
    run.sub_steps.sort_unstable();
    run
}

/// Returns the root mean square of the difference relative to that of `right`, in percent.
fn difference(forces: &[Vector], right: &[Vector]) -> f64 {
    let (mut off, mut sum) = (0.0, 0.0);
    for (one, other) in forces.iter().zip(right) {
        for axis in 0..3 {
            off += (one[axis] - other[axis]).powi(2) / DEVICE[axis];
            sum += other[axis].powi(2) / DEVICE[axis];
        }
    }
    assert!(sum > 0.0);
    100.0 * (off / sum).sqrt()
}

#[test]
fn sub_steps_leave_little_of_an_error_where_an_engine_s_contact_changes() {
    for scene in scenes() {
        let fine = SubSteps {
            least: 4000,
            most: 4000,
            finer: 512,
            refined: 100,
            ..SubSteps::default()
        };
        let right = run(&scene, fine);
        let usual = run(&scene, SubSteps::default());
        let error = difference(&usual.forces, &right.forces);
        let counts = &usual.sub_steps;
        let of = |share: usize| counts[(counts.len() - 1) * share / 100];
        println!(
            "{}: E {error:.4} %, sub-steps {} {} {}, unrefined {}",
            scene.name,
            of(50),
            of(99),
            of(100),
            usual.unrefined
        );
        assert!(error < scene.allowed, "{}: {error} %", scene.name);
        assert_eq!(usual.unrefined, 0, "{}", scene.name);
        // At most 64 per engine step, plus the replacements of four of them.
        assert!(of(100) <= STEPS * (64 + 128), "{counts:?}");
    }
}

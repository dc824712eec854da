//! A light ball that two heavy ones squeeze out becomes much faster than any body at the start of the interval.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Motion, Sample, Shape, World, WorldLoop,
    WorldMethod, WorldRenderer,
};

use crate::common::{FAR, ball, world};

const PERIOD: f64 = 0.01;
const POST: f64 = 0.003;

fn free(mass: f64, velocity: [f64; 3]) -> Free {
    Free {
        velocity,
        ..Free::of_mass(mass)
    }
}

/// Returns a ball of 2 g between two heavy ones, which eject it towards a fixed post at `x` `[m]`.
fn ejecting(x: f64, distant: usize) -> World {
    let side = 0.033_454_774_646_900_94;
    let light = 0.001_727_086_556_017_146_7;
    let mut bodies = vec![
        ball("left", 0.03, free(1.0, [0.0, -1.0, 0.0])).at([0.0, side, 0.0]),
        ball("right", 0.03, free(1.0, [0.0, 1.0, 0.0])).at([0.0, -side, 0.0]),
        ball("light", POST, free(0.002, [0.0; 3])).at([light, 0.0, 0.0]),
        Body::new("post", Shape::Sphere { radius: POST }, Motion::Fixed).at([x, 0.0, 0.0]),
    ];
    for number in 0..distant {
        let at = [-0.5 - 0.1 * number as f64, 0.0, 0.3];
        bodies.push(ball(&format!("distant {number}"), POST, Free::of_mass(0.05)).at(at));
    }
    world(0.005, bodies, ContactLaw::spring(20_000.0))
}

/// Returns how far the ball comes.
fn furthest(method: WorldMethod, x: f64, distant: usize) -> f64 {
    let world = ejecting(x, distant);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(PERIOD), method).unwrap();
    let mut state = renderer.start();
    let mut furthest = 0.0_f64;
    for _ in 0..8 {
        assert_eq!(renderer.step(&mut state, &Sample::at(&[FAR])).fault, None);
        furthest = furthest.max(state.bodies()[2].position[0]);
    }
    furthest
}

#[test]
fn an_ejected_ball_stops_at_what_is_beyond_the_expected_reach() {
    for distant in [0, 3] {
        for x in [0.08, 0.0877, 0.1, 0.12, 0.15, 0.2] {
            for method in [
                BasicParams::default().into(),
                CoupledParams::new(vec![[0.1; 3]]).into(),
            ] {
                let came = furthest(method, x, distant);
                assert!(
                    came > 0.03 && came < x,
                    "{distant} distant: {came} of {x} m"
                );
            }
        }
    }
}

/// The same ball hits a light tool, which moves freely. With more than four free bodies its island has no tool yet.
#[test]
fn a_tool_foresees_the_ejected_ball_in_a_large_world() {
    let forces = |distant: usize| {
        let world = ejecting(0.3, distant);
        let method = CoupledParams::new(vec![[0.05; 3]]);
        let renderer = WorldRenderer::new(&world, WorldLoop::new(PERIOD), method).unwrap();
        let mut state = renderer.start();
        let forces = (0..8).map(|_| {
            let output = renderer.step(&mut state, &Sample::at(&[[0.088, 0.0, 0.0]]));
            assert_eq!(output.fault, None);
            output.forces[0][0]
        });
        forces.collect::<Vec<_>>()
    };
    let (few, many) = (forces(0), forces(3));
    assert!(few.iter().any(|force| force.abs() > 1.0), "{few:?}");
    for (few, many) in few.iter().zip(&many) {
        assert!((few - many).abs() < 1e-6, "{few} {many}");
    }
}

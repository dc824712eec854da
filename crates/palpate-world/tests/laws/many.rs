//! Worlds with many bodies and contact points.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, HfcrParams, MAX_POINTS, Motion, Party, Sample,
    Shape, Vector, World, WorldLoop, WorldMethod, WorldRenderer, WorldState,
};

use crate::common::{FAR, ball, plane, world};

const MASS: f64 = 0.05;
const WEIGHT: f64 = 9.81 * MASS;
const STIFFNESS: f64 = 4000.0;
const RADIUS: f64 = 0.02;

fn law() -> ContactLaw {
    ContactLaw::spring(STIFFNESS)
        .with_damping(2.0)
        .with_friction(0.5)
}

fn heavy() -> Free {
    Free::of_mass(MASS).pulled_by([0.0, 0.0, -WEIGHT])
}

/// Returns `count` balls that lie on a floor, in rows of ten with this distance.
pub fn balls(count: usize, apart: f64) -> World {
    let mut bodies = vec![plane("floor", [0.0, 0.0, 1.0])];
    let height = RADIUS - WEIGHT / STIFFNESS;
    for number in 0..count {
        let (row, place) = (number / 10, number % 10);
        let at = [apart * place as f64, apart * row as f64, height];
        bodies.push(ball(&format!("ball {number}"), RADIUS, heavy()).at(at));
    }
    world(0.005, bodies, law())
}

/// Returns `count` boxes on a floor, in stacks of `high`.
fn boxes(count: usize, high: usize) -> World {
    let mut bodies = vec![plane("floor", [0.0, 0.0, 1.0])];
    let shape = Shape::Box {
        half_extents: [0.02, 0.02, 0.01],
    };
    for number in 0..count {
        let (stack, level) = (number / high, number % high);
        let x = 0.06 * stack as f64;
        bodies.push(
            Body::new(
                format!("box {number}"),
                shape.clone(),
                Motion::Free(heavy()),
            )
            .at([x, 0.0, 0.01 + 0.02 * level as f64]),
        );
    }
    world(0.005, bodies, law())
}

fn methods() -> [WorldMethod; 3] {
    [
        BasicParams::default().into(),
        HfcrParams::default().into(),
        CoupledParams::new(vec![[0.1; 3]]).into(),
    ]
}

fn start(world: &World, method: impl Into<WorldMethod>) -> (WorldRenderer, WorldState) {
    let renderer = WorldRenderer::new(world, WorldLoop::new(0.001), method).unwrap();
    let state = renderer.start();
    (renderer, state)
}

#[test]
fn large_worlds_are_rendered_whole() {
    let worlds = [
        ("ten free balls", balls(10, 0.0405), 9),
        ("fifty balls on a floor", balls(50, 0.06), 50),
        ("two hundred balls", balls(200, 0.0405), 200),
        ("a tower of five boxes", boxes(5, 5), 20),
        ("a hundred boxes", boxes(100, 1), 400),
        ("a thousand points", boxes(125, 1), 500),
    ];
    for (name, world, least) in worlds {
        for method in methods() {
            let (renderer, mut state) = start(&world, method);
            let mut touching = 0;
            for _ in 0..3 {
                let output = renderer.step(&mut state, &Sample::at(&[FAR]));
                assert_eq!(output.fault, None, "{name}");
                assert_eq!(output.effort.left_out, 0, "{name}");
                let contacts = state.contacts().iter();
                touching = contacts.filter(|contact| contact.penetration > 0.0).count();
            }
            assert!(touching >= least, "{name}: {touching} points touch");
        }
    }
}

#[test]
fn near_points_beyond_the_capacity_are_counted_and_touching_ones_stay() {
    let count = 150;
    let mut world = boxes(count, 1);
    // More are possible if the boxes touch each other.
    world.contacts[0].between = [Party::Named("floor".into()), Party::Any];
    let (renderer, mut state) = start(&world, BasicParams::default());
    for _ in 0..20 {
        let output = renderer.step(&mut state, &Sample::at(&[FAR]));
        assert_eq!(output.fault, None);
        // Whole boxes of 8 corners.
        assert_eq!(output.effort.left_out as usize, 8 * count - MAX_POINTS);
    }
    let held = state.bodies()[1..].iter();
    let held = held.filter(|body| body.velocity[2] > -0.01).count();
    assert_eq!(held, MAX_POINTS / 8);
}

/// A device that presses a tool down on a ball and moves it across, the same for every world.
fn place(tick: usize, above: Vector) -> Vector {
    let time = 0.001 * tick as f64;
    let down = 0.0015 * (1.0 - (12.0 * time).cos());
    let along = 0.004 * (7.0 * time).sin();
    [
        above[0] + along,
        above[1] + 0.5 * along,
        above[2] + 2.0 * RADIUS + 0.0055 - down,
    ]
}

#[test]
fn a_tool_on_one_of_twenty_balls_feels_the_world_of_that_ball() {
    let many = balls(20, 0.06);
    let touched = 14;
    let above = many.bodies[touched].position;
    let above = [above[0], above[1], 0.0];
    let one = World {
        bodies: vec![many.bodies[0].clone(), many.bodies[touched].clone()],
        ..many.clone()
    };
    for method in methods() {
        let name = method.name();
        let (of_many, mut crowd) = start(&many, method.clone());
        let (of_one, mut alone) = start(&one, method);
        let (mut largest, mut off) = (0.0_f64, 0.0_f64);
        for tick in 0..600 {
            let positions = [place(tick, above)];
            let sample = Sample::at(&positions);
            let [x, y, z] = of_many.step(&mut crowd, &sample).forces[0];
            let force = of_one.step(&mut alone, &sample).forces[0];
            for (a, b) in [x, y, z].into_iter().zip(force) {
                off = off.max((a - b).abs());
                largest = largest.max(b.abs());
            }
            for (a, b) in crowd.bodies()[touched]
                .position
                .iter()
                .zip(alone.bodies()[1].position)
            {
                off = off.max((a - b).abs());
            }
        }
        println!("{name}: {off:.1e} of {largest:.2} N");
        assert!(largest > 1.0 && off < 1e-9, "{name}: {off} of {largest}");
    }
}

//! Worlds with many bodies and contact points.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, HfcrParams, Motion, Party, Sample, Shape,
    Vector, World, WorldLoop, WorldMethod, WorldRenderer, WorldState,
};

use crate::balance::{Balance, of_bodies};
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
        ("a hundred boxes in stacks of four", boxes(100, 4), 300),
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

/// Each box has 8 points on the floor.
#[test]
fn a_tool_feels_one_of_many_boxes_as_if_it_were_alone() {
    let felt = |count: usize| {
        let mut world = boxes(count, 1);
        // More points are possible if the boxes touch each other.
        world.contacts[0].between = [Party::Named("floor".into()), Party::Any];
        let mut of_tool = world.contacts[0].clone();
        of_tool.between = [Party::Named("tool".into()), Party::Any];
        world.contacts.push(of_tool);
        let (renderer, mut state) = start(&world, BasicParams::default());
        let mut forces = Vec::new();
        for tick in 0..60 {
            let tool = [0.0, 0.0, 0.0255 - 2e-5 * f64::from(tick)];
            let output = renderer.step(&mut state, &Sample::at(&[tool]));
            assert_eq!((output.fault, output.effort.left_out), (None, 0));
            forces.push(output.forces[0][2]);
        }
        // The tool presses the first one down.
        for body in &state.bodies()[2..] {
            assert!(body.velocity[2] > -0.01, "{:?}", body.velocity);
        }
        forces
    };
    let alone = felt(1);
    assert!(alone[59] > 1.0, "{} N", alone[59]);
    for (many, alone) in felt(200).into_iter().zip(alone) {
        assert!((many - alone).abs() < 1e-9, "{many} instead of {alone} N");
    }
}

/// With a period of 20 ms all pairs of 60 balls are near.
#[test]
fn the_order_of_the_bodies_does_not_decide_what_touches() {
    let fallen = |is_floor_last: bool| {
        let mut world = balls(60, 0.045);
        world.contacts[0].law = ContactLaw::spring(300.0).with_damping(1.0);
        for body in &mut world.bodies[1..] {
            body.position[2] = 0.04;
            if let Motion::Free(free) = &mut body.motion {
                free.velocity = [0.0, 0.0, -1.5];
            }
        }
        if is_floor_last {
            world.bodies.rotate_left(1);
        }
        let method = BasicParams::default();
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.02), method).unwrap();
        let mut state = renderer.start();
        for _ in 0..8 {
            let output = renderer.step(&mut state, &Sample::at(&[FAR]));
            assert_eq!(output.fault, None);
        }
        let mut bodies = state.bodies().to_vec();
        if is_floor_last {
            bodies.rotate_right(1);
        }
        bodies
    };
    for (first, last) in fallen(false).iter().zip(fallen(true)) {
        let off = (first.position[2] - last.position[2]).abs();
        assert!(off < 1e-9, "{off} m apart");
    }
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

/// Sums the entries that have to balance, and the energy of all bodies.
fn imbalance(state: &WorldState, at_start: f64) -> f64 {
    let balance = Balance::since(at_start, state);
    balance.world
}

#[test]
fn a_crowd_rests_wakes_where_it_is_touched_and_keeps_its_ledger() {
    // Slightly too high: the balls fall, swing and come to rest.
    let mut world = balls(20, 0.06);
    for body in &mut world.bodies[1..] {
        body.position[2] += 2e-4;
    }
    // Two of them nearly touch.
    world.bodies[7].position[0] = world.bodies[6].position[0] + 2.0 * RADIUS + 1e-5;
    let touched = 5;
    let above = world.bodies[1 + touched].position;
    let away = [above[0], above[1], 2.0 * RADIUS + 0.015];
    let model = CoupledParams::new(vec![[0.1; 3]]);
    let (renderer, mut state) = start(&world, model);
    let at_start = of_bodies(&state);
    let moving = |state: &WorldState| -> Vec<usize> {
        let bodies = state.bodies()[1..].iter().enumerate();
        let moving = bodies.filter(|(_, body)| body.velocity != [0.0; 3]);
        moving.map(|(number, _)| number).collect()
    };
    let mut turned_over = 0.0_f64;
    let mut step = |state: &mut WorldState, tool: Vector| {
        assert_eq!(renderer.step(state, &Sample::at(&[tool])).fault, None);
        let ledger = state.ledger();
        turned_over = turned_over.max(ledger.dissipated());
        let off = imbalance(state, at_start).abs();
        assert!(off < 1e-10 * turned_over + 1e-14, "{off} J");
    };
    let mut samples = 0;
    while !moving(&state).is_empty() || samples < 10 {
        step(&mut state, away);
        samples += 1;
        assert!(samples < 5000, "{:?} still move", moving(&state));
    }
    let rest: Vec<_> = state.bodies().to_vec();
    for body in &rest[1..] {
        let sunk = RADIUS - body.position[2];
        assert!((sunk - WEIGHT / STIFFNESS).abs() < 1e-8, "{sunk}");
    }
    let before = state.ledger().clone();
    for _ in 0..50 {
        step(&mut state, away);
    }
    assert_eq!(state.bodies(), rest, "a resting world does not move");
    assert_eq!(state.ledger(), &before, "nor does its ledger");
    // The tool presses on one of the two that touch.
    for tick in 0..110 {
        let down = away[2] - 1e-4 * f64::from(tick);
        step(&mut state, [above[0], above[1], down]);
    }
    assert_eq!(
        moving(&state),
        [5, 6],
        "only what the tool can reach is awake"
    );
}

#[test]
fn what_is_changed_from_outside_wakes() {
    let world = balls(6, 0.06);
    let (renderer, mut state) = start(&world, BasicParams::default());
    for _ in 0..300 {
        let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    assert_eq!(state.bodies()[1].velocity, [0.0; 3]);
    let mut lifted = state.bodies()[2];
    lifted.position[2] += 0.01;
    renderer.place(&mut state, 2, &lifted).unwrap();
    let mut lighter = world.clone();
    if let Motion::Free(free) = &mut lighter.bodies[1].motion {
        free.force[2] *= 0.5;
    }
    for _ in 0..10 {
        let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    assert!(
        state.bodies()[2].velocity[2] < -0.05,
        "the lifted ball falls"
    );
    let (renderer, mut state) = renderer.changed(&state, &lighter).unwrap();
    for _ in 0..10 {
        let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    assert!(
        state.bodies()[1].velocity[2] > 1e-3,
        "the lighter ball rises"
    );
    for _ in 0..2000 {
        let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    let bodies = state.bodies()[1..].iter();
    assert!(
        bodies.into_iter().all(|body| body.velocity == [0.0; 3]),
        "all rest again"
    );
}

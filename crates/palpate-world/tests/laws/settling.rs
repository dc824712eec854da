//! Which bodies come to rest, and when.

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Joint, JointKind, JointLaw,
    Motion, Party, Sample, Shape, World, WorldLoop, WorldMethod, WorldRenderer,
};

use crate::common::{FAR, ball, plane, world};

const RADIUS: f64 = 0.02;

/// Adds balls without a force, so that the world is not one island.
fn among_others(mut bodies: Vec<Body>) -> Vec<Body> {
    for number in 0..5 {
        let at = [1.0 + f64::from(number), 0.0, 1.0];
        bodies.push(ball(&format!("ball {number}"), RADIUS, Free::of_mass(0.05)).at(at));
    }
    bodies
}

fn start(world: &World, method: WorldMethod) -> WorldRenderer {
    WorldRenderer::new(world, WorldLoop::new(0.001), method).unwrap()
}

#[test]
fn a_spinning_body_without_contact_laws_goes_on() {
    let can = Shape::Cylinder {
        radius: 0.03,
        half_length: 0.02,
    };
    let free = Free {
        angular_velocity: [0.0, 0.0, 10.0],
        ..Free::of_mass(0.1)
    };
    let can = Body::new("can", can, Motion::Free(free));
    let hinge = Joint {
        body: "can".into(),
        against: None,
        kind: JointKind::Hinge,
        point: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        law: JointLaw::new(1e4, 0.03),
    };
    for joints in [Vec::new(), vec![hinge]] {
        let world = World {
            joints,
            contacts: vec![Contact {
                between: [Party::Named("tool".into()), Party::Named("ball 0".into())],
                law: ContactLaw::spring(1000.0),
            }],
            ..world(
                0.005,
                among_others(vec![can.clone()]),
                ContactLaw::spring(1000.0),
            )
        };
        for method in [
            BasicParams::default().into(),
            CoupledParams::new(vec![[0.1; 3]]).into(),
        ] {
            let renderer = start(&world, method);
            let mut state = renderer.start();
            for _ in 0..300 {
                let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
            }
            let [_, _, turning] = state.bodies()[0].angular_velocity;
            let error = state.ledger().bodies[0].step_error;
            assert!((turning - 10.0).abs() < 1e-9, "{turning} rad/s");
            assert!(error.abs() < 1e-12, "{error} J");
        }
    }
}

/// A ball that slides on a floor more slowly than a rest allows. A tool passes near it, without a force.
#[test]
fn the_time_to_rest_starts_anew_after_a_tool_was_near() {
    const WEIGHT: f64 = 0.5;
    const STIFFNESS: f64 = 4000.0;
    let free = Free {
        velocity: [5e-7, 0.0, 0.0],
        ..Free::of_mass(0.05).pulled_by([0.0, 0.0, -WEIGHT])
    };
    let slides = ball("slides", RADIUS, free).at([0.0, 0.0, RADIUS - WEIGHT / STIFFNESS]);
    let bodies = among_others(vec![slides, plane("floor", [0.0, 0.0, 1.0])]);
    let world = world(0.005, bodies, ContactLaw::spring(STIFFNESS));
    let renderer = start(&world, BasicParams::default().into());
    let mut state = renderer.start();
    // Gap between tool and ball [m]: far, approach, near, withdrawal, far.
    let gap = |sample: usize| match sample {
        0..60 => 0.03,
        60..90 => 0.03 - 0.001 * (sample - 60) as f64,
        90..300 => 1e-4,
        300..330 => 0.001 * (sample - 300) as f64,
        _ => 0.03,
    };
    let mut stopped = None;
    for sample in 0..500 {
        let tool = [0.0, 0.0, 2.0 * RADIUS + 0.005 + gap(sample).max(1e-4)];
        let output = renderer.step(&mut state, &Sample::at(&[tool]));
        assert_eq!((output.fault, output.forces[0]), (None, [0.0; 3]));
        if state.bodies()[0].velocity == [0.0; 3] {
            stopped = stopped.or(Some(sample));
        }
    }
    let stopped = stopped.expect("the ball rests at last");
    println!("the ball stops at sample {stopped}");
    assert!((400..440).contains(&stopped), "{stopped}");
}

#[test]
fn a_body_that_nothing_touches_starts_from_rest_however_near_the_next_one() {
    let force = 8e-6;
    let of_mass = |mass| Free::of_mass(mass).pulled_by([0.0, 0.0, force * mass]);
    let near = 2.0 * RADIUS + 1e-4;
    let bodies = vec![
        ball("drifts", RADIUS, of_mass(0.05)).at([0.0, 0.0, near]),
        Body::new("fixed", Shape::Sphere { radius: RADIUS }, Motion::Fixed),
        // Another one, next to a ball that lies on a floor.
        ball("drifts too", RADIUS, of_mass(0.05)).at([0.5, 0.0, -0.98 + near]),
        ball(
            "lies",
            RADIUS,
            Free::of_mass(0.05).pulled_by([0.0, 0.0, -4e-6]),
        )
        .at([0.5, 0.0, -0.98 - 1e-9]),
        plane("floor", [0.0, 0.0, 1.0]).at([0.0, 0.0, -1.0]),
    ];
    let world = world(0.005, among_others(bodies), ContactLaw::spring(4000.0));
    let renderer = start(&world, BasicParams::default().into());
    let mut state = renderer.start();
    for _ in 0..301 {
        let _ = renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    for body in [0, 2] {
        let speed = state.bodies()[body].velocity[2];
        assert!(
            (speed / (0.3 * force) - 1.0).abs() < 1e-6,
            "{body}: {speed} m/s"
        );
    }
}

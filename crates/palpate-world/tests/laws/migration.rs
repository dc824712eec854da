//! Migration of a world to another world, method or loop, or to another joint position.

use std::sync::Arc;

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, GodObjectParams, Mesh, Motion, Sample,
    Shape, World, WorldGuard, WorldGuardParams, WorldLoop, WorldMethod, WorldRenderer, WorldState,
};

use crate::changes::{assert_balanced, methods, on_floor, pendulum, pushed, start};
use crate::common::{FAR, ball, plane, world};

/// Returns the renderer of a world with another method, and the migrated state.
fn other(
    world: &World,
    loop_params: WorldLoop,
    method: WorldMethod,
    before: (&WorldRenderer, &WorldState),
) -> (WorldRenderer, WorldState) {
    let mut renderer = WorldRenderer::new(world, loop_params, method).expect("renderable");
    let succession = renderer.migrate(before.0, &[]).expect("the same tools");
    let mut state = renderer.start();
    renderer.resume(&mut state, before, &succession);
    (renderer, state)
}

/// Returns all methods, and other settings of two of them.
fn others() -> Vec<WorldMethod> {
    let mut all = methods().to_vec();
    all.push(
        GodObjectParams {
            stiffness: vec![3000.0],
            damping: vec![2.0],
        }
        .into(),
    );
    all.push(CoupledParams::new(vec![[0.15; 3]]).into());
    all
}

/// From every method to every other, during a push: bodies and ledgers continue, and the force has no jump.
#[test]
fn another_method_goes_on_with_the_bodies_and_finds_the_device() {
    let world = on_floor();
    for from in methods() {
        for to in others() {
            let words = format!("{} to {to:?}", from.name());
            let (renderer, mut state) = start(&world, from.clone());
            for sample in 0..500 {
                renderer.step(&mut state, &Sample::at(&pushed(sample)));
            }
            let before = (&renderer, &state);
            let (next, mut gone_on) = other(&world, WorldLoop::new(1e-3), to.clone(), before);
            assert_eq!(gone_on.bodies(), state.bodies(), "{words}");
            let created = [&state, &gone_on].map(|state| state.ledger().created());
            assert!(
                (created[0] - created[1]).abs() < 1e-12,
                "{words}: {created:?}"
            );
            assert_balanced(&gone_on, 0.0);
            let mut most = 0.0_f64;
            for sample in 500..800 {
                let positions = pushed(sample);
                let output = next.step(&mut gone_on, &Sample::at(&positions));
                assert_eq!(output.fault, None, "{words}");
                let force = output.forces[0].iter().map(|x| x * x).sum::<f64>().sqrt();
                most = most.max(force);
                renderer.step(&mut state, &Sample::at(&positions));
                let [one, before] = [&gone_on, &state].map(|state| state.bodies()[1].position);
                let apart = (one[0] - before[0]).abs();
                let allowed = if sample == 500 { 1e-5 } else { 1e-3 };
                assert!(apart < allowed, "{words}, sample {sample}: {apart} m");
            }
            assert!((0.1..3.0).contains(&most), "{words}: {most} N");
            assert_balanced(&gone_on, 0.0);
            // State known only to the previous method is not carried over.
            let (_, mut alone) = start(&world, to.clone());
            next.step(&mut alone, &Sample::at(&pushed(0)));
            let says = |state: &WorldState| {
                let tool = state.tools()[0];
                (tool.mass.is_some(), tool.inertia.is_some())
            };
            assert_eq!(says(&gone_on), says(&alone), "{words}");
            if to.name() == "basic" {
                assert_eq!(gone_on.tools()[0].offset, [0.0; 3], "{words}");
            }
        }
    }
}

/// A point that presses on triangles stays behind them, and continues to press with any next method.
#[test]
fn another_method_keeps_the_side_of_a_mesh() {
    let corners = [
        [-0.1, -0.1, 0.0],
        [0.1, -0.1, 0.0],
        [0.1, 0.1, 0.0],
        [-0.1, 0.1, 0.0],
        [0.0, 0.0, -0.1],
    ];
    let faces = [
        [0, 1, 2],
        [0, 2, 3],
        [1, 0, 4],
        [2, 1, 4],
        [3, 2, 4],
        [0, 3, 4],
    ];
    let mesh = Shape::Mesh(Arc::new(Mesh::new(&corners, &faces).unwrap()));
    let mesh = Body::new("mesh", mesh, Motion::Fixed);
    let world = world(0.0, vec![mesh], ContactLaw::spring(1000.0));
    for from in methods() {
        for to in others() {
            let (renderer, mut state) = start(&world, from.clone());
            let depth = |sample: u32| 0.002 - 1e-4 * f64::from(sample.min(40));
            for sample in 0..200 {
                renderer.step(&mut state, &Sample::at(&[[0.01, 0.02, depth(sample)]]));
            }
            let before = (&renderer, &state);
            let (next, mut gone_on) = other(&world, WorldLoop::new(1e-3), to.clone(), before);
            let mut force = 0.0;
            for sample in 200..400 {
                let output = next.step(&mut gone_on, &Sample::at(&[[0.01, 0.02, depth(sample)]]));
                force = output.forces[0][2];
            }
            let words = format!("{} to {to:?}", from.name());
            assert!((1.0..7.0).contains(&force), "{words}: {force} N");
        }
    }
}

/// Before a first sample, and after a rejected one, the next sample starts the method.
#[test]
fn a_world_without_a_sample_in_progress_goes_on_by_beginning() {
    let world = on_floor();
    for to in others() {
        for is_refused in [false, true] {
            let (renderer, mut state) = start(&world, CoupledParams::new(vec![[0.1; 3]]).into());
            if is_refused {
                for sample in 0..450 {
                    renderer.step(&mut state, &Sample::at(&pushed(sample)));
                }
                let nowhere = Sample::at(&[[f64::NAN; 3]]);
                assert!(renderer.step(&mut state, &nowhere).fault.is_some());
            }
            let before = (&renderer, &state);
            let (next, mut gone_on) = other(&world, WorldLoop::new(1e-3), to.clone(), before);
            assert_eq!(gone_on.bodies(), state.bodies());
            let first = if is_refused { 450 } else { 0 };
            for sample in first..first + 250 {
                let output = next.step(&mut gone_on, &Sample::at(&pushed(sample)));
                assert_eq!(output.fault, None, "{to:?}");
                assert!(output.forces[0].iter().all(|x| x.abs() < 5.0), "{to:?}");
            }
            assert_balanced(&gone_on, 0.0);
        }
    }
}

/// A new joint holds the body at its current pose, although the world describes its initial pose.
#[test]
fn a_new_joint_bears_the_bodies_as_they_stand() {
    let mut swinging = pendulum();
    if let Motion::Free(free) = &mut swinging.bodies[0].motion {
        free.angular_velocity = [0.0, -6.0, 0.0];
        free.velocity = [0.3, 0.0, 0.0];
    }
    let far = Sample::at(&[FAR]);
    let method = || WorldMethod::from(BasicParams::default());
    let (renderer, mut state) = start(&swinging, method());
    for _ in 0..60 {
        renderer.step(&mut state, &far);
    }
    let hung = state.bodies()[0];
    assert!(hung.position[0] > 5e-3, "{hung:?}");
    let mut elsewhere = swinging.clone();
    elsewhere.joints[0].point = [0.005, 0.0, 0.0];
    // Relaxed at its anchor: otherwise its spring would pull it back.
    elsewhere.joints[0].law.spring = 0.0;
    let before = (&renderer, &state);
    let (next, mut gone_on) = other(&elsewhere, WorldLoop::new(1e-3), method(), before);
    let entry = gone_on.ledger().joints[0];
    assert!(
        entry.stored.abs() < 1e-12,
        "nothing is stretched: {entry:?}"
    );
    let arm = |state: &WorldState| {
        let [x, _, z] = state.bodies()[0].position;
        (x - 0.005).hypot(z)
    };
    let length = arm(&gone_on);
    for _ in 0..200 {
        next.step(&mut gone_on, &far);
        assert!((arm(&gone_on) - length).abs() < 1e-3, "{}", arm(&gone_on));
    }
}

/// A guard that is enabled later starts with the present energy: the energy of a flying ball is available to the
/// device, and without energy nothing is delivered.
#[test]
fn a_guard_that_comes_later_begins_with_the_energy_that_is_there() {
    for (speed, is_limited) in [(5.0, false), (0.0, true)] {
        let free = Free::of_mass(0.1).moving([speed, 0.0, 0.0]);
        let bodies = vec![
            plane("floor", [0.0, 0.0, 1.0]),
            ball("ball", 0.01, free).at([1.0, 0.0, 1.0]),
        ];
        let world = world(0.005, bodies, ContactLaw::spring(200_000.0));
        let (renderer, mut state) = start(&world, BasicParams::default().into());
        // 20 N, with a stored energy of one millijoule.
        let pressed = [[0.0, 0.0, 0.0049]];
        for _ in 0..50 {
            renderer.step(&mut state, &Sample::at(&pressed));
        }
        let guard = WorldGuard::Limit(WorldGuardParams {
            late: 1,
            ..WorldGuardParams::by_speed(1.0, 10.0, 1e-4)
        });
        let loop_params = WorldLoop {
            guard,
            ..WorldLoop::new(1e-3)
        };
        let method = BasicParams::default().into();
        let (next, mut gone_on) = other(&world, loop_params, method, (&renderer, &state));
        for sample in 0..20 {
            let output = next.step(&mut gone_on, &Sample::at(&pressed));
            assert_eq!(output.limited.guard, is_limited, "{speed} m/s, {sample}");
        }
    }
}

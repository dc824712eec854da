use super::*;
use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, Motion, Party, Shape, Tool, World, WorldGuard,
    WorldGuardParams, WorldLoop,
};

const PERIOD: f64 = 1e-3;

/// A point above a floor of 1 kN/m.
fn world(limits: SafetyParams) -> BoundedWorld {
    let floor = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let world = World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
        bodies: vec![Body::new("floor", floor, Motion::Fixed)],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(1000.0),
        }],
        joints: Vec::new(),
        fields: Vec::new(),
    };
    let loop_params = WorldLoop::new(PERIOD);
    let renderer =
        WorldRenderer::new(&world, loop_params, BasicParams::default()).expect("renderable");
    BoundedWorld::new(renderer, limits).expect("limits in their range")
}

fn held(world: &mut BoundedWorld, depth: f64) -> ([f64; 3], Held<'_>) {
    let held = world.step(&Sample::at(&[[0.0, 0.0, -depth]]));
    (held.wrenches[0].force, held)
}

#[test]
fn a_force_is_bounded_and_the_renderer_knows() {
    let limits = SafetyParams {
        largest_force: 2.0,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let mut world = world(limits);
    let (force, answer) = held(&mut world, 1e-3);
    assert_eq!(force, [0.0, 0.0, 1.0]);
    assert!(!answer.bounded.any());
    let (force, answer) = held(&mut world, 5e-3);
    assert_eq!(force, [0.0, 0.0, 2.0]);
    assert!(answer.bounded.force);
    // The ledger contains the 2 N held over the next millimetre, not 5 N.
    let _ = held(&mut world, 6e-3);
    let work = world.state().ledger().devices[0].port_work;
    // 1 N over 4 mm inwards, then 2 N over 1 mm.
    assert!((work + 4e-3 + 2e-3).abs() < 1e-12, "{work}");
}

#[test]
fn a_force_comes_in_softly_and_a_sample_that_is_refused_gets_none() {
    let mut world = world(SafetyParams {
        soft_start: 4.0 * PERIOD,
        ..SafetyParams::default()
    });
    for expected in [0.0, 0.25, 0.5, 0.75, 1.0, 1.0] {
        let (force, answer) = held(&mut world, 1e-3);
        assert!((force[2] - expected).abs() < 1e-12);
        assert_eq!(answer.bounded.soft_start, expected < 1.0);
    }
    let (force, answer) = held(&mut world, f64::NAN);
    assert_eq!(force, [0.0; 3]);
    assert!(answer.fault.is_some());
    // The force returns gradually.
    assert!(held(&mut world, 1e-3).0[2] < 0.5);
    // After a restart the soft start repeats.
    world.restart();
    assert_eq!(world.state().ledger().devices[0].port_work, 0.0);
    assert_eq!(held(&mut world, 1e-3).0, [0.0; 3]);
    assert!((held(&mut world, 1e-3).0[2] - 0.25).abs() < 1e-12);
}

fn unbounded() -> SafetyParams {
    SafetyParams {
        soft_start: 0.0,
        ..SafetyParams::default()
    }
}

#[test]
fn what_a_change_makes_of_the_force_comes_in_without_a_step() {
    let mut world = world(unbounded());
    for _ in 0..10 {
        assert_eq!(held(&mut world, 1e-3).0, [0.0, 0.0, 1.0]);
    }
    let mut stiffer = world.renderer().world().clone();
    stiffer.contacts[0].law = ContactLaw::spring(5000.0);
    world.change(&stiffer).expect("renderable");
    for _ in 0..3 {
        assert_eq!(held(&mut world, 1e-3).0[2], 1.0);
    }
    for tick in 1..=100 {
        let (force, answer) = held(&mut world, 1e-3);
        let expected = 1.0 + 4.0 * f64::from(tick) * PERIOD / crate::CHANGE_DURATION;
        assert!((force[2] - expected).abs() < 1e-9, "{tick}: {force:?}");
        assert!(answer.fault.is_none());
    }
    assert_eq!(held(&mut world, 1e-3).0[2], 5.0);
    // The ledger contains the held and the requested forces.
    let ledger = world.state().ledger();
    assert!(ledger.contacts[0].outside > 0.0);
}

#[test]
fn force_of_removed_floor_fades_and_refused_sample_zeroes_it_at_once() {
    for is_refused in [false, true] {
        let mut world = world(unbounded());
        held(&mut world, 2e-3);
        let mut empty = world.renderer().world().clone();
        empty.bodies.clear();
        world.change(&empty).expect("renderable");
        for _ in 0..3 {
            assert_eq!(held(&mut world, 2e-3).0[2], 2.0);
        }
        if is_refused {
            assert_eq!(held(&mut world, f64::NAN).0, [0.0; 3]);
            assert_eq!(held(&mut world, 2e-3).0, [0.0; 3]);
            continue;
        }
        for tick in 1..=100 {
            let force = held(&mut world, 2e-3).0[2];
            let expected = 2.0 * (1.0 - f64::from(tick) * 1e-2);
            assert!((force - expected).abs() < 1e-9, "{tick}: {force}");
        }
        assert_eq!(held(&mut world, 2e-3).0, [0.0; 3]);
    }
}

#[test]
fn a_floor_that_is_put_elsewhere_does_not_strike() {
    let mut world = world(unbounded());
    held(&mut world, 0.0);
    let higher = BodyState {
        position: [0.0, 0.0, 1e-3],
        ..world.state().bodies()[0]
    };
    world.place(0, &higher).expect("a place");
    for _ in 0..3 {
        assert_eq!(held(&mut world, 0.0).0, [0.0; 3]);
    }
    assert!((held(&mut world, 0.0).0[2] - 0.01).abs() < 1e-9);
    assert!(world.place(1, &higher).is_err());
}

/// The world's loop limits and guard, not only the limits of the safety, bound the forces held from before a
/// change.
#[test]
fn the_limits_and_the_guard_of_a_world_hold_in_every_tick_of_a_change() {
    let params = WorldGuardParams::by_speed(1.0, 1.0, 1e-3);
    // The guard also allows 1 N: one millijoule within a millisecond at 1 m/s.
    for guard in [WorldGuard::Off, WorldGuard::Limit(params)] {
        let plain = world(unbounded()).renderer().world().clone();
        let mut loop_params = WorldLoop::new(PERIOD).with_guard(guard);
        if guard == WorldGuard::Off {
            loop_params = loop_params.with_force_limits(vec![1.0]);
        }
        let renderer =
            WorldRenderer::new(&plain, loop_params, BasicParams::default()).expect("renderable");
        let mut world = BoundedWorld::new(renderer, unbounded()).expect("limits in their range");
        // Force of 5 N held from a previous world.
        world.wrenches[0] = Wrench::of_force([0.0, 0.0, 5.0]);
        world.fade.begin();
        let mut acted = 0;
        for tick in 0..120 {
            let (force, answer) = held(&mut world, -1e-3);
            assert!(force[2] <= 1.0 + 1e-12, "{guard:?}, tick {tick}: {force:?}");
            acted += usize::from(answer.limited.any());
        }
        assert!(acted > 0, "{guard:?}");
        assert_eq!(held(&mut world, -1e-3).0, [0.0; 3]);
    }
}

/// Coupled rendering with a finger at rest: a change of stiffness takes effect within 0.1 s, without a step.
#[test]
fn a_change_under_a_coupled_finger_does_not_step() {
    let stiff = world(unbounded()).renderer().world().clone();
    let method = palpate_world::CoupledParams::new(vec![[0.15; 3]]);
    let renderer = WorldRenderer::new(&stiff, WorldLoop::new(PERIOD), method).expect("renderable");
    let mut world = BoundedWorld::new(renderer, unbounded()).expect("limits in their range");
    for _ in 0..200 {
        held(&mut world, 4e-3);
    }
    let mut before = held(&mut world, 4e-3).0[2];
    assert!((before - 4.0).abs() < 0.1, "{before}");
    let mut softer = stiff;
    softer.contacts[0].law = ContactLaw::spring(100.0);
    world.change(&softer).expect("renderable");
    let mut steps: f64 = 0.0;
    for _ in 0..300 {
        let force = held(&mut world, 4e-3).0[2];
        steps = steps.max((force - before).abs());
        before = force;
    }
    assert!((before - 0.4).abs() < 0.02, "{before}");
    assert!(steps < 0.1, "a step of {steps} N");
}

#[test]
fn a_change_far_away_is_not_felt() {
    let (mut world, mut beside) = (world(unbounded()), world(unbounded()));
    let mut more = world.renderer().world().clone();
    let ball = Shape::Sphere { radius: 0.01 };
    more.bodies.insert(
        0,
        Body::new("ball", ball, Motion::Fixed).at([1.0, 0.0, 0.0]),
    );
    for tick in 0..300 {
        if tick == 100 {
            world.change(&more).expect("renderable");
        }
        let depth = 1e-5 * f64::from(tick);
        assert_eq!(held(&mut world, depth).0, held(&mut beside, depth).0);
    }
}

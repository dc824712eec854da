//! The safety layer without a loop.

use palpate_core::Actuation;
use palpate_device::clock::SteppedClock;
use palpate_device::{ScriptedDevice, Wrench};

use palpate_record::recording::Flags;
use palpate_rt::safety::{OscillationParams, Rendered, Safety, SafetyParams, SafetyStop};
use palpate_rt::{BoundedWorld, ControlLoop};
use palpate_scene::method::MethodName;
use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Motion, Party, Sample, Shape,
    Tool, World, WorldLoop, WorldRenderer,
};

use super::{at, scene};

/// Creates a fresh sample one millisecond after the last.
fn sample(position: [f64; 3], force: f64) -> Rendered {
    Rendered {
        elapsed: Some(0.001),
        position,
        coordinate: position[0],
        wrench: Wrench::of_force([force, 0.0, 0.0]),
        slope: [0.0; 3],
        created_energy: 0.0,
        refused: false,
        stalled: false,
    }
}

fn safety() -> Safety {
    let limits = SafetyParams {
        workspace: Some([[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]]),
        largest_speed: f64::INFINITY,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    Safety::new(limits, 0.001).unwrap()
}

const HERE: [f64; 3] = [0.0; 3];

#[test]
fn a_force_that_is_no_number_is_none() {
    for force in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut safety = safety();
        assert_eq!(safety.evaluate(&sample(HERE, 1.0)).wrench.force[0], 1.0);
        let verdict = safety.evaluate(&sample(HERE, force));
        assert_eq!(verdict.wrench.force[0], 0.0);
        assert_eq!(verdict.stopped, Some(SafetyStop::NotANumber));
        assert_eq!(safety.evaluate(&sample(HERE, 1.0)).wrench.force[0], 1.0);
    }
}

#[test]
fn the_box_has_six_sides() {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let extent = axis as f64 + 1.0;
            let mut position = HERE;
            position[axis] = sign * extent;
            let mut safety = safety();
            assert_eq!(safety.evaluate(&sample(position, 1.0)).wrench.force[0], 1.0);
            position[axis] = sign * (extent + 1e-9);
            let verdict = safety.evaluate(&sample(position, 1.0));
            assert_eq!(verdict.wrench.force[0], 0.0);
            assert_eq!(verdict.stopped, Some(SafetyStop::OutsideWorkspace));
        }
    }
}

#[test]
fn the_range_lies_along_the_axis_of_the_contact() {
    let limits = SafetyParams {
        range: Some([-0.01, 0.02]),
        largest_speed: f64::INFINITY,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    for (coordinate, is_inside) in [
        (-0.0101, false),
        (-0.01, true),
        (0.02, true),
        (0.0201, false),
    ] {
        let mut safety = Safety::new(limits, 0.001).unwrap();
        // The position in the device's own frame does not matter.
        let verdict = safety.evaluate(&Rendered {
            coordinate,
            ..sample([0.3, -0.2, 0.1], 1.0)
        });
        assert_eq!(verdict.wrench.force[0] == 1.0, is_inside, "{coordinate}");
        let safety_stop = (!is_inside).then_some(SafetyStop::OutsideWorkspace);
        assert_eq!(verdict.stopped, safety_stop, "{coordinate}");
    }
}

#[test]
fn persistent_safety_stop_takes_precedence_over_self_clearing_one() {
    let mut safety = safety();
    safety.evaluate(&sample([f64::NAN; 3], 1.0));
    assert_eq!(safety.safety_stop(), Some(SafetyStop::NotANumber));
    let outside = safety.evaluate(&sample([9.0; 3], 1.0));
    assert_eq!(outside.stopped, Some(SafetyStop::OutsideWorkspace));
    // A self-clearing stop does not replace it, and its end lifts nothing.
    assert_eq!(safety.stop_on(SafetyStop::Stalled).stopped, None);
    safety.missing();
    safety.missing();
    assert_eq!(safety.evaluate(&sample(HERE, 1.0)).wrench.force[0], 0.0);
    assert_eq!(safety.safety_stop(), Some(SafetyStop::OutsideWorkspace));
}

#[test]
fn missing_samples_that_do_not_follow_each_other_do_not_add_up() {
    let mut safety = safety();
    for _ in 0..5 {
        assert_eq!(safety.evaluate(&sample(HERE, 1.0)).wrench.force[0], 1.0);
        assert_eq!(safety.missing().wrench.force[0], 1.0);
    }
    assert_eq!(safety.safety_stop(), None);
    assert_eq!(safety.missing().wrench.force[0], 0.0);
    assert_eq!(safety.safety_stop(), Some(SafetyStop::StaleSample));
}

/// A millijoule each 10 ms decays as fast as it arrives; the same energy at once does not.
#[test]
fn created_energy_counts_for_a_while_only() {
    let limits = SafetyParams {
        oscillation: OscillationParams {
            energy: 0.05,
            window: 0.2,
        },
        // Energy generated during a soft start does not count.
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let created = |period: f64| {
        let mut safety = Safety::new(limits, period).unwrap();
        (1..=200).find(|number| {
            safety.evaluate(&Rendered {
                elapsed: Some(period),
                created_energy: 1e-3 * f64::from(*number),
                ..sample(HERE, 1.0)
            });
            safety.safety_stop() == Some(SafetyStop::Oscillation)
        })
    };
    assert_eq!(created(0.01), None);
    let number = created(1e-6).unwrap();
    assert!((50..=52).contains(&number), "{number}");
}

fn with(wrench: Wrench) -> Rendered {
    Rendered {
        wrench,
        ..sample(HERE, 0.0)
    }
}

/// A force above its limit keeps its direction, and so does a torque; neither affects the other.
#[test]
fn what_is_too_long_keeps_its_direction() {
    let limits = SafetyParams {
        largest_force: 10.0,
        largest_torque: 0.5,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let mut safety = Safety::new(limits, 0.001).unwrap();
    let long = Wrench {
        force: [12.0, 0.0, -16.0],
        torque: [0.0, 0.3, 0.0],
    };
    let verdict = safety.evaluate(&with(long));
    assert_eq!(verdict.wrench.force, [6.0, 0.0, -8.0]);
    assert_eq!(verdict.wrench.torque, long.torque);
    assert!(verdict.bounded.force);
    let twisted = Wrench {
        force: [6.0, 0.0, -8.0],
        torque: [0.0, -3.0, 4.0],
    };
    let verdict = safety.evaluate(&with(twisted));
    assert_eq!(verdict.wrench.force, twisted.force);
    for (given, wanted) in verdict.wrench.torque.iter().zip([0.0, -0.3, 0.4]) {
        assert!((given - wanted).abs() < 1e-15, "{verdict:?}");
    }
    // Each component alone is within the limit.
    let diagonal = Wrench::of_force([9.0, 9.0, 9.0]);
    let [x, y, z] = safety.evaluate(&with(diagonal)).wrench.force;
    assert!((x * x + y * y + z * z - 100.0).abs() < 1e-12 && x == y && y == z);
}

#[test]
fn a_wrench_that_changes_too_fast_goes_straight_to_the_new_one() {
    let limits = SafetyParams {
        slew_limit: 1000.0,
        torque_slew_limit: 100.0,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let mut safety = Safety::new(limits, 0.001).unwrap();
    let wanted = Wrench {
        force: [0.0, 3.0, 4.0],
        torque: [0.3, 0.0, 0.0],
    };
    let mut before = Wrench::NONE;
    for step in 1..=5 {
        let verdict = safety.evaluate(&with(wanted));
        let now = verdict.wrench;
        assert_eq!(verdict.bounded.slew, step < 5, "{step}");
        let change: f64 = (0..3)
            .map(|k| (now.force[k] - before.force[k]).powi(2))
            .sum();
        assert!((change.sqrt() - 1.0).abs() < 1e-12, "{step}: {now:?}");
        assert!(
            (now.force[1] / now.force[2] - 0.75).abs() < 1e-12,
            "{now:?}"
        );
        assert!((now.torque[0] - (0.1 * f64::from(step)).min(0.3)).abs() < 1e-12);
        before = now;
    }
    assert_eq!(before, wanted);
}

/// A late loop has had more time to change its force, and an early one less.
#[test]
fn the_slew_limit_goes_by_the_time_that_has_passed() {
    let limits = SafetyParams {
        slew_limit: 1000.0,
        torque_slew_limit: 10.0,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let mut safety = Safety::new(limits, 0.001).unwrap();
    let wanted = Wrench {
        force: [9.0, 0.0, 0.0],
        torque: [0.0, 0.0, 0.09],
    };
    let mut force = 0.0;
    for elapsed in [0.001, 0.0005, 0.003, 0.0001] {
        let rendered = Rendered {
            elapsed: Some(elapsed),
            ..with(wanted)
        };
        let now = safety.evaluate(&rendered).wrench;
        force += 1000.0 * elapsed;
        assert!((now.force[0] - force).abs() < 1e-12, "{elapsed}: {now:?}");
        assert!((now.torque[2] - 0.01 * force).abs() < 1e-12, "{now:?}");
    }
    // After an outage the time without a force is unknown: the change is limited as after one period.
    safety.stop_on(SafetyStop::StaleSample);
    let back = safety.evaluate(&Rendered {
        elapsed: Some(0.1),
        ..with(wanted)
    });
    assert!((back.wrench.force[0] - 1.0).abs() < 1e-12, "{back:?}");
}

#[test]
fn a_torque_that_is_no_number_is_none() {
    let mut safety = safety();
    let torque = [0.0, f64::NAN, 0.0];
    let verdict = safety.evaluate(&with(Wrench {
        torque,
        ..Wrench::NONE
    }));
    assert_eq!(verdict.stopped, Some(SafetyStop::NotANumber));
    assert_eq!(verdict.wrench, Wrench::NONE);
}

/// The squares of such forces overflow.
#[test]
fn forces_of_any_size_are_shortened() {
    let mut safety = safety();
    for size in [1e200, f64::MAX] {
        let [x, y, _] = safety
            .evaluate(&with([size, -size, 0.0].into()))
            .wrench
            .force;
        assert!((x.hypot(y) - 20.0).abs() < 1e-12 && y == -x, "{size}");
    }
}

/// For any requested forces, consecutive ones differ by at most the slew limit times the period, except at a safety
/// stop or a rejected sample.
#[test]
fn the_slew_limit_holds_in_soft_starts_and_recoveries() {
    const PERIOD: f64 = 0.001;
    let of_loop = 300.0;
    let mut random = 1_u64;
    let mut draw = move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    for soft_start in [0.0, 0.004, 0.05] {
        for gain in [0.5, 1.0, 2.0] {
            // As in `pipe` and the bindings: the rendering has the slew limit, and the safety has none.
            let limits = SafetyParams::bounding(Some(20.0), None, soft_start);
            let safety = Safety::new(limits, PERIOD).unwrap();
            let mut safety = safety.rendering(&Actuation::default().with_gain(gain), of_loop);
            let largest = gain.max(1.0);
            let (mut before, mut moved, mut soft) = (0.0_f64, 0, 0);
            for tick in 0..4000 {
                let asked = 60.0 * (draw() - 0.5) + 20.0 * (0.01 * f64::from(tick)).sin();
                let mut rendered = sample(HERE, asked);
                rendered.refused = draw() < 0.01;
                rendered.stalled = draw() < 0.01;
                let verdict = if draw() < 0.02 {
                    safety.missing()
                } else {
                    safety.evaluate(&rendered)
                };
                let force = verdict.wrench.force[0];
                assert!(force.abs() * largest <= 20.0 + 1e-12, "{tick}: {force} N");
                let is_taken_off = force == 0.0;
                let change = (force - before).abs() * largest;
                assert!(
                    is_taken_off || change <= of_loop * PERIOD + 1e-12,
                    "{tick}: {before} to {force} N"
                );
                moved += i32::from(change > 0.9 * of_loop * PERIOD);
                soft += i32::from(verdict.bounded.soft_start && verdict.bounded.slew);
                before = force;
            }
            assert!(moved > 1000, "{moved}");
            assert!(soft > 0 || soft_start == 0.0, "{soft}");
        }
    }
}

/// Creates a world of a point above a floor.
fn point_above_a_floor(stiffness: f64) -> World {
    let floor = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
        bodies: vec![Body::new("floor", floor, Motion::Fixed)],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(stiffness),
        }],
        joints: Vec::new(),
        fields: Vec::new(),
    }
}

/// Creates a point above a floor at 1 kHz, with limited forces, in a caller-owned loop.
fn floor_within(force_limit: f64, stiffness: f64) -> BoundedWorld {
    let world = point_above_a_floor(stiffness);
    let loop_params = WorldLoop::new(0.001);
    let renderer = WorldRenderer::new(&world, loop_params, BasicParams::default()).unwrap();
    let limits = SafetyParams::bounding(Some(force_limit), None, 0.2);
    BoundedWorld::new(renderer, limits).unwrap()
}

/// Renders a mass of 0.05 kg that a hand presses with 5 N on a floor at 1 kHz, in a caller-owned loop. Returns the
/// tick of the safety stop and the generated energy of the world's ledger.
fn pressed(stiffness: f64, ticks: usize) -> (Option<usize>, f64) {
    const PERIOD: f64 = 0.001;
    let mut world = floor_within(20.0, stiffness);
    let (mut position, mut velocity) = (1e-3, 0.0);
    let mut stopped = None;
    for tick in 0..ticks {
        let held = world.step(&Sample::at(&[[0.0, 0.0, position]]));
        let force = held.wrenches[0].force[2];
        let is_stopped = held.bounded.stopped;
        if is_stopped {
            assert_eq!(force, 0.0);
            stopped.get_or_insert(tick);
        }
        assert_eq!(
            world.safety_stop() == Some(SafetyStop::Oscillation),
            is_stopped
        );
        let acceleration = (force - 5.0 - 2.0 * velocity) / 0.05;
        position += PERIOD * velocity + 0.5 * PERIOD * PERIOD * acceleration;
        velocity += PERIOD * acceleration;
        // The hand catches the falling mass.
        position = position.max(-0.02);
    }
    let created = world.state().ledger().created();
    if stopped.is_some() {
        world.restart();
        assert_eq!(world.safety_stop(), None);
    }
    (stopped, created)
}

#[test]
fn a_bounded_world_that_creates_energy_is_stopped() {
    let (stopped, _) = pressed(20_000.0, 2000);
    assert!(stopped.is_some_and(|tick| tick < 1000), "{stopped:?}");
    let (stopped, created) = pressed(300.0, 2000);
    assert_eq!(stopped, None, "{created} J");
}

/// A hand stronger than the motor presses through its limit: no energy is generated, though the contact stores more
/// than the limited force takes in.
#[test]
fn a_press_through_the_force_limit_is_no_oscillation() {
    let mut world = floor_within(5.0, 1000.0);
    let mut max_in_ledger: f64 = 0.0;
    for tick in 0..800 {
        let turn = 2.0 * std::f64::consts::PI * f64::from(tick) / 800.0;
        let position = 1e-3 - 0.015 * (1.0 - turn.cos());
        let held = world.step(&Sample::at(&[[0.0, 0.0, position]]));
        assert!(!held.bounded.stopped, "{tick}");
        max_in_ledger = max_in_ledger.max(world.state().ledger().created());
        // Generated by a held spring of 1 N/mm at speeds under 0.12 m/s: less than 2 mJ.
        let created = world.created_energy();
        assert!(created.abs() < 2e-3, "{tick}: {created} J");
    }
    // With the whole stored energy it would stop: 5 N over 29 mm are 133 mJ, and the spring stores 421 mJ.
    assert!(max_in_ledger > 0.25, "{max_in_ledger} J");
}

/// A ball of 0.1 kg is thrown by a contact of up to 40 N, of which 5 N reach the device. It gains more energy than
/// the hand provides: the world provides the rest, and the hand gets none of it.
#[test]
fn a_ball_that_a_limited_force_throws_is_no_oscillation() {
    let mut ball = Body::new(
        "ball",
        Shape::Sphere { radius: 0.03 },
        Motion::Free(Free::of_mass(0.1)),
    );
    ball.position = [0.0, 0.0, -0.03];
    let world = World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
        bodies: vec![ball],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(20_000.0),
        }],
        joints: Vec::new(),
        fields: Vec::new(),
    };
    let loop_params = WorldLoop::new(0.001);
    let renderer =
        WorldRenderer::new(&world, loop_params, CoupledParams::new(vec![[0.1; 3]])).unwrap();
    let limits = SafetyParams::bounding(Some(5.0), None, 0.0);
    let mut world = BoundedWorld::new(renderer, limits).unwrap();
    let (mut given, mut limited): (f64, usize) = (0.0, 0);
    for tick in 0..200 {
        let position = 0.02 - 2e-3 * f64::from(tick);
        let held = world.step(&Sample::at(&[[0.0, 0.0, position]]));
        assert!(!held.bounded.stopped, "{tick}");
        limited += usize::from(held.bounded.force);
        given += 2e-3 * held.wrenches[0].force[2];
    }
    let speed = world.state().bodies()[0].velocity[2];
    let kinetic = 0.05 * speed * speed;
    println!("{given} J from the hand, {kinetic} J in the ball, {limited} samples");
    assert!(
        limited > 0 && kinetic > given + 0.05,
        "{kinetic} J of {given} J"
    );
}

/// A hand presses a wall of 1 N/mm 22 mm deep and pulls back, through the 5 N of the device: whichever layer limits the
/// force, and whether its action is measured or modelled, no energy is generated.
#[test]
fn a_press_through_the_limit_of_the_safety_is_no_oscillation() {
    let script: Vec<_> = (0..1000)
        .map(|tick| {
            let turn = 2.0 * std::f64::consts::PI * f64::from(tick) / 1000.0;
            at(11.0 * (1.0 - turn.cos()))
        })
        .collect();
    for method in [MethodName::Basic, MethodName::Hfcr, MethodName::Coupled] {
        for force_limit in [None, Some(20.0), Some(5.0)] {
            for lag in [0.0, 0.5e-3] {
                let mut pressed = scene("wall.toml");
                pressed.virtual_force = 0.0;
                pressed.loop_params.force_limit = force_limit;
                pressed.loop_params.actuation.lag = lag;
                let clock = SteppedClock::new();
                let device = ScriptedDevice::new(clock.clone(), 1, script.clone());
                let limits = SafetyParams {
                    largest_force: 5.0,
                    // Generated by a held spring of 1 N/mm at speeds under 0.07 m/s: less.
                    oscillation: OscillationParams {
                        energy: 2e-3,
                        window: 0.5,
                    },
                    ..SafetyParams::default()
                };
                let rendering = pressed.rendering(method).unwrap();
                let mut control = ControlLoop::new(device, clock, rendering, limits).unwrap();
                let case = format!("{method}, {force_limit:?}, lag {lag} s");
                let mut largest: f64 = 0.0;
                for tick in 0..1000 {
                    let row = control.tick();
                    assert!(!row.tick.flags.has(Flags::SAFETY_STOPPED), "{case}: {tick}");
                    largest = largest.max(row.contact.force_on_device.abs());
                }
                assert_eq!(largest, 5.0, "{case}");
            }
        }
    }
}

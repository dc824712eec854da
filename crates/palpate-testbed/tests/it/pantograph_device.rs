//! The pantograph as a device: friction, encoders, motors, controller and safety box.

use palpate_testbed::device::DevicePlant;
use palpate_testbed::pantograph::{
    Actuation, Pantograph, PantographParameter, PantographParams, Pid, SafetyBox,
};

fn deg(angles: [f64; 2]) -> [f64; 2] {
    angles.map(f64::to_radians)
}

const PID: Pid = Pid {
    target: 0.0,
    proportional: 1500.0,
    integral: 4000.0,
    derivative: 25.0,
    max_force: 15.0,
};

/// What must not change: stored energy, less what the motors put in, plus what was lost.
fn account(device: &Pantograph) -> f64 {
    device.stored_energy() + device.dissipated() - device.motor_work()
}

fn rubbing(coulomb: f64, viscous: f64) -> PantographParams {
    PantographParams {
        coulomb_friction: coulomb,
        viscous_friction: viscous,
        ..crate::pantographs::desktop()
    }
}

#[test]
fn friction_only_dissipates_and_brings_free_arms_to_rest() {
    for (coulomb, viscous) in [(0.01, 0.0), (0.0, 0.01), (0.01, 0.003)] {
        let mut device = Pantograph::new(rubbing(coulomb, viscous))
            .and_then(|device| device.starting_at(deg([130.0, 50.0]), [1.0, 0.6]))
            .unwrap();
        let start = device.stored_energy();
        let mut energy = start;
        for _ in 0..3000 {
            device.advance(0.0, 1e-3);
            assert!(device.stored_energy() <= energy + 1e-13 * start);
            energy = device.stored_energy();
            assert!((account(&device) - start).abs() < 1e-9 * start);
        }
        assert!(energy < 0.01 * start, "{coulomb} {viscous} {energy}");
        assert_eq!(device.rates() == [0.0, 0.0], coulomb > 0.0);
    }
}

#[test]
fn a_shaken_device_with_friction_keeps_its_account() {
    // Reversals and sticking of either joint, many of them.
    let mut device = Pantograph::new(rubbing(0.03, 0.002))
        .and_then(|device| device.starting_at(deg([140.0, 55.0]), [0.0, 0.0]))
        .unwrap();
    let start = account(&device);
    let (mut lost, mut at_rest, mut one_at_rest) = (0.0, 0, 0);
    for i in 0..4000 {
        let t = f64::from(i) * 1e-3;
        device.sample(1e-3);
        device.advance(0.8 * (12.0 * t).sin(), 1e-3);
        assert!(device.dissipated() >= lost);
        lost = device.dissipated();
        let resting = device.rates().iter().filter(|&&rate| rate == 0.0).count();
        at_rest += usize::from(resting == 2);
        one_at_rest += usize::from(resting == 1);
    }
    assert!(!device.is_jammed());
    assert!((account(&device) - start).abs() < 1e-8 * lost);
    assert!(
        lost > 0.01 && at_rest > 20 && one_at_rest > 10,
        "{lost} J, {at_rest}, {one_at_rest}"
    );
}

#[test]
fn a_stuck_device_stays_exactly_where_it_is_until_the_force_is_enough() {
    let params = rubbing(0.01, 0.0);
    let device = Pantograph::new(params).unwrap();
    let arm = device.pose().jacobian()[1][1].abs();
    let threshold = params.coulomb_friction / arm;
    let mut held = device.with_user_force([0.0, 0.999 * threshold]).unwrap();
    for _ in 0..1000 {
        assert_eq!(held.advance(0.0, 1e-3), 0.0);
    }
    assert_eq!(held.end_point(), device.end_point());
    assert_eq!(held.rates(), [0.0, 0.0]);
    let mut pushed = device.with_user_force([0.0, 1.01 * threshold]).unwrap();
    pushed.advance(0.0, 0.1);
    assert!(pushed.velocity() > 0.0);
}

#[test]
fn coulomb_friction_slows_a_symmetric_motion_by_its_force() {
    let params = rubbing(0.02, 0.0);
    let mut device = Pantograph::new(params)
        .and_then(|device| device.with_user_force([0.0, 1.0]))
        .unwrap();
    let arm = device.pose().jacobian()[1][1].abs();
    let net = 1.0 - 2.0 * params.coulomb_friction / (2.0 * arm);
    let expected = net / device.effective_mass_y();
    device.advance(0.0, 1e-4);
    assert!((device.velocity() / 1e-4 / expected - 1.0).abs() < 1e-4);
}

#[test]
fn measured_positions_move_in_counts_and_stay_within_one_of_the_truth() {
    let params = crate::pantographs::haply(3);
    let quantum = std::f64::consts::TAU / params.counts_per_rev.unwrap();
    let mut steps = 0;
    let mut previous = None;
    for i in 0..100 {
        let angle = 130.0 + 0.02 * f64::from(i);
        let device = Pantograph::new(params)
            .and_then(|device| device.starting_at(deg([angle, 50.0]), [0.0, 0.0]))
            .unwrap();
        let measured = device.measured_pose().unwrap();
        let behind = device.pose().angles[0] - measured.angles[0];
        assert!((-1e-12..=quantum).contains(&behind), "{behind}");
        let counts = measured.angles[0] / quantum;
        assert!((counts - counts.round()).abs() < 1e-9);
        steps += usize::from(previous.is_some_and(|p| p != measured.position));
        previous = Some(measured.position);
    }
    // 1.98° are 13.4 counts.
    assert!((13..=14).contains(&steps), "{steps}");
}

#[test]
fn torques_follow_the_pose_of_the_sample_and_are_held() {
    let params = PantographParams {
        actuation: Actuation::MotorsAtTruePose,
        ..crate::pantographs::desktop().frictionless()
    };
    let mut device = Pantograph::new(params)
        .and_then(|device| device.starting_at(deg([120.0, 55.0]), [2.0, -1.0]))
        .unwrap();
    device.sample(0.02);
    let expected = device.pose().torques([0.0, -2.0]);
    for _ in 0..20 {
        device.advance(2.0, 1e-3);
        assert_eq!(device.motor_torques(), expected);
    }
    let now = device.pose().torques([0.0, -2.0]);
    assert!((now[0] - expected[0]).abs() > 1e-3);
    device.sample(0.02);
    device.advance(2.0, 1e-3);
    assert_eq!(device.motor_torques(), now);
}

#[test]
fn the_measured_pose_makes_other_torques_than_the_true_one() {
    let torques = |actuation| {
        let params = PantographParams {
            actuation,
            ..crate::pantographs::haply(3)
        };
        let mut device = Pantograph::new(params).unwrap();
        device.sample(1e-3);
        let measured = device.measured_pose().unwrap();
        device.advance(0.5, 1e-3);
        (device.motor_torques(), measured.torques([0.0, -0.5]))
    };
    let (from_measured, expected) = torques(Actuation::MotorsAtMeasuredPose);
    assert_eq!(from_measured, expected);
    assert_ne!(torques(Actuation::MotorsAtTruePose).0, expected);
}

#[test]
fn work_through_the_port_is_force_times_travel_and_the_motors_keep_their_own_account() {
    let mut device = Pantograph::new(crate::pantographs::desktop().frictionless())
        .and_then(|device| device.with_user_force([0.0, 1.0]))
        .unwrap();
    let (start, before) = (account(&device), device.position());
    let mut work = 0.0;
    device.sample(0.1);
    for _ in 0..100 {
        work += device.advance(0.4, 1e-3);
    }
    let travel = device.position() - before;
    assert!(travel > 1e-3);
    assert!((work - 0.4 * travel).abs() < 1e-14);
    assert!((account(&device) - start).abs() < 1e-12);
    // Held torques make another force once the pose has changed.
    let mismatch = (device.motor_work() + work).abs() / work;
    assert!(mismatch > 1e-3 && mismatch < 0.2, "{mismatch}");
}

#[test]
fn motors_saturate_at_their_limit() {
    let mut device = Pantograph::new(crate::pantographs::haply(3)).unwrap();
    device.sample(1e-3);
    device.advance(1.7, 1e-3);
    assert!(!device.is_saturated());
    // 1.9 N at the fully retracted pose is all there is.
    device.advance(50.0, 1e-3);
    assert!(device.is_saturated());
    assert_eq!(device.motor_torques().map(f64::abs), [0.123, 0.123]);
}

#[test]
fn the_controller_holds_x_while_y_is_pushed() {
    let run = |pid: Option<Pid>| {
        let mut device = Pantograph::new(crate::pantographs::desktop())
            .and_then(|device| device.with_user_force([0.3, 1.0]))
            .unwrap();
        if let Some(pid) = pid {
            device = device.with_pid(pid).unwrap();
        }
        let (start, y) = (account(&device), device.position());
        let mut worst = 0.0_f64;
        for i in 0..2000 {
            device.sample(1e-3);
            // A damped spring of 200 N/m along y.
            let force = 200.0 * (device.position() - y) + 5.0 * device.velocity();
            device.advance(force, 1e-3);
            if i > 1000 {
                worst = worst.max(device.end_point()[0].abs());
            }
            if device.is_jammed() {
                break;
            }
        }
        let drift = (account(&device) - start).abs();
        assert!(drift < 1e-8, "{drift}");
        (worst, device.position() - y, device.is_jammed())
    };
    let (held, travel, jammed) = run(Some(PID));
    assert!(!jammed && held < 1e-4, "{held}");
    // 1 N on the spring, give or take the friction.
    assert!((travel - 0.005).abs() < 0.001, "{travel}");
    let (free, _, _) = run(None);
    assert!(free > 0.01, "{free}");
}

#[test]
fn leaving_the_box_disconnects_the_motors_until_reset() {
    let safety_box = SafetyBox {
        x: [-0.1, 0.1],
        y: [0.18, 0.22],
    };
    let mut device = Pantograph::new(crate::pantographs::desktop())
        .and_then(|device| device.with_pid(PID))
        .and_then(|device| device.with_safety_box(safety_box))
        .unwrap();
    let mut left = None;
    for i in 0..1000 {
        device.sample(1e-3);
        if device.is_disconnected() {
            left = Some(i);
            break;
        }
        device.advance(-2.0, 1e-3);
        assert_ne!(device.motor_torques(), [0.0, 0.0]);
    }
    assert!(left.is_some_and(|i| i > 10), "{left:?}");
    assert!(device.position() > 0.22 && device.position() < 0.225);
    device.advance(-2.0, 1e-3);
    assert_eq!(device.motor_torques(), [0.0, 0.0]);
    // Back inside it stays disconnected.
    let home = device.params().home;
    let mut device = device.starting_at(home, [0.0, 0.0]).unwrap();
    device.sample(1e-3);
    device.advance(-2.0, 1e-3);
    assert!(device.is_disconnected());
    assert_eq!(device.motor_torques(), [0.0, 0.0]);
    device.reset();
    device.sample(1e-3);
    device.advance(-2.0, 1e-3);
    assert!(!device.is_disconnected());
    assert_ne!(device.motor_torques(), [0.0, 0.0]);
}

#[test]
fn a_hand_in_the_motors_is_a_part_of_what_they_are_to_give() {
    let params = PantographParams {
        actuation: Actuation::MotorsAtTruePose,
        ..crate::pantographs::desktop().frictionless()
    };
    let new = || Pantograph::new(params).unwrap();
    // As if the loop had asked for a force that is as much weaker, held from sample to sample.
    let mut hand = new().with_user_force_by_motors([0.0, 1.0]).unwrap();
    let mut loop_alone = new();
    for _ in 0..5 {
        hand.sample(0.02);
        loop_alone.sample(0.02);
        hand.advance(0.25, 0.02);
        loop_alone.advance(0.25 - 1.0, 0.02);
        assert_eq!(hand.motor_torques(), loop_alone.motor_torques());
        assert_eq!(hand.position(), loop_alone.position());
    }
    // A force at the end-point begins with the same acceleration and then differs, since torques are
    // held while the pose changes.
    let moved = |in_motors: bool, duration: f64| {
        let device = new();
        let mut device = if in_motors {
            device.with_user_force_by_motors([0.0, 1.0]).unwrap()
        } else {
            device.with_user_force([0.0, 1.0]).unwrap()
        };
        let before = device.position();
        device.sample(duration);
        device.advance(0.0, duration);
        device.position() - before
    };
    let apart = |duration: f64| (moved(true, duration) / moved(false, duration) - 1.0).abs();
    assert!(apart(1e-4) < 1e-6, "{}", apart(1e-4));
    assert!(apart(0.1) > 1e-3, "{}", apart(0.1));
    // Its work is the motors'.
    let (start, end) = (account(&new()), account(&hand));
    assert!((end - start).abs() < 1e-10, "{start} {end}");
    assert!(hand.motor_work() > 0.0);
}

#[test]
fn a_hand_in_the_motors_is_gone_outside_the_box_and_weak_at_their_limit() {
    let safety_box = SafetyBox {
        x: [-0.1, 0.1],
        y: [0.18, 0.2],
    };
    let mut device = Pantograph::new(crate::pantographs::desktop())
        .and_then(|device| device.with_user_force_by_motors([0.0, 2.0]))
        .and_then(|device| device.with_safety_box(safety_box))
        .unwrap();
    for _ in 0..1000 {
        device.sample(1e-3);
        device.advance(0.0, 1e-3);
    }
    assert!(device.is_disconnected());
    assert_eq!(device.motor_torques(), [0.0, 0.0]);
    let mut weak = Pantograph::new(crate::pantographs::haply(3))
        .and_then(|device| device.with_user_force_by_motors([0.0, 50.0]))
        .unwrap();
    weak.sample(1e-3);
    weak.advance(0.0, 1e-3);
    assert!(weak.is_saturated());
    // Without motors the force itself acts.
    let ideal = PantographParams {
        actuation: Actuation::Ideal,
        ..crate::pantographs::desktop()
    };
    let position = |device: Pantograph| {
        let mut device = device;
        device.sample(0.02);
        device.advance(0.3, 0.02);
        device.position()
    };
    let force = [0.0, 1.0];
    let new = || Pantograph::new(ideal).unwrap();
    assert_eq!(
        position(new().with_user_force_by_motors(force).unwrap()),
        position(new().with_user_force(force).unwrap())
    );
    assert!(new().with_user_force_by_motors([f64::NAN, 0.0]).is_err());
}

#[test]
fn a_rejected_parameter_is_named() {
    let good = crate::pantographs::desktop();
    let mut bad = [good; 5];
    bad[0].home = [1.0, f64::NAN];
    bad[1].distal[1].mass = -1.0;
    bad[2].max_torque = 0.0;
    bad[3].counts_per_rev = Some(0.0);
    bad[4].coulomb_friction = f64::INFINITY;
    for (params, name) in bad.into_iter().zip([
        PantographParameter::Home,
        PantographParameter::DistalMass,
        PantographParameter::MaxTorque,
        PantographParameter::CountsPerRev,
        PantographParameter::CoulombFriction,
    ]) {
        assert_eq!(Pantograph::new(params).unwrap_err().name, name);
    }
    let gen2 = PantographParams {
        home: [1.0, 1.0],
        ..crate::pantographs::haply(2)
    };
    let error = Pantograph::new(gen2).unwrap_err();
    assert_eq!(error.name, PantographParameter::Home);
    assert_eq!(error.name.to_string(), "home");
    let device = Pantograph::new(good).unwrap();
    let upside_down = SafetyBox {
        x: [0.1, -0.1],
        y: [0.0, 1.0],
    };
    assert!(device.with_safety_box(upside_down).is_err());
    assert!(device.with_user_force([f64::NAN, 0.0]).is_err());
    assert!(
        device
            .with_pid(Pid {
                max_force: 0.0,
                ..PID
            })
            .is_err()
    );
}

#[test]
fn no_input_makes_a_nan() {
    for actuation in [Actuation::Ideal, Actuation::MotorsAtMeasuredPose] {
        let mut device = Pantograph::new(PantographParams {
            actuation,
            ..crate::pantographs::desktop()
        })
        .unwrap();
        for force in [f64::NAN, f64::INFINITY, -5.0, 1e300] {
            for duration in [f64::NAN, -1.0, 0.0, f64::INFINITY, 1e-3] {
                device.sample(duration);
                let work = device.advance(force, duration);
                assert!(work.is_finite());
                assert!(device.position().is_finite() && device.velocity().is_finite());
            }
        }
        assert_eq!(device.is_jammed(), actuation == Actuation::Ideal);
    }
}

#[test]
fn sticking_and_sliding_do_not_depend_on_the_length_of_an_advance() {
    let mut broke_away = 0;
    for k in 0..12 {
        // One joint slides off, and what its motion does to the other grows.
        let force = [-0.4, -0.6 + 0.05 * f64::from(k)];
        let device = Pantograph::new(rubbing(0.02, 0.0))
            .and_then(|device| device.with_user_force(force))
            .unwrap();
        let (mut long, mut short) = (device, device);
        long.advance(0.0, 0.15);
        let mut was_stuck = false;
        for _ in 0..1500 {
            short.advance(0.0, 1e-4);
            let stuck = short.rates()[1] == 0.0;
            broke_away += usize::from(was_stuck && !stuck);
            was_stuck = stuck;
        }
        for i in 0..2 {
            let apart = (long.pose().angles[i] - short.pose().angles[i]).abs();
            assert!(apart < 1e-10, "{force:?} {apart}");
        }
    }
    assert!(broke_away >= 2, "{broke_away}");
}

#[test]
fn a_reset_clears_what_the_controller_holds() {
    let mut device = Pantograph::new(crate::pantographs::desktop())
        .and_then(|device| {
            device.with_pid(Pid {
                target: 0.005,
                ..PID
            })
        })
        .unwrap();
    device.sample(1e-3);
    device.advance(0.0, 1e-3);
    assert_ne!(device.motor_torques(), [0.0, 0.0]);
    device.reset();
    device.advance(0.0, 1e-3);
    assert_eq!(device.motor_torques(), [0.0, 0.0]);
}

#[test]
fn torques_from_elsewhere_move_it_as_its_own_would() {
    let params = PantographParams {
        actuation: Actuation::MotorsAtTruePose,
        ..rubbing(0.002, 0.001)
    };
    let mut own = Pantograph::new(params)
        .and_then(|device| device.with_user_force([0.1, 0.3]))
        .unwrap();
    let mut model = own;
    let start = account(&model);
    for i in 0..300 {
        let force = 0.7 * (0.05 * f64::from(i)).sin();
        own.sample(1e-3);
        own.advance(force, 1e-3);
        model.turn(own.motor_torques(), 1e-3);
    }
    assert_eq!(own.pose().angles, model.pose().angles);
    assert!((account(&model) - start).abs() < 1e-9);
    model.turn([f64::NAN, 1e9], 1e-3);
    assert_eq!(model.motor_torques(), [0.0, params.max_torque]);
}

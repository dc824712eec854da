//! Rejected samples: zero force, a reason, and continued rendering with the next sample.

use crate::common::{entries, every_number_is_finite, explained, methods};
use palpate_core::{
    Actuation, AnyMemory, AnyParams, AnyRenderer, Contact, Fault, LoopParams, ObjectState, Phase,
    Renderer, Sample, Scalar, Side, State,
};

const PERIOD: f64 = 0.001;
const STIFFNESS: f64 = 400.0;
/// Device displacement per tick `[m]`.
const PER_TICK: f64 = 1e-4;

struct Pressed<S: Scalar> {
    renderer: AnyRenderer<S>,
    state: State<S, AnyMemory<S>>,
    /// Stored energy at the first sample `[J]`.
    stored_at_start: f64,
    position: f64,
    sign: f64,
}

impl<S: Scalar> Pressed<S> {
    /// Creates a device that moves into the object at 0.1 m/s to a penetration of 1 mm.
    fn new(contact: Contact<S>, loop_params: LoopParams<S>, method: AnyParams<S>) -> Self {
        let renderer = Renderer::new(contact, loop_params, method).unwrap();
        let state = renderer.start(ObjectState::at_rest(S::ZERO)).unwrap();
        let mut pressed = Self {
            renderer,
            state,
            stored_at_start: 0.0,
            position: -5.0 * PER_TICK,
            sign: contact.side.sign::<f64>(),
        };
        for tick in 0..16 {
            let output = pressed.resume();
            assert_eq!(output.fault, None);
            if tick == 0 {
                pressed.stored_at_start = pressed.state.ledger().stored.to_f64();
            }
        }
        pressed
    }

    fn resume(&mut self) -> palpate_core::Output<S> {
        let sample = Sample::at(S::from_f64(self.sign * self.position));
        self.position += PER_TICK;
        self.renderer.step(&mut self.state, sample)
    }

    fn ledger_balances(&self) {
        let ledger = self.state.ledger();
        let scale: f64 = entries(ledger).iter().map(|x| x.to_f64().abs()).sum();
        let off = ledger.stored.to_f64() - self.stored_at_start - explained(ledger);
        assert!(
            off.abs() <= 4.0 * S::EPSILON.to_f64() * scale,
            "{off} J of {scale} J unexplained: {ledger:?}"
        );
    }
}

fn contacts<S: Scalar>() -> Vec<Contact<S>> {
    let k = S::from_f64(STIFFNESS);
    let object = Contact::object(k, S::from_f64(0.1));
    vec![
        object,
        object.on(Side::Negative),
        Contact::wall(k),
        Contact::wall(k).on(Side::Negative),
    ]
}

/// Applies `bad` to every method and contact and checks all guarantees for a fault. The force returns after `lost`
/// further samples.
fn is_refused_and_survived<S: Scalar>(
    loop_params: LoopParams<S>,
    bad: impl Fn(S) -> Sample<S>,
    fault: Fault,
    lost: usize,
) {
    for (name, method) in methods::<S>() {
        for contact in contacts() {
            let mut pressed = Pressed::new(contact, loop_params, method);
            let here = S::from_f64(pressed.sign * pressed.position);
            for repeat in 0..3 {
                let output = pressed.renderer.step(&mut pressed.state, bad(here));
                let case = format!("{name}, {contact:?}, {fault:?}, repeat {repeat}");
                assert_eq!(output.fault, Some(fault), "{case}");
                assert_eq!(output.phase, Phase::Waiting, "{case}");
                assert!(output.force_on_device == S::ZERO, "{case}");
                assert!(output.force_on_object == S::ZERO, "{case}");
                assert!(every_number_is_finite(&output), "{case}: {output:?}");
                assert!(output.object_position.abs() < S::from_f64(0.01), "{case}");
                for _ in 0..lost {
                    let output = pressed.resume();
                    assert_eq!(output.fault, Some(Fault::JumpTooFast), "{case}");
                    assert!(output.force_on_device == S::ZERO, "{case}");
                }
                pressed.position -= PER_TICK * lost as f64;
                let output = pressed.resume();
                assert_eq!(output.fault, None, "{case}");
                assert!(every_number_is_finite(&output), "{case}: {output:?}");
                // Rendering resumes as if the device had come to rest: the largest extrapolation factor is that of the
                // differences of sample-estimate-hold, 2.
                let spring = STIFFNESS * output.penetration.to_f64().max(0.0);
                let force = output.force_on_object.to_f64() * pressed.sign;
                assert!(
                    (0.0..=2.0001 * spring).contains(&force),
                    "{case}: {force} N where the spring has {spring} N"
                );
                pressed.ledger_balances();
                let recorded = entries(pressed.state.ledger());
                assert!(
                    recorded.iter().all(|entry| entry.abs() < S::ONE),
                    "{case}: a refused sample moved energy: {recorded:?}"
                );
                for _ in 0..3 {
                    assert_eq!(pressed.resume().fault, None, "{case}");
                }
                pressed.ledger_balances();
            }
        }
    }
}

fn in_both_precisions(
    loop_params: impl Fn(LoopParams<f64>) -> LoopParams<f64>,
    bad: impl Fn(f64) -> Sample<f64>,
    fault: Fault,
    lost: usize,
) {
    let double = loop_params(LoopParams::new(PERIOD));
    is_refused_and_survived::<f64>(double, &bad, fault, lost);
    let single = |value: f64| f32::from_f64(value);
    is_refused_and_survived::<f32>(
        LoopParams {
            period: single(double.period),
            largest_gap: double.largest_gap.map(single),
            speed_limit: double.speed_limit.map(single),
            force_limit: None,
            slew_limit: None,
            actuation: Actuation::default(),
            guard: palpate_core::Guard::Off,
        },
        |here| {
            let sample = bad(here.to_f64());
            Sample {
                device_position: single(sample.device_position),
                elapsed: sample.elapsed.map(single),
                virtual_force: single(sample.virtual_force),
            }
        },
        fault,
        lost,
    );
}

#[test]
fn a_position_that_is_no_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let fault = Fault::PositionNotFinite;
        in_both_precisions(|l| l, |_| Sample::at(bad), fault, 0);
    }
}

#[test]
fn a_virtual_force_that_is_no_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let fault = Fault::VirtualForceNotFinite;
        let sample = |here| Sample::at(here).with_virtual_force(bad);
        in_both_precisions(|l| l, sample, fault, 0);
    }
}

#[test]
fn an_elapsed_time_that_is_not_positive_is_refused() {
    for bad in [0.0, -0.0, -PERIOD, f64::NAN, f64::INFINITY] {
        let fault = Fault::ElapsedNotPositive;
        in_both_precisions(|l| l, |here| Sample::at(here).after(bad), fault, 0);
    }
}

#[test]
fn a_gap_beyond_the_largest_is_refused_and_one_up_to_it_is_bridged() {
    let set = |l: LoopParams<f64>| LoopParams {
        largest_gap: Some(0.005),
        ..l
    };
    let after = |gap| move |here| Sample::at(here).after(gap);
    in_both_precisions(set, after(0.005_01), Fault::GapTooLong, 0);
    in_both_precisions(|l| l, after(20.01 * PERIOD), Fault::GapTooLong, 0);

    for (l, gap) in [
        (set(LoopParams::new(PERIOD)), 0.005),
        (LoopParams::new(PERIOD), 20.0 * PERIOD),
    ] {
        let contact = Contact::object(STIFFNESS, 0.1);
        let mut pressed = Pressed::new(contact, l, AnyParams::Basic);
        let here = Sample::at(pressed.position).after(gap);
        assert_eq!(pressed.renderer.step(&mut pressed.state, here).fault, None);
    }
}

#[test]
fn a_jump_beyond_the_speed_limit_is_refused_and_the_next_good_sample_recovers() {
    for jump in [0.11, -0.11, 1e30] {
        let sample = |here| Sample::at(here + jump);
        in_both_precisions(|l| l, sample, Fault::JumpTooFast, 0);
    }
    let contact = Contact::object(STIFFNESS, 0.1);
    let mut pressed = Pressed::new(contact, LoopParams::new(PERIOD), AnyParams::Basic);
    let just_believed = Sample::at(pressed.position - PER_TICK + 0.099);
    let output = pressed.renderer.step(&mut pressed.state, just_believed);
    assert_eq!(output.fault, None);
}

#[test]
fn a_device_that_stays_where_it_jumped_to_is_followed_there() {
    let contact = Contact::object(STIFFNESS, 0.1);
    let mut pressed = Pressed::new(contact, LoopParams::new(PERIOD), AnyParams::Basic);
    let there = pressed.position - 5.0;
    let faults = [there, there + 0.001, there - 0.2, pressed.position, there].map(|position| {
        pressed
            .renderer
            .step(&mut pressed.state, Sample::at(position))
            .fault
    });
    let jump = Some(Fault::JumpTooFast);
    assert_eq!(faults, [jump, None, jump, jump, None]);
}

#[test]
fn a_penetration_too_large_to_compute_with_is_refused() {
    let any_speed = LoopParams {
        speed_limit: None,
        ..LoopParams::new(PERIOD)
    };
    for huge in [1e160, 1e300, f64::MAX] {
        let deep = |here: f64| Sample::at(huge.copysign(here));
        is_refused_and_survived::<f64>(any_speed, deep, Fault::Overflow, 0);
    }
    let any_speed = LoopParams {
        speed_limit: None,
        ..LoopParams::new(1e-3_f32)
    };
    for huge in [1e21_f32, 1e30, f32::MAX] {
        let deep = |here: f32| Sample::at(huge.copysign(here));
        is_refused_and_survived::<f32>(any_speed, deep, Fault::Overflow, 0);
    }
}

#[test]
fn a_huge_position_on_the_free_side_gives_no_force_while_the_device_is_there() {
    for (name, method) in methods::<f64>() {
        // A proxy pulls its device in free motion, too.
        if name == "virtual-coupling" {
            continue;
        }
        for contact in contacts() {
            let l = LoopParams {
                speed_limit: None,
                ..LoopParams::new(PERIOD)
            };
            let mut pressed = Pressed::new(contact, l, method);
            for huge in [1e160, 1e300, f64::MAX] {
                let away = Sample::at(-huge * pressed.sign);
                let output = pressed.renderer.step(&mut pressed.state, away);
                assert!(output.force_on_device == 0.0, "{name}: {output:?}");
                assert!(every_number_is_finite(&output), "{name}: {output:?}");
            }
        }
    }
}

#[test]
fn a_virtual_force_too_large_to_compute_with_does_not_take_the_object_away_for_good() {
    for (name, method) in methods::<f64>() {
        for huge in [1e158, -1e158, 1e300, -1e300, f64::MAX] {
            let contact = Contact::object(STIFFNESS, 0.1);
            let mut pressed = Pressed::new(contact, LoopParams::new(PERIOD), method);
            let sample = Sample::at(pressed.position).with_virtual_force(huge);
            let mut faults = 0;
            let output = pressed.renderer.step(&mut pressed.state, sample);
            faults += usize::from(output.fault.is_some());
            faults += usize::from(pressed.resume().fault.is_some());
            assert!(faults > 0, "{name}, {huge} N: nothing noticed");
            let output = pressed.resume();
            assert_eq!(output.fault, None, "{name}, {huge} N");
            assert!(output.object_position.abs() < 0.01, "{name}: {output:?}");
        }
    }
}

#[test]
fn an_object_further_from_the_device_than_numbers_reach_is_refused() {
    let l = LoopParams {
        speed_limit: None,
        ..LoopParams::new(PERIOD)
    };
    let renderer = Renderer::new(Contact::object(400.0, 0.1), l, AnyParams::Basic).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(1.7e308)).unwrap();
    let output = renderer.step(&mut state, Sample::at(-1.7e308));
    assert!(every_number_is_finite(&output), "{output:?}");
    assert_eq!(output.fault, Some(Fault::Overflow));
}

#[test]
fn the_object_finishes_its_interval_and_then_waits() {
    let contact = Contact::object(STIFFNESS, 0.1);
    let mut pressed = Pressed::new(contact, LoopParams::new(PERIOD), AnyParams::Basic);
    let mut untroubled = pressed.state;
    let there = Sample::at(pressed.position);
    let due = pressed.renderer.step(&mut untroubled, there);
    for _ in 0..3 {
        let output = pressed
            .renderer
            .step(&mut pressed.state, Sample::at(f64::NAN));
        assert_eq!(output.object_position, due.object_position);
        assert_eq!(output.object_velocity, due.object_velocity);
    }
    // The effect of the object's own interval and the device's unobserved motion is outside work.
    let before = *pressed.state.ledger();
    let output = pressed.renderer.step(&mut pressed.state, there);
    assert_eq!(output.object_position, due.object_position);
    let after = pressed.state.ledger();
    assert_eq!(
        after.outside_work - before.outside_work,
        after.stored - before.stored
    );
    assert_eq!(after.port_work, before.port_work);
    assert_eq!(after.held_leak, before.held_leak);
}

#[test]
fn every_fault_has_its_own_name_and_says_what_was_wrong() {
    let all = [
        Fault::PositionNotFinite,
        Fault::VirtualForceNotFinite,
        Fault::ElapsedNotPositive,
        Fault::GapTooLong,
        Fault::JumpTooFast,
        Fault::Overflow,
    ];
    let mut names: Vec<_> = all.iter().map(|fault| fault.name()).collect();
    let mut messages: Vec<_> = all.iter().map(ToString::to_string).collect();
    names.sort_unstable();
    names.dedup();
    messages.sort_unstable();
    messages.dedup();
    assert_eq!((names.len(), messages.len()), (all.len(), all.len()));
    assert!(names.iter().all(|name| {
        name.bytes()
            .all(|byte| byte.is_ascii_lowercase() || byte == b'-')
    }));
}

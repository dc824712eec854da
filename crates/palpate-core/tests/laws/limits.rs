//! Limits of the held force: their effect, their flags, and the resulting ledger.

use crate::common::{Auditor, PointMass, methods};
use palpate_core::{
    AnyParams, AnyRenderer, Contact, HfcrParams, Limited, LoopParams, Mass, ObjectState, Renderer,
    Sample, Side,
};

const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;

fn contact() -> Contact<f64> {
    Contact::object(100.0, 0.1)
}

/// Without limits, this device diverges with the over-damped coupling.
fn stable_methods() -> impl Iterator<Item = (&'static str, AnyParams<f64>)> {
    methods()
        .into_iter()
        .filter(|(name, _)| *name != "damper, over-damped")
}

/// Coupled rendering plans within the force limit, so a limit changes the planned force.
fn plans_within(method: AnyParams<f64>, limits: &LoopParams<f64>) -> bool {
    matches!(method, AnyParams::Coupled(_)) && limits.force_limit.is_some()
}

/// A bounce under `limits`; every force is compared with the unlimited force of the same state, clamped as documented.
/// Returns the number of actions of each limit.
fn obeys(contact: Contact<f64>, limits: LoopParams<f64>, method: AnyParams<f64>) -> [usize; 3] {
    let renderer = AnyRenderer::new(contact, limits, method).unwrap();
    let free_contact = Contact {
        unilateral: false,
        ..contact
    };
    let unlimited = AnyRenderer::new(free_contact, LoopParams::new(PERIOD), method).unwrap();
    let sign: f64 = contact.side.sign();
    let mut state = renderer.start(ObjectState::at_rest(sign * 0.1)).unwrap();
    let mut auditor = Auditor::new(&contact);
    let is_wall = matches!(contact.object_mass, Mass::Infinite);
    if let Some(limit) = limits.force_limit
        && (is_wall || matches!(method, AnyParams::Coupled(_)))
    {
        auditor = auditor.yielding_to(limit);
    }
    let mut device = PointMass {
        mass: 0.1,
        user_force: 0.981,
        position: 0.0,
        velocity: 0.0,
    };
    let (mut counts, mut held) = ([0; 3], 0.0_f64);
    for _ in 0..200 {
        let sample = Sample::at(sign * device.position).with_virtual_force(sign * WEIGHT);
        let planned = sign * unlimited.step(&mut state.clone(), sample).force_on_object;
        let output = renderer.step(&mut state, sample);
        let mut expected = planned;
        let mut acted = Limited::default();
        if contact.unilateral && expected < 0.0 {
            acted.pull = true;
            expected = 0.0;
        }
        if let Some(limit) = limits.force_limit.filter(|limit| expected.abs() > *limit) {
            acted.force = true;
            expected = limit.copysign(expected);
        }
        if let Some(limit) = limits.slew_limit {
            let (low, high) = (held - limit * PERIOD, held + limit * PERIOD);
            acted.slew = !(low..=high).contains(&expected);
            expected = expected.clamp(low, high);
        }
        held = sign * output.force_on_object;
        if plans_within(method, &limits) {
            let limit = limits.force_limit.unwrap_or(f64::INFINITY);
            assert!(held.abs() <= limit, "{held} N");
            acted = output.limited;
            expected = held;
        }
        assert!((held - expected).abs() < 1e-15, "{held} N, not {expected}");
        assert_eq!(output.limited, acted, "{held} N");
        assert_eq!(acted.any(), acted != Limited::default());
        assert_eq!(output.force_on_device, -output.force_on_object);
        if sign > 0.0 {
            auditor.observe(sample, output);
            auditor.agrees_with(state.ledger(), 1e-12);
        }
        for (count, acted) in counts.iter_mut().zip([acted.pull, acted.force, acted.slew]) {
            *count += usize::from(acted);
        }
        device.hold(-held, PERIOD);
    }
    counts
}

#[test]
fn the_force_limit_clamps_the_force_and_is_reported_only_then() {
    for (name, method) in stable_methods() {
        let limit = |newton| LoopParams {
            force_limit: Some(newton),
            ..LoopParams::new(PERIOD)
        };
        let counts = obeys(contact(), limit(1.5), method);
        assert!(counts[1] > 0, "{name}: {counts:?}");
        assert_eq!([counts[0], counts[2]], [0, 0], "{name}");
        assert_eq!(obeys(contact(), limit(1e6), method), [0; 3], "{name}");
    }
}

/// A device strikes an object with 2 m/s; the force of the spring is six times the limit. The device does not deliver
/// all the energy of the object.
#[test]
fn an_object_thrown_by_more_than_the_limited_force_is_no_generated_energy() {
    let period = 0.001;
    let contact = Contact::object(20_000.0, 0.2);
    let struck = |method, force_limit| {
        let loop_params = LoopParams {
            force_limit,
            ..LoopParams::new(period)
        };
        let renderer = AnyRenderer::new(contact, loop_params, method).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.001)).unwrap();
        for tick in 0..30 {
            let _ = renderer.step(&mut state, Sample::at(0.002 * f64::from(tick)));
        }
        let ledger = state.ledger();
        (ledger.held_leak.accumulated, ledger.created())
    };
    for (name, method) in methods() {
        let (without, of_method) = struck(method, None);
        let (leak, created) = struck(method, Some(20.0));
        println!("{name}: {leak:.3} J, {created:.3} J generated; {of_method:.3} J without a limit");
        assert_eq!(without, of_method, "{name}");
        assert!(created < of_method.max(0.0) + 0.1, "{name}: {created} J");
        if matches!(name, "basic" | "hfcr") {
            assert!(leak > 1.0, "{name}: {leak} J");
        }
    }
}

/// A later stage of the program or the device cuts the force below the limit of the renderer, which its report tells.
#[test]
fn a_press_through_a_reported_limit_is_no_generated_energy() {
    const LIMIT: f64 = 5.0;
    for force_limit in [None, Some(LIMIT), Some(4.0 * LIMIT)] {
        for name in ["basic", "hfcr", "coupled"] {
            let mut named = methods().into_iter();
            let (_, method) = named.find(|(found, _)| *found == name).unwrap();
            let loop_params = LoopParams {
                force_limit,
                ..LoopParams::new(0.001)
            };
            let renderer = AnyRenderer::new(Contact::wall(1000.0), loop_params, method).unwrap();
            let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
            let (mut most, mut stored): (f64, f64) = (0.0, 0.0);
            for tick in 0..=1000 {
                let turn = core::f64::consts::TAU * f64::from(tick) / 1000.0;
                let output = renderer.step(&mut state, Sample::at(0.011 * (1.0 - turn.cos())));
                let force = output.force_on_object;
                renderer.report_sent(&mut state, force.clamp(-LIMIT, LIMIT));
                most = most.max(state.ledger().created().abs());
                stored = stored.max(state.ledger().stored);
            }
            // The spring stores 242 mJ, and 5 N take in at most 110 mJ.
            assert!(
                most < 2e-3,
                "{name}, {force_limit:?}: {most} J of {stored} J"
            );
        }
    }
}

#[test]
fn the_slew_limit_holds_up_and_down_and_is_reported_only_then() {
    for (name, method) in stable_methods() {
        let limit = |newton_per_second| LoopParams {
            slew_limit: Some(newton_per_second),
            ..LoopParams::new(PERIOD)
        };
        let counts = obeys(contact(), limit(60.0), method);
        assert!(counts[2] > 0, "{name}: {counts:?}");
        assert_eq!([counts[0], counts[1]], [0, 0], "{name}");
        assert_eq!(obeys(contact(), limit(1e6), method), [0; 3], "{name}");
    }
}

#[test]
fn a_pushing_contact_never_pulls_on_either_side_and_says_when_it_would_have() {
    let sticky = AnyParams::Hfcr(HfcrParams::with_damping(2.0));
    for side in [Side::Positive, Side::Negative] {
        let pushing = contact().on(side).pushing_only();
        let counts = obeys(pushing, LoopParams::new(PERIOD), sticky);
        assert!(counts[0] > 0, "{counts:?}");
        assert_eq!([counts[1], counts[2]], [0, 0]);
        let pulling = contact().on(side);
        assert_eq!(obeys(pulling, LoopParams::new(PERIOD), sticky), [0; 3]);
    }
}

/// The limit is per second: larger for a late sample, smaller for an early one.
#[test]
fn the_slew_limit_goes_by_the_measured_time() {
    for side in [Side::Positive, Side::Negative] {
        let limits = LoopParams {
            slew_limit: Some(10.0),
            ..LoopParams::new(PERIOD)
        };
        let renderer = Renderer::new(contact().on(side), limits, AnyParams::Basic).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let sign: f64 = side.sign();
        let pressed = Sample::at(sign * 0.05).with_virtual_force(sign * -5.0);
        let mut expected = 0.0;
        for elapsed in [PERIOD, 0.5 * PERIOD, 3.0 * PERIOD, 0.1 * PERIOD] {
            let output = renderer.step(&mut state, pressed.after(elapsed));
            expected += 10.0 * elapsed;
            assert!(
                (sign * output.force_on_object - expected).abs() < 1e-12,
                "{elapsed}"
            );
            assert!(output.limited.slew);
        }
    }
}

#[test]
fn all_limits_together_act_in_the_stated_order() {
    let limits = LoopParams {
        force_limit: Some(1.5),
        slew_limit: Some(90.0),
        ..LoopParams::new(PERIOD)
    };
    let sticky = AnyParams::Hfcr(HfcrParams::with_damping(2.0));
    let counts = obeys(contact().pushing_only(), limits, sticky);
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn a_fault_drops_a_slew_limited_force_at_once_and_it_rises_again_from_zero() {
    let limits = LoopParams {
        slew_limit: Some(10.0),
        ..LoopParams::new(PERIOD)
    };
    let renderer = Renderer::new(contact(), limits, AnyParams::Basic).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let pressed = Sample::at(0.05).with_virtual_force(-5.0);
    for tick in 1..=10 {
        let force = renderer.step(&mut state, pressed).force_on_object;
        assert!((force - 0.1 * f64::from(tick)).abs() < 1e-12);
    }
    let fault = renderer.step(&mut state, Sample::at(f64::NAN));
    assert_eq!(fault.force_on_object, 0.0);
    assert!(!fault.limited.any());
    let again = renderer.step(&mut state, pressed);
    assert!((again.force_on_object - 0.1).abs() < 1e-12);
    assert!(again.limited.slew);
}

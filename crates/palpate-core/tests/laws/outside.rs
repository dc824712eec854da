//! Changes of the object from outside: teleports, and other parameters.

use crate::common::{every_number_is_finite, explained, methods};
use palpate_core::{
    AnyMemory, AnyParams, AnyRenderer, Contact, HfcrParams, LoopParams, ObjectState, Parameter,
    Renderer, Sample, State, VirtualDamperParams,
};

const STIFFNESS: f64 = 400.0;
const MASS: f64 = 0.1;
const PERIOD: f64 = 0.001;
const WEIGHT: f64 = -0.981;

fn renderer(contact: Contact<f64>, method: AnyParams<f64>) -> AnyRenderer<f64> {
    Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap()
}

fn object() -> Contact<f64> {
    Contact::object(STIFFNESS, MASS)
}

fn device_at(tick: i32) -> Sample<f64> {
    Sample::at(1e-4 * f64::from(tick)).with_virtual_force(WEIGHT)
}

/// Runs a device at 0.1 m/s, sampled up to but excluding `tick`; the object is at rest at 0.
fn pressed(renderer: &AnyRenderer<f64>, tick: i32) -> State<f64, AnyMemory<f64>> {
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    for before in -5..tick {
        renderer.step(&mut state, device_at(before));
    }
    state
}

fn balances(state: &State<f64, AnyMemory<f64>>) {
    let ledger = state.ledger();
    let off = ledger.stored - explained(ledger);
    assert!(off.abs() < 1e-14, "{off} J unexplained: {ledger:?}");
}

#[test]
fn a_start_or_a_teleport_to_nowhere_is_refused_and_changes_nothing() {
    for contact in [object(), Contact::wall(STIFFNESS)] {
        let renderer = renderer(contact, AnyParams::Basic);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for (name, object) in [
                (Parameter::ObjectPosition, ObjectState::at_rest(bad)),
                (
                    Parameter::ObjectVelocity,
                    ObjectState {
                        position: 0.0,
                        velocity: bad,
                    },
                ),
            ] {
                assert_eq!(renderer.start(object).unwrap_err().parameter, name);
                let mut state = pressed(&renderer, 10);
                let mut untouched = state;
                let error = renderer.teleport(&mut state, object).unwrap_err();
                assert_eq!(error.parameter, name);
                let next = device_at(10);
                let output = renderer.step(&mut state, next);
                assert_eq!(output, renderer.step(&mut untouched, next));
            }
        }
    }
}

#[test]
fn a_teleport_is_outside_work_of_exactly_the_energy_it_changes() {
    for (name, method) in methods() {
        let renderer = renderer(object(), method);
        for (place, velocity) in [(0.0005, 0.3), (-0.002, 0.0), (5.0, -1.0)] {
            let mut state = pressed(&renderer, 10);
            let mut untouched = state;
            let there = ObjectState {
                position: place,
                velocity,
            };
            renderer.teleport(&mut state, there).unwrap();
            assert_eq!(state.ledger(), untouched.ledger(), "{name}: not yet");
            let output = renderer.step(&mut state, device_at(10));
            renderer.step(&mut untouched, device_at(10));
            assert_eq!(output.object_position, place, "{name}");
            assert_eq!(output.object_velocity, velocity, "{name}");
            let (ledger, closed) = (state.ledger(), untouched.ledger());
            let p = (0.001 - place).max(0.0);
            let stored = 0.5 * STIFFNESS * p * p + 0.5 * MASS * velocity * velocity;
            assert!((ledger.stored - stored).abs() < 1e-15, "{name}");
            assert_eq!(ledger.outside_work, stored - closed.stored, "{name}");
            // The previous interval is closed without an effect of the teleport.
            assert_eq!(ledger.port_work, closed.port_work, "{name}");
            assert_eq!(ledger.held_leak, closed.held_leak, "{name}");
            balances(&state);
            let outside_work = ledger.outside_work;
            for tick in 11..30 {
                let output = renderer.step(&mut state, device_at(tick));
                assert!(every_number_is_finite(&output), "{name}");
                balances(&state);
            }
            assert_eq!(state.ledger().outside_work, outside_work, "{name}");
        }
    }
}

#[test]
fn after_a_teleport_a_damper_sees_no_velocity_that_never_was() {
    let params = VirtualDamperParams::new(5.0);
    let renderer = renderer(object(), AnyParams::VirtualDamper(params));
    let mut state = pressed(&renderer, 10);
    renderer
        .teleport(&mut state, ObjectState::at_rest(-0.02))
        .unwrap();
    let output = renderer.step(&mut state, device_at(10));
    // 20 mm in one period would be 20 m/s, and 100 N.
    assert_eq!(output.force_on_object, STIFFNESS * output.penetration);
    let next = renderer.step(&mut state, device_at(11));
    let rate = (next.penetration - output.penetration) / PERIOD;
    let expected = STIFFNESS * next.penetration + 5.0 * rate;
    assert!((next.force_on_object - expected).abs() < 1e-12);
}

#[test]
fn after_a_teleport_past_forces_are_forgotten_and_the_device_velocity_is_not() {
    for (name, factor) in [("seh ab2", 1.5), ("seh ab3", 23.0 / 12.0)] {
        let (_, method) = methods()
            .into_iter()
            .find(|(other, _)| *other == name)
            .unwrap();
        let renderer = renderer(object(), method);
        let mut state = pressed(&renderer, 10);
        renderer
            .teleport(&mut state, ObjectState::at_rest(-0.02))
            .unwrap();
        let output = renderer.step(&mut state, device_at(10));
        let expected = factor * STIFFNESS * output.penetration;
        assert!((output.force_on_object - expected).abs() < 1e-12, "{name}");
    }
    let hfcr = AnyParams::Hfcr(HfcrParams::default());
    let renderer = renderer(Contact::wall(STIFFNESS), hfcr);
    let mut state = pressed(&renderer, 10);
    renderer
        .teleport(&mut state, ObjectState::at_rest(-0.02))
        .unwrap();
    let output = renderer.step(&mut state, device_at(10));
    let expected = STIFFNESS * (output.penetration + 0.5 * 1e-4);
    assert!((output.force_on_object - expected).abs() < 1e-12);
}

#[test]
fn a_teleport_waits_for_a_sample_that_can_be_trusted() {
    let renderer = renderer(object(), AnyParams::Basic);
    let mut state = pressed(&renderer, 10);
    renderer
        .teleport(&mut state, ObjectState::at_rest(0.3))
        .unwrap();
    let refused = renderer.step(&mut state, Sample::at(f64::NAN));
    assert!(refused.object_position < 0.01);
    let output = renderer.step(&mut state, device_at(10));
    assert_eq!(output.object_position, 0.3);
    balances(&state);
    let output = renderer.step(&mut state, device_at(11).with_virtual_force(0.0));
    assert!((output.object_position - 0.3).abs() < 1e-4, "only once");
}

#[test]
fn new_parameters_are_outside_work_of_the_energy_they_change() {
    for (name, method) in methods() {
        let before = renderer(object(), method);
        for (stiffness, mass) in [(800.0, MASS), (STIFFNESS, 0.3), (50.0, f64::INFINITY)] {
            let after = renderer(Contact::object(stiffness, mass), method);
            let mut state = pressed(&before, 10);
            let output = before.step(&mut state, device_at(10));
            assert!(output.penetration > 0.0);
            let stored = state.ledger().stored;
            after.adopt(&mut state);
            let inertia = if mass.is_finite() { mass } else { 0.0 };
            let expected = 0.5 * stiffness * output.penetration.powi(2)
                + 0.5 * inertia * output.object_velocity.powi(2);
            let ledger = state.ledger();
            assert!((ledger.stored - expected).abs() < 1e-15, "{name}");
            assert!((ledger.outside_work - (expected - stored)).abs() < 1e-15);
            balances(&state);

            // The interval in progress ends under the new parameters.
            let next = after.step(&mut state, device_at(11));
            if mass == f64::INFINITY {
                let placed = output.object_position + next.proxy_shift;
                assert!((next.object_position - placed).abs() < 1e-15, "{name}");
                assert_eq!(next.object_velocity, 0.0, "{name}");
            } else if !name.starts_with("damper") && !name.starts_with("coupled") {
                let omega = (stiffness / mass).sqrt();
                let rest = output.penetration + WEIGHT / stiffness;
                let by = rest * (1.0 - (omega * PERIOD).cos())
                    + output.object_velocity / omega * (omega * PERIOD).sin();
                let moved = next.object_position - output.object_position;
                assert!((moved - by).abs() < 1e-15, "{name}: {moved}, not {by}");
            }
            // The held force did the work, independent of the parameters.
            balances(&state);
            for tick in 12..30 {
                assert_eq!(after.step(&mut state, device_at(tick)).fault, None);
                balances(&state);
            }
        }
    }
}

#[test]
fn a_state_that_has_seen_no_sample_or_a_refused_one_can_be_adopted() {
    let before = renderer(object(), AnyParams::Basic);
    let after = renderer(Contact::object(2.0 * STIFFNESS, MASS), AnyParams::Basic);
    let mut state = before.start(ObjectState::at_rest(0.0)).unwrap();
    after.adopt(&mut state);
    after.step(&mut state, Sample::at(0.001));
    assert!((state.ledger().stored - STIFFNESS * 1e-6).abs() < 1e-18);
    assert_eq!(state.ledger().outside_work, 0.0);

    let mut state = pressed(&before, 10);
    before.step(&mut state, Sample::at(f64::NAN));
    after.adopt(&mut state);
    balances(&state);
    let output = after.step(&mut state, device_at(10));
    assert_eq!(output.fault, None);
    balances(&state);
}

#[test]
fn object_changed_to_wall_rests_despite_pending_velocity() {
    let before = renderer(object(), AnyParams::Basic);
    let wall = renderer(Contact::wall(STIFFNESS), AnyParams::Basic);
    let mut state = pressed(&before, 10);
    let moving = ObjectState {
        position: 0.01,
        velocity: 3.0,
    };
    before.teleport(&mut state, moving).unwrap();
    wall.adopt(&mut state);
    for tick in 10..20 {
        let output = wall.step(&mut state, device_at(tick));
        assert_eq!(output.object_position, 0.01);
        assert_eq!(output.object_velocity, 0.0);
    }
}

#[test]
fn a_force_that_was_really_held_is_the_one_that_is_booked() {
    let renderer = renderer(object(), AnyParams::Basic);
    let mut state = pressed(&renderer, 10);
    let output = renderer.step(&mut state, device_at(10));
    let before = state.ledger().port_work;
    renderer.report_held(&mut state, 0.25 * output.force_on_object);
    renderer.report_held(&mut state, f64::NAN);
    renderer.step(&mut state, device_at(11));
    let work = state.ledger().port_work - before;
    assert!((work - 0.25 * output.force_on_object * 1e-4).abs() < 1e-16);
    balances(&state);
}

//! Samples that are not exactly one period apart.

use crate::common::{PointMass, Random, entries, methods};
use palpate_core::{
    AnyParams, AnyRenderer, Contact, EntryHold, HfcrParams, LoopParams, ObjectState, Output, Phase,
    Renderer, Sample,
};

const STIFFNESS: f64 = 100.0;
const MASS: f64 = 0.1;
const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;

fn renderer(method: AnyParams<f64>) -> AnyRenderer<f64> {
    let contact = Contact::object(STIFFNESS, MASS);
    Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap()
}

fn device() -> PointMass {
    PointMass {
        mass: 0.1,
        user_force: 0.981,
        position: 0.0,
        velocity: 0.0,
    }
}

/// Textbook form of Eq. (4).
fn fly((eta, velocity): (f64, f64), h: f64) -> (f64, f64) {
    let alpha = WEIGHT / MASS;
    (
        eta + velocity * h + 0.5 * alpha * h * h,
        velocity + alpha * h,
    )
}

/// Eq. (6a) as in the paper.
fn press((eta, velocity): (f64, f64), xi: f64, h: f64) -> (f64, f64) {
    let omega = (STIFFNESS / MASS).sqrt();
    let zeta = xi + WEIGHT / STIFFNESS;
    let (sin, cos) = (omega * h).sin_cos();
    (
        zeta + (eta - zeta) * cos + velocity / omega * sin,
        -omega * (eta - zeta) * sin + velocity * cos,
    )
}

#[test]
fn a_period_within_a_millionth_of_the_nominal_is_the_nominal_bit_for_bit() {
    for (name, method) in methods() {
        let renderer = renderer(method);
        let run = |elapsed: &dyn Fn(usize) -> Option<f64>| {
            let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
            let mut device = device();
            let mut outputs = Vec::new();
            for tick in 0..80 {
                let sample = Sample {
                    device_position: device.position,
                    elapsed: elapsed(tick),
                    virtual_force: WEIGHT,
                };
                let output = renderer.step(&mut state, sample);
                device.hold(output.force_on_device, PERIOD);
                outputs.push((output, entries(state.ledger())));
            }
            outputs
        };
        let unmeasured = run(&|_| None);
        let jittered = run(&|tick| {
            let sign = if tick % 2 == 0 { 1.0 } else { -1.0 };
            Some(PERIOD * (1.0 + sign * 0.9e-6))
        });
        assert!(unmeasured == jittered, "{name}");
        assert!(
            unmeasured.iter().any(|(o, _)| o.force_on_object != 0.0),
            "{name}: no contact"
        );
        let measurably_longer = run(&|_| Some(PERIOD * (1.0 + 1.1e-6)));
        assert!(unmeasured != measurably_longer, "{name}");
    }
}

/// End of an interval relative to its plan.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Free,
    Contact,
    BeforeEntry,
    AfterEntry,
    BeforeRelease,
    AfterRelease,
}

/// Returns the object's state after `h` in the interval that `planned` began, piece by piece.
fn expected(
    planned: &Output<f64>,
    hold: EntryHold,
    xi: f64,
    velocity: f64,
    h: f64,
) -> (Course, (f64, f64)) {
    let start = (planned.object_position, planned.object_velocity);
    let tau = planned.transition_after;
    match planned.phase {
        Phase::Free => (Course::Free, fly(start, h)),
        Phase::Contact => (Course::Contact, press(start, xi, h)),
        Phase::Enters if h <= tau => (Course::BeforeEntry, fly(start, h)),
        Phase::Enters => {
            let touch = fly(start, tau);
            let crossing = xi + velocity * tau;
            assert!((crossing - touch.0).abs() < 1e-12, "tau is not the entry");
            let held_at = match hold {
                EntryHold::Crossing => crossing,
                EntryHold::Sample => xi,
                EntryHold::Midpoint => 0.5 * (crossing + xi + velocity * PERIOD),
            };
            (Course::AfterEntry, press(touch, held_at, h - tau))
        }
        Phase::Leaves if h <= tau => (Course::BeforeRelease, press(start, xi, h)),
        Phase::Leaves => {
            let apart = press(start, xi, tau);
            assert!(
                (xi + velocity * tau - apart.0).abs() < 1e-12,
                "tau is not the release"
            );
            (Course::AfterRelease, fly(apart, h - tau))
        }
        Phase::Waiting => panic!("a fault"),
    }
}

#[test]
fn an_early_or_late_sample_finds_the_object_where_its_plan_had_it_at_that_instant() {
    for entry_hold in [EntryHold::Crossing, EntryHold::Sample, EntryHold::Midpoint] {
        finds_the_object_where_its_plan_had_it(entry_hold);
    }
}

fn finds_the_object_where_its_plan_had_it(entry_hold: EntryHold) {
    let renderer = renderer(AnyParams::Hfcr(HfcrParams {
        entry_hold,
        ..HfcrParams::default()
    }));
    let mut random = Random(3);
    let mut seen = Vec::new();
    for _ in 0..40 {
        let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
        let mut device = device();
        device.velocity = random.between(0.0, 0.3);
        let mut last: Option<(Output<f64>, f64, f64)> = None;
        let mut elapsed = PERIOD;
        for _ in 0..120 {
            let xi = device.position;
            let sample = Sample::at(xi).with_virtual_force(WEIGHT).after(elapsed);
            let output = renderer.step(&mut state, sample);
            let velocity = last
                .as_ref()
                .map_or(0.0, |(_, before, _)| (xi - before) / elapsed);
            if let Some((planned, xi, velocity)) = &last {
                let (course, (eta, eta_velocity)) =
                    expected(planned, entry_hold, *xi, *velocity, elapsed);
                seen.push(course);
                assert!(
                    (output.object_position - eta).abs() < 1e-13
                        && (output.object_velocity - eta_velocity).abs() < 1e-12,
                    "{course:?}, {elapsed} s: {output:?}, not {eta}, {eta_velocity}"
                );
            }
            last = Some((output, xi, velocity));
            elapsed = PERIOD * random.pick(&[0.2, 0.5, 0.9, 1.0, 1.0, 1.3, 2.0]);
            device.hold(output.force_on_device, elapsed);
        }
    }
    for course in [
        Course::Free,
        Course::Contact,
        Course::BeforeEntry,
        Course::AfterEntry,
        Course::BeforeRelease,
        Course::AfterRelease,
    ] {
        let count = seen.iter().filter(|&&other| other == course).count();
        println!("{course:?}: {count}");
        assert!(count >= 20, "{course:?} seen only {count} times");
    }
}

#[test]
fn free_flight_is_exact_at_any_steady_rate() {
    for h in [0.3 * PERIOD, 0.999_99 * PERIOD, 7.0 * PERIOD] {
        for (name, method) in methods() {
            let renderer = renderer(method);
            let mut state = renderer
                .start(ObjectState {
                    position: 0.5,
                    velocity: 2.0,
                })
                .unwrap();
            for tick in 0..=50 {
                // Far below: no contact.
                let sample = Sample::at(-100.0).with_virtual_force(WEIGHT).after(h);
                let output = renderer.step(&mut state, sample);
                let (eta, velocity) = fly((0.5, 2.0), h * f64::from(tick));
                assert_eq!(output.force_on_object, 0.0, "{name}");
                assert!((output.object_position - eta).abs() < 1e-11, "{name}");
                assert!((output.object_velocity - velocity).abs() < 1e-11, "{name}");
            }
            let ledger = state.ledger();
            assert!(ledger.held_leak.absolute < 1e-12, "{name}: {ledger:?}");
        }
    }
}

#[test]
fn the_leak_of_sustained_contact_is_known_in_closed_form_for_any_elapsed_time() {
    // L = K dxi ((dxi - d) / 2 + by(T) - by(h)); for h = T the theory's (K/2) dxi (dxi - d).
    let renderer = renderer(AnyParams::Hfcr(HfcrParams::modified_force_only()));
    let mut random = Random(4);
    let mut checked = 0;
    for _ in 0..2000 {
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let at = |xi: f64| Sample::at(xi).with_virtual_force(WEIGHT);
        let xi_0 = random.between(0.01, 0.05);
        renderer.step(&mut state, at(xi_0));
        let xi_1 = xi_0 + random.between(-0.005, 0.01);
        let planned = renderer.step(&mut state, at(xi_1));
        let h = PERIOD * random.pick(&[1.0, 0.4, 0.8, 1.7]);
        let xi_2 = xi_1 + random.between(-0.005, 0.01);
        let output = renderer.step(&mut state, at(xi_2).after(h));
        let predicted_out = planned.penetration + (xi_1 - xi_0)
            - (press(
                (planned.object_position, planned.object_velocity),
                xi_1,
                PERIOD,
            )
            .0 - planned.object_position)
            <= 0.0;
        if predicted_out || planned.penetration <= 0.0 || output.penetration <= 0.0 {
            continue;
        }
        checked += 1;
        let start = (planned.object_position, planned.object_velocity);
        let by = |h| press(start, xi_1, h).0 - start.0;
        let (moved, d) = (xi_2 - xi_1, xi_1 - xi_0);
        let leak = STIFFNESS * moved * (0.5 * (moved - d) + by(PERIOD) - by(h));
        let recorded = state.ledger().held_leak.last;
        assert!(
            (recorded - leak).abs() < 1e-14,
            "{recorded} J, not {leak} J"
        );
    }
    assert!(checked > 500, "{checked}");
}

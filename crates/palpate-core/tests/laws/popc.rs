//! Passivity controllers compared with their formulas over a closed loop.

use crate::common::PointMass;
use palpate_core::{
    AnyParams, AnyRenderer, Contact, LoopParams, ObjectState, Output, PopcParams, PopcRefParams,
    Renderer, Sample,
};

const STIFFNESS: f64 = 100.0;
const MASS: f64 = 0.1;
const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;
const CAP: f64 = 6.0;
const THRESHOLD: f64 = 1e-4;

fn renderer(method: AnyParams<f64>) -> AnyRenderer<f64> {
    let contact = Contact::object(STIFFNESS, MASS);
    Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap()
}

fn popc(initial_energy: f64) -> AnyParams<f64> {
    AnyParams::Popc(PopcParams {
        initial_energy,
        ..PopcParams::new(CAP)
    })
}

/// Runs a bounce and returns (device position, output) of every tick.
fn bounce(method: AnyParams<f64>) -> Vec<(f64, Output<f64>)> {
    let renderer = renderer(method);
    let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
    let mut device = PointMass {
        mass: 0.1,
        user_force: 0.981,
        position: 0.0,
        velocity: 0.0,
    };
    (0..80)
        .map(|_| {
            let xi = device.position;
            let output = renderer.step(&mut state, Sample::at(xi).with_virtual_force(WEIGHT));
            device.hold(output.force_on_device, PERIOD);
            (xi, output)
        })
        .collect()
}

/// Checks every force of a run against `K p + alpha v`, with the energy to remove `deficit(E_i, V_i - V_0)`; returns
/// how often alpha was 0, below and at the cap.
fn obeys(run: &[(f64, Output<f64>)], deficit: impl Fn(f64, f64) -> f64) -> [usize; 3] {
    let mut counts = [0; 3];
    let (mut port, mut virtual_work, mut stored_at_start) = (0.0, 0.0, None);
    let mut last: Option<&(f64, Output<f64>)> = None;
    for now in run {
        let (xi, output) = now;
        let p = xi - output.object_position;
        let mut v = 0.0;
        if let Some((before, held)) = last {
            port += held.force_on_object * (xi - before);
            virtual_work += WEIGHT * (output.object_position - held.object_position);
            v = (xi - before) / PERIOD;
        }
        let stored = 0.5 * MASS * output.object_velocity.powi(2)
            + 0.5 * STIFFNESS * p.max(0.0).powi(2)
            - virtual_work;
        let gained = stored - *stored_at_start.get_or_insert(stored);
        let mut expected = 0.0;
        if p > 0.0 {
            let d = deficit(port, gained);
            let alpha = if d > 0.0 && v.abs() > THRESHOLD {
                (d / (PERIOD * v * v)).min(CAP)
            } else {
                0.0
            };
            counts[usize::from(alpha > 0.0) + usize::from(alpha >= CAP)] += 1;
            expected = STIFFNESS * p + alpha * v;
        }
        assert!(
            (output.force_on_object - expected).abs() < 1e-9,
            "{output:?}, not {expected} N"
        );
        last = Some(now);
    }
    counts
}

#[test]
fn the_passivity_controller_takes_back_what_went_out() {
    for initial_energy in [0.0, 0.02] {
        let run = bounce(popc(initial_energy));
        let counts = obeys(&run, |port, _| -(port + initial_energy));
        println!("E_0 = {initial_energy}: alpha 0, free, capped {counts:?}");
        assert!(counts[0] > 0 && counts[1] + counts[2] > 0, "{counts:?}");
    }
}

#[test]
fn reference_following_takes_back_what_is_stored_beyond_what_came_in() {
    let run = bounce(AnyParams::PopcRef(PopcRefParams::new(CAP)));
    let counts = obeys(&run, |port, gained| gained - port);
    println!("alpha 0, free, capped {counts:?}");
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn energy_stored_at_the_start_may_be_given_out_before_the_controller_acts() {
    // A device pushed out of a penetrated object extracts energy from the first interval on.
    let stored = 0.5 * STIFFNESS * 0.01 * 0.01;
    let second_force = |initial_energy| {
        let renderer = renderer(popc(initial_energy));
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        renderer.step(&mut state, Sample::at(0.01));
        let output = renderer.step(&mut state, Sample::at(0.009));
        (output.force_on_object, STIFFNESS * output.penetration)
    };
    let (force, spring) = second_force(0.0);
    // f_0 = 1 N extracted 1 mJ; the damping is capped at 6 N s/m, and v = -0.1 m/s.
    assert!((force - (spring - CAP * 0.1)).abs() < 1e-12, "{force}");
    let (force, spring) = second_force(stored);
    assert_eq!(force, spring);
    // Less than the whole: 1 mJ - 0.9 mJ within one period.
    let (force, spring) = second_force(0.0009);
    assert!((force - (spring - 0.0001 / (PERIOD * 0.1))).abs() < 1e-9);
}

#[test]
fn no_damping_is_injected_up_to_the_speed_threshold() {
    // Powers of two, so that the speed equals the threshold without rounding.
    let period = 2f64.powi(-10);
    let threshold = 2f64.powi(-8);
    let extra_force = |speed: f64, method| {
        let contact = Contact::object(STIFFNESS, MASS);
        let renderer = AnyRenderer::new(contact, LoopParams::new(period), method).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let xi = 2f64.powi(-6);
        renderer.step(&mut state, Sample::at(xi));
        let output = renderer.step(&mut state, Sample::at(xi - speed * period));
        output.force_on_object - STIFFNESS * output.penetration
    };
    let plain = AnyParams::Popc(PopcParams {
        speed_threshold: threshold,
        ..PopcParams::new(CAP)
    });
    let reference = AnyParams::PopcRef(PopcRefParams {
        speed_threshold: threshold,
        ..PopcRefParams::new(CAP)
    });
    for method in [plain, reference] {
        assert_eq!(extra_force(threshold, method), 0.0, "{method:?}");
        assert!(extra_force(1.01 * threshold, method) < 0.0, "{method:?}");
    }
    // At rest there is no division by zero, even without a threshold.
    let no_threshold = AnyParams::Popc(PopcParams {
        speed_threshold: 0.0,
        ..PopcParams::new(CAP)
    });
    assert_eq!(extra_force(0.0, no_threshold), 0.0);
}

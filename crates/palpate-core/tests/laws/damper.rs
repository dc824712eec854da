//! Virtual damper: the object's motion compared with a fine numerical integration.

use palpate_core::{
    Contact, LoopParams, ObjectState, Output, Renderer, Sample, VirtualDamperParams,
};

// Chosen so that Omega = 200 rad/s and B = 4 N s/m is critical, both without rounding.
const STIFFNESS: f64 = 400.0;
const MASS: f64 = 0.01;
const CRITICAL: f64 = 4.0;
const PERIOD: f64 = 0.004;
const WEIGHT: f64 = -0.1;

const SAMPLES: [f64; 2] = [0.001, 0.0014];

/// Plans an interval from a moving object and a moving device, and ends it after `h`.
fn interval(damping: f64, h: f64) -> (Output<f64>, Output<f64>) {
    let contact = Contact::object(STIFFNESS, MASS);
    let params = VirtualDamperParams::new(damping);
    let renderer = Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap();
    let object = ObjectState {
        position: 0.0,
        velocity: 0.05,
    };
    let mut state = renderer.start(object).unwrap();
    let at = |xi: f64| Sample::at(xi).with_virtual_force(WEIGHT);
    renderer.step(&mut state, at(SAMPLES[0]));
    let start = renderer.step(&mut state, at(SAMPLES[1]));
    let end = renderer.step(&mut state, at(SAMPLES[1]).after(h));
    (start, end)
}

/// Fourth-order Runge-Kutta of `M eta'' = f_V + K (xi - eta) + B (v - eta')`.
fn integrated(start: &Output<f64>, damping: f64, h: f64) -> (f64, f64) {
    let (xi, v) = (SAMPLES[1], (SAMPLES[1] - SAMPLES[0]) / PERIOD);
    let acceleration = |eta: f64, velocity: f64| {
        (WEIGHT + STIFFNESS * (xi - eta) + damping * (v - velocity)) / MASS
    };
    let fastest = 200.0 + damping / MASS;
    let steps = (h * fastest * 50.0).ceil().max(2000.0);
    let dt = h / steps;
    let (mut eta, mut velocity) = (start.object_position, start.object_velocity);
    let mut step = 0.0;
    while step < steps {
        let (x1, a1) = (velocity, acceleration(eta, velocity));
        let second = velocity + 0.5 * dt * a1;
        let (x2, a2) = (second, acceleration(eta + 0.5 * dt * x1, second));
        let third = velocity + 0.5 * dt * a2;
        let (x3, a3) = (third, acceleration(eta + 0.5 * dt * x2, third));
        let fourth = velocity + dt * a3;
        let (x4, a4) = (fourth, acceleration(eta + dt * x3, fourth));
        eta += dt / 6.0 * (x1 + 2.0 * (x2 + x3) + x4);
        velocity += dt / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
        step += 1.0;
    }
    (eta, velocity)
}

fn follows_the_integration(damping: f64, tolerance: f64) {
    for h in [PERIOD, 0.3 * PERIOD, 2.5 * PERIOD] {
        let (start, end) = interval(damping, h);
        let (eta, velocity) = integrated(&start, damping, h);
        assert_eq!((start.fault, end.fault), (None, None));
        assert!(
            (end.object_position - eta).abs() <= tolerance
                && (end.object_velocity - velocity).abs() <= 200.0 * tolerance,
            "B = {damping}, h = {h}: {} {}, not {eta} {velocity}",
            end.object_position,
            end.object_velocity
        );
        assert!((eta - start.object_position).abs() > 1e-6, "it moves");
    }
}

#[test]
fn the_under_damped_object_moves_as_integrated() {
    follows_the_integration(0.5, 1e-14);
    follows_the_integration(3.0, 1e-14);
}

#[test]
fn the_critically_damped_object_and_its_neighbours_move_as_integrated() {
    follows_the_integration(CRITICAL, 1e-14);
    for relative in [1e-15, 1e-13, 1e-10, 1e-8, 1e-5] {
        follows_the_integration(CRITICAL * (1.0 - relative), 1e-14);
        follows_the_integration(CRITICAL * (1.0 + relative), 1e-14);
    }
}

#[test]
fn the_over_damped_object_moves_as_integrated() {
    follows_the_integration(10.0, 1e-14);
    follows_the_integration(400.0, 1e-13);
}

#[test]
fn an_object_of_extreme_damping_moves_with_the_device() {
    for damping in [1e6, 1e9] {
        let velocity = (SAMPLES[1] - SAMPLES[0]) / PERIOD;
        let (start, end) = interval(damping, PERIOD);
        assert_eq!((start.fault, end.fault), (None, None));
        let moved = end.object_position - start.object_position;
        assert!(
            (moved - velocity * PERIOD).abs() < 1e-7,
            "B = {damping}: {moved}"
        );
        assert!((end.object_velocity - velocity).abs() < 1e-4);
    }
}

#[test]
fn the_force_feels_the_penetration_velocity_and_the_object_the_device_velocity() {
    let (damping, tolerance) = (0.5, 1e-14);
    let (start, _) = interval(damping, PERIOD);
    // p_0 is the first sample's: the object began at 0.
    let rate = (start.penetration - SAMPLES[0]) / PERIOD;
    let expected = STIFFNESS * start.penetration + damping * rate;
    assert!((start.force_on_object - expected).abs() < tolerance);
    let device = damping * (SAMPLES[1] - SAMPLES[0]) / PERIOD;
    assert!((damping * rate - device).abs() > 0.01, "they differ here");
}

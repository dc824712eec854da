//! The closed form of the relative motion against its own differential equation and laws.

use crate::common::{assert_close, midpoint};
use palpate_testbed::relative_motion::{Passage, RelativeMotion, RelativeState};

fn state(penetration: f64, velocity: f64) -> RelativeState {
    RelativeState {
        penetration,
        velocity,
    }
}

fn over(motion: [f64; 3], from: RelativeState, duration: f64) -> Passage {
    RelativeMotion::new(motion[0], motion[1], motion[2])
        .and_then(|motion| motion.over(from, duration))
        .unwrap()
}

/// Classical Runge-Kutta; the kink at p = 0 costs it an error of third order in the step.
fn runge_kutta(motion: [f64; 3], from: RelativeState, duration: f64, steps: u32) -> RelativeState {
    let [stiffness, mobility, acceleration] = motion;
    let rate = |p: f64| acceleration - stiffness * mobility * p.max(0.0);
    let h = duration / f64::from(steps);
    let (mut p, mut v) = (from.penetration, from.velocity);
    for _ in 0..steps {
        let (p1, v1) = (v, rate(p));
        let (p2, v2) = (v + 0.5 * h * v1, rate(p + 0.5 * h * p1));
        let (p3, v3) = (v + 0.5 * h * v2, rate(p + 0.5 * h * p2));
        let (p4, v4) = (v + h * v3, rate(p + h * p3));
        p += h / 6.0 * (p1 + 2.0 * p2 + 2.0 * p3 + p4);
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    }
    state(p, v)
}

/// (stiffness, mobility, acceleration), state, duration
const CASES: [([f64; 3], RelativeState, f64); 12] = {
    const fn at(penetration: f64, velocity: f64) -> RelativeState {
        RelativeState {
            penetration,
            velocity,
        }
    }
    [
        ([100.0, 20.0, 19.62], at(-0.1, 0.0), 2.0),
        ([400.0, 14.0, 13.81], at(-0.05, 0.3), 2.0),
        ([400.0, 14.0, 13.81], at(-0.05, -0.3), 2.0),
        ([400.0, 14.0, 13.81], at(0.03, 0.5), 1.0),
        ([400.0, 14.0, 13.81], at(0.03, -0.9), 1.0),
        ([100.0, 4.0, 0.0], at(-0.1, 0.4), 1.0),
        ([100.0, 4.0, 0.0], at(0.1, 0.4), 1.0),
        ([100.0, 4.0, -3.0], at(-0.1, 1.4), 1.0),
        ([100.0, 4.0, -3.0], at(0.1, 0.4), 1.0),
        ([100.0, 4.0, 3.0], at(0.008, 0.0), 1.0), // never leaves
        ([100.0, 0.0, -3.0], at(0.1, 0.4), 1.0),  // nothing yields to the contact
        ([1e-9, 1e-3, 2.0], at(-0.1, 0.4), 1.0),  // hardly a contact
    ]
};

#[test]
fn it_solves_its_differential_equation() {
    for (motion, from, duration) in CASES {
        let exact = over(motion, from, duration).state;
        let stepped = runge_kutta(motion, from, duration, 1_000_000);
        assert_close("p", exact.penetration, stepped.penetration, 3e-9);
        assert_close("p'", exact.velocity, stepped.velocity, 3e-8);
    }
}

#[test]
fn energy_is_conserved_for_any_duration() {
    for (motion, from, _) in CASES {
        let [stiffness, mobility, acceleration] = motion;
        let energy = |s: RelativeState| {
            let p = s.penetration.max(0.0);
            0.5 * s.velocity * s.velocity + 0.5 * stiffness * mobility * p * p
                - acceleration * s.penetration
        };
        for duration in [1e-6, 0.01, 0.5, 3.0, 40.0] {
            let after = over(motion, from, duration).state;
            let scale =
                1e-3 + after.velocity * after.velocity + (acceleration * after.penetration).abs();
            assert_close("energy", energy(after), energy(from), 1e-11 * scale);
        }
    }
}

#[test]
fn impulse_is_momentum() {
    for (motion, from, _) in CASES {
        let [_, mobility, acceleration] = motion;
        for duration in [1e-3, 0.01, 0.5, 3.0, 40.0] {
            let after = over(motion, from, duration);
            // y J = a h − Δp′
            let expected = acceleration * duration - (after.state.velocity - from.velocity);
            let scale = 1.0 + (acceleration * duration).abs();
            assert_close("yJ", mobility * after.impulse, expected, 2e-12 * scale);
        }
    }
}

#[test]
fn impulse_and_square_agree_with_a_quadrature_of_the_motion() {
    for (motion, from, duration) in CASES {
        let force = |t: f64| motion[0] * over(motion, from, t).state.penetration.max(0.0);
        let exact = over(motion, from, duration);
        let impulse = midpoint(0.0, duration, 20_000, force);
        let square = midpoint(0.0, duration, 20_000, |t| force(t).powi(2));
        let scale = exact.impulse.abs().max(1e-12);
        assert_close("J", exact.impulse, impulse, 1e-6 * scale);
        let scale = exact.squared_force.abs().max(1e-12);
        assert_close("Q", exact.squared_force, square, 1e-6 * scale);
    }
}

#[test]
fn one_long_step_equals_many_short_ones() {
    for (motion, from, duration) in CASES {
        let long = over(motion, from, duration);
        let (mut now, mut impulse, mut square) = (from, 0.0, 0.0);
        for _ in 0..997 {
            let short = over(motion, now, duration / 997.0);
            now = short.state;
            impulse += short.impulse;
            square += short.squared_force;
        }
        assert_close("p", now.penetration, long.state.penetration, 1e-11);
        assert_close("p'", now.velocity, long.state.velocity, 1e-10);
        assert_close("J", impulse, long.impulse, 1e-11);
        assert_close("Q", square, long.squared_force, 1e-10);
    }
}

#[test]
fn every_collision_has_its_events_and_peak() {
    // A ball on a spring: contact half a turn, speed kept, so all of it is known.
    let (stiffness, mobility, speed) = (100.0, 4.0, 0.4);
    let passage = over([stiffness, mobility, 0.0], state(-0.1, speed), 10.0);
    let [collision] = passage.collisions[..] else {
        panic!("{:?}", passage.collisions)
    };
    let rate = (stiffness * mobility).sqrt();
    assert_close("start", collision.start, 0.25, 1e-15);
    let end = collision.end.unwrap();
    assert_close("end", end, 0.25 + std::f64::consts::PI / rate, 1e-15);
    assert_close(
        "peak",
        collision.peak_force,
        stiffness * speed / rate,
        1e-13,
    );
    assert_close("impulse", collision.impulse, 2.0 * speed / mobility, 1e-15);
    assert_close("speed", collision.impact_speed, speed, 1e-15);

    // The peak is found inside a step, and not found where the step ends before it.
    let quarter = 0.25 + 0.5 * std::f64::consts::PI / rate;
    for (after, expected) in [(0.01, speed / rate), (-0.01, speed / rate * (0.2f64).cos())] {
        let cut = over(
            [stiffness, mobility, 0.0],
            state(-0.1, speed),
            quarter + after,
        );
        assert_eq!(cut.collisions[0].end, None);
        assert_close(
            "peak",
            cut.collisions[0].peak_force,
            stiffness * expected,
            1e-12,
        );
    }
}

#[test]
fn collisions_repeat_with_one_period() {
    let passage = over([400.0, 14.0, 13.81], state(-0.05, 0.0), 100.0);
    let starts: Vec<f64> = passage.collisions.iter().map(|c| c.start).collect();
    assert!(starts.len() > 400, "{}", starts.len());
    let cycle = starts[1] - starts[0];
    for (k, start) in starts.iter().enumerate() {
        assert_close("start", *start, starts[0] + k as f64 * cycle, 1e-10);
    }
}

#[test]
fn grazing_and_rest_are_no_events() {
    // Thrown upwards just high enough: v² = 2 g h.
    let graze = over([100.0, 4.0, -2.0], state(-1.0, 2.0), 5.0);
    assert!(graze.collisions.is_empty());
    // At rest on the surface without force, or pulled away.
    for acceleration in [0.0, -1.0] {
        let rest = over([100.0, 4.0, acceleration], state(0.0, 0.0), 5.0);
        assert!(rest.collisions.is_empty());
        assert_eq!(rest.impulse, 0.0);
    }
    // At rest on the surface and pushed: contact comes back to the surface with no speed and stays.
    let pushed = over([100.0, 4.0, 3.0], state(0.0, 0.0), 50.0);
    assert_eq!(pushed.collisions.len(), 1);
    assert_eq!(pushed.collisions[0].end, None);
    assert_close(
        "peak",
        pushed.collisions[0].peak_force,
        2.0 * 3.0 / 4.0,
        1e-14,
    );
    // In equilibrium.
    let resting = over([100.0, 4.0, 4.0], state(0.01, 0.0), 50.0);
    assert_eq!(resting.state, state(0.01, 0.0));
    assert_close("J", resting.impulse, 50.0, 1e-10);
    assert_close("Q", resting.squared_force, 50.0, 1e-10);
}

#[test]
fn extreme_stiffness_still_conserves_momentum() {
    for exponent in [-200, -12, -3, 3, 9, 12] {
        let stiffness = 10f64.powi(exponent);
        let passage = over([stiffness, 14.0, 13.81], state(-0.05, 0.0), 0.3);
        let expected = 13.81 * 0.3 - passage.state.velocity;
        assert_close("yJ", 14.0 * passage.impulse, expected, 1e-10);
    }
    // From 1 GN/m on, a collision is a reflection with twice the momentum.
    let hard = over([1e12, 14.0, 13.81], state(-0.05, 0.0), 0.1);
    let speed = (2.0 * 13.81f64 * 0.05).sqrt();
    assert_close("J", hard.impulse, 2.0 * speed / 14.0, 1e-6);
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let motion = RelativeMotion::new(1e12, 1.0, 1.0).unwrap();
    assert_eq!(
        motion.over(state(0.0, 0.0), 1e3).unwrap_err().name,
        "duration"
    );
    assert_eq!(
        motion.over(state(0.0, 0.0), -1.0).unwrap_err().name,
        "duration"
    );
    assert_eq!(
        motion.over(state(f64::NAN, 0.0), 1.0).unwrap_err().name,
        "penetration"
    );
    assert_eq!(
        RelativeMotion::new(0.0, 1.0, 1.0).unwrap_err().name,
        "stiffness"
    );
    assert_eq!(
        RelativeMotion::new(1.0, f64::INFINITY, 1.0)
            .unwrap_err()
            .name,
        "mobility"
    );
}

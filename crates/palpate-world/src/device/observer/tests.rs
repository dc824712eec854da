use super::*;

fn constant(mean: f64) -> AxisForce {
    AxisForce {
        mean,
        lead: 0.0,
        impulse_deviation: 0.0,
        bias: 0.0,
        bias_lead: 0.0,
        share: 1.0,
    }
}

fn some_motion() -> AxisMotion {
    AxisMotion {
        offset: 1e-6,
        velocity: 0.13,
        external: -7.0,
        mobility: 8.0,
        damping_rate: 17.0,
        spring_rate: 900.0,
    }
}

/// Comparison with many small steps of the same equations.
#[test]
fn the_motion_is_that_of_a_hand_with_spring_and_damper() {
    let (motion, force, h) = (some_motion(), 1.5, 0.004);
    let change = motion.under(&constant(force), h);
    let (mut x, mut u, mut a) = (0.0, motion.velocity, motion.external);
    let steps = 100_000;
    let step = h / f64::from(steps);
    for _ in 0..steps {
        let before = (u, a + motion.mobility * force);
        let middle = (
            u + 0.5 * step * before.1,
            before.1
                - 0.5 * step * (motion.damping_rate * before.1 + motion.spring_rate * before.0),
        );
        x += step * middle.0;
        u += step * middle.1;
        a -= step * (motion.damping_rate * middle.1 + motion.spring_rate * middle.0);
    }
    assert!((change.travel - x).abs() < 1e-12, "{} {x}", change.travel);
    assert!((change.gained - (u - motion.velocity)).abs() < 1e-9);
    assert!((change.external - (a - motion.external)).abs() < 1e-4);
}

#[test]
fn the_transition_is_the_derivative_of_the_motion() {
    let (motion, force, h) = (some_motion(), -2.0, 0.004);
    let rows = motion.transition(&constant(force), h);
    let end = |motion: &AxisMotion| {
        let change = motion.under(&constant(force), h);
        [
            motion.offset + change.travel,
            motion.velocity + change.gained,
            motion.external + change.external,
        ]
    };
    let steps = [1e-6, 1e-4, 1e-3, 1e-4, 1e-3, 1e-2];
    for (state, step) in steps.into_iter().enumerate() {
        let moved = |by: f64| {
            let mut moved = motion;
            let places = [
                &mut moved.offset,
                &mut moved.velocity,
                &mut moved.external,
                &mut moved.mobility,
                &mut moved.damping_rate,
                &mut moved.spring_rate,
            ];
            *places[state] += by;
            end(&moved)
        };
        let [more, less] = [moved(step), moved(-step)];
        for row in 0..3 {
            let slope = (more[row] - less[row]) / (2.0 * step);
            let model = rows[row][state];
            assert!(
                (slope - model).abs() < 1e-6 * model.abs().max(1e-3),
                "{row} {state}: {slope} {model}"
            );
        }
    }
}

/// A hand with spring and damper and a device with wrong model mass, under known forces: the observer estimates all
/// three.
#[test]
fn mass_damping_and_stiffness_are_learned_from_forces() {
    let mut real = AxisMotion {
        offset: 0.0,
        velocity: 0.0,
        external: 0.0,
        mobility: 6.0,
        damping_rate: 12.0,
        spring_rate: 800.0,
    };
    let from = AxisPrior::new(0.25, 1e-6, Prior::default());
    let (mut observer, h) = (AxisObserver::new(&from), 0.001);
    let (mut place, mut measured) = (0.0, 0.0);
    for sample in 0..4000_u32 {
        let force = if sample / 37 % 2 == 0 { 1.0 } else { -1.0 };
        let change = real.under(&constant(force), h);
        place += change.travel;
        real.velocity += change.gained;
        real.external += change.external;
        let now = (place / 1e-6_f64).round() * 1e-6;
        observer.see(&from, now - measured, &constant(force), h);
        measured = now;
    }
    let found = observer.motion;
    assert!((found.mobility / 6.0 - 1.0).abs() < 0.02, "{found:?}");
    assert!((found.damping_rate / 12.0 - 1.0).abs() < 0.2, "{found:?}");
    assert!((found.spring_rate / 800.0 - 1.0).abs() < 0.2, "{found:?}");
}

/// Returns the root mean square error of the velocity `[m/s]` for a device swung by a hand and a sensor with 5 um of
/// noise. The observer is given a quantum.
fn velocity_off(quantum: f64) -> f64 {
    let (from, h) = (AxisPrior::new(0.25, quantum, Prior::default()), 0.001);
    let mut observer = AxisObserver::new(&from);
    let (mut state, mut measured, mut square) = (1_u64, 0.0, 0.0);
    for sample in 1..2000_u32 {
        let t = f64::from(sample) * h;
        // Sums of twelve numbers of a linear congruential generator are nearly normal.
        let mut noise = -6.0;
        for _ in 0..12 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            noise += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        let now = 0.05 * (6.0 * t).sin() + 5e-6 * noise;
        observer.see(&from, now - measured, &constant(0.0), h);
        measured = now;
        if sample >= 1000 {
            square += (observer.motion.velocity - 0.3 * (6.0 * t).cos()).powi(2);
        }
    }
    (square / 1000.0_f64).sqrt()
}

/// The observer has settled on a device at rest; then the hand swings it at 100 Hz, at up to 0.12 m/s.
#[test]
fn a_hand_that_has_rested_is_followed() {
    let (h, quantum, rest) = (0.01, 2e-6, 200);
    let from = AxisPrior::new(0.25, quantum, Prior::default());
    let mut observer = AxisObserver::new(&from);
    let (mut measured, mut off) = (0.0, 0.0_f64);
    for sample in 1..rest + 100 {
        let t = f64::from(sample.max(rest) - rest) * h;
        let now = quantum * (0.006 * (1.0 - (20.0 * t).cos()) / quantum).round();
        observer.see(&from, now - measured, &constant(0.0), h);
        measured = now;
        if sample == rest {
            assert!(observer.jerk_variance < 0.01 * from.prior.jerk.powi(2));
        }
        if sample > rest + 3 {
            off = off.max((observer.motion.velocity - 0.12 * (20.0 * t).sin()).abs());
        }
    }
    assert!(off < 0.005, "{off:e} m/s");
}

#[test]
fn unmodelled_noise_raises_velocity_error_by_less_than_ten_percent() {
    let (model, unmodelled) = (velocity_off(5e-6 * 12_f64.sqrt()), velocity_off(0.0));
    assert!(
        unmodelled < 1.1 * model,
        "{unmodelled:e} m/s, told {model:e} m/s"
    );
}

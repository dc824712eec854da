//! Every hand against a fine Runge-Kutta integration written here, and against passivity.

use std::f64::consts::TAU;
use std::sync::Arc;

use palpate_testbed::device::DevicePlant;
use palpate_testbed::hand::{Hand, IntendedPath, Intention, Sinusoid};
use palpate_testbed::held_mass::HeldMass;
use palpate_testbed::recorded_path::RecordedPath;

const MASS: f64 = 0.1;
const VISCOUS: f64 = 0.15;

fn assert_close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!(
        (a - b).abs() <= tolerance,
        "{what}: {a} and {b}, {:e}",
        a - b
    );
}

/// Position, velocity, ∫ u v dt and ∫ B v² dt after `duration`, for a force u(t, x, v) on a moved
/// mass.
fn runge_kutta(
    moved_mass: f64,
    start: (f64, f64),
    held: f64,
    duration: f64,
    hand: impl Fn(f64, f64, f64) -> f64,
) -> [f64; 4] {
    let steps = 40_000;
    let h = duration / f64::from(steps);
    let rate = |t: f64, y: [f64; 4]| {
        let u = hand(t, y[0], y[1]);
        let acceleration = (u - VISCOUS * y[1] - held) / moved_mass;
        [y[1], acceleration, u * y[1], VISCOUS * y[1] * y[1]]
    };
    let add = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let mut y = [start.0, start.1, 0.0, 0.0];
    for i in 0..steps {
        let t = f64::from(i) * h;
        let k1 = rate(t, y);
        let k2 = rate(t + 0.5 * h, add(y, k1, 0.5 * h));
        let k3 = rate(t + 0.5 * h, add(y, k2, 0.5 * h));
        let k4 = rate(t + h, add(y, k3, h));
        y = std::array::from_fn(|j| y[j] + h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]));
    }
    y
}

/// Compares a device that takes 0.8 s in one advance with the integration above.
fn agrees_with_runge_kutta(hand: Hand, what: &str, force: impl Fn(f64, f64, f64) -> f64) {
    let mut device = HeldMass::new(MASS, hand)
        .and_then(|device| device.with_friction(VISCOUS, 0.0))
        .and_then(|device| device.starting_at(0.015, -0.2))
        .unwrap();
    let expected = runge_kutta(device.moved_mass(), (0.015, -0.2), 0.4, 0.8, force);
    let work = device.advance(0.4, 0.8);
    assert_close(device.position(), expected[0], 1e-11, what);
    assert_close(device.velocity(), expected[1], 1e-10, what);
    assert_close(device.accounts().hand_work, expected[2], 1e-10, what);
    assert_close(device.accounts().friction_loss, expected[3], 1e-10, what);
    assert_close(work, 0.4 * (expected[0] - 0.015), 1e-11, what);
}

#[test]
fn a_constant_force_with_tremor() {
    let tremor = Sinusoid {
        amplitude: 0.5,
        frequency_hz: 10.0,
        phase: 0.7,
    };
    let hand = Hand::ConstantForce {
        force: 0.3,
        tremor: Some(tremor),
    };
    agrees_with_runge_kutta(hand, "constant force", |t, _, _| {
        0.3 + 0.5 * (TAU * 10.0 * t + 0.7).sin()
    });
}

#[test]
fn an_impedance_in_every_regime_of_damping() {
    let hand_mass = 0.06;
    let critical = |stiffness: f64| 2.0 * (stiffness * (MASS + hand_mass)).sqrt() - VISCOUS;
    for (what, stiffness, damping) in [
        ("no hand", 0.0, 0.0),
        ("damper only", 0.0, 2.0),
        ("spring only", 400.0, 0.0),
        ("underdamped", 400.0, 2.0),
        ("just under critical", 400.0, critical(400.0) - 1e-9),
        ("critical", 400.0, critical(400.0)),
        ("just over critical", 400.0, critical(400.0) + 1e-9),
        ("overdamped", 400.0, 90.0),
        ("very soft", 1e-9, 1.0),
        ("very weakly damped", 400.0, 1e-9),
    ] {
        let hand = Hand::Impedance {
            mass: hand_mass,
            stiffness,
            damping,
            intention: Intention {
                path: IntendedPath::Sinusoid {
                    centre: 0.02,
                    swing: Sinusoid {
                        amplitude: 0.03,
                        frequency_hz: 1.3,
                        phase: -0.4,
                    },
                },
                tremor: Some(Sinusoid {
                    amplitude: 5e-4,
                    frequency_hz: 8.0,
                    phase: 0.1,
                }),
            },
            force: 0.25,
            tremor: Some(Sinusoid {
                amplitude: 0.2,
                frequency_hz: 11.0,
                phase: 2.0,
            }),
        };
        agrees_with_runge_kutta(hand, what, |t, x, v| {
            let (a, b, c) = (
                TAU * 1.3 * t - 0.4,
                TAU * 8.0 * t + 0.1,
                TAU * 11.0 * t + 2.0,
            );
            let aim = 0.02 + 0.03 * a.sin() + 5e-4 * b.sin();
            let aim_rate = 0.03 * TAU * 1.3 * a.cos() + 5e-4 * TAU * 8.0 * b.cos();
            0.25 + stiffness * (aim - x) + damping * (aim_rate - v) + 0.2 * c.sin()
        });
    }
}

/// A tremor at the frequency of an undamped hand, where the particular solution has no bound.
#[test]
fn resonance_grows_with_time_as_the_textbook_says() {
    let stiffness = 300.0_f64;
    let rate = (stiffness / MASS).sqrt();
    for detuning in [0.0, 1e-12, 1e-7] {
        let hand = Hand::Impedance {
            mass: 0.0,
            stiffness,
            damping: 0.0,
            intention: Intention::constant(0.0),
            force: 0.0,
            tremor: Some(Sinusoid {
                amplitude: 0.1,
                frequency_hz: rate * (1.0 + detuning) / TAU,
                phase: 0.0,
            }),
        };
        let mut device = HeldMass::new(MASS, hand).unwrap();
        let time = 2.0;
        device.advance(0.0, time);
        let (sine, cosine) = (rate * time).sin_cos();
        let expected = 0.1 / (2.0 * MASS * rate * rate) * (sine - rate * time * cosine);
        let tolerance = 1e-13 + detuning * 1.0;
        assert_close(device.position(), expected, tolerance, "resonance");
    }
}

#[test]
fn a_recorded_intention_bends_at_its_samples() {
    let times = [0.1, 0.25, 0.3, 0.301, 0.6];
    let positions = [0.0, 0.03, -0.01, 0.0, 0.02];
    let path = RecordedPath::new(&times, &positions).unwrap();
    let hand = Hand::Impedance {
        mass: 0.05,
        stiffness: 250.0,
        damping: 1.5,
        intention: Intention {
            path: IntendedPath::Recorded(Arc::new(path)),
            tremor: None,
        },
        force: 0.0,
        tremor: None,
    };
    let mut whole = HeldMass::new(MASS, hand.clone())
        .and_then(|device| device.with_friction(VISCOUS, 0.0))
        .unwrap();
    let (mut cut, mut apart) = (whole.clone(), whole.clone());
    whole.advance(0.0, 0.8);
    for _ in 0..1000 {
        cut.advance(0.0, 8e-4);
    }
    assert_close(whole.position(), cut.position(), 1e-14, "cut in pieces");
    assert_close(whole.velocity(), cut.velocity(), 1e-12, "cut in pieces");
    assert_close(
        whole.accounts().hand_work,
        cut.accounts().hand_work,
        1e-13,
        "cut in pieces",
    );

    // Runge-Kutta from bend to bend, since it is not of fourth order across one.
    let mut state = (0.0, 0.0);
    let bends = [0.0, 0.1, 0.25, 0.3, 0.301, 0.6, 0.8];
    let aims = [0.0, 0.0, 0.03, -0.01, 0.0, 0.02, 0.02];
    for i in 0..6 {
        let span = bends[i + 1] - bends[i];
        let slope = (aims[i + 1] - aims[i]) / span;
        let y = runge_kutta(MASS + 0.05, state, 0.0, span, |t, x, v| {
            250.0 * (aims[i] + slope * t - x) + 1.5 * (slope - v)
        });
        state = (y[0], y[1]);
        apart.advance(0.0, span);
        assert_close(apart.position(), state.0, 1e-12, "Runge-Kutta");
        assert_close(apart.velocity(), state.1, 1e-11, "Runge-Kutta");
    }
    assert_close(whole.position(), state.0, 1e-12, "Runge-Kutta");
    // Long after the recording the hand rests at its end.
    whole.advance(0.0, 20.0);
    assert_close(whole.position(), 0.02, 1e-12, "rest");
}

/// SplitMix64, for random forces.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Energy drawn from a hand at the device's handle, ∫ (u − m_h x″) x′ dt, by quadrature of states
/// that the device passes through, and the most it may be.
fn drawn_energy(stiffness: f64, damping: f64, pumping: f64, seed: u64) -> (f64, f64) {
    let (hand_mass, aim) = (0.08, 0.02);
    let hand = Hand::Impedance {
        mass: hand_mass,
        stiffness,
        damping,
        intention: Intention::constant(aim),
        force: pumping,
        tremor: None,
    };
    let mut device = HeldMass::new(MASS, hand)
        .and_then(|device| device.with_friction(0.0, 0.2))
        .and_then(|device| device.starting_at(-0.01, 0.3))
        .unwrap();
    let stored = |x: f64, v: f64| 0.5 * stiffness * (aim - x) * (aim - x) + 0.5 * hand_mass * v * v;
    let initial = stored(device.position(), device.velocity());
    let mut numbers = seed;
    let (mut drawn, mut most) = (0.0, f64::NEG_INFINITY);
    for _ in 0..300 {
        let force = 6.0 * (random(&mut numbers) - 0.5);
        let held_for = 0.03 * random(&mut numbers);
        let mut time = 0.0;
        while time < held_for {
            time += 5e-4;
            // Simpson's rule on u v, with u from its definition at the device's states.
            let power = |device: &HeldMass| {
                let (x, v) = (device.position(), device.velocity());
                (stiffness * (aim - x) - damping * v + pumping) * v
            };
            let (first, speed) = (power(&device), device.velocity());
            device.advance(force, 2.5e-4);
            let middle = power(&device);
            device.advance(force, 2.5e-4);
            let muscles = 5e-4 / 6.0 * (first + 4.0 * middle + power(&device));
            let inertia = 0.5 * hand_mass * (device.velocity().powi(2) - speed * speed);
            drawn += muscles - inertia;
            most = f64::max(most, drawn);
        }
    }
    // The device's own account of the muscles, and this one.
    let kinetic = |v: f64| 0.5 * hand_mass * v * v;
    assert_close(
        device.accounts().hand_work - (kinetic(device.velocity()) - kinetic(0.3)),
        drawn,
        1e-4 * (1.0 + drawn.abs()),
        "hand work",
    );
    (most, initial)
}

#[test]
fn no_more_can_be_drawn_from_a_hand_than_was_stored_in_it() {
    for (stiffness, damping) in [(0.0, 3.0), (300.0, 0.0), (300.0, 4.0), (300.0, 60.0)] {
        for seed in 0..20 {
            let (most, initial) = drawn_energy(stiffness, damping, 0.0, seed);
            assert!(
                most <= initial + 1e-4,
                "{stiffness}, {damping}, {seed}: {most} of {initial}"
            );
        }
    }
    // Negative control: a hand that also pushes has more to give.
    let beyond = (0..20).any(|seed| {
        let (most, initial) = drawn_energy(0.0, 0.3, 2.0, seed);
        most > initial + 1e-3
    });
    assert!(beyond);
}

#[test]
fn a_bad_hand_is_refused_by_the_name_of_its_parameter() {
    let name = |hand: Hand| HeldMass::new(MASS, hand).unwrap_err().name;
    let still = Sinusoid {
        amplitude: 1.0,
        frequency_hz: 0.0,
        phase: 0.0,
    };
    let tremor = |tremor| Hand::ConstantForce {
        force: 0.0,
        tremor: Some(tremor),
    };
    assert_eq!(name(Hand::pushing(f64::INFINITY)), "hand.force");
    assert_eq!(name(tremor(still)), "frequency_hz");
    assert_eq!(
        name(tremor(Sinusoid {
            amplitude: f64::NAN,
            ..still
        })),
        "hand.tremor.amplitude"
    );
    let impedance = |mass: f64, damping: f64, aim: f64| Hand::Impedance {
        mass,
        stiffness: 1.0,
        damping,
        intention: Intention::constant(aim),
        force: 0.0,
        tremor: None,
    };
    assert_eq!(name(impedance(-0.1, 0.0, 0.0)), "hand.mass");
    assert_eq!(name(impedance(0.0, f64::NAN, 0.0)), "hand.damping");
    assert_eq!(name(impedance(0.0, 0.0, f64::NAN)), "intention");
}

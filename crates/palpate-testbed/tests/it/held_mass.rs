//! The held mass between its events and at them: friction, stick and slip, and the accounts.

use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::hand::{Hand, IntendedPath, Intention, Sinusoid};
use palpate_testbed::held_mass::HeldMass;

fn spring(stiffness: f64, damping: f64, intention: Intention) -> Hand {
    Hand::Impedance {
        mass: 0.05,
        stiffness,
        damping,
        intention,
        force: 0.0,
        tremor: None,
    }
}

fn swing(amplitude: f64, frequency_hz: f64) -> Intention {
    Intention {
        path: IntendedPath::Sinusoid {
            centre: 0.01,
            swing: Sinusoid {
                amplitude,
                frequency_hz,
                phase: 0.3,
            },
        },
        tremor: None,
    }
}

/// A device whose hand drives it through stick and slip many times a second.
fn sticking_and_slipping() -> HeldMass {
    let hand = Hand::Impedance {
        mass: 0.05,
        stiffness: 200.0,
        damping: 1.0,
        intention: Intention {
            path: swing(0.03, 1.5).path,
            tremor: Some(Sinusoid {
                amplitude: 1e-3,
                frequency_hz: 9.0,
                phase: -1.0,
            }),
        },
        force: 0.2,
        tremor: Some(Sinusoid {
            amplitude: 0.3,
            frequency_hz: 7.0,
            phase: 0.0,
        }),
    };
    HeldMass::new(0.1, hand)
        .and_then(|device| device.with_friction(0.2, 0.8))
        .unwrap()
}

fn assert_close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} and {b}: {:e}", a - b);
}

#[test]
fn without_friction_a_constant_force_gives_the_point_mass_bit_for_bit() {
    let mut point = PointMass::new(0.3, 0.981)
        .and_then(|device| device.starting_at(0.02, -0.3))
        .unwrap();
    let mut held = HeldMass::new(0.3, Hand::pushing(0.981))
        .and_then(|device| device.starting_at(0.02, -0.3))
        .unwrap();
    for i in 0..1000 {
        let force = f64::from(i * 7 % 23) * 0.31 - 2.0;
        let duration = f64::from(i * 5 % 17 + 1) * 1.7e-4;
        assert_eq!(
            held.advance(force, duration),
            point.advance(force, duration)
        );
        assert_eq!(held.position(), point.position());
        assert_eq!(held.velocity(), point.velocity());
    }
    assert_eq!(held.stored_energy(), point.stored_energy());
}

#[test]
fn a_lossless_hand_keeps_its_energy_in_long_steps_and_in_short_ones() {
    let device = HeldMass::new(0.1, spring(300.0, 0.0, Intention::constant(0.02)))
        .and_then(|device| device.starting_at(0.0, 0.4))
        .unwrap();
    let before = device.stored_energy();
    let mut ends = Vec::new();
    for steps in [3, 10_000, 1_000_000] {
        let mut device = device.clone();
        for _ in 0..steps {
            assert_eq!(device.advance(0.0, 10.0 / f64::from(steps)), 0.0);
        }
        let drift = device.stored_energy() / before - 1.0;
        assert!(drift.abs() < 1e-9, "{steps} steps: {drift:e}");
        ends.push((device.position(), device.velocity()));
    }
    for end in &ends[1..] {
        assert_close(end.0, ends[0].0, 1e-11);
        assert_close(end.1, ends[0].1, 1e-9);
    }
    // The harmonic itself, written apart.
    let rate = (300.0_f64 / 0.15).sqrt();
    let (sine, cosine) = (10.0 * rate).sin_cos();
    assert_close(ends[0].0, 0.02 - 0.02 * cosine + 0.4 / rate * sine, 1e-12);
}

#[test]
fn at_rest_below_the_friction_level_nothing_ever_moves() {
    let hand = Hand::ConstantForce {
        force: 0.3,
        tremor: Some(Sinusoid {
            amplitude: 0.4,
            frequency_hz: 8.0,
            phase: 0.0,
        }),
    };
    let resting = HeldMass::new(0.1, hand)
        .and_then(|device| device.starting_at(0.123, 0.0))
        .unwrap();
    let mut stuck = resting.clone().with_friction(0.1, 1.0).unwrap();
    for i in 0..1_000_000 {
        // 0.3 + 0.4 + 0.29 N in one direction, 0.4 - 0.3 + 0.29 N in the other.
        let force = if i % 3 == 0 { 0.29 } else { -0.29 };
        assert_eq!(stuck.advance(force, 1e-5), 0.0);
    }
    assert_eq!((stuck.position(), stuck.velocity()), (0.123, 0.0));
    assert_eq!(stuck.accounts().friction_loss, 0.0);
    assert_close(stuck.time(), 10.0, 1e-14);

    let mut weaker = resting.with_friction(0.1, 0.65).unwrap();
    weaker.advance(0.0, 0.1);
    assert!(weaker.position() > 0.123);
}

#[test]
fn a_sliding_mass_stops_where_the_textbook_says_and_stays() {
    let (mass, friction, speed) = (0.2, 0.5, -0.7);
    let mut device = HeldMass::new(mass, Hand::pushing(0.0))
        .and_then(|device| device.with_friction(0.0, friction))
        .and_then(|device| device.starting_at(0.0, speed))
        .unwrap();
    let stop = mass * speed * speed / (2.0 * friction);
    device.advance(0.0, 100.0);
    assert_close(device.position(), -stop, 1e-16);
    assert_eq!(device.velocity(), 0.0);
    assert_close(device.accounts().friction_loss, friction * stop, 1e-16);

    // A push above the level turns it round at once, and it slides against the friction.
    let mut turned = device.clone();
    turned.advance(-0.9, 0.1);
    assert_close(
        turned.position() - device.position(),
        0.5 * 0.4 / mass * 0.01,
        1e-15,
    );
}

/// Dry friction takes 2 F_c/k from the amplitude in every half swing.
#[test]
fn dry_friction_ends_a_swing_step_by_step() {
    let (stiffness, friction) = (150.0, 0.3);
    let hand = spring(stiffness, 0.0, Intention::constant(0.0));
    let step = 2.0 * friction / stiffness;
    let mut device = HeldMass::new(0.1, hand)
        .and_then(|device| device.with_friction(0.0, friction))
        .and_then(|device| device.starting_at(10.3 * step, 0.0))
        .unwrap();
    let half_swing = std::f64::consts::PI * (0.15_f64 / stiffness).sqrt();
    for i in 1..=10 {
        device.advance(0.0, half_swing);
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        assert_close(
            device.position(),
            side * (10.3 - f64::from(i)) * step,
            1e-14,
        );
    }
    // 0.3 steps from the centre, the spring is below the friction.
    device.advance(0.0, 1e3);
    assert_close(device.position(), 0.3 * step, 1e-14);
    assert_eq!(device.velocity(), 0.0);
}

#[test]
fn break_away_waits_for_the_instant_at_which_the_hand_exceeds_the_friction() {
    // 2 sin(2π t) N reaches 1 N after a twelfth of a second.
    let hand = Hand::ConstantForce {
        force: 0.0,
        tremor: Some(Sinusoid {
            amplitude: 2.0,
            frequency_hz: 1.0,
            phase: 0.0,
        }),
    };
    let mut device = HeldMass::new(0.5, hand)
        .and_then(|device| device.with_friction(0.0, 1.0))
        .unwrap();
    device.advance(0.0, 1.0 / 12.0);
    assert_close(device.position(), 0.0, 1e-30);
    let after = 0.05;
    device.advance(0.0, after);
    // m x″ = 2 sin(ωt) − 1 from there on, integrated twice by hand.
    let rate = std::f64::consts::TAU;
    let (from, to) = (rate / 12.0, rate / 12.0 + rate * after);
    let expected = 2.0 / (rate * rate) * (from.sin() - to.sin()) + 2.0 / rate * from.cos() * after
        - 0.5 * after * after;
    assert_close(device.position(), expected / 0.5, 1e-15);
}

/// The crest of the tremor is above the friction by round-off, and falls back at once.
#[test]
fn a_push_that_only_touches_the_friction_level_is_no_slide_and_takes_no_time() {
    for friction in [1.0, 1.0 - 1.2e-16, 1.0 - 4e-16, 1.0 - 1e-14] {
        let hand = Hand::ConstantForce {
            force: 0.0,
            tremor: Some(Sinusoid {
                amplitude: 1.0,
                frequency_hz: 5.0,
                phase: std::f64::consts::FRAC_PI_2,
            }),
        };
        let mut device = HeldMass::new(0.1, hand)
            .and_then(|device| device.with_friction(0.0, friction))
            .unwrap();
        for _ in 0..100 {
            device.advance(0.0, 0.1);
        }
        assert!(!device.gave_up());
        assert_close(device.position(), 0.0, 1e-18);
    }
}

#[test]
fn one_advance_is_a_thousand_advances_through_stick_and_slip() {
    let mut whole = sticking_and_slipping();
    let mut cut = whole.clone();
    let (mut at_rest, mut moving) = (0, 0);
    for force in [0.0, 0.5, -0.7, 0.1] {
        let work = whole.advance(force, 1.0);
        let pieces: f64 = (0..1000)
            .map(|_| {
                let work = cut.advance(force, 1e-3);
                if cut.velocity() == 0.0 {
                    at_rest += 1;
                } else {
                    moving += 1;
                }
                work
            })
            .sum();
        assert_close(whole.position(), cut.position(), 1e-12);
        assert_close(whole.velocity(), cut.velocity(), 1e-12);
        assert_close(work, pieces, 1e-12);
        assert_close(
            whole.accounts().friction_loss,
            cut.accounts().friction_loss,
            1e-12,
        );
        assert_close(whole.accounts().hand_work, cut.accounts().hand_work, 1e-12);
    }
    assert!(at_rest > 100 && moving > 100, "{at_rest}, {moving}");
    assert!(!whole.gave_up());
}

#[test]
fn ledger_closes_with_independently_integrated_accounts() {
    for step in [1e-5, 1e-3, 0.37] {
        let mut device = sticking_and_slipping().starting_at(0.0, 0.2).unwrap();
        let before = device.kinetic_energy();
        let mut time = 0.0;
        let mut returned = 0.0;
        let mut i = 0;
        while time < 4.0 {
            returned += device.advance(f64::from(i * 7 % 11) * 0.2 - 1.0, step);
            time += step;
            i += 1;
        }
        let accounts = device.accounts();
        assert!(accounts.friction_loss > 0.05, "{accounts:?}");
        assert_close(accounts.port_work, returned, 1e-12);
        assert_close(
            device.kinetic_energy() - before,
            accounts.hand_work - accounts.friction_loss - accounts.port_work,
            1e-12,
        );
    }
}

#[test]
fn the_motor_gives_no_more_than_it_can() {
    let free = HeldMass::new(0.1, Hand::pushing(0.0)).unwrap();
    let mut weak = free.clone().with_largest_force(2.0).unwrap();
    let mut strong = free;
    let expected = strong.advance(2.0, 0.1);
    assert_eq!(weak.advance(50.0, 0.1), expected);
    assert_eq!(weak.position(), strong.position());
    assert_eq!(weak.given_force(-3.0), -2.0);
    assert_eq!(weak.given_force(1.5), 1.5);
    assert_eq!(weak.accounts().port_work, expected);
}

#[test]
fn parameters_far_from_any_device_end_in_finite_time_with_finite_numbers() {
    let hand = spring(1e10, 0.0, swing(1.0, 1e5));
    let mut device = HeldMass::new(1e-3, hand)
        .and_then(|device| device.with_friction(0.0, 1e3))
        .unwrap();
    let work = device.advance(1.0, 1e6);
    assert!(device.gave_up());
    assert!(work.is_finite() && device.position().is_finite() && device.velocity().is_finite());
    assert_eq!(device.time(), 1e6);
    for duration in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let before = device.clone();
        assert_eq!(device.advance(1.0, duration), 0.0);
        assert_eq!(device, before);
    }
}

#[test]
fn a_rejected_parameter_is_named() {
    let free = HeldMass::new(0.1, Hand::pushing(0.0)).unwrap();
    let hand = spring(-1.0, 0.0, Intention::constant(0.0));
    assert_eq!(HeldMass::new(0.1, hand).unwrap_err().name, "hand.stiffness");
    assert_eq!(
        HeldMass::new(0.0, Hand::pushing(0.0)).unwrap_err().name,
        "mass"
    );
    // Millions of spans in a period.
    let light = HeldMass::new(1e-9, spring(0.0, 1e6, Intention::constant(0.0))).unwrap_err();
    assert_eq!((light.name, light.value), ("mass", 1e-9));
    let light = HeldMass::new(1e-9, Hand::pushing(0.0)).unwrap();
    assert_eq!(light.with_friction(1.0, 0.0).unwrap_err().name, "mass");
    assert_eq!(
        free.clone().with_friction(0.0, f64::NAN).unwrap_err().name,
        "coulomb_friction"
    );
    assert_eq!(
        free.clone().with_friction(-1.0, 0.0).unwrap_err().name,
        "viscous_friction"
    );
    assert_eq!(
        free.with_largest_force(0.0).unwrap_err().name,
        "largest_force"
    );
}

/// SplitMix64: 0 in one of seven cases, otherwise spread over the decades from `least` to `most`.
fn random(state: &mut u64, least: f64, most: f64) -> f64 {
    let mut unit = || {
        *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    if unit() < 1.0 / 7.0 {
        0.0
    } else {
        least * (most / least).powf(unit())
    }
}

#[test]
fn random_hand_motion_with_friction_can_be_split_and_its_ledger_closes() {
    let mut state = 1;
    for case in 0..1000 {
        let mut random = |least, most| random(&mut state, least, most);
        let force = random(0.01, 3.0);
        let frequency_hz = 0.1 + random(0.1, 12.0);
        let hand = Hand::Impedance {
            mass: random(1e-3, 1.0),
            stiffness: random(1.0, 2000.0),
            damping: random(1e-3, 50.0),
            intention: swing(random(1e-4, 0.05), frequency_hz),
            force,
            tremor: Some(Sinusoid {
                amplitude: random(1e-3, 2.0),
                frequency_hz: 4.0 + frequency_hz,
                phase: 0.0,
            }),
        };
        let mut whole = HeldMass::new(0.05, hand)
            .and_then(|device| device.with_friction(random(1e-3, 5.0), random(1e-3, 3.0)))
            .and_then(|device| device.starting_at(0.0, random(0.01, 1.0)))
            .unwrap();
        let mut cut = whole.clone();
        let before = whole.kinetic_energy();
        for held in [force, -0.1, force, 0.3] {
            whole.advance(held, 0.5);
            for _ in 0..50 {
                cut.advance(held, 0.01);
            }
        }
        let accounts = whole.accounts();
        let turnover = before
            + accounts.friction_loss
            + accounts.hand_work.abs()
            + accounts.port_work.abs()
            + 1e-3;
        let gained = accounts.hand_work - accounts.friction_loss - accounts.port_work;
        let gap = (whole.kinetic_energy() - before - gained).abs() / turnover;
        assert!(gap < 1e-12, "case {case}: {gap:e}");
        let apart = (whole.position() - cut.position()).abs() / (1e-3 + whole.position().abs());
        assert!(apart < 1e-11, "case {case}: {apart:e}");
        assert!(!whole.gave_up() && !cut.gave_up());
    }
}

#[test]
fn released_device_moves_as_without_hand() {
    let release = 0.123;
    let mut whole = sticking_and_slipping().released_at(release).unwrap();
    let mut first = sticking_and_slipping();
    let before = whole.kinetic_energy();
    let step = 0.0017; // the release lies within one
    let mut worked = 0.0;
    for _ in 0..300 {
        worked += whole.advance(0.1, step);
    }
    // The same in two parts: in the hand, then without it from where that ended.
    first.advance(0.1, release);
    let mut rest = HeldMass::new(0.1, Hand::pushing(0.0))
        .and_then(|device| device.with_friction(0.2, 0.8))
        .and_then(|device| device.starting_at(first.position(), first.velocity()))
        .unwrap();
    assert!(first.velocity().abs() > 1e-3, "it moves when it is let go");
    rest.advance(0.1, 300.0 * step - release);
    assert_close(whole.position(), rest.position(), 1e-12);
    assert_close(whole.velocity(), rest.velocity(), 1e-12);
    assert_eq!(
        (whole.moved_mass(), whole.hand()),
        (0.1, &Hand::pushing(0.0))
    );
    // The accounts still explain the kinetic energy, the hand's own share included.
    let accounts = whole.accounts();
    assert_close(accounts.port_work, worked, 1e-15);
    let explained = accounts.hand_work - accounts.friction_loss - accounts.port_work;
    assert_close(whole.kinetic_energy() - before, explained, 1e-12);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let error = sticking_and_slipping().released_at(bad).unwrap_err();
        assert_eq!(error.name, "release");
    }
}

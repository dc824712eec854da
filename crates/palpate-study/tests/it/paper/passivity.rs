//! Which device damping makes sustained contact passive.

use palpate_core::{AnyParams, HfcrParams, ObjectState, Phase};

use crate::common::Random;
use crate::paper::trial::{Case, Trial};

const STEP: f64 = 1e-3;

/// Sum of the leaks and of the squared displacements over a motion that stays 0.1 m deep inside an
/// object in equilibrium.
fn leak_and_squares(case: &Case, displacements: &[f64]) -> (f64, f64) {
    let depth = 0.1;
    let case = Case {
        virtual_force: -case.stiffness * depth,
        object: ObjectState::at_rest(-depth),
        ..*case
    };
    let mut trial = Trial::new(&case, AnyParams::Hfcr(HfcrParams::modified_force_only()));
    let mut device = 0.0;
    trial.at(device);
    let mut squares = 0.0;
    for displacement in displacements {
        device += displacement;
        squares += displacement * displacement;
        assert_eq!(
            trial.at(device).phase,
            Phase::Contact,
            "contact is sustained"
        );
    }
    (trial.ledger().held_leak.accumulated, squares)
}

fn plants(random: &mut Random) -> Vec<Case> {
    // Up to Kc = 1: a motion at half the loop rate then finds no resonance of the object.
    (0..60)
        .map(|i| {
            let (period, stiffness) = (random.decades(1e-4, 0.1), random.decades(10.0, 1e5));
            let object_kappa = random.decades(1e-4, 1.0);
            Case {
                stiffness,
                mass: if i % 6 == 0 {
                    f64::INFINITY
                } else {
                    stiffness * period * period / object_kappa
                },
                period,
                virtual_force: 0.0,
                object: ObjectState::default(),
            }
        })
        .collect()
}

/// The motion that leaks most: each displacement against the one before.
fn alternating(samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|i| if i % 2 == 0 { STEP } else { -STEP })
        .collect()
}

/// Source: derived here from the leak identity.
///
/// A damping B in the device dissipates at least `B dxi_i^2 / T` over an interval, however it
/// moves in between. From `dxi_i dxi_{i-1} >= -(dxi_i^2 + dxi_{i-1}^2)/2` and a start at rest,
/// `sum L_i <= K sum dxi_i^2`: B = KT pays for every motion, whatever the object's mass.
#[test]
fn device_damping_of_kt_pays_for_every_leak_of_sustained_contact() {
    let mut random = Random(40);
    let mut worst = f64::NEG_INFINITY;
    let mut motions = 0;
    for case in plants(&mut random) {
        let mut tried = vec![alternating(200)];
        for attempt in 0..10 {
            tried.push((0..200).map(|_| random.between(-STEP, STEP)).collect());
            // Turns round at random, at full speed: between the two extremes.
            let (mut direction, mut far) = (STEP, 0.0_f64);
            tried.push(
                (0..200)
                    .map(|_| {
                        if random.once_in(1 + attempt) || (far + direction).abs() > 20.0 * STEP {
                            direction = -direction;
                        }
                        far += direction;
                        direction
                    })
                    .collect(),
            );
        }
        for displacements in tried {
            let (leak, squares) = leak_and_squares(&case, &displacements);
            let needed = leak / (case.stiffness * squares);
            worst = worst.max(needed);
            motions += 1;
            assert!(needed <= 1.0 + 1e-9, "{needed} K T, {case:?}");
        }
    }
    eprintln!("{motions} motions; the worst needs a damping of {worst:.4} K T");
}

/// Source: derived here. The bound above is tight: negative control.
#[test]
fn device_damping_below_kt_does_not_pay_for_a_motion_that_alternates() {
    let mut random = Random(41);
    for case in plants(&mut random) {
        let (leak, squares) = leak_and_squares(&case, &alternating(200));
        let paid = |share: f64| share * case.stiffness * squares;
        assert!(leak > paid(0.5), "half of K T would do");
        assert!(leak > paid(0.95), "95 % of K T would do");
        assert!(leak <= paid(1.0) * (1.0 + 1e-9));
    }
}

/// Source: derived here: for a sine of n samples per turn, `sum L_i = K sum dxi_i^2
/// (1 - cos(2 pi/n))/2`. A hand at a hundredth of the loop rate needs a thousandth of K T.
#[test]
fn slow_motion_needs_little_damping() {
    let mut random = Random(42);
    for samples_per_turn in [4.0, 10.0, 100.0] {
        let angle = std::f64::consts::TAU / samples_per_turn;
        let share = 0.5 * (1.0 - angle.cos());
        let mut worst = 0.0_f64;
        // Away from the object's own oscillation on the contact spring, which would throw it off.
        let calm = |case: &Case| {
            let own = (case.stiffness / case.mass).sqrt() * case.period;
            !(0.5..2.0).contains(&(own / angle))
        };
        for case in plants(&mut random).into_iter().filter(calm) {
            // From a standstill: the first displacement has none before it to be paired with.
            let position = |i: i32| STEP * (angle * (f64::from(i) - 0.5)).cos();
            let displacements: Vec<f64> =
                (0..4000).map(|i| position(i + 1) - position(i)).collect();
            let (leak, squares) = leak_and_squares(&case, &displacements);
            worst = worst.max((leak / (case.stiffness * squares) - share).abs() / share);
        }
        eprintln!("{samples_per_turn} samples per turn: {share:.5} K T, within {worst:.1e}");
        assert!(worst < 0.05);
    }
}

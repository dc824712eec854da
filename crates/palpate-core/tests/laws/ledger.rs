//! Energy ledger over the whole range of difficulty, compared with an independent ledger.

use crate::common::{Auditor, PointMass, every_number_is_finite, explained, methods};
use palpate_core::{Contact, Difficulty, Fault, Ledger, LoopParams, ObjectState, Renderer, Sample};
use proptest::prelude::*;

/// Log-uniform distribution over [1e-4, 10].
fn difficulty() -> impl Strategy<Value = f64> {
    (-4.0..1.0_f64).prop_map(|exponent| 10f64.powf(exponent))
}

const DEVICE_MASS: f64 = 0.25;
const PERIOD: f64 = 0.01;

fn contact(kappa: f64, object_kappa: f64) -> Contact<f64> {
    let pair = Difficulty {
        kappa,
        object_kappa,
    };
    Contact::object(
        pair.stiffness(DEVICE_MASS, PERIOD).unwrap(),
        pair.object_mass(DEVICE_MASS).unwrap(),
    )
}

fn balances(ledger: &Ledger<f64>, start: f64, auditor: &Auditor) {
    auditor.agrees_with(ledger, 1e-10);
    assert_eq!(ledger.outside_work, 0.0);
    let off = ledger.stored - start - explained(ledger);
    assert!(
        off.abs() <= 1e-10 * auditor.turned_over,
        "{off} J unexplained: {ledger:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn closed_loops_of_any_difficulty_stay_finite_and_their_books_balance(
        kappa in difficulty(),
        object_kappa in difficulty(),
        wall in prop::bool::weighted(0.2),
        user_force in 0.1..5.0_f64,
        weight in -3.0..0.0_f64,
        gap in 0.0..0.05_f64,
        jitter in prop::collection::vec(0.3..2.0_f64, 100),
        measured in any::<bool>(),
    ) {
        let contact = contact(kappa, if wall { 0.0 } else { object_kappa });
        for (name, method) in methods() {
            let renderer = Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap();
            let mut state = renderer.start(ObjectState::at_rest(gap)).unwrap();
            let mut auditor = Auditor::new(&contact);
            let mut device =
                PointMass { mass: DEVICE_MASS, user_force, position: 0.0, velocity: 0.0 };
            let (mut elapsed, mut start) = (PERIOD, None);
            for ratio in &jitter {
                let mut sample = Sample::at(device.position).with_virtual_force(weight);
                if measured {
                    sample = sample.after(elapsed);
                    elapsed = PERIOD * ratio;
                }
                let output = renderer.step(&mut state, sample);
                prop_assert!(every_number_is_finite(&output), "{name}: {output:?}");
                if let Some(fault) = output.fault {
                    // Unstable loops diverge; no other sample may be rejected.
                    prop_assert_eq!(fault, Fault::JumpTooFast, "{}", name);
                    break;
                }
                let start = *start.get_or_insert(state.ledger().stored);
                auditor.observe(sample, output);
                balances(state.ledger(), start, &auditor);
                device.hold(output.force_on_device, elapsed);
            }
        }
    }

    #[test]
    fn open_loop_motions_of_any_difficulty_stay_finite_and_their_books_balance(
        kappa in difficulty(),
        object_kappa in difficulty(),
        waves in prop::collection::vec((1.0..60.0_f64, 0.0..6.3_f64, 0.001..0.02_f64), 3),
        weight in -3.0..0.0_f64,
    ) {
        let contact = contact(kappa, object_kappa);
        for (name, method) in methods() {
            let renderer = Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap();
            let position = |tick| {
                let t = f64::from(tick) * PERIOD;
                waves.iter().map(|(rate, phase, size)| size * (rate * t + phase).sin()).sum::<f64>()
            };
            // Initial penetration of 1 mm; later ones depend on the motion.
            let object = ObjectState::at_rest(position(0) - 0.001);
            let mut state = renderer.start(object).unwrap();
            let mut auditor = Auditor::new(&contact);
            let mut start = None;
            for tick in 0..200 {
                let position = position(tick);
                // A virtual force that changes in every tick.
                let push = weight * (1.0 + (0.7 * f64::from(tick)).sin());
                let sample = Sample::at(position).with_virtual_force(push);
                let output = renderer.step(&mut state, sample);
                prop_assert_eq!(output.fault, None, "{}", name);
                prop_assert!(every_number_is_finite(&output), "{name}: {output:?}");
                let start = *start.get_or_insert(state.ledger().stored);
                auditor.observe(sample, output);
                balances(state.ledger(), start, &auditor);
            }
        }
    }
}

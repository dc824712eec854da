//! A million hostile samples to every method: output and ledger stay finite.

use crate::common::{Random, entries, every_number_is_finite, methods};
use palpate_core::{Contact, LoopParams, ObjectState, Renderer, Sample, Scalar, Side};

const SAMPLE_COUNT: usize = 1_000_000;
const PERIOD: f64 = 0.001;

/// Returns a position, time or force that is likely to cause errors.
fn hostile(random: &mut Random, largest_exponent: f64) -> f64 {
    let special = [
        0.0,
        -0.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        5e-324,
        f64::from(f32::MAX),
        f64::from(f32::MIN_POSITIVE),
        1e-45,
    ];
    if random.unit() < 0.3 {
        random.pick(&special)
    } else {
        let exponent = random.between(-1.1 * largest_exponent, largest_exponent);
        random.pick(&[1.0, -1.0]) * 10f64.powf(exponent)
    }
}

fn survives<S: Scalar>(seed: u64, largest_exponent: f64) {
    let mut random = Random(seed);
    let k = S::from_f64(400.0);
    let object = Contact::object(k, S::from_f64(0.1));
    let contacts = [
        object,
        object.on(Side::Negative),
        Contact::wall(k),
        Contact::wall(k).on(Side::Negative).pushing_only(),
    ];
    for (name, method) in methods::<S>() {
        let (mut recovered, mut forces, mut pulls) = (0, 0, 0);
        for (index, contact) in contacts.into_iter().enumerate() {
            let l = LoopParams {
                speed_limit: (index % 2 == 0).then_some(S::from_f64(100.0)),
                ..LoopParams::new(S::from_f64(PERIOD))
            };
            let renderer = Renderer::new(contact, l, method).unwrap();
            let mut state = renderer.start(ObjectState::at_rest(S::ZERO)).unwrap();
            let mut previous_fault = None;
            for _ in 0..SAMPLE_COUNT / contacts.len() {
                let mut value = |calm: f64, odds: f64| {
                    if random.unit() < odds {
                        hostile(&mut random, largest_exponent)
                    } else {
                        random.between(-calm, calm)
                    }
                };
                let sample = Sample {
                    device_position: S::from_f64(value(0.002, 0.15)),
                    virtual_force: S::from_f64(value(1.0, 0.05)),
                    elapsed: match value(1.0, 0.1) {
                        calm if calm.abs() <= 1.0 && calm < 0.5 => None,
                        wild => Some(S::from_f64(wild * 2.0 * PERIOD)),
                    },
                };
                if random.unit() < 1e-3 {
                    // Return to positions with forces; a hostile position is rejected or tolerated.
                    let mut place = |odds| {
                        S::from_f64(if random.unit() < odds {
                            hostile(&mut random, largest_exponent)
                        } else {
                            0.0
                        })
                    };
                    let there = ObjectState {
                        position: place(0.2),
                        velocity: place(0.2),
                    };
                    let numbers = there.position.is_finite() && there.velocity.is_finite();
                    assert_eq!(renderer.teleport(&mut state, there).is_ok(), numbers);
                }
                let output = renderer.step(&mut state, sample);
                let tell = || format!("{name}, {contact:?}\n{sample:?}\n{output:?}\n{state:?}");
                assert!(every_number_is_finite(&output), "{}", tell());
                assert!(
                    entries(state.ledger()).iter().all(|x| x.is_finite()),
                    "{}",
                    tell()
                );
                if output.fault.is_some() {
                    assert!(output.force_on_device == S::ZERO, "{}", tell());
                    assert!(output.force_on_object == S::ZERO, "{}", tell());
                } else {
                    recovered += usize::from(previous_fault.is_some());
                    forces += usize::from(output.force_on_object != S::ZERO);
                    let push = output.force_on_object * contact.side.sign();
                    pulls += usize::from(push < S::ZERO);
                    assert!(!contact.unilateral || push >= S::ZERO, "{}", tell());
                }
                previous_fault = output.fault;
            }
        }
        // The attack is meaningful only if rendering continues under it.
        println!("{name}: {recovered} recoveries, {forces} forces, {pulls} pulls");
        assert!(recovered > SAMPLE_COUNT / 50, "{name}: {recovered}");
        assert!(forces > SAMPLE_COUNT / 20, "{name}: {forces}");
    }
}

#[test]
fn no_sample_makes_a_double_precision_output_or_ledger_infinite() {
    survives::<f64>(1, 308.0);
}

#[test]
fn no_sample_makes_a_single_precision_output_or_ledger_infinite() {
    survives::<f32>(2, 38.5);
}

#[test]
fn samples_near_overflow_keep_the_ledger_finite() {
    // Energies of single intervals are just representable here; their sum is not.
    survives::<f64>(3, 154.0);
    survives::<f32>(4, 19.0);
}

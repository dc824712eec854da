//! Remaining leak of the modified force: Eq. (10) in closed form.

use palpate_core::{AnyParams, HfcrParams, Phase};

use crate::common::Random;
use crate::paper::trial::{Case, Trial, object};

/// Source: Eq. (10), with the closed forms of Eq. (9); derived here.
///
/// With e the misprediction `xi_{i+1} - xi~`, the leak is what the spring stores beyond the
/// prediction less what the held force did over it. In sustained contact that is
/// `(K/2) dxi_i (dxi_i - dxi_{i-1})`, less `K p_{i+1}^2 / 2` if the device has in fact left.
#[test]
fn the_remaining_leak_is_a_product_of_device_displacements() {
    let mut random = Random(10);
    let mut met = std::collections::BTreeMap::<&str, (usize, f64)>::new();
    for case_number in 0..40_000 {
        let case = Case::random(&mut random);
        let k = case.stiffness;
        let params = AnyParams::Hfcr(HfcrParams {
            smooth_transition: case_number % 2 == 0,
            ..HfcrParams::default()
        });
        let mut trial = Trial::new(&case, params);
        let before = random.between(-2e-3, 2e-3);
        let now = before + random.between(-2e-3, 2e-3);
        let next = now + random.between(-3e-3, 3e-3);
        trial.at(before);
        let output = trial.at(now);
        let force = output.force_on_object;
        let predicted = trial.peek(2.0 * now - before).0.penetration;
        let (after, ledger) = trial.peek(next);
        let p = after.penetration;
        let elastic = |p: f64| 0.5 * k * p.max(0.0) * p.max(0.0);
        let (step, last_step) = (next - now, now - before);
        let (row, expected) = match output.phase {
            Phase::Contact if predicted > 0.0 && p > 0.0 => {
                ("sustained contact", 0.5 * k * step * (step - last_step))
            }
            Phase::Contact if predicted > 0.0 => (
                "sustained contact, left in fact",
                0.5 * k * step * (step - last_step) - 0.5 * k * p * p,
            ),
            // Free flight costs nothing but what the device unexpectedly presses.
            Phase::Free if p <= 0.0 => ("free", 0.0),
            Phase::Free => ("free, entered in fact", elastic(p)),
            Phase::Leaves if p <= 0.0 => ("leaves", -force * (step - last_step)),
            Phase::Leaves => (
                "leaves, stayed in fact",
                elastic(p) - force * (step - last_step),
            ),
            Phase::Contact => (
                "predicted out, no smooth transition",
                elastic(p) - force * (step - last_step),
            ),
            Phase::Enters => (
                "enters",
                elastic(p) - 0.5 * k * predicted * predicted - force * (step - last_step),
            ),
            Phase::Waiting => unreachable!("no sample is refused"),
        };
        let scale = 0.5 * k * (4e-3 * 4e-3) + case.stored(now, object(&output)).abs();
        let error = (ledger.held_leak.last - expected).abs() / scale;
        assert!(
            error < 1e-12,
            "{row}: leak {} J instead of {expected} J, {case:?}",
            ledger.held_leak.last
        );
        let (count, worst) = met.entry(row).or_default();
        *count += 1;
        *worst = worst.max(error);
    }
    for (row, (count, worst)) in &met {
        eprintln!("{row}: {count} intervals, largest error {worst:.1e}");
        assert!(*count >= 100, "{row} was met only {count} times");
    }
    assert_eq!(met.len(), 8);
}

/// Source: Eq. (10) for the spring force K p_i, with the work of f_V; derived here.
///
/// The spring force assumes that the device is at rest. While contact lasts it leaks `K dxi (dxi/2 - deta)`: on a wall
/// half of K times the square of every displacement, always generated, never dissipated.
#[test]
fn the_spring_force_leaks_k_dxi_times_half_dxi_less_deta() {
    let mut random = Random(11);
    let mut compared = 0;
    for _ in 0..20_000 {
        let case = Case::random(&mut random);
        let now = random.between(0.0, 3e-3);
        let next = now + random.between(-2e-3, 2e-3);
        let trials = [
            AnyParams::Basic,
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
        ]
        .map(|params| {
            let mut trial = Trial::new(&case, params);
            let first = trial.at(now);
            let (second, ledger) = trial.peek(next);
            (first, second, ledger)
        });
        let (first, second, ledger) = &trials[0];
        if first.penetration <= 0.0 || second.penetration <= 0.0 {
            continue;
        }
        assert_eq!(ledger.original_leak, ledger.held_leak);
        let (dxi, deta) = (next - now, second.object_position - first.object_position);
        let expected = case.stiffness * dxi * (0.5 * dxi - deta);
        let scale = case.stiffness * 1e-5 + case.stored(now, object(first)).abs();
        for (_, _, ledger) in &trials {
            let leak = ledger.original_leak.last;
            assert!((leak - expected).abs() < 1e-12 * scale, "{leak} {expected}");
        }
        assert!(case.mass.is_finite() || ledger.held_leak.last >= 0.0);
        compared += 1;
    }
    eprintln!("{compared} intervals in contact");
    assert!(compared > 5000);
}

//! The metrics of energy, on loops simple enough to be written here.

use crate::common::{FALLING_BLOCK, PAPER, WALL, assert_close, ideal_loop, spring_loop, windowed};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::metrics::{EnergyEvaluation, Rebound};

#[test]
fn a_loop_like_the_ideal_keeps_its_energy() {
    for (name, scene, period, collisions, _) in PAPER {
        let (ideal, profile) = windowed(scene, period, collisions);
        let record = ideal_loop(&ideal, &profile);
        let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
        assert!(!evaluated.diverged);
        assert_close(name, evaluated.energy_drift.unwrap(), 0.0, 1e-12);
        assert_eq!(evaluated.rebounds.len(), collisions);
        for rebound in evaluated.rebounds {
            let Rebound::EnergyError(error) = rebound else {
                panic!("{rebound:?}")
            };
            assert_close(name, error, 0.0, 1e-12);
        }
    }
}

#[test]
fn the_energy_a_loop_makes_is_what_went_through_its_ports() {
    for (name, scene) in [("falling block", FALLING_BLOCK), ("wall", WALL)] {
        let (ideal, profile) = windowed(scene, 0.005, 2);
        let record = spring_loop(&ideal, &profile, 0.0);
        let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
        let impact = ideal.impact_energy(&profile.collisions()[0]);
        // Σ f (Δη − Δξ): the work done on the object less the work taken from the device.
        let mut made = 0.0;
        let mut parted = None;
        for pair in record.windows(2) {
            made += pair[0].force_on_object * (pair[0].penetration() - pair[1].penetration());
            if pair[0].force_on_object != 0.0 && pair[1].penetration() <= 0.0 {
                parted = parted.or(Some(made));
            }
        }
        let Rebound::EnergyError(first) = evaluated.rebounds[0] else {
            panic!("{:?}", evaluated.rebounds)
        };
        assert_close(name, first, parted.unwrap() / impact, 1e-9);
        assert!(
            first > 0.1,
            "{name}: a sampled spring generates energy, {first}"
        );
    }
}

#[test]
fn missing_and_stuck_collisions_are_reported() {
    let (ideal, profile) = windowed(FALLING_BLOCK, 0.01, 3);
    let mut record = ideal_loop(&ideal, &profile);
    // From the second collision on device and object stay together without any force.
    for snapshot in &mut record[42..] {
        snapshot.force_on_object = 0.0;
        snapshot.device_position = snapshot.object_position + 1e-3;
    }
    let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
    assert!(matches!(evaluated.rebounds[0], Rebound::EnergyError(_)));
    assert_eq!(
        evaluated.rebounds[1..],
        [Rebound::NotReleased, Rebound::NotRendered]
    );
}

#[test]
fn tenfold_energy_is_divergence_and_less_is_not() {
    let (ideal, profile) = windowed(FALLING_BLOCK, 0.01, 3);
    let impact = ideal.impact_energy(&profile.collisions()[0]);
    for (impacts, diverged) in [(8.9, false), (9.1, true)] {
        let mut record = ideal_loop(&ideal, &profile);
        let height = &mut record[30];
        // Raised by so much that gravity holds the extra energy.
        height.object_position += impacts * impact / 0.981;
        let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
        assert_eq!(evaluated.diverged, diverged);
    }
    let unstable = spring_loop(&ideal, &profile, -8.0);
    assert!(
        EnergyEvaluation::new(&ideal, &profile, &unstable)
            .unwrap()
            .diverged
    );
    let sampled = spring_loop(&ideal, &profile, 0.3);
    assert!(
        !EnergyEvaluation::new(&ideal, &profile, &sampled)
            .unwrap()
            .diverged
    );
}

#[test]
fn a_press_from_rest_is_measured_by_its_spring() {
    let ideal = Ideal::new(PointMassScene {
        device_position: 0.02,
        device_velocity: 0.0,
        ..WALL
    })
    .unwrap();
    let profile = ideal.profile(0.001, 400).unwrap();
    let mut record = ideal_loop(&ideal, &profile);
    let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
    assert!(!evaluated.diverged && evaluated.rebounds.is_empty());
    assert_close("drift", evaluated.energy_drift.unwrap(), 0.0, 1e-12);
    // The spring's energy at the peak 2 f_u is 2 f_u²/K.
    let reference = 2.0 * 1.3f64.powi(2) / 900.0;
    let last = record.last_mut().unwrap();
    last.device_velocity = (last.device_velocity.powi(2) + 2.0 * reference / 0.3).sqrt();
    let evaluated = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
    assert_close("drift", evaluated.energy_drift.unwrap(), 1.0, 1e-9);
}

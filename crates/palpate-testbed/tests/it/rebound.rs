//! Rebound speeds, on loops simple enough to be written here.

use crate::common::{FALLING_BLOCK, PAPER, WALL, assert_close, ideal_loop, spring_loop, windowed};
use palpate_testbed::metrics::{EnergyEvaluation, Rebound, ReboundSpeed};

#[test]
fn a_loop_like_the_ideal_parts_as_fast_as_the_ideal() {
    for (name, scene, period, collisions, _) in PAPER {
        let (ideal, profile) = windowed(scene, period, collisions);
        let record = ideal_loop(&ideal, &profile);
        let rebounds = ReboundSpeed::new(&profile, &record).unwrap();
        assert_eq!(rebounds.len(), collisions);
        for (rebound, collision) in rebounds.iter().zip(profile.collisions()) {
            // A sample late, gravity and the hand have changed the speed by up to a quarter.
            assert_close(name, rebound.error.unwrap(), 0.0, 1e-12);
            assert_close(name, rebound.ideal, collision.impact_speed, 1e-12);
        }
    }
}

#[test]
fn a_sampled_spring_parts_faster_by_the_energy_it_makes() {
    for (name, scene, period) in [
        ("falling block", FALLING_BLOCK, 0.005),
        ("wall", WALL, 0.005),
    ] {
        let (ideal, profile) = windowed(scene, period, 1);
        let record = spring_loop(&ideal, &profile, 0.0);
        let speeds = ReboundSpeed::new(&profile, &record).unwrap();
        let energies = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
        let (Some(error), Rebound::EnergyError(energy)) = (speeds[0].error, &energies.rebounds[0])
        else {
            panic!("{name}: {speeds:?} {energies:?}");
        };
        assert!(
            error > 0.04,
            "{name}: a sampled spring makes energy, {error}"
        );
        assert_close(name, (1.0 + error).powi(2) - 1.0, *energy, 1e-9);
    }
}

#[test]
fn a_collision_that_is_missing_or_does_not_end_has_no_speed() {
    let (ideal, profile) = windowed(FALLING_BLOCK, 0.01, 3);
    let mut record = ideal_loop(&ideal, &profile);
    for snapshot in &mut record[42..] {
        snapshot.force_on_object = 0.0;
    }
    let rebounds = ReboundSpeed::new(&profile, &record).unwrap();
    assert!(rebounds[0].rendered.is_some() && rebounds[1].rendered.is_some());
    assert_eq!((rebounds[2].rendered, rebounds[2].error), (None, None));
    for snapshot in &mut record[42..] {
        snapshot.force_on_object = 1.0;
        snapshot.object_position = snapshot.device_position - 0.01;
    }
    let rebounds = ReboundSpeed::new(&profile, &record).unwrap();
    assert!(rebounds[0].rendered.is_some());
    assert_eq!((rebounds[2].rendered, rebounds[2].error), (None, None));
    let short = ReboundSpeed::new(&profile, &record[..40]).unwrap_err();
    assert_eq!((short.given, short.expected), (40, record.len()));
}

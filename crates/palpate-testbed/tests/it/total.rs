//! Nothing turns into a NaN over a wide range of contacts.

use palpate_testbed::driven::{DrivenIdeal, DrivenScene};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::metrics::{EnergyEvaluation, ForceEvaluation};
use palpate_testbed::profile::Snapshot;
use palpate_testbed::recorded_path::RecordedPath;
use proptest::prelude::*;

/// A number spread evenly over decades.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

prop_compose! {
    /// A scene by its difficulty: K T²/m and K T²/M.
    fn scenes()(
        period in decades(1e-4, 0.1),
        device_mass in decades(0.01, 10.0),
        device_difficulty in decades(1e-4, 10.0),
        object_difficulty in prop_oneof![9 => decades(1e-4, 10.0), 1 => Just(0.0)],
        forces in (-5.0..5.0, -5.0..5.0),
        positions in (-0.2..0.2, -0.2..0.2),
        velocities in (-2.0..2.0, -2.0..2.0),
    ) -> (PointMassScene, f64) {
        let stiffness = device_difficulty * device_mass / (period * period);
        let wall = object_difficulty == 0.0;
        let scene = PointMassScene {
            stiffness,
            device_mass,
            object_mass: if wall { f64::INFINITY } else { stiffness * period * period / object_difficulty },
            user_force: forces.0,
            virtual_force: forces.1,
            device_position: positions.0,
            device_velocity: velocities.0,
            object_position: positions.1,
            object_velocity: if wall { 0.0 } else { velocities.1 },
        };
        (scene, period)
    }
}

proptest! {
    #[test]
    fn an_ideal_and_its_judgement_are_numbers(
        (scene, period) in scenes(),
        forces in prop::collection::vec(-1e3..1e3, 64),
    ) {
        let ideal = Ideal::new(scene).unwrap();
        let profile = ideal.profile(period, 64).unwrap();
        for (j, q) in profile.impulses().iter().zip(profile.squared_forces()) {
            prop_assert!(j.is_finite() && *j >= -1e-12 && q.is_finite() && *q >= 0.0);
            // No mean is above the root mean square.
            prop_assert!(j * j <= q * period * (1.0 + 1e-9) + 1e-300);
        }
        let mut before = 0.0;
        for collision in profile.collisions() {
            prop_assert!(collision.start >= before);
            before = collision.end.unwrap_or(collision.start);
            prop_assert!(before >= collision.start);
            prop_assert!(collision.impulse.is_finite() && collision.peak_force.is_finite());
            prop_assert!(collision.impact_speed.is_finite());
        }
        let evaluated = ForceEvaluation::new(&forces, &profile).unwrap();
        if let Some(fidelity) = evaluated.fidelity {
            prop_assert!(fidelity.force_rendering_error.is_finite());
            prop_assert!(fidelity.mean_force_error.is_finite());
            prop_assert!((0.0..=100.0 + 1e-9).contains(&fidelity.hold_bound));
            let sides = fidelity.hold_bound.hypot(fidelity.mean_force_error);
            prop_assert!((fidelity.force_rendering_error - sides).abs() <= 1e-9 * sides);
        }
        let record: Vec<Snapshot> = (0..=64).map(|i| ideal.at(f64::from(i) * period)).collect();
        prop_assert!(record.iter().all(Snapshot::is_finite));
        let energy = EnergyEvaluation::new(&ideal, &profile, &record).unwrap();
        prop_assert!(energy.energy_drift.is_none_or(f64::is_finite));
    }

    #[test]
    fn contact_is_where_the_positions_say(
        (scene, period) in scenes(),
        instants in prop::collection::vec(0.0..64.0, 64),
    ) {
        let ideal = Ideal::new(scene).unwrap();
        let profile = ideal.profile(period, 64).unwrap();
        for instant in instants {
            let at = ideal.at(instant * period);
            let digits = 1e-11 * (1.0 + at.device_position.abs());
            let spring = scene.stiffness * at.penetration().max(0.0);
            prop_assert!((at.force_on_object - spring).abs() <= scene.stiffness * digits);
            let collides = profile
                .collisions()
                .iter()
                .any(|c| c.start <= at.time && c.end.is_none_or(|end| at.time <= end));
            let inside = if collides { at.penetration() } else { -at.penetration() };
            prop_assert!(inside > -digits);
        }
        for (number, collision) in profile.collisions().iter().enumerate() {
            if let Some(end) = collision.end {
                let at = ideal.at(end);
                let digits = 1e-11 * (1.0 + at.device_position.abs());
                prop_assert!(at.penetration().abs() <= digits);
                let counted = ideal.end_of_collision(number + 1).unwrap();
                prop_assert!((counted - end).abs() <= 1e-12 * end);
            }
        }
    }

    #[test]
    fn momentum_is_conserved_by_the_ideal((scene, period) in scenes()) {
        let ideal = Ideal::new(scene).unwrap();
        let profile = ideal.profile(period, 64).unwrap();
        let (start, end) = (ideal.at(0.0), ideal.at(64.0 * period));
        let impulse: f64 = profile.impulses().iter().sum();
        let given = scene.device_mass * (start.device_velocity - end.device_velocity)
            + scene.user_force * end.time;
        let scale = impulse.abs() + scene.device_mass * (start.device_velocity.abs() + end.device_velocity.abs())
            + (scene.user_force * end.time).abs();
        prop_assert!((impulse - given).abs() <= 1e-9 * scale, "{impulse} {given} {scale}");
        let of_collisions: f64 = profile.collisions().iter().map(|collision| collision.impulse).sum();
        prop_assert!((impulse - of_collisions).abs() <= 1e-10 * (impulse + 1e-9));
    }

    #[test]
    fn a_driven_ideal_is_made_of_numbers(
        (scene, period) in scenes(),
        steps in prop::collection::vec((0.1..2.0, -0.01..0.01), 2..80),
    ) {
        let (mut time, mut position) = (0.0, scene.device_position);
        let (mut times, mut positions) = (vec![time], vec![position]);
        for (duration, travel) in steps {
            time += duration * period;
            position += travel;
            times.push(time);
            positions.push(position);
        }
        let path = RecordedPath::new(&times, &positions).unwrap();
        let driven = DrivenIdeal::new(
            DrivenScene {
                stiffness: scene.stiffness,
                object_mass: scene.object_mass,
                virtual_force: scene.virtual_force,
                object_position: scene.object_position,
                object_velocity: scene.object_velocity,
            },
            path,
        )
        .unwrap();
        let intervals = driven.path().whole_periods(period).unwrap();
        let profile = driven.profile(period, intervals).unwrap();
        for (j, q) in profile.impulses().iter().zip(profile.squared_forces()) {
            prop_assert!(j.is_finite() && *j >= -1e-12 && q.is_finite() && *q >= 0.0);
        }
        for i in 0..=200 {
            prop_assert!(driven.at(time * f64::from(i) / 200.0).is_finite());
        }
        // The object's momentum accounts for every newton second.
        if scene.object_mass.is_finite() {
            let end = intervals as f64 * period;
            let impulse: f64 = profile.impulses().iter().sum();
            let after = driven.at(end).object_velocity;
            let given = scene.object_mass * (after - scene.object_velocity) - scene.virtual_force * end;
            let scale = impulse.abs() + scene.object_mass * (after.abs() + scene.object_velocity.abs())
                + (scene.virtual_force * end).abs();
            prop_assert!((impulse - given).abs() <= 1e-9 * scale, "{impulse} {given}");
        }
    }
}

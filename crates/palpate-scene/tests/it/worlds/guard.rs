//! The guard of a scene file.

use palpate_core::HandLimit;
use palpate_scene::world::{WorldFile, hand_guard, usual_guard};
use palpate_world::{WorldGuard, WorldGuardParams, WorldHandBound, WorldHandLimit};

use super::{BALL, said};

#[test]
fn a_guard_is_read_and_its_faults_are_said() {
    let with = |guard: &str| BALL.replace("[render]", &format!("[render]\nguard = {guard}"));
    let read = |guard: &str| {
        let scene = WorldFile::parse("ball.toml", &with(guard)).unwrap().scene;
        assert_eq!(scene.loop_params().guard, scene.guard_of_devices());
        scene.render.guard
    };
    assert_eq!(
        read("{ mode = \"limit\" }"),
        WorldGuard::Limit(usual_guard())
    );
    assert_eq!(read("{ mode = \"off\", allowance_j = 1 }"), WorldGuard::Off);
    let all = "{ mode = \"report\", speed_m_per_s = 2, turning_rad_per_s = 5, allowance_j = 0.1, late_samples = 2 }";
    let params = WorldGuardParams {
        largest_speed: 2.0,
        largest_turning: 5.0,
        allowance: 0.1,
        late: 2,
        recovery: 0.02,
        quantum: 0.0,
        angle_quantum: 0.0,
        hand: None,
    };
    assert_eq!(read(all), WorldGuard::Report(params));
    let hand = WorldHandBound {
        least_mass: [0.1; 3],
        ..hand_guard(HandLimit::Acceleration(80.0))
    };
    let params = WorldGuardParams {
        recovery: 0.0,
        hand: Some(hand),
        ..usual_guard()
    };
    let given =
        "{ mode = \"limit\", acceleration_m_per_s2 = 80, least_mass_kg = 0.1, recovery_w = 0 }";
    assert_eq!(read(given), WorldGuard::Limit(params));
    for (guard, words) in [
        ("{ mode = \"on\" }", "limit"),
        (
            "{ mode = \"limit\", speed_m_per_s = 0 }",
            "speed_m_per_s is 0, and has to be above 0",
        ),
        (
            "{ mode = \"limit\", allowance_j = -1 }",
            "allowance_j is -1, and has to be at least 0",
        ),
        ("{ mode = \"limit\", allowance = 1 }", "allowance"),
        (
            "{ mode = \"limit\", recovery_w = -1 }",
            "recovery_w is -1, and has to be at least 0",
        ),
        (
            "{ mode = \"limit\", acceleration_m_per_s2 = 0 }",
            "acceleration_m_per_s2 is 0, and has to be above 0",
        ),
        (
            "{ mode = \"limit\", least_mass_kg = 0.1 }",
            "render.guard.least_mass_kg needs acceleration_m_per_s2 or hand_force_n",
        ),
        (
            "{ mode = \"limit\", hand_force_n = 8, learn_mass = true }",
            "render.guard.learn_mass is for one contact along one axis; remove it",
        ),
        (
            "{ mode = \"limit\", hand_force_n = 0 }",
            "hand_force_n is 0, and has to be above 0",
        ),
        (
            "{ mode = \"limit\", hand_force_n = 8, acceleration_m_per_s2 = 80 }",
            "render.guard.hand_force_n excludes acceleration_m_per_s2; remove one",
        ),
        (
            "{ mode = \"limit\", acceleration_m_per_s2 = 80, hand_torque_n_m = 1 }",
            "render.guard.hand_torque_n_m needs hand_force_n",
        ),
        (
            "{ mode = \"limit\", acceleration_m_per_s2 = 80, least_mass_kg = 0 }",
            "least_mass_kg is 0, and has to be above 0",
        ),
    ] {
        let said = said(&with(guard));
        assert!(
            said.len() == 1 && said[0].contains(words),
            "{guard}: {said:?}"
        );
    }
    // An error that only a renderer detects is reported at its key.
    let late = with("{ mode = \"limit\", late_samples = 9 }");
    let file = WorldFile::parse("ball.toml", &late).unwrap();
    let faults = file.scene.renderer("coupled").unwrap_err();
    let error = file.at(
        faults.first().part,
        faults.first().field,
        faults.first().to_string(),
    );
    assert!(error.to_string().contains("at most 8"), "{error}");
    assert_eq!(&late[error.span.clone()], "9");
    let late = with("{ mode = \"limit\", acceleration_m_per_s2 = 80, late_samples = 2 }");
    let file = WorldFile::parse("ball.toml", &late).unwrap();
    let faults = file.scene.renderer("coupled").unwrap_err();
    let error = file.at(
        faults.first().part,
        faults.first().field,
        faults.first().to_string(),
    );
    assert!(
        error
            .to_string()
            .contains("put the delay into the actuation"),
        "{error}"
    );
    assert_eq!(&late[error.span.clone()], "2");
}

/// Half of the least model mass, the quantum of the sensors, and no value for a rotation that a device does not have.
#[test]
fn a_guard_takes_its_other_values_from_the_devices() {
    let guard = "[render]\nguard = { mode = \"limit\", acceleration_m_per_s2 = 80 }";
    let source = BALL.replace("[render]", guard);
    let scene = WorldFile::parse("ball.toml", &source).unwrap().scene;
    let WorldGuard::Limit(params) = scene.loop_params().guard else {
        panic!("{:?}", scene.loop_params().guard);
    };
    let mass = scene.render.device_mass[0].map(|mass| 0.5 * mass);
    assert_eq!(params.hand.unwrap().least_mass, mass);
    assert_eq!(scene.loop_params().guard_masses, [mass]);
    let given = source.replace("s2 = 80", "s2 = 80, least_mass_kg = 0.01");
    let given = WorldFile::parse("ball.toml", &given).unwrap().scene;
    assert!(given.loop_params().guard_masses.is_empty());
    assert_eq!(params.quantum, 2e-6);
    scene.renderer("coupled").unwrap();
    let turning = source.replacen("mass_kg", "inertia_kg_m2 = [3e-4, 1e-4, 2e-4]\nmass_kg", 1);
    let faults = said(&turning);
    let words = "needs turning_acceleration_rad_per_s2, because a device turns";
    assert!(faults.len() == 1 && faults[0].contains(words), "{faults:?}");
    let turning = turning.replace("s2 = 80", "s2 = 80, turning_acceleration_rad_per_s2 = 3000");
    let scene = WorldFile::parse("ball.toml", &turning).unwrap().scene;
    let WorldGuard::Limit(params) = scene.loop_params().guard else {
        panic!("{:?}", scene.loop_params().guard);
    };
    let hand = params.hand.unwrap();
    let (linear, angular) = (80.0, 3000.0);
    assert_eq!(hand.limit, WorldHandLimit::Acceleration { linear, angular });
    assert_eq!(hand.least_inertia, 0.5e-4);
    scene.renderer("coupled").unwrap();
    let accelerations = "acceleration_m_per_s2 = 80, turning_acceleration_rad_per_s2 = 3000";
    let by_force = turning.replace(accelerations, "hand_force_n = 8");
    let faults = said(&by_force);
    let words = "hand_force_n needs hand_torque_n_m, because a device turns";
    assert!(faults.len() == 1 && faults[0].contains(words), "{faults:?}");
    let by_force = by_force.replace("_n = 8", "_n = 8, hand_torque_n_m = 0.1");
    let scene = WorldFile::parse("ball.toml", &by_force).unwrap().scene;
    let hand = scene.guard_of_devices().params().unwrap().hand.unwrap();
    let (force, torque) = (8.0, 0.1);
    assert_eq!(hand.limit, WorldHandLimit::Force { force, torque });
    scene.renderer("coupled").unwrap();
}

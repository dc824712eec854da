//! Methods of other authors on the paper's scenes and on random ones.

use palpate_core::ParameterValue;
use palpate_scene::Measure;
use palpate_scene::method::{MethodName, SettingKey, Settings};

use crate::common::{PAPER_SCENES, Random, damping, fidelity, scene, with};

fn word(key: SettingKey, word: &'static str) -> Settings {
    Settings::default().with(key, ParameterValue::Word(word))
}

/// A method with its settings, and its errors.
type Row = ((MethodName, Option<Settings>), [f64; 3]);

/// FRE in percent on Fig. 2, experiment 1 and experiment 2, each method with the settings of the scene or those of the
/// row. The third scene is chaotic in these settings.
#[test]
fn force_rendering_errors_on_the_papers_scenes() {
    let own = |method| (method, None);
    let as_given = |method, settings| (method, Some(settings));
    let rows: [Row; 8] = [
        (own(MethodName::EnergyCorrected), [14.7, 17.8, 101.0]),
        (own(MethodName::ForceBounding), [99.5, 94.4, 64.1]),
        (own(MethodName::Pmi), [106.8, 96.1, 135.9]),
        (
            as_given(
                MethodName::Pmi,
                word(SettingKey::MIDPOINT_DEVICE, "extrapolated"),
            ),
            [28.7, 54.8, 116.8],
        ),
        (own(MethodName::EnergyTank), [18.5, 38.3, 57.3]),
        (own(MethodName::VirtualCoupling), [52.8, 38.4, 86.5]),
        (
            as_given(
                MethodName::VirtualDamper,
                word(SettingKey::DAMPING, "stability-optimal"),
            ),
            [150.0, 175.0, 178.0],
        ),
        (
            as_given(MethodName::Hfcr, word(SettingKey::DAMPING, "adaptive")),
            [13.2, 22.7, 89.1],
        ),
    ];
    for ((method, settings), expected) in rows {
        for (name, expected) in PAPER_SCENES.into_iter().zip(expected) {
            let scene = scene(name);
            let scene = match settings {
                Some(settings) => with(scene, method, settings),
                None => scene,
            };
            let error = fidelity(&scene, method).force_rendering_error;
            eprintln!("{method} {name}: {error:.2}");
            assert!((error - expected).abs() < 0.1, "{method} {name}: {error}");
        }
    }
}

/// Undamped bounces of three collisions: the energy-corrected object needs no setting, and has less error than HFCR.
#[test]
fn the_energy_corrected_object_on_random_undamped_scenes() {
    let mut random = Random(12);
    let methods = [
        MethodName::EnergyCorrected,
        MethodName::HfcrModSt,
        MethodName::Pmi,
    ];
    let mut errors = methods.map(|_| Vec::new());
    for _ in 0..40 {
        let mut scene = scene("experiment1");
        scene.settings.clear();
        let (mass, period) = (random.decades(0.05, 0.5), random.decades(0.001, 0.02));
        let (kappa, object_kappa) = (random.decades(0.01, 0.3), random.decades(0.01, 0.5));
        let stiffness = kappa * mass / (period * period);
        let object_mass = stiffness * period * period / object_kappa;
        let (push, speed) = (random.between(2.0, 10.0), random.between(0.2, 1.0));
        scene.loop_params.period = period;
        scene.contact.stiffness = stiffness;
        scene.contact.object_mass = palpate_core::Mass::Finite(object_mass);
        scene.virtual_force = -9.81 * object_mass;
        scene.object.position = speed * speed / (2.0 * (push + 9.81));
        let device = scene.device.point_mass_mut().unwrap();
        device.mass = mass;
        device.hand.force = mass * push;
        scene.measure = Measure::Collisions(3);
        for (method, errors) in methods.into_iter().zip(&mut errors) {
            errors.push(fidelity(&scene, method).mean_force_error);
        }
    }
    let medians = errors.map(|mut errors| {
        errors.sort_by(f64::total_cmp);
        0.5 * (errors[19] + errors[20])
    });
    eprintln!("median E of {methods:?}: {medians:.1?} %");
    assert!(medians[0] < 0.6 * medians[1] && medians[1] < 0.6 * medians[2]);
}

/// The setting equals a damping of 0.828 m/T.
#[test]
fn stability_optimal_damping_is_in_the_report_as_a_number() {
    let scene = with(
        scene("fig2"),
        MethodName::VirtualDamper,
        word(SettingKey::DAMPING, "stability-optimal"),
    );
    let best = 2.0 * (2f64.sqrt() - 1.0) * 0.1 / 0.01;
    let as_number = with(scene.clone(), MethodName::VirtualDamper, damping(best));
    assert_eq!(
        fidelity(&scene, MethodName::VirtualDamper),
        fidelity(&as_number, MethodName::VirtualDamper)
    );
}

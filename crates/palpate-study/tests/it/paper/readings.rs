//! Ambiguous statements of the paper, and the effect of each interpretation on its claims.
//!
//! docs/results/readings.md has the readings and these numbers in tables.

use palpate_core::{
    AnyParams, DamperObject, EnergyBalance, EntryHold, HfcrParams, ObjectState, Phase, Prediction,
};
use palpate_scene::Scene;
use palpate_scene::method::{MethodName, PredictionName, SettingKey, Settings};

use crate::common::{PAPER_SCENES, Random, damping, fidelity, scene, with};
use crate::paper::trial::{Case, Trial};

fn damper(object: DamperObject, value: f64) -> Settings {
    damping(value).with(SettingKey::DAMPER_OBJECT, object)
}

fn hfcr(hold: EntryHold, value: f64) -> Settings {
    damping(value).with(SettingKey::ENTRY_HOLD, hold)
}

/// FRE `[%]`.
fn error(scene: &Scene, method: MethodName, settings: Settings) -> f64 {
    fidelity(&with(scene.clone(), method, settings), method).force_rendering_error
}

/// FRE `[%]` of the virtual damper for every B from 0.01 to 8 N s/m.
fn over_all_dampings(name: &str, object: DamperObject) -> Vec<(f64, f64)> {
    let scene = scene(name);
    (1..=800)
        .map(|i| {
            let value = 0.01 * f64::from(i);
            let settings = damper(object, value);
            (value, error(&scene, MethodName::VirtualDamper, settings))
        })
        .collect()
}

fn least(errors: &[(f64, f64)]) -> (f64, f64) {
    *errors.iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

fn near(given: f64, expected: f64, tolerance: f64) {
    assert!(
        (given - expected).abs() <= tolerance,
        "{given:.2} for {expected}"
    );
}

/// Source: the paper's section on its experiments, and Figs. 4 and 5: a virtual damper cannot achieve
/// good fidelity, FRE 84.9 % in the first experiment, and in the second no B is satisfactory.
///
/// With the damper in the held force only, that is what comes out. With the damper in the object's
/// motion too, the default, the first experiment has a B that is good.
#[test]
fn with_the_damper_in_the_force_only_no_damper_has_good_fidelity() {
    let first = over_all_dampings("experiment1", DamperObject::Spring);
    let (best, lowest) = least(&first);
    let bad = first.iter().filter(|(_, error)| *error > 80.0).count();
    eprintln!(
        "experiment 1, spring: least FRE {lowest:.1} % at {best:.2}; {bad} of 800 above 80 %"
    );
    near(lowest, 64.0, 0.2);
    assert!((best - 1.68).abs() < 1e-9, "{best}");
    assert!(bad >= 768, "{bad}");
    near(first[124].1, 86.8, 0.2);
    let second = over_all_dampings("experiment2", DamperObject::Spring);
    let (best, lowest) = least(&second);
    eprintln!("experiment 2, spring: least FRE {lowest:.1} % at {best:.2}");
    assert!(lowest > 130.0, "{lowest}");
}

/// Source: derived here. The least FRE of any B up to 8 N s/m, and that B: found with knowledge of the
/// ideal.
#[test]
fn the_best_damper_of_a_scene_depends_on_what_moves_its_object() {
    let expected: [(DamperObject, [(f64, f64); 3]); 3] = [
        (
            DamperObject::SpringAndDamper,
            [(19.0, 0.53), (23.4, 0.57), (96.3, 6.65)],
        ),
        (
            DamperObject::Spring,
            [(27.6, 0.97), (64.0, 1.68), (130.4, 0.43)],
        ),
        (
            DamperObject::HeldForce,
            [(20.7, 0.61), (42.8, 1.38), (124.2, 5.18)],
        ),
    ];
    for (object, expected) in expected {
        for (name, (error, value)) in PAPER_SCENES.into_iter().zip(expected) {
            let (best, lowest) = least(&over_all_dampings(name, object));
            eprintln!("{name}, {object:?}: least FRE {lowest:.1} % at {best:.2} N s/m");
            near(lowest, error, if lowest > 90.0 { 1.0 } else { 0.2 });
            assert!((best - value).abs() < 1e-9, "{best} for {value}");
        }
    }
}

/// Source: Eqs. (8) to (10) as printed, without the work of f_V.
#[test]
fn as_printed_the_modified_force_is_far_off() {
    for (method, expected) in [
        (MethodName::HfcrMod, [97.6, 135.0, 1324.9]),
        (MethodName::HfcrModSt, [124.1, 220.6, 263.4]),
    ] {
        for (name, expected) in PAPER_SCENES.into_iter().zip(expected) {
            let settings = |balance| Settings::default().with(SettingKey::BALANCE, balance);
            let scene = scene(name);
            let usual = error(&scene, method, settings(EnergyBalance::WithVirtualForce));
            let printed = error(&scene, method, settings(EnergyBalance::AsPrinted));
            eprintln!("{name}, {method}: FRE {usual:.1} %, as printed {printed:.1} %");
            near(printed, expected, if printed > 1000.0 { 5.0 } else { 0.3 });
        }
    }
}

/// Source: Fig. 2; its user's force only carries the device's weight, so that the net force is 0.
#[test]
fn fig_2_with_a_carried_device_keeps_the_order_of_hfcr_and_damper() {
    let carried = scene("readings/fig2_carried");
    for (method, expected) in [
        (MethodName::Hfcr, 34.5),
        (MethodName::PopcRef, 113.7),
        (MethodName::VirtualDamper, 34.7),
    ] {
        let found = fidelity(&carried, method).force_rendering_error;
        near(found, expected, 0.1);
    }
}

/// Source: Fig. 5, FRE 52.2 % with some b, and the paper's remark that only quantities of t_i are used.
///
/// Held at the sample, HFCR reaches that, but in a valley: its neighbours in b and in height are where
/// the other readings are.
#[test]
fn held_at_the_sample_hfcr_reaches_the_paper_s_second_experiment_in_a_valley() {
    let second = scene("experiment2");
    let at = |value| error(&second, MethodName::Hfcr, hfcr(EntryHold::Sample, value));
    for (value, expected) in [
        (0.01, 101.8),
        (0.05, 54.8),
        (0.07, 49.7),
        (0.08, 50.4),
        (0.1, 93.6),
    ] {
        let found = at(value);
        eprintln!("experiment 2, sample, b = {value}: FRE {found:.1} %");
        near(found, expected, 1.0);
    }
    // 11 heights within 5 %, one by one of 1 %.
    for value in [0.05, 0.07, 0.08] {
        let mut errors: Vec<f64> = (-5..=5)
            .map(|percent| {
                let mut scene = second.clone();
                scene.object.position *= 1.0 + 0.01 * f64::from(percent);
                error(&scene, MethodName::Hfcr, hfcr(EntryHold::Sample, value))
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        eprintln!(
            "experiment 2, sample, b = {value}: median of 11 heights {:.1} %",
            errors[5]
        );
        near(errors[5], 90.0, 1.0);
    }
}

/// Source: derived here from Eqs. (9) and (10). What sustained contact leaks is the price of the
/// prediction: a device that moves as predicted leaves none.
#[test]
fn a_device_at_constant_acceleration_leaks_nothing_by_extrapolation() {
    let mut random = Random(23);
    let (mut checked, mut by_last_step) = (0, 0);
    for _ in 0..4000 {
        let case = Case {
            object: ObjectState::default(),
            ..Case::random(&mut random)
        };
        let (first, step, change) = (
            random.between(1e-3, 4e-3),
            random.between(-1e-3, 1e-3),
            random.between(-5e-4, 5e-4),
        );
        // Constant acceleration: the steps grow by the same each time.
        let positions: Vec<f64> = (0..4)
            .map(|i| {
                let i = f64::from(i);
                first + step * i + 0.5 * change * i * (i - 1.0)
            })
            .collect();
        let leak = |prediction| {
            let mut trial = Trial::new(
                &case,
                AnyParams::Hfcr(HfcrParams {
                    prediction,
                    ..HfcrParams::modified_force_only()
                }),
            );
            let outputs = positions.clone().into_iter().map(|xi| trial.at(xi));
            let outputs: Vec<_> = outputs.collect();
            let contact = outputs.iter().all(|output| output.penetration > 0.0)
                && outputs[2].phase == Phase::Contact;
            (contact, trial.ledger().held_leak.last)
        };
        let (contact, none) = leak(Prediction::Extrapolation);
        let (contact_too, some) = leak(Prediction::LastStep);
        if !(contact && contact_too) {
            continue;
        }
        let scale = case.stiffness * 1e-5;
        assert!(none.abs() < 1e-9 * scale, "{none:e} J: {case:?}");
        checked += 1;
        by_last_step += usize::from(some.abs() > 1e-4 * scale);
    }
    eprintln!("{checked} intervals, {by_last_step} of them leak by the last step");
    assert!(checked > 300 && by_last_step > checked / 2);
}

/// FRE `[%]` at the scene's own height with an encoder of this quantum `[m]`.
fn quantised(name: &str, method: MethodName, predictor: PredictionName, quantum: f64) -> f64 {
    let mut scene = scene(name);
    scene.device.point_mass_mut().unwrap().encoder_quantum = quantum;
    let value = match method {
        MethodName::Hfcr => 0.0,
        _ => 0.5 * scene.contact.stiffness * scene.loop_params.period,
    };
    let settings = damping(value).with(SettingKey::PREDICTION, predictor);
    error(&scene, method, settings)
}

/// Source: the paper's remark on enhanced velocity estimation; Janabi-Sharifi, Hayward and Chen, IEEE
/// Trans. Control Systems Technology 8(6), 2000.
///
/// At the paper's rates a device in motion curves by more than a quantum within two periods, so there is
/// nothing to average: adaptive windowing is the last step but for encoders of a millimetre.
#[test]
fn at_the_paper_s_rates_an_adaptive_window_is_the_last_step_unless_the_encoder_is_very_coarse() {
    let mut changed = 0;
    for name in PAPER_SCENES {
        for method in [MethodName::Hfcr, MethodName::VirtualDamper] {
            for quantum in [0.0, 1e-6, 1e-5, 1e-4, 1e-3] {
                let [last, window] = [
                    PredictionName::LastStep,
                    PredictionName::FirstOrderAdaptiveWindow,
                ]
                .map(|predictor| quantised(name, method, predictor, quantum));
                eprintln!(
                    "{name}, {method}, quantum {quantum:e} m: FRE {last:.1} % by the last step, \
                     {window:.1} % by an adaptive window"
                );
                if quantum <= 1e-4 {
                    assert!((last - window).abs() < 0.5, "{name}: {last} and {window}");
                } else {
                    changed += usize::from((last - window).abs() > 0.1);
                }
            }
        }
    }
    assert!(changed >= 4, "{changed}");
}

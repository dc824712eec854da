//! Tuning against single runs and known best settings.
#![allow(clippy::print_stdout)] // what was measured

use crate::common::scene;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::tune::{HEIGHTS, Objective, TuneError, best, tune};

fn grid(from: f64, step: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| from + step * f64::from(i)).collect()
}

#[test]
fn at_its_own_height_a_value_does_what_a_single_run_does() {
    for (method, value) in [
        (MethodName::VirtualDamper, 0.4),
        (MethodName::PopcRef, 3.0),
        (MethodName::Hfcr, 0.05),
    ] {
        let mut scene = scene("fig2");
        let points = tune(&scene, method, &[value], || ()).unwrap();
        let given = match method {
            MethodName::PopcRef => Settings::default().with(SettingKey::DAMPING_CAP, value),
            _ => Settings::default().with(SettingKey::DAMPING, value),
        };
        scene.settings.insert(method, given);
        let run = Bench::new(&scene).unwrap().run(method).unwrap();
        let error = run.force.fidelity.unwrap().mean_force_error;
        assert_eq!(points[0].mean_force_error.own, error, "{method}");
        assert_eq!(points[0].leak.own, run.last().ledger.held_leak.absolute);
    }
}

#[test]
fn median_and_worst_are_those_of_the_start_heights() {
    let scene = scene("experiment1");
    let mut finished = 0;
    let points = tune(&scene, MethodName::Hfcr, &[0.0], || finished += 1).unwrap();
    assert_eq!(finished, HEIGHTS);
    let mut errors: Vec<f64> = (-10..=10)
        .map(|step| {
            let mut scene = scene.clone();
            scene.object.position *= 1.0 + 0.005 * f64::from(step);
            scene.settings.clear();
            let run = Bench::new(&scene).unwrap().run(MethodName::Hfcr).unwrap();
            run.force.fidelity.unwrap().mean_force_error
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let spread = points[0].mean_force_error;
    assert!((spread.median - errors[10]).abs() < 1e-6, "{spread:?}");
    assert!((spread.worst - errors[20]).abs() < 1e-6, "{spread:?}");
    assert!(spread.worst > spread.median);
}

#[test]
fn the_damper_that_is_best_at_one_height_is_not_the_best_of_all() {
    let points = tune(
        &scene("fig2"),
        MethodName::VirtualDamper,
        &grid(0.0, 0.01, 201),
        || (),
    )
    .unwrap();
    let median = best(&points, Objective::Error).unwrap();
    let own = points
        .iter()
        .min_by(|a, b| a.mean_force_error.own.total_cmp(&b.mean_force_error.own))
        .unwrap();
    assert!((own.value - 0.53).abs() < 1e-9, "{own:?}");
    assert!((median.value - 0.39).abs() < 1e-9, "{median:?}");
    assert!(own.mean_force_error.median > 4.0 * median.mean_force_error.median);
}

#[test]
fn hfcr_has_a_flat_curve_where_the_damper_has_a_narrow_valley() {
    // The paper: b hardly matters, B does. The range is a factor of 4 around the best of each.
    let range = |method, centre: f64| {
        let values = [0.5 * centre, centre, 2.0 * centre];
        let points = tune(&scene("fig2"), method, &values, || ()).unwrap();
        let errors = points.iter().map(|point| point.mean_force_error.median);
        errors.clone().fold(0.0, f64::max) / errors.fold(f64::INFINITY, f64::min)
    };
    let (hfcr, damper) = (
        range(MethodName::Hfcr, 0.01),
        range(MethodName::VirtualDamper, 0.39),
    );
    println!("median error within a factor of 4: hfcr x{hfcr:.2}, damper x{damper:.2}");
    assert!(hfcr < 2.0 && damper > 4.0, "{hfcr}, {damper}");
}

#[test]
fn a_method_without_a_damping_and_a_scene_without_contact_are_refused() {
    let scene = scene("fig2");
    let error = tune(&scene, MethodName::Seh, &[0.1], || ()).unwrap_err();
    assert_eq!(error, TuneError::NothingToTune(MethodName::Seh));
    let mut apart = scene;
    apart.measure = palpate_scene::Measure::Duration(0.05);
    let error = tune(&apart, MethodName::Hfcr, &[0.1], || ()).unwrap_err();
    assert_eq!(error, TuneError::NoContact);
}

//! Force rendering errors of the paper's scenes, in percent.

use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::closed_loop::Bench;

use crate::common::{PAPER_SCENES, cap, damping, fidelity, scene, with};

/// FRE of a method on the paper's three scenes, with these settings on each.
fn errors(method: MethodName, settings: [Settings; 3]) -> [f64; 3] {
    let mut errors = [0.0; 3];
    for ((error, name), settings) in errors.iter_mut().zip(PAPER_SCENES).zip(settings) {
        *error = fidelity(&with(scene(name), method, settings), method).force_rendering_error;
    }
    eprintln!("{method}: FRE {errors:.2?} %");
    errors
}

fn assert_near(given: [f64; 3], expected: [f64; 3], tolerance: [f64; 3]) {
    for ((given, expected), tolerance) in given.into_iter().zip(expected).zip(tolerance) {
        assert!(
            (given - expected).abs() <= tolerance,
            "{given:.3} for {expected}"
        );
    }
}

/// Source: the paper's Fig. 2 scene and its experiments, with a point mass; derived here. No zero-order hold can do
/// better at this loop rate.
#[test]
fn hold_bounds() {
    let mut floors = [0.0; 3];
    for (floor, name) in floors.iter_mut().zip(PAPER_SCENES) {
        *floor = fidelity(&scene(name), MethodName::Basic).hold_bound;
    }
    eprintln!("floors {floors:.3?} %");
    assert_near(floors, [11.03, 17.32, 35.01], [0.006; 3]);
}

/// Source: the paper's baselines on its scenes, with a point mass and without friction.
#[test]
fn errors_of_methods_without_a_setting() {
    let none = [Settings::default(); 3];
    assert_near(
        errors(MethodName::Basic, none),
        [120.6, 121.9, 163.1],
        [0.1; 3],
    );
    assert_near(
        errors(MethodName::Seh, none),
        [102.3, 97.2, 141.5],
        [0.1; 3],
    );
    let hfcr = errors(MethodName::Hfcr, none);
    assert_near(hfcr, [15.0, 22.7, 107.7], [0.1; 3]);
}

/// Source: as above. The second experiment is chaotic in these settings: there, 1 %.
#[test]
fn errors_at_the_best_settings() {
    let tolerance = [0.15, 0.15, 1.0];
    let at = |values: [f64; 3], setting: fn(f64) -> Settings| values.map(setting);
    let damper = errors(MethodName::VirtualDamper, at([0.53, 0.57, 6.65], damping));
    assert_near(damper, [19.0, 23.4, 96.0], tolerance);
    let reference = errors(MethodName::PopcRef, at([3.45, 5.5, 0.9], cap));
    assert_near(reference, [43.1, 48.4, 129.0], tolerance);
    let hfcr = errors(MethodName::Hfcr, at([0.01, 0.0, 0.46], damping));
    assert_near(hfcr, [13.4, 22.7, 85.2], tolerance);
    // These are the settings the committed scenes come with.
    for method in [
        MethodName::VirtualDamper,
        MethodName::PopcRef,
        MethodName::Hfcr,
    ] {
        let committed = PAPER_SCENES.map(|name| fidelity(&scene(name), method));
        let expected = match method {
            MethodName::VirtualDamper => damper,
            MethodName::PopcRef => reference,
            _ => hfcr,
        };
        assert_near(
            committed.map(|f| f.force_rendering_error),
            expected,
            [0.0; 3],
        );
    }
}

/// Source: derived here: interval means are an orthogonal projection.
#[test]
fn the_square_of_the_error_is_that_of_the_floor_and_of_the_mean_force_error() {
    let mut worst = 0.0_f64;
    for name in PAPER_SCENES {
        let scene = scene(name);
        let bench = Bench::new(&scene).unwrap();
        for method in MethodName::ALL {
            let evaluated = bench.run(method).unwrap().force.fidelity.unwrap();
            let square = evaluated.hold_bound.powi(2) + evaluated.mean_force_error.powi(2);
            worst = worst.max((evaluated.force_rendering_error.powi(2) / square - 1.0).abs());
            let wrong = evaluated.mean_force_error;
            eprintln!("{name} {method}: E {wrong:.2e} %");
            // With the true model mass, on scenes that are perfect except for sampling, coupled leaves only the hold
            // bound.
            match method {
                MethodName::Coupled => assert!(wrong < 0.001, "{name}"),
                // Least for energy-corrected in experiment 1.
                _ => assert!(wrong > 3.0, "{name} {method}"),
            }
        }
    }
    eprintln!("largest relative difference {worst:.1e}");
    assert!(worst < 1e-12);
}

//! Robustness of an optimum: the same setting from 21 heights.

use palpate_scene::method::{MethodName, Settings};

use crate::common::{PAPER_SCENES, cap, damping, fidelity, scene, with};

/// Best on the scenes themselves, of grids of 0.01 and 0.05 N s/m.
const BEST_DAMPING: [f64; 3] = [0.53, 0.57, 6.65];
const BEST_CAP: [f64; 3] = [3.45, 5.5, 0.9];

/// Mean-force errors E `[%]` from 21 start heights within 5 % of the scene's, sorted.
fn errors_over_heights(name: &str, method: MethodName, settings: Settings) -> Vec<f64> {
    let mut errors: Vec<f64> = (-10..=10)
        .map(|step| {
            let mut scene = with(scene(name), method, settings);
            scene.object.position *= 1.0 + 0.005 * f64::from(step);
            fidelity(&scene, method).mean_force_error
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Median and worst E `[%]` on the paper's three scenes.
type Expected = [(f64, f64); 3];

/// Source: derived here, on the paper's scenes.
///
/// A method that needs its setting found on the very scene looks better there than it is: the best
/// damper of Fig. 2 has E = 15.5 % at its height, and 88 % at half of the heights around it.
#[test]
fn median_and_worst_mean_force_error_over_start_heights() {
    let none = [Settings::default(); 3];
    let rows: [(&str, MethodName, [Settings; 3], Expected); 5] = [
        (
            "basic",
            MethodName::Basic,
            none,
            [(118.9, 120.6), (121.2, 128.5), (156.2, 201.0)],
        ),
        (
            "seh",
            MethodName::Seh,
            none,
            [(96.4, 103.4), (96.8, 105.4), (163.0, 276.1)],
        ),
        (
            "virtual-damper, best B",
            MethodName::VirtualDamper,
            BEST_DAMPING.map(damping),
            [(88.2, 94.4), (18.4, 21.0), (184.9, 242.3)],
        ),
        (
            "popc-ref, best cap",
            MethodName::PopcRef,
            BEST_CAP.map(cap),
            [(41.8, 51.7), (56.0, 97.4), (149.5, 244.3)],
        ),
        (
            "hfcr, b = 0",
            MethodName::Hfcr,
            none,
            [(10.0, 11.1), (14.8, 15.3), (100.4, 107.0)],
        ),
    ];
    eprintln!("E in %: at the scene's height; median / worst of 21 heights; {PAPER_SCENES:?}");
    for (label, method, settings, expected) in rows {
        let mut line = format!("| {label} |");
        let mut measured = Vec::new();
        for (name, settings) in PAPER_SCENES.into_iter().zip(settings) {
            let here = fidelity(&with(scene(name), method, settings), method).mean_force_error;
            let errors = errors_over_heights(name, method, settings);
            line += &format!(" {here:.1}; {:.1} / {:.1} |", errors[10], errors[20]);
            measured.push((errors[10], errors[20]));
        }
        eprintln!("{line}");
        // The second experiment amplifies rounding: looser there.
        for ((given, expected), tolerance) in measured.iter().zip(expected).zip([0.1, 0.1, 1.0]) {
            assert!((given.0 - expected.0).abs() <= tolerance, "{label}: median");
            assert!((given.1 - expected.1).abs() <= tolerance, "{label}: worst");
        }
    }
}

/// FRE `[%]` for every setting of a grid that begins with its step.
fn errors_on_grid(
    name: &str,
    method: MethodName,
    step: f64,
    count: u32,
    setting: fn(f64) -> Settings,
) -> Vec<(f64, f64)> {
    (1..=count)
        .map(|i| {
            let value = step * f64::from(i);
            let scene = with(scene(name), method, setting(value));
            (value, fidelity(&scene, method).force_rendering_error)
        })
        .collect()
}

/// Source: the settings committed with the paper's scenes; derived here.
#[test]
fn the_committed_settings_are_the_best_of_their_grids() {
    let rows = [
        (
            MethodName::VirtualDamper,
            0.01,
            800,
            damping as fn(f64) -> Settings,
            BEST_DAMPING,
        ),
        (MethodName::PopcRef, 0.05, 300, cap, BEST_CAP),
        (MethodName::Hfcr, 0.01, 200, damping, [0.01, 0.0, 0.46]),
    ];
    for (method, step, count, setting, best) in rows {
        for (name, best) in PAPER_SCENES.into_iter().zip(best) {
            let mut grid = errors_on_grid(name, method, step, count, setting);
            if method == MethodName::Hfcr {
                let scene = with(scene(name), method, damping(0.0));
                grid.push((0.0, fidelity(&scene, method).force_rendering_error));
            }
            let (value, error) = grid.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            eprintln!("{name}, {method}: FRE {error:.2} % at {value:.2} N s/m");
            assert!((value - best).abs() < 1e-9, "{value} for {best}");
        }
    }
}

/// Source: derived here. In a chaotic loop the error is a jagged function of a setting, and an optimum is accidental.
#[test]
fn in_the_second_experiment_the_best_damper_is_no_robust_setting() {
    let grid = errors_on_grid("experiment2", MethodName::VirtualDamper, 0.01, 800, damping);
    let at = |value: f64| {
        let near = grid
            .iter()
            .find(|(damping, _)| (damping - value).abs() < 1e-9);
        near.unwrap().1
    };
    let (here, near) = (at(3.80), at(3.82));
    let neighbours = [at(6.64), at(6.65), at(6.66)];
    eprintln!(
        "FRE {here:.1} % at B = 3.80 N s/m, {near:.1} % at 3.82; {neighbours:.1?} % at 6.64, 6.65 \
         and 6.66"
    );
    assert!((here - 191.0).abs() < 2.0 && (near - 131.0).abs() < 2.0);
    assert!(neighbours[0] > neighbours[1] + 10.0 && neighbours[2] > neighbours[1] + 10.0);
    let largest_jump = |grid: &[(f64, f64)]| {
        grid.windows(2)
            .map(|pair| (pair[1].1 - pair[0].1).abs())
            .fold(0.0, f64::max)
    };
    let hfcr = errors_on_grid("experiment2", MethodName::Hfcr, 0.01, 100, damping);
    let jumps = (largest_jump(&grid), largest_jump(&hfcr));
    eprintln!("largest jump from a setting to the next: {jumps:.1?} % (damper to 8, hfcr to 1)");
    assert!(jumps.0 > 90.0 && jumps.1 < jumps.0);
}

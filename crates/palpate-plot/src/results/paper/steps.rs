//! Fig. 2: the block on the light device, step by step.

use crate::figure::Figure;
use palpate_scene::Scene;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_study::report::{Report, Subject};
use palpate_study::sim::closed_loop::{Bench, LoopError};

use crate::results::step_by_step;

/// Dampings of HFCR compared over many collisions `[N s/m]`, with their labels.
const DAMPINGS: [(f64, &str); 4] = [
    (0.0, "b = 0 N s/m"),
    (0.0125, "b = 0.0125 N s/m"),
    (0.03, "b = 0.03 N s/m"),
    (0.05, "b = 0.05 N s/m"),
];

/// Returns Fig. 2 of `scene`: the steps from the basic model to HFCR, then the methods `besides`.
///
/// # Errors
/// The scene cannot be simulated.
pub fn fig2(
    scene: &Scene,
    besides: &[(MethodName, &'static str)],
) -> Result<(Report, Figure), LoopError> {
    const STEPS: [(MethodName, &str); 4] = [
        (MethodName::Basic, "basic model"),
        (MethodName::HfcrMod, "modified force"),
        (MethodName::HfcrModSt, "+ smooth transitions"),
        (MethodName::Hfcr, "+ leak dissipation"),
    ];
    let columns = [&STEPS, besides].concat();
    let methods: Vec<MethodName> = columns.iter().map(|(method, _)| *method).collect();
    let bench = Bench::new(scene)?;
    let runs = bench.run_all(&methods)?;
    let steps: Vec<_> = columns
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    let figure = step_by_step(&scene.title, bench.reference(), &steps);
    let report = Report::new(&Subject::new(scene), bench.reference(), &runs);
    Ok((report, figure))
}

/// Returns Fig. 2 of `scene` over many collisions: HFCR with several dampings.
///
/// # Errors
/// The scene cannot be simulated.
pub fn fig2_long(scene: &Scene) -> Result<(Report, Figure, String), LoopError> {
    let mut runs = Vec::with_capacity(DAMPINGS.len());
    for (damping, _) in DAMPINGS {
        let mut damped = scene.clone();
        let settings = Settings::default().with(SettingKey::DAMPING, damping);
        damped.settings.insert(MethodName::Hfcr, settings);
        let bench = Bench::new(&damped)?;
        runs.push(bench.run(MethodName::Hfcr)?);
    }
    let steps: Vec<_> = DAMPINGS.iter().map(|(_, name)| *name).zip(&runs).collect();
    let bench = Bench::new(scene)?;
    let figure = step_by_step(&scene.title, bench.reference(), &steps);
    let report = Report::new(&Subject::new(scene), bench.reference(), &runs);
    let dampings = DAMPINGS.map(|(damping, _)| damping.to_string()).join(", ");
    let below = format!("\nFrom top to bottom b = {dampings} N s/m.\n");
    Ok((report, figure, below))
}

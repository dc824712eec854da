//! Fig. 2: the block on the light device, step by step.

use palpate_scene::SceneFile;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_sim::closed_loop::Bench;

use super::super::simulate::simulate;
use crate::failure::Failure;
use crate::plots;
use palpate_figure::Figure;
use palpate_study::report::{Report, Subject};

const FIG2: &str = include_str!("../../../experiments/fig2.toml");
const LONG: &str = include_str!("../../../experiments/fig2_long.toml");

/// Dampings of HFCR that are beside each other over many collisions `[N s/m]`, and what they are.
const DAMPINGS: [(f64, &str); 4] = [
    (0.0, "b = 0"),
    (0.0125, "b = 0.0125"),
    (0.03, "b = 0.03"),
    (0.05, "b = 0.05 N s/m"),
];

/// Fig. 2: from the basic model to HFCR, and then what is shown `besides`.
pub fn fig2(besides: &[(MethodName, &'static str)]) -> Result<(Report, Figure), Failure> {
    const STEPS: [(MethodName, &str); 4] = [
        (MethodName::Basic, "basic model"),
        (MethodName::HfcrMod, "modified force"),
        (MethodName::HfcrModSt, "+ smooth transitions"),
        (MethodName::Hfcr, "+ leak dissipation"),
    ];
    let columns = [&STEPS, besides].concat();
    let methods: Vec<MethodName> = columns.iter().map(|(method, _)| *method).collect();
    let file = SceneFile::parse("fig2.toml", FIG2).map_err(Failure::input)?;
    let (bench, runs) = simulate(&file.scene, &methods)?;
    let steps: Vec<_> = columns
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    let figure = plots::step_by_step(&file.scene.title, bench.reference(), &steps);
    let report = Report::new(&Subject::of(&file.scene), bench.reference(), &runs);
    Ok((report, figure))
}

/// Fig. 2 over many collisions: HFCR with several dampings.
pub fn fig2_long() -> Result<(Report, Figure, String), Failure> {
    let file = SceneFile::parse("fig2_long.toml", LONG).map_err(Failure::input)?;
    let mut runs = Vec::with_capacity(DAMPINGS.len());
    for (damping, _) in DAMPINGS {
        let mut scene = file.scene.clone();
        let settings = Settings::default().with(SettingKey::DAMPING, damping);
        scene.settings.insert(MethodName::Hfcr, settings);
        let bench = Bench::new(&scene).map_err(Failure::input)?;
        runs.push(bench.run(MethodName::Hfcr).map_err(Failure::input)?);
    }
    let steps: Vec<_> = DAMPINGS.iter().map(|(_, name)| *name).zip(&runs).collect();
    let bench = Bench::new(&file.scene).map_err(Failure::input)?;
    let figure = plots::step_by_step(&file.scene.title, bench.reference(), &steps);
    let report = Report::new(&Subject::of(&file.scene), bench.reference(), &runs);
    let dampings = DAMPINGS.map(|(damping, _)| damping.to_string()).join(", ");
    let below = format!("\nFrom top to bottom b = {dampings} N s/m.\n");
    Ok((report, figure, below))
}

//! `palpate figure`: figures of the paper.

use std::path::PathBuf;

use palpate_sim::method::MethodName;
use palpate_sim::scene::SceneFile;

use super::simulate::{simulate, subject};
use crate::arguments::{FigureArguments, FigureName};
use crate::failure::Failure;
use crate::figure::Figure;
use crate::plots;
use crate::report::Report;
use crate::results::{draw, print};

/// The scene of Fig. 2, as in `experiments/fig2.toml`.
const FIG2: &str = include_str!("../../../../experiments/fig2.toml");

/// Draws a figure and prints its numbers.
pub fn run(arguments: &FigureArguments) -> Result<(), Failure> {
    let FigureName::Fig2 = arguments.figure;
    let path = arguments
        .plot
        .clone()
        .unwrap_or_else(|| PathBuf::from("fig2.svg"));
    let (mut report, figure) = fig2()?;
    draw(&path, &figure)?;
    report.wrote(&path);
    print(&if arguments.json {
        report.json() + "\n"
    } else {
        report.to_string()
    })
}

/// Fig. 2: the block on the light device, step by step from the basic model to HFCR.
pub fn fig2() -> Result<(Report, Figure), Failure> {
    const STEPS: [(MethodName, &str); 4] = [
        (MethodName::Basic, "basic model"),
        (MethodName::HfcrMod, "modified force"),
        (MethodName::HfcrModSt, "+ smooth transitions"),
        (MethodName::Hfcr, "+ leak dissipation"),
    ];
    let file = SceneFile::parse("fig2.toml", FIG2).map_err(Failure::input)?;
    let (bench, runs) = simulate(&file.scene, &STEPS.map(|(method, _)| method))?;
    let steps: Vec<_> = STEPS
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    let figure = plots::step_by_step(&file.scene.title, bench.reference(), &steps);
    let report = Report::new(&subject(&file.scene), bench.reference(), &runs);
    Ok((report, figure))
}

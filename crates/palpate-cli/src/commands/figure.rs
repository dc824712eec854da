//! `palpate figure`: figures of the paper.

use std::fmt::Write;
use std::path::PathBuf;

use comfy_table::CellAlignment;
use palpate_scene::method::MethodName;
use palpate_scene::{Measure, SceneFile};
use palpate_sim::closed_loop::error_against;
use palpate_sim::run::Run;

use super::simulate::{simulate, subject};
use crate::arguments::{FigureArguments, FigureName};
use crate::failure::Failure;
use crate::plots;
use crate::progress::Progress;
use crate::report::{Report, lines, number, percent, plain_table};
use crate::results::{draw, plan_picture, print};
use palpate_figure::{Figure, Sheet};

/// The scenes of the figures, as in `experiments/`.
const FIG2: &str = include_str!("../../../../experiments/fig2.toml");
const FIG4: &str = include_str!("../../../../experiments/fig4.toml");
const FIG5: &str = include_str!("../../../../experiments/fig5.toml");

/// What the paper measured on its device: FRE in percent, or that the method failed.
type Measured = [(MethodName, &'static str); 3];
const MEASURED_1: Measured = [
    (MethodName::Hfcr, "17.1"),
    (MethodName::PopcRef, "51.1"),
    (MethodName::VirtualDamper, "84.9"),
];
const MEASURED_2: Measured = [
    (MethodName::Hfcr, "52.2"),
    (MethodName::PopcRef, "failed"),
    (MethodName::VirtualDamper, "failed"),
];

/// Period of the loop that the paper takes for the truth `[s]`.
const FINE_PERIOD: f64 = 0.001;

/// Draws a figure and prints its numbers.
pub fn run(arguments: &FigureArguments) -> Result<(), Failure> {
    let name = match arguments.figure {
        FigureName::Fig2 => "fig2.svg",
        FigureName::Fig4 => "fig4.svg",
        FigureName::Fig5 => "fig5.svg",
    };
    let path = arguments
        .plot
        .clone()
        .unwrap_or_else(|| PathBuf::from(name));
    let mut outputs = arguments.overwriting.outputs();
    plan_picture(&mut outputs, "--plot", &path)?;
    let progress = Progress::new(1);
    progress.begin(name);
    let (mut report, figure, comparison) = match arguments.figure {
        FigureName::Fig2 => {
            fig2(&[]).map(|(report, figure)| (report, Sheet::from(&figure), None))?
        }
        FigureName::Fig4 => experiment(FIG4, &MEASURED_1)?,
        FigureName::Fig5 => experiment(FIG5, &MEASURED_2)?,
    };
    drop(progress);
    draw(&outputs, &path, &figure)?;
    report.wrote(&path);
    print(&if arguments.json {
        report.json() + "\n"
    } else {
        format!("{report}{}", comparison.unwrap_or_default())
    })
}

/// Fig. 2: the block on the light device, step by step from the basic model to HFCR,
/// and then what is shown `besides`.
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
    let report = Report::new(&subject(&file.scene), bench.reference(), &runs);
    Ok((report, figure))
}

/// Figs. 4 and 5: the paper's five methods on one of its experiments, against the ideal and, as the
/// paper does, against the basic model at 1 kHz.
fn experiment(
    scene: &str,
    measured: &Measured,
) -> Result<(Report, Sheet, Option<String>), Failure> {
    const METHODS: [(MethodName, &str); 5] = [
        (MethodName::Basic, "basic model"),
        (MethodName::Seh, "SEH"),
        (MethodName::VirtualDamper, "virtual damper"),
        (MethodName::PopcRef, "POPC-REF"),
        (MethodName::Hfcr, "HFCR"),
    ];
    let file = SceneFile::parse("experiment", scene).map_err(Failure::input)?;
    let (bench, runs) = simulate(&file.scene, &METHODS.map(|(method, _)| method))?;
    let mut fine = file.scene.clone();
    fine.loop_params.period = FINE_PERIOD;
    let window = bench.reference().profile.intervals() as f64 * file.scene.loop_params.period;
    fine.measure = Measure::Duration(window);
    let (_, fine_runs) = simulate(&fine, &[MethodName::Basic])?;
    let columns: Vec<_> = METHODS
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    let fine = ("basic at 1 kHz", &fine_runs[0]);
    let figure = plots::method_by_method(&file.scene.title, bench.reference(), &columns, fine);
    let report = Report::new(&subject(&file.scene), bench.reference(), &runs);
    let comparison = beside_the_paper(&runs, &fine_runs[0], measured);
    Ok((report, figure, Some(comparison)))
}

/// FRE against the ideal and against the basic model at 1 kHz, beside what the paper measured.
fn beside_the_paper(runs: &[Run], fine: &Run, measured: &Measured) -> String {
    let header = [
        "method",
        "FRE % to ideal",
        "to basic at 1 kHz",
        "paper, on its device",
    ];
    let mut table = plain_table(CellAlignment::Left, &header);
    for run in runs {
        let fidelity = run.force.fidelity;
        let found = measured.iter().find(|(method, _)| run.method == *method);
        table.add_row([
            run.method.name().into(),
            number(fidelity.map(|f| f.force_rendering_error), percent),
            number(error_against(run, fine), percent),
            comfy_table::Cell::new(found.map_or("-", |(_, value)| value))
                .set_alignment(CellAlignment::Right),
        ]);
    }
    let mut text = String::new();
    let to_ideal = fine.force.fidelity.map(|f| f.force_rendering_error);
    let _ = write!(
        text,
        "\nBeside the paper (its device, user and tuning were others)\n\n{}\n\nThe basic model at 1 kHz \
         is itself {} % off the ideal{}.\n",
        lines(&table),
        to_ideal.map_or_else(|| "-".into(), percent),
        fine.jammed_at
            .map_or_else(String::new, |time| format!(", and jams at {time:.2} s")),
    );
    text
}

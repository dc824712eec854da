//! `palpate paper figure`: figures of the paper.

use std::path::PathBuf;

use palpate_plot::paper::{self, MEASURED_1, MEASURED_2};
use palpate_scene::{ContactFile, Linkage, Scene};
use palpate_study::json;
use palpate_study::report::DrawingReport;

use crate::arguments::{FigureArguments, FigureName};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, plan_picture, print};
use palpate_plot::figure::{Drawing, Picture, Sheet};
use palpate_study::report::Report;

/// The scenes of the figures.
const SCENES: [(&str, &str); 5] = [
    ("fig2.toml", include_str!("../../../experiments/fig2.toml")),
    (
        "fig2_long.toml",
        include_str!("../../../experiments/fig2_long.toml"),
    ),
    ("fig4.toml", include_str!("../../../experiments/fig4.toml")),
    ("fig5.toml", include_str!("../../../experiments/fig5.toml")),
    (
        "fig5_box.toml",
        include_str!("../../../experiments/fig5_box.toml"),
    ),
];

/// The scene of a figure.
pub fn scene(name: &str) -> Result<Scene, Failure> {
    let (_, text) = SCENES
        .iter()
        .find(|(scene, _)| *scene == name)
        .expect("it is one of the scenes");
    Ok(ContactFile::parse(name, text)
        .map_err(Failure::input)?
        .scene)
}

/// A figure with its report.
enum Drawn {
    /// Figure of runs, with a report and a text below it.
    Runs(Box<Report>, Sheet, String),
    /// Drawing without runs.
    Drawing(Drawing),
}

impl Drawn {
    fn picture(&self) -> &dyn Picture {
        match self {
            Self::Runs(_, sheet, _) => sheet,
            Self::Drawing(drawing) => drawing,
        }
    }
}

/// Draws a figure and prints its numbers.
pub fn run(arguments: &FigureArguments) -> Result<(), Failure> {
    let name = match arguments.figure {
        FigureName::Fig1 => "fig1.svg",
        FigureName::Fig2 => "fig2.svg",
        FigureName::Fig2Long => "fig2-long.svg",
        FigureName::Fig3 => "fig3.svg",
        FigureName::Fig4 => "fig4.svg",
        FigureName::Fig5 => "fig5.svg",
        FigureName::Fig5Box => "fig5-box.svg",
    };
    let path = arguments
        .plot
        .clone()
        .unwrap_or_else(|| PathBuf::from(name));
    let mut outputs = arguments.overwriting.outputs();
    plan_picture(&mut outputs, "--plot", &path)?;
    let progress = Progress::new(1);
    progress.begin(name);
    let of_runs = |(report, sheet, below): (Report, Sheet, String)| {
        Drawn::Runs(Box::new(report), sheet, below)
    };
    let experiment = |name: &str, measured| {
        paper::experiment(&scene(name)?, measured)
            .map(of_runs)
            .map_err(Failure::input)
    };
    let drawn = match arguments.figure {
        FigureName::Fig1 => Drawn::Drawing(paper::modes()),
        FigureName::Fig2 => {
            let (report, figure) =
                paper::fig2(&scene("fig2.toml")?, &[]).map_err(Failure::input)?;
            of_runs((report, Sheet::from(&figure), String::new()))
        }
        FigureName::Fig2Long => {
            let (report, figure, below) =
                paper::fig2_long(&scene("fig2_long.toml")?).map_err(Failure::input)?;
            of_runs((report, Sheet::from(&figure), below))
        }
        FigureName::Fig3 => {
            let linkage = Linkage::preset("paper-like").expect("it is one of the presets");
            Drawn::Drawing(paper::linkage(&linkage).map_err(Failure::input)?)
        }
        FigureName::Fig4 => experiment("fig4.toml", &MEASURED_1)?,
        FigureName::Fig5 => experiment("fig5.toml", &MEASURED_2)?,
        FigureName::Fig5Box => experiment("fig5_box.toml", &MEASURED_2)?,
    };
    drop(progress);
    let drawn = match drawn {
        Drawn::Runs(report, sheet, below) => Drawn::Runs(report, arguments.time.cut(sheet)?, below),
        drawing @ Drawn::Drawing(_) => drawing,
    };
    draw(&outputs, &path, drawn.picture(), &arguments.look)?;
    print(&match drawn {
        Drawn::Runs(mut report, _, below) => {
            report.wrote(&path);
            if arguments.json {
                report.json() + "\n"
            } else {
                format!("{report}{below}")
            }
        }
        Drawn::Drawing(_) if arguments.json => json(&DrawingReport::new(&path)) + "\n",
        Drawn::Drawing(_) => format!("wrote {}\n", path.display()),
    })
}

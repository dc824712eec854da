//! `palpate figure`: figures of the paper.

mod experiment;
mod linkage;
mod modes;
mod steps;

use std::path::PathBuf;

use palpate_scene::Linkage;
use palpate_study::json;
use palpate_study::report::DrawingReport;

use crate::arguments::{FigureArguments, FigureName};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, plan_picture, print};
use palpate_figure::{Drawing, Picture, Sheet};
use palpate_study::report::Report;

pub use steps::fig2;

/// A figure, and what it has to say beside itself.
enum Drawn {
    /// Of runs, with a report and what stands below it.
    Runs(Box<Report>, Sheet, String),
    /// Of no run.
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
    let drawn = match arguments.figure {
        FigureName::Fig1 => Drawn::Drawing(modes::drawing()),
        FigureName::Fig2 => {
            let (report, figure) = fig2(&[])?;
            of_runs((report, Sheet::from(&figure), String::new()))
        }
        FigureName::Fig2Long => {
            let (report, figure, below) = steps::fig2_long()?;
            of_runs((report, Sheet::from(&figure), below))
        }
        FigureName::Fig3 => {
            let linkage = Linkage::preset("paper-like").expect("it is one of the presets");
            Drawn::Drawing(linkage::drawing(&linkage).map_err(Failure::input)?)
        }
        FigureName::Fig4 => of_runs(experiment::fig4()?),
        FigureName::Fig5 => of_runs(experiment::fig5()?),
        FigureName::Fig5Box => of_runs(experiment::fig5_box()?),
    };
    drop(progress);
    let drawn = match drawn {
        Drawn::Runs(report, sheet, below) => Drawn::Runs(report, arguments.time.cut(sheet)?, below),
        drawing @ Drawn::Drawing(_) => drawing,
    };
    draw(&outputs, &path, drawn.picture(), arguments.size)?;
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

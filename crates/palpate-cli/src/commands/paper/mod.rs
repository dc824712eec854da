//! `palpate paper`: figures, claims and start heights of the paper.

mod claims;
pub mod figure;
mod heights;

use clap::{Args, Subcommand};

use crate::arguments::{ClaimsArguments, FigureArguments, HeightsArguments};
use crate::failure::Failure;

/// Arguments of `paper`.
#[derive(Args, Debug)]
pub struct PaperArguments {
    /// The result to reproduce.
    #[command(subcommand)]
    pub what: What,
}

/// Results of the paper.
#[derive(Subcommand, Debug)]
pub enum What {
    /// Draw a figure of the paper
    #[command(after_help = "\
Examples:
  palpate paper figure fig1
  palpate paper figure fig4
  palpate paper figure fig2 --plot fig2.svg --json")]
    Figure(FigureArguments),
    /// Check the numbers that the paper claims
    #[command(long_about = "\
Check the numbers that the paper claims.

Each claim is recomputed on the scenes of experiments/, and listed with its criterion. A claim that does not \
hold here is not a failure of this program: the exit code is 0.")]
    #[command(after_help = "\
Example:
  palpate paper claims")]
    Claims(ClaimsArguments),
    /// Evaluate methods on scenes from 21 start heights
    #[command(long_about = "\
Evaluate methods on scenes from 21 start heights.

The gap between device and object changes by up to 5 %, because an error at a single height can be a \
coincidence. --model-mass-factor gives the renderer a wrong mass of the device. Settings are the scene's.")]
    #[command(after_help = "\
Examples:
  palpate paper heights experiments/fig2.toml experiments/experiment1.toml --model-mass-factor 1.5
  palpate paper heights experiments/experiment2.toml --method hfcr,hfcr-mod-st --json")]
    Heights(HeightsArguments),
}

/// Reproduces a result of the paper.
pub fn run(arguments: &PaperArguments) -> Result<(), Failure> {
    match &arguments.what {
        What::Figure(arguments) => figure::run(arguments),
        What::Claims(arguments) => claims::run(arguments),
        What::Heights(arguments) => heights::run(arguments),
    }
}

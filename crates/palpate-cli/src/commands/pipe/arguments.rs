//! Arguments of `pipe`.

use std::path::PathBuf;

use crate::pipe::{AnswerColumn, Columns, columns};
use clap::{Args, ValueHint};
use palpate_record::unit::LengthUnit;

use crate::arguments::{Flags, Given};
use crate::values::{length_unit, number};

/// Arguments of `pipe`.
#[derive(Args, Debug)]
pub struct PipeArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Scene file (TOML): a world of several bodies, or a scene as for --scene
    #[arg(value_name = "FILE.toml", value_hint = ValueHint::FilePath, conflicts_with = "scene")]
    pub file: Option<PathBuf>,
    /// Scene file (TOML) for contact, loop, method and device mass; flags change its values
    #[arg(long, value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: Option<PathBuf>,
    /// Input and output format.
    #[command(flatten)]
    pub stream: StreamArguments,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
    /// Print the final summary on standard error as JSON
    #[arg(long)]
    pub json: bool,
}

/// Input and output format.
#[derive(Args, Debug)]
#[command(next_help_heading = "Stream")]
pub struct StreamArguments {
    /// Each line is a time and a position, `t_s,position_m`; without it a line is a position
    #[arg(long)]
    pub time: bool,
    /// Unit of the input positions: m, cm, mm or um; m also disables the plausibility check of the motion's length and
    /// speed [default: m, or that of the header]
    #[arg(long, value_name = "UNIT", value_parser = length_unit)]
    pub unit: Option<LengthUnit>,
    /// Columns to print.
    #[arg(long, value_name = "NAMES", value_parser = columns, default_value = "force", help = columns_help())]
    pub columns: Columns,
    /// Print the names of the columns first, with their units
    #[arg(long)]
    pub header: bool,
    /// Duration of the soft start if a start or a recovery finds contact, at most 60 [s]; 0: none [default: 0.2]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub soft_start: Option<f64>,
}

/// Returns the help of `--columns` with the names.
fn columns_help() -> String {
    let names = AnswerColumn::all().map(AnswerColumn::short_name);
    let names: Vec<_> = names.collect();
    format!(
        "Columns to print, in this order, separated by commas: {}; all in SI units",
        names.join(", ")
    )
}

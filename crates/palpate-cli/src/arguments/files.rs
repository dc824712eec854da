//! Arguments about files: what becomes of those that are there, and which part of a motion is read.

use std::path::PathBuf;

use clap::{ArgAction, Args, ValueHint};
use palpate_figure::Size;
use palpate_files::atomic::Existing;
use palpate_files::outputs::{Kept, Outputs};
use palpate_record::trace::{Delimiter, Layout, Part, Ways};
use palpate_record::unit::{LengthUnit, TimeUnit};

use crate::failure::Failure;
use crate::values::{TraceColumns, delimiter, length_unit, number, time_unit, trace_columns};

/// What becomes of files that are there already. The flag `--force` of other programs is the
/// virtual force here.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct Overwriting {
    /// Replace files that are there already; without it they are kept, and nothing is done
    #[arg(long, action = ArgAction::SetTrue, help_heading = "Results")]
    pub overwrite: bool,
}

impl Overwriting {
    /// The files of a command, none yet.
    pub fn outputs(self) -> Outputs {
        let existing = if self.overwrite {
            Existing::Replace
        } else {
            Existing::Keep
        };
        Outputs::new(existing).keeping(Kept {
            kind: "a recording",
            begins: palpate_record::recording::BEGINS,
        })
    }
}

/// Where the figure of a command goes.
#[derive(Args, Debug, Default, Clone)]
pub struct PlotFlags {
    /// Draw a figure into a file, .svg or .pdf (or .png where built with the feature png)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub plot: Option<PathBuf>,
    /// How large it is.
    #[command(flatten)]
    pub size: SizeFlag,
}

/// How large a figure is.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct SizeFlag {
    /// Size of the figure: column (85 mm wide), page (170 mm wide), slide (254x142.9), or width and
    /// height in mm, such as 120x80 [default: its own]
    #[arg(long, value_name = "SIZE", help_heading = "Results")]
    pub size: Option<Size>,
}

/// Which part of a figure over time is drawn.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct TimeFlags {
    /// Draw the figure from this time on [s]; what is computed stays the same [default: its begin]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Results")]
    pub plot_from: Option<f64>,
    /// Draw the figure up to this time [s] [default: its end]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Results")]
    pub plot_to: Option<f64>,
}

/// How the table of a recorded motion is laid out.
#[derive(Args, Debug, Default, Clone)]
pub struct TraceFlags {
    /// Unit of the positions in the table: m, cm, mm or um; m also means that a motion too long or too
    /// fast for a hand is right [default: that of the unit row or the column's name]
    #[arg(long, value_name = "UNIT", value_parser = length_unit)]
    pub unit: Option<LengthUnit>,
    /// Unit of the times: s, ms, us or ns; s also means that samples so far apart are right [default:
    /// that of the unit row or the column's name]
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    pub time_unit: Option<TimeUnit>,
    /// Columns of the table: t=time,x=X (of one contact t, x and force; of a world t, x,
    /// y, z, qw, qx, qy, qz, of several devices NAME.x); t=#2: the second column
    #[arg(long, value_name = "QUANTITY=COLUMN,...", value_parser = trace_columns)]
    pub columns: Option<TraceColumns>,
    /// What separates the columns: comma, semicolon or tab [default: what separates those of the header]
    #[arg(long, value_name = "NAME", value_parser = delimiter)]
    pub delimiter: Option<Delimiter>,
    /// Read numbers with a comma in place of the decimal point
    #[arg(long)]
    pub decimal_comma: bool,
    /// Leave out samples without a value: an empty cell, NaN, NA or null; without it they are refused
    #[arg(long)]
    pub skip_missing: bool,
}

impl TraceFlags {
    /// Their names, for the list of flags that a command takes.
    pub const NAMES: [&str; 6] = [
        "unit",
        "time_unit",
        "columns",
        "delimiter",
        "decimal_comma",
        "skip_missing",
    ];

    /// The layout that they say.
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::in_unit(self.unit);
        layout.time_unit = self.time_unit;
        layout.columns = self
            .columns
            .as_ref()
            .map_or_else(Vec::new, |columns| columns.0.clone());
        layout.delimiter = self.delimiter;
        layout.decimal_comma = self.decimal_comma;
        layout.skip_missing = self.skip_missing;
        layout.ways = Ways::Flags;
        layout
    }

    /// The first of them that was given.
    pub fn given(&self) -> Option<&'static str> {
        [
            ("--unit", self.unit.is_some()),
            ("--time-unit", self.time_unit.is_some()),
            ("--columns", self.columns.is_some()),
            ("--delimiter", self.delimiter.is_some()),
            ("--decimal-comma", self.decimal_comma),
            ("--skip-missing", self.skip_missing),
        ]
        .into_iter()
        .find_map(|(flag, is_given)| is_given.then_some(flag))
    }
}

/// Which part of a recorded motion is taken.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct PartFlags {
    /// Take the recorded motion from this time of its own on [s] [default: its first sample]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub from: Option<f64>,
    /// Take it up to this time of its own [s]; nothing after it is read [default: its last sample]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub to: Option<f64>,
}

impl PartFlags {
    /// The part, which lasts at most `longest` `[s]`.
    pub fn part(self, longest: f64) -> Result<Part, Failure> {
        let part = Part {
            from: self.from.unwrap_or(Part::WHOLE.from),
            to: self.to.unwrap_or(Part::WHOLE.to),
            longest,
        };
        if part.from < part.to {
            return Ok(part);
        }
        Err(Failure::Arguments(format!(
            "--from {} --to {}: the part must begin before it ends",
            part.from, part.to
        )))
    }

    /// Whether a part was asked for.
    pub fn is_given(self) -> bool {
        self.from.is_some() || self.to.is_some()
    }

    /// What a receipt says of the part.
    pub fn receipt(self) -> impl Iterator<Item = (String, String)> {
        let line = |(name, time): (&str, Option<f64>)| {
            time.map(|time| (name.to_owned(), time.to_string()))
        };
        [("from_s", self.from), ("to_s", self.to)]
            .into_iter()
            .filter_map(line)
    }
}

//! Arguments for files: overwriting, figures, trace layout and the selected part of a motion.

use std::path::PathBuf;

use clap::{ArgAction, Args, ValueHint};
use palpate_plot::figure::{Size, Wording};
use palpate_record::files::atomic::Existing;
use palpate_record::files::outputs::{Kept, Outputs};
use palpate_record::trace::{Delimiter, Layout, Part, Ways};
use palpate_record::unit::{LengthUnit, TimeUnit};

use crate::failure::Failure;
use crate::values::{TraceColumns, delimiter, length_unit, number, time_unit, trace_columns};

/// Overwriting of existing files. The flag `--force` of other programs is the virtual force here.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct Overwriting {
    /// Replace existing files; without it they are kept and the command stops
    #[arg(long, action = ArgAction::SetTrue, help_heading = "Results")]
    pub overwrite: bool,
}

impl Overwriting {
    /// Creates an empty list of a command's output files.
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

/// Figure of a command.
#[derive(Args, Debug, Default, Clone)]
pub struct PlotFlags {
    /// Draw a figure into a file, .svg or .pdf (or .png where built with the feature png)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub plot: Option<PathBuf>,
    /// Size and words of the figure.
    #[command(flatten)]
    pub look: LookFlags,
}

/// Size and words of a figure.
#[derive(Args, Debug, Default, Clone)]
pub struct LookFlags {
    /// Size of the figure: column (85 mm wide), page (170 mm wide), slide (254x142.9), or width and
    /// height in mm, such as 120x80 [default: its own]
    #[arg(long, value_name = "SIZE", help_heading = "Results")]
    pub size: Option<Size>,
    /// Title of the figure, in place of its title and subtitle; none: neither [default: its own]
    #[arg(long, value_name = "TEXT|none", help_heading = "Results")]
    pub title: Option<String>,
    /// none: the figure without its small print
    #[arg(long, value_name = "none", value_parser = ["none"], help_heading = "Results")]
    pub caption: Option<String>,
}

impl LookFlags {
    /// Returns the first of these flags on the command line.
    pub fn given(&self) -> Option<&'static str> {
        [
            ("--size", self.size.is_some()),
            ("--title", self.title.is_some()),
            ("--caption", self.caption.is_some()),
        ]
        .into_iter()
        .find_map(|(flag, is_given)| is_given.then_some(flag))
    }

    /// Returns the requested words; `None` keeps those of the figure.
    pub fn wording(&self) -> Option<Wording> {
        let title = self.title.as_deref();
        let wording = Wording {
            title: title.map(|title| if title == "none" { "" } else { title }.to_owned()),
            without_caption: self.caption.is_some(),
        };
        (wording != Wording::default()).then_some(wording)
    }
}

/// Time range of a figure.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct TimeFlags {
    /// Draw the figure from this time on [s]; the computation is unchanged [default: its begin]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Results")]
    pub plot_from: Option<f64>,
    /// Draw the figure up to this time [s] [default: its end]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Results")]
    pub plot_to: Option<f64>,
}

/// Layout of the table of a recorded motion.
#[derive(Args, Debug, Default, Clone)]
pub struct TraceFlags {
    /// Unit of the positions in the table: m, cm, mm or um; m also disables the plausibility check of the motion's
    /// length and speed [default: that of the unit row or the column's name]
    #[arg(long, value_name = "UNIT", value_parser = length_unit)]
    pub unit: Option<LengthUnit>,
    /// Unit of the times: s, ms, us or ns; s also allows samples that are far apart [default: that of the unit row or
    /// the column's name]
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    pub time_unit: Option<TimeUnit>,
    /// Columns of the table: t=time,x=X (for one contact t, x and force; for a world t, x, y, z, qw, qx, qy, qz, with
    /// several devices NAME.x); t=#2: the second column
    #[arg(long, value_name = "QUANTITY=COLUMN,...", value_parser = trace_columns)]
    pub columns: Option<TraceColumns>,
    /// Column separator: comma, semicolon or tab [default: that of the header]
    #[arg(long, value_name = "NAME", value_parser = delimiter)]
    pub delimiter: Option<Delimiter>,
    /// Read numbers with a decimal comma
    #[arg(long)]
    pub decimal_comma: bool,
    /// Skip samples without a value: an empty cell, NaN, NA or null; without it they are rejected
    #[arg(long)]
    pub skip_missing: bool,
}

impl TraceFlags {
    /// Field names, for the list of flags that a command takes.
    pub const NAMES: [&str; 6] = [
        "unit",
        "time_unit",
        "columns",
        "delimiter",
        "decimal_comma",
        "skip_missing",
    ];

    /// Returns the layout from the flags.
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

    /// Returns the first of these flags on the command line.
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

/// Selected part of a recorded motion.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct PartFlags {
    /// Start time in the recorded motion [s] [default: its first sample]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub from: Option<f64>,
    /// End time in the recorded motion [s]; nothing after it is read [default: its last sample]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub to: Option<f64>,
}

impl PartFlags {
    /// Returns the selected part, which lasts at most `longest` `[s]`.
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

    /// Whether a part was selected.
    pub fn is_given(self) -> bool {
        self.from.is_some() || self.to.is_some()
    }

    /// Returns the metadata entries of the part.
    pub fn metadata(self) -> impl Iterator<Item = (String, String)> {
        let line = |(name, time): (&str, Option<f64>)| {
            time.map(|time| (name.to_owned(), time.to_string()))
        };
        [("from_s", self.from), ("to_s", self.to)]
            .into_iter()
            .filter_map(line)
    }
}

//! Arguments about files: what becomes of those that are there, and which part of a motion is read.

use clap::{ArgAction, Args};
use palpate_files::atomic::Existing;
use palpate_files::outputs::Outputs;
use palpate_record::trace::Part;

use crate::failure::Failure;
use crate::values::number;

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
        Outputs::new(if self.overwrite {
            Existing::Replace
        } else {
            Existing::Keep
        })
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

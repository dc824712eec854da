//! Traces, as commands meet them.

use std::fs::File;
use std::io;
use std::path::Path;

use palpate_record::trace::{self, HeldTrace, Part, TraceError, TraceFault};
use palpate_record::unit::LengthUnit;
use palpate_sim::run::MOST_PERIODS;
use palpate_study::text::digits;

use crate::failure::Failure;
use crate::inside;

/// Name that stands for standard input.
pub const STANDARD_INPUT: &str = "-";

/// Where so many periods as fit are less than this `[s]`, the period is wrong, not the trace.
const SHORTEST_FIT: f64 = 1.0;

/// What to do with a recording that has too many periods.
pub fn how_to_cut() -> String {
    format!(
        "at most {MOST_PERIODS} fit, so take a part of it with --from and --to [s], or a longer --period"
    )
}

/// A part of the trace at `path`, its positions in `unit` if one is said, with the force that was held,
/// where it says so.
pub fn read_trace(
    path: &Path,
    name: &str,
    part: &Part,
    unit: Option<LengthUnit>,
) -> Result<HeldTrace, Failure> {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        return Err(Failure::Arguments(format!(
            "{name} is a recording: `palpate replay` takes it, and `--motion` of `run --device replay`"
        )));
    }
    let read = if path == Path::new(STANDARD_INPUT) {
        trace::read_part(io::stdin().lock(), name, part, unit)
    } else {
        let file = File::open(path).map_err(|error| Failure::System(format!("{name}: {error}")))?;
        palpate_files::inputs::note(path);
        trace::read_part(file, name, part, unit)
    };
    let held = read.map_err(|error| match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        // The last line that was read is not what is wrong.
        TraceError::Invalid {
            fault: TraceFault::TooLong { longest, first },
            ..
        } => {
            let fits = longest * MOST_PERIODS as f64 / (MOST_PERIODS + 1) as f64;
            let message = format!(
                "{name}: the trace goes on for more than {MOST_PERIODS} periods ({} s) after its first \
                 sample at {first} s; {}",
                digits(fits),
                how_to_cut()
            );
            if fits < SHORTEST_FIT {
                Failure::Arguments(format!("--period is too short: {message}"))
            } else {
                Failure::input(message)
            }
        }
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    })?;
    inside::check_trace(name, &held.trace, unit)?;
    Ok(held)
}

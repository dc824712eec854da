//! `palpate convert`: a recording as a table.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum, ValueHint};
use palpate_record::files::outputs::Outputs;
use palpate_record::recording::Recording;

use crate::arguments::Overwriting;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::{open, whole_or_said};
use crate::results::{STANDARD_OUTPUT, print, written};
use palpate_study::text::counted;

/// Arguments of `convert`.
#[derive(Args, Debug)]
pub struct ConvertArguments {
    /// Recording (MCAP)
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub recording: PathBuf,
    /// Table format; parquet if built with the feature parquet
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = Format::Csv)]
    pub to: Format,
    /// File to write, - for standard output; events go to NAME-events.csv, the bodies of a world to NAME-bodies.csv,
    /// and each device of a loop with several to NAME-devices.csv [default: that of the recording, with .csv or
    /// .parquet]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
}

/// Kinds of tables.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated text
    Csv,
    /// Apache Parquet
    Parquet,
}

/// Writes the tables.
pub fn run(arguments: &ConvertArguments) -> Result<(), Failure> {
    if arguments.to == Format::Parquet && cfg!(not(feature = "parquet")) {
        return Err(Failure::Arguments(
            "--to parquet: this build writes CSV only; for Parquet build with --features parquet"
                .into(),
        ));
    }
    let path = &arguments.recording;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| beside(path, arguments.to));
    let mut outputs = arguments.overwriting.outputs();
    outputs.protect(path);
    if out != Path::new(STANDARD_OUTPUT) {
        outputs.plan("--out", &out)?;
    }
    let progress = Progress::new(1);
    progress.begin(&format!("reading {}", path.display()));
    let recording = open(path)?;
    if recording.ticks == 0 {
        drop(progress);
        // Damage to the recording can be the reason.
        let _ = whole_or_said(&recording);
        return Err(Failure::input(format_args!(
            "{}: the recording has no ticks, so no table is written",
            path.display()
        )));
    }
    let tables = OtherTables::plan(&recording, &out, &mut outputs)?;
    let mut wrote = String::new();
    if out == Path::new(STANDARD_OUTPUT) {
        drop(progress);
        write_to_standard_output(&recording, arguments.to, path)?;
    } else {
        progress.begin(&format!("writing {}", out.display()));
        wrote += &write_tables(&recording, arguments.to, &out, &tables, &outputs)?;
        drop(progress);
    }
    print(&wrote)?;
    whole_or_said(&recording)
}

/// Tables beside that of the ticks; `None` if one is not written.
struct OtherTables {
    /// Table of events.
    events: Option<PathBuf>,
    /// Table of bodies.
    bodies: Option<PathBuf>,
    /// Table of devices.
    devices: Option<PathBuf>,
}

impl OtherTables {
    /// Plans the tables of the recording beside that of the ticks at `out`.
    fn plan(recording: &Recording, out: &Path, outputs: &mut Outputs) -> Result<Self, Failure> {
        let events = (recording.events > 0 && out != Path::new(STANDARD_OUTPUT))
            .then(|| table_beside(out, "events"));
        if let Some(events) = &events {
            outputs.plan("the table of events", events)?;
        }
        let bodies = (recording.has_bodies && out != Path::new(STANDARD_OUTPUT))
            .then(|| table_beside(out, "bodies"));
        if let Some(bodies) = &bodies {
            outputs.plan("the table of bodies", bodies)?;
        }
        let devices = (recording.devices > 1 && out != Path::new(STANDARD_OUTPUT))
            .then(|| table_beside(out, "devices"));
        if let Some(devices) = &devices {
            outputs.plan("the table of devices", devices)?;
        }
        Ok(Self {
            events,
            bodies,
            devices,
        })
    }
}

/// Writes the ticks to standard output, and names the omitted tables of the recording at `path`.
fn write_to_standard_output(recording: &Recording, to: Format, path: &Path) -> Result<(), Failure> {
    let mut output = BufWriter::new(io::stdout().lock());
    written(write(recording, to, &mut output).and_then(|()| output.flush()))?;
    if recording.has_bodies {
        crate::failure::tell(format_args!(
            "{}: world bodies omitted; with --out FILE, a file beside it contains them",
            path.display()
        ));
    }
    if recording.devices > 1 {
        crate::failure::tell(format_args!(
            "{}: values of each of {} devices omitted; with --out FILE, a file beside it contains them",
            path.display(),
            recording.devices
        ));
    }
    if recording.events > 0 {
        crate::failure::tell(format_args!(
            "{}: {} omitted; with --out FILE, a file beside it contains them",
            path.display(),
            counted(recording.events, "event")
        ));
    }
    Ok(())
}

/// Writes the tables of ticks, events, bodies and devices, and returns the messages about them.
fn write_tables(
    recording: &Recording,
    to: Format,
    out: &Path,
    tables: &OtherTables,
    outputs: &Outputs,
) -> Result<String, Failure> {
    let mut wrote = String::new();
    outputs.write(out, |writer| write(recording, to, writer))?;
    wrote += &format!(
        "wrote {}: {}\n",
        out.display(),
        counted(recording.ticks, "tick")
    );
    if let Some(events) = &tables.events {
        outputs.write(events, |writer| recording.write_events_csv(writer))?;
        let count = counted(recording.events, "event");
        wrote += &format!("wrote {}: {count}\n", events.display());
    }
    if let Some(bodies) = &tables.bodies {
        outputs.write(bodies, |writer| recording.write_bodies_csv(writer))?;
        wrote += &format!("wrote {}: the bodies of each tick\n", bodies.display());
    }
    if let Some(devices) = &tables.devices {
        outputs.write(devices, |writer| recording.write_devices_csv(writer))?;
        let count = recording.devices;
        wrote += &format!(
            "wrote {}: {count} devices of each tick\n",
            devices.display()
        );
    }
    Ok(wrote)
}

fn write(recording: &Recording, to: Format, out: &mut dyn Write) -> io::Result<()> {
    match to {
        Format::Csv => recording.write_csv(out),
        #[cfg(feature = "parquet")]
        Format::Parquet => recording.write_parquet(out),
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => unreachable!("refused above"),
    }
}

/// Returns the name of a table beside its recording, without the `.part` of an unfinished recording.
fn beside(recording: &Path, to: Format) -> PathBuf {
    let finished = match recording.extension() {
        Some(extension) if extension == "part" => recording.with_extension(""),
        _ => recording.to_owned(),
    };
    finished.with_extension(match to {
        Format::Csv => "csv",
        Format::Parquet => "parquet",
    })
}

/// Returns the name of another table beside that of ticks.
fn table_beside(out: &Path, of: &str) -> PathBuf {
    let stem = out.file_stem().unwrap_or_default();
    let mut name = stem.to_owned();
    name.push(format!("-{of}.csv"));
    out.with_file_name(name)
}

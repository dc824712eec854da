//! `palpate info`: contents and gaps of a recording.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use palpate_study::recording::report::RecordingReport;

use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::{open, whole_or_code};
use crate::results::{print, print_report};

/// Arguments of `info`.
#[derive(Args, Debug)]
pub struct InfoArguments {
    /// Recording (MCAP)
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub recording: PathBuf,
    /// Print only this metadata entry, such as scene
    #[arg(long, value_name = "NAME", conflicts_with = "json")]
    pub text: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Reports on a recording.
pub fn run(arguments: &InfoArguments) -> Result<(), Failure> {
    let progress = Progress::new(1);
    progress.begin(&format!("reading {}", arguments.recording.display()));
    let recording = open(&arguments.recording)?;
    if let Some(name) = &arguments.text {
        drop(progress);
        let texts = &recording.metadata.texts;
        let text = texts.get(name).ok_or_else(|| {
            let names: Vec<&str> = texts.keys().map(String::as_str).collect();
            Failure::Arguments(format!(
                "--text: the metadata has no text called {name}; it has {}",
                if names.is_empty() {
                    "none".into()
                } else {
                    names.join(", ")
                }
            ))
        })?;
        return print(text);
    }
    let report = RecordingReport::new(&recording).map_err(Failure::input)?;
    drop(progress);
    print_report(&report, arguments.json)?;
    whole_or_code(&recording)
}

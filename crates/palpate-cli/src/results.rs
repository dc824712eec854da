//! Where results go: the run file, the figure, the report.

use std::io::{self, Write};
use std::path::Path;

use palpate_sim::run::Run;

use crate::arguments::Results;
use crate::failure::{Failure, tell};
use crate::figure::{Figure, Picture};
use crate::progress::Progress;
use crate::report::Report;
use crate::run_file;

impl Results {
    /// Refuses, before any work is done, results that would take the place of the `input` or that
    /// cannot be drawn.
    pub fn check(&self, input: &Path) -> Result<(), Failure> {
        if let Some(plot) = &self.plot {
            picture_format(plot)?;
        }
        let same = |out: &Path| match (out.canonicalize(), input.canonicalize()) {
            (Ok(out), Ok(input)) => out == input && input.is_file(),
            _ => false,
        };
        for (flag, path) in [("--out", &self.out), ("--plot", &self.plot)] {
            if path.as_deref().is_some_and(same) {
                return Err(Failure::Arguments(format!(
                    "{flag} would overwrite the input {}",
                    input.display()
                )));
            }
        }
        if self.out.is_some() && self.out == self.plot {
            return Err(Failure::Arguments(
                "--out and --plot name the same file; the figure would overwrite the run".into(),
            ));
        }
        Ok(())
    }
}

/// Writes what was asked for, then prints the report.
pub fn deliver(
    results: &Results,
    mut report: Report,
    receipt: &[(String, String)],
    runs: &[Run],
    figure: impl FnOnce() -> Figure,
    progress: Progress,
) -> Result<(), Failure> {
    let to_standard_output = results.out.as_deref() == Some(Path::new("-"));
    // Ticks on standard output may go to the terminal that the bar is on.
    let progress = Some(progress).filter(|_| !to_standard_output);
    let begin = |path: &Path| {
        if let Some(progress) = &progress {
            progress.begin(&format!("writing {}", path.display()));
        }
    };
    match &results.out {
        None => {}
        Some(_) if to_standard_output => {
            let mut buffer = io::BufWriter::new(io::stdout().lock());
            finish(
                run_file::write(&mut buffer, receipt, runs)
                    .map_err(io::Error::from)
                    .and_then(|()| buffer.flush()),
            )?;
        }
        Some(path) => {
            begin(path);
            palpate_io::atomic::write(path, |writer| {
                run_file::write(writer, receipt, runs).map_err(io::Error::from)
            })
            .map_err(|error| Failure::System(error.to_string()))?;
            report.wrote(path);
        }
    }
    if let Some(path) = &results.plot {
        begin(path);
        draw(path, &figure())?;
        report.wrote(path);
    }
    drop(progress);
    let text = if results.json {
        report.json() + "\n"
    } else {
        report.to_string()
    };
    if to_standard_output {
        tell(text.trim_end());
        Ok(())
    } else {
        print(&text)
    }
}

/// Prints to standard output; a reader that has left is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    finish(io::stdout().lock().write_all(text.as_bytes()))
}

fn finish(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::System(format!(
            "standard output cannot be written: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Pixels of a PNG for each of the figure's units.
#[cfg(feature = "png")]
const PIXELS_PER_UNIT: f32 = 2.5;

enum PictureFormat {
    Svg,
    Png,
}

fn picture_format(path: &Path) -> Result<PictureFormat, Failure> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("svg") => Ok(PictureFormat::Svg),
        Some("png") if cfg!(feature = "png") => Ok(PictureFormat::Png),
        Some("png") => Err(Failure::Arguments(format!(
            "{}: this build draws SVG only; for PNG build with --features png",
            path.display()
        ))),
        _ => Err(Failure::Arguments(format!(
            "{}: the name of a figure ends in .svg or .png",
            path.display()
        ))),
    }
}

/// Refuses a name that no figure can have.
pub fn check_picture(path: &Path) -> Result<(), Failure> {
    picture_format(path).map(|_| ())
}

/// Draws a figure into a file, whole or not at all.
pub fn draw(path: &Path, figure: &impl Picture) -> Result<(), Failure> {
    let bytes = match picture_format(path)? {
        PictureFormat::Svg => crate::figure::svg(figure).into_bytes(),
        #[cfg(feature = "png")]
        PictureFormat::Png => crate::figure::png(figure, PIXELS_PER_UNIT).map_err(|error| {
            Failure::System(format!("{} cannot be drawn: {error}", path.display()))
        })?,
        #[cfg(not(feature = "png"))]
        PictureFormat::Png => unreachable!("refused above"),
    };
    palpate_io::atomic::write(path, |writer| writer.write_all(&bytes))
        .map_err(|error| Failure::System(error.to_string()))
}

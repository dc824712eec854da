//! Output of results: the run file, the figure, the report.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use palpate_record::files::outputs::Outputs;
use palpate_study::json;
use palpate_study::report::Report;
use palpate_study::sim::run::Run;
use palpate_study::table::TableFormat;
use serde::Serialize;

use crate::arguments::{LookFlags, PlotFlags, Results, TimeFlags};
use crate::failure::{Failure, printable, tell};
use crate::progress::Progress;
use crate::run_file;
use palpate_plot::figure::{Picture, Sheet, Size, SizeError};

/// Name of standard output.
pub const STANDARD_OUTPUT: &str = "-";

impl Results {
    /// Plans the files of the results before any work. Rejects files that cannot be written or drawn, that exist
    /// already, or that would replace the `input`.
    pub fn check(&self, input: &Path) -> Result<Outputs, Failure> {
        let mut outputs = self.overwriting.outputs();
        outputs.protect(input);
        if let Some(out) = self
            .out
            .as_deref()
            .filter(|out| *out != Path::new(STANDARD_OUTPUT))
        {
            outputs.plan("--out", out)?;
        }
        self.picture.plan(&mut outputs)?;
        if self.picture.plot.is_none() {
            self.time.refuse()?;
        }
        Ok(outputs)
    }
}

/// Writes the requested files, then prints the report.
pub fn deliver(
    (results, outputs): (&Results, &Outputs),
    mut report: Report,
    metadata: &[(String, String)],
    runs: &[Run],
    figure: impl FnOnce() -> Sheet,
    progress: Progress,
) -> Result<(), Failure> {
    let to_standard_output = results.out.as_deref() == Some(Path::new(STANDARD_OUTPUT));
    // Ticks on standard output may share the terminal with the progress bar.
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
            written(
                run_file::write(&mut buffer, metadata, runs)
                    .map_err(io::Error::from)
                    .and_then(|()| buffer.flush()),
            )?;
        }
        Some(path) => {
            begin(path);
            outputs.write(path, |writer| {
                run_file::write(writer, metadata, runs).map_err(io::Error::from)
            })?;
            report.wrote(path);
        }
    }
    if let Some(path) = &results.picture.plot {
        begin(path);
        let figure = results.time.cut(figure())?;
        draw(outputs, path, &figure, &results.picture.look)?;
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

/// Prints a report as text or JSON.
pub fn print_report(
    report: &(impl Serialize + fmt::Display),
    as_json: bool,
) -> Result<(), Failure> {
    print(&if as_json {
        json(report) + "\n"
    } else {
        report.to_string()
    })
}

/// Prints to standard output, [`printable`]; a reader that has exited is not a failure.
pub fn print(text: &str) -> Result<(), Failure> {
    written(io::stdout().lock().write_all(printable(text).as_bytes()))
}

/// Converts the result of writing to standard output; a reader that has exited is not a failure.
pub fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::System(format!(
            "standard output cannot be written: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Pixels of a PNG per unit of the figure.
#[cfg(feature = "png")]
const PIXELS_PER_UNIT: f32 = 2.5;

enum PictureFormat {
    Svg,
    Pdf,
    Png,
}

fn picture_format(path: &Path) -> Result<PictureFormat, Failure> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("svg") => Ok(PictureFormat::Svg),
        Some("pdf") => Ok(PictureFormat::Pdf),
        Some("png") if cfg!(feature = "png") => Ok(PictureFormat::Png),
        Some("png") => Err(Failure::Arguments(format!(
            "{}: this build draws SVG and PDF only; for PNG build with --features png",
            path.display()
        ))),
        _ => Err(Failure::Arguments(format!(
            "{}: the name of a figure must end in .svg, .pdf or .png",
            path.display()
        ))),
    }
}

/// Plans a figure in the file at `path`, from the flag `name`. Rejects an invalid figure name.
pub fn plan_picture(outputs: &mut Outputs, name: &str, path: &Path) -> Result<(), Failure> {
    picture_format(path)?;
    Ok(outputs.plan(name, path)?)
}

impl PlotFlags {
    /// Plans the figure, if requested.
    pub fn plan(&self, outputs: &mut Outputs) -> Result<(), Failure> {
        match &self.plot {
            Some(path) => plan_picture(outputs, "--plot", path),
            None => match self.look.given() {
                Some(flag) => Err(Failure::Arguments(format!(
                    "{flag} is for a figure; name its file with --plot"
                ))),
                None => Ok(()),
            },
        }
    }
}

/// Writes the table of a study, if requested; returns the written file.
pub fn write_table<const N: usize>(
    outputs: &Outputs,
    out: Option<&PathBuf>,
    columns: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> Result<Option<String>, Failure> {
    let Some(out) = out else { return Ok(None) };
    outputs.write(out, |writer| {
        TableFormat::from_path(out).write(writer, columns, rows)
    })?;
    Ok(Some(out.display().to_string()))
}

/// Draws the figure of a study, if requested; returns the written file.
pub fn draw_study<P: Picture>(
    outputs: &Outputs,
    picture: &PlotFlags,
    figure: impl FnOnce() -> P,
) -> Result<Option<String>, Failure> {
    let Some(path) = &picture.plot else {
        return Ok(None);
    };
    draw(outputs, path, &figure(), &picture.look)?;
    Ok(Some(path.display().to_string()))
}

/// Draws a figure into a file, atomically.
pub fn draw(
    outputs: &Outputs,
    path: &Path,
    figure: &(impl Picture + ?Sized),
    look: &LookFlags,
) -> Result<(), Failure> {
    let size = look.size.unwrap_or(Size::NATURAL);
    let worded = look.wording().and_then(|wording| figure.worded(&wording));
    match worded {
        Some(figure) => write_picture(outputs, path, &*figure, size),
        None => write_picture(outputs, path, figure, size),
    }
}

fn write_picture(
    outputs: &Outputs,
    path: &Path,
    figure: &(impl Picture + ?Sized),
    size: Size,
) -> Result<(), Failure> {
    let refused = |error: SizeError| Failure::Arguments(format!("--size: {error}"));
    let bytes = match picture_format(path)? {
        PictureFormat::Svg => palpate_plot::figure::svg(figure, size)
            .map_err(refused)?
            .into_bytes(),
        PictureFormat::Pdf => palpate_plot::figure::pdf(figure, size).map_err(refused)?,
        #[cfg(feature = "png")]
        PictureFormat::Png => palpate_plot::figure::png(figure, size, PIXELS_PER_UNIT).map_err(
            |error| match error {
                palpate_plot::figure::PngError::Size(error) => refused(error),
                palpate_plot::figure::PngError::Image(error) => {
                    Failure::System(format!("{} cannot be drawn: {error}", path.display()))
                }
            },
        )?,
        #[cfg(not(feature = "png"))]
        PictureFormat::Png => unreachable!("refused above"),
    };
    Ok(outputs.write(path, |writer| writer.write_all(&bytes))?)
}

impl TimeFlags {
    /// Rejects a time range without a figure.
    fn refuse(self) -> Result<(), Failure> {
        if self.plot_from.is_none() && self.plot_to.is_none() {
            return Ok(());
        }
        Err(Failure::Arguments(
            "--plot-from and --plot-to are for a figure; name its file with --plot".into(),
        ))
    }

    /// Crops a figure over time to the requested range.
    pub fn cut(self, mut sheet: Sheet) -> Result<Sheet, Failure> {
        if self.plot_from.is_none() && self.plot_to.is_none() {
            return Ok(sheet);
        }
        let Some((first, last)) = sheet.reach() else {
            return Ok(sheet);
        };
        let from = self.plot_from.unwrap_or(first);
        let to = self.plot_to.unwrap_or(last);
        // This form of the condition is false for NaN.
        if from < to && from < last && to > first {
            sheet.keep(from, to);
            return Ok(sheet);
        }
        Err(Failure::Arguments(format!(
            "--plot-from {from} --plot-to {to}: the part must begin before it ends, and lie within the \
             figure's {first} to {last} s"
        )))
    }
}

//! The files of a map, checked before it is computed.

use std::path::{Path, PathBuf};

use palpate_record::files::atomic::{Existing, is_stream};
use palpate_record::files::outputs::Outputs;
use palpate_record::map::Map;

use super::arguments::MapResults;
use crate::failure::Failure;
use crate::results::{draw, plan_picture};
use crate::values::Methods;
use palpate_plot::map;
use palpate_study::map::report::MapReport;

/// The files of a map, and permission to write them.
pub struct Files {
    outputs: Outputs,
    /// The map itself, if it is written.
    pub out: Option<PathBuf>,
    plot: Option<PathBuf>,
    parquet: Option<PathBuf>,
    /// Files that a resumed map has already.
    kept: Vec<PathBuf>,
    is_resumed: bool,
}

impl Files {
    /// Creates a set without files.
    ///
    /// # Errors
    /// This build cannot write a file.
    pub fn new(results: &MapResults) -> Result<Self, Failure> {
        if results.parquet.is_some() && cfg!(not(feature = "parquet")) {
            return Err(Failure::Arguments(
                "--parquet: this build writes CSV only; for Parquet build with --features parquet"
                    .into(),
            ));
        }
        Ok(Self {
            outputs: results.overwriting.outputs(),
            out: None,
            plot: None,
            parquet: None,
            kept: Vec::new(),
            is_resumed: false,
        })
    }

    /// Protects parts of maps from being overwritten.
    pub fn protect(&mut self, parts: &[PathBuf]) {
        for part in parts {
            self.outputs.protect(part);
        }
    }

    /// Plans a computed map at `out`. A resumed map may exist already. Reading it later shows whether it is the same
    /// map.
    pub fn compute(&mut self, out: &Path, is_resumed: bool) -> Result<(), Failure> {
        let existing = if is_resumed && out.is_file() {
            Existing::Replace
        } else {
            self.outputs.existing()
        };
        self.outputs.plan_over("--out", out, existing)?;
        if is_stream(out) {
            return Err(Failure::Arguments(format!(
                "--out {}: not a file, and the computation keeps a journal beside it; name a file",
                out.display()
            )));
        }
        self.out = Some(out.to_owned());
        Ok(())
    }

    /// Plans a joined map at `out`.
    pub fn join(&mut self, out: &Path) -> Result<(), Failure> {
        self.outputs.plan("--out", out)?;
        self.out = Some(out.to_owned());
        Ok(())
    }

    /// Plans the figure at `plot`, and the Parquet table of `results`. For an existing resumed map both may exist
    /// already.
    pub fn show(
        &mut self,
        results: &MapResults,
        plot: Option<PathBuf>,
        is_resumed: bool,
    ) -> Result<(), Failure> {
        self.is_resumed = is_resumed;
        let may_be_there = is_resumed
            && self.outputs.existing() == Existing::Keep
            && self.out.as_ref().is_some_and(|out| out.is_file());
        let is_kept = |path: &PathBuf| may_be_there && path.is_file();
        if let Some(path) = plot {
            if is_kept(&path) {
                self.kept.push(path);
            } else {
                plan_picture(&mut self.outputs, "--plot", &path)?;
                self.plot = Some(path);
            }
        }
        if let Some(path) = results.parquet.clone() {
            if is_kept(&path) {
                self.kept.push(path);
            } else {
                self.outputs.plan("--parquet", &path)?;
                self.parquet = Some(path);
            }
        }
        Ok(())
    }

    /// Whether existing files are replaced.
    pub fn overwrites(&self) -> bool {
        self.outputs.existing() == Existing::Replace
    }

    /// Writes the map itself.
    pub fn write_map(&self, map: &Map) -> Result<(), Failure> {
        let Some(out) = &self.out else {
            return Ok(());
        };
        Ok(self.outputs.write(out, |writer| map.write(writer))?)
    }

    /// Draws the map and writes it as Parquet, as far as requested, and records both in the report. If the map was
    /// `found` complete, files created since then are kept too.
    pub fn deliver(
        &self,
        map: &Map,
        (results, methods): (&MapResults, Option<&Methods>),
        found: bool,
        report: &mut MapReport,
    ) -> Result<(), Failure> {
        let found = found && self.is_resumed;
        let mut kept = Vec::new();
        match &self.out {
            Some(out) if found => kept.push(out.clone()),
            Some(out) => report.wrote(out),
            None => {}
        }
        kept.extend(self.kept.iter().cloned());
        let is_kept = |path: &PathBuf| found && !self.overwrites() && path.is_file();
        if let Some(path) = &self.parquet {
            if is_kept(path) {
                kept.push(path.clone());
            } else {
                self.write_parquet(map, path)?;
                report.wrote(path);
            }
        }
        if let Some(path) = &self.plot {
            if is_kept(path) {
                kept.push(path.clone());
            } else {
                let figure = map::figure(
                    map,
                    &results.show,
                    methods.map(|Methods(methods)| &methods[..]),
                )?;
                draw(&self.outputs, path, &figure, &results.look)?;
                report.wrote(path);
            }
        }
        for path in &kept {
            report.kept(path);
        }
        Ok(())
    }

    #[cfg(feature = "parquet")]
    fn write_parquet(&self, map: &Map, path: &Path) -> Result<(), Failure> {
        let write =
            |writer: &mut dyn std::io::Write| palpate_record::map::write_parquet(map, writer);
        Ok(self.outputs.write(path, write)?)
    }

    #[cfg(not(feature = "parquet"))]
    fn write_parquet(&self, _: &Map, _: &Path) -> Result<(), Failure> {
        unreachable!("refused by new")
    }
}

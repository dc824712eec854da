//! Computation of a map into a file: cells are written to a journal beside the file, and the journal to the map.

use std::collections::BTreeMap;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use palpate_record::files::atomic::{Existing, WriteError, check};
use palpate_record::files::journal::{Journal, JournalError};
use palpate_record::map::{Format, Map, Row};

use super::report::Speed;
use super::{BounceError, Done, MapParams, compute, metadata};

/// A map to be computed, and its output file.
#[derive(Clone, Copy, Debug)]
pub struct MapJob<'a> {
    /// The map.
    pub params: &'a MapParams,
    /// Part of the map, counted from 1, and number of parts.
    pub part: (usize, usize),
    /// Number of threads.
    pub threads: usize,
    /// Output file. A journal beside it stores finished cells.
    pub out: &'a Path,
    /// Whether it continues an interrupted run.
    pub is_resumed: bool,
    /// Whether it replaces an existing file.
    pub overwrites: bool,
}

/// Observer of a map computation.
pub trait MapFollower {
    /// The journal cannot be locked, so another process may write to it.
    fn is_unlocked(&mut self, journal: &Path, why: &io::Error);
    /// The computation of `cells` cells starts.
    fn begin(&mut self, cells: usize);
    /// One cell is finished.
    fn advance(&mut self);
    /// The computation ends.
    fn end(&mut self);
}

/// Reason why a map could not be computed into its file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapJobError {
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The file already exists.
    #[error(transparent)]
    There(#[from] WriteError),
    /// An existing file or journal has other content.
    #[error("{0}")]
    Other(String),
    /// A cell cannot be run.
    #[error(transparent)]
    Cell(#[from] BounceError),
    /// The journal could not be completed.
    #[error("{error}\n{keeps}")]
    Unwritten {
        /// Cause of the error.
        error: JournalError,
        /// Stored cells, and how to resume.
        keeps: String,
    },
    /// The computation was stopped.
    #[error("stopped: {0}")]
    Stopped(String),
}

/// A computed map, and the stored content of its journal.
#[derive(Debug)]
pub struct Computed {
    /// The computed map.
    pub map: Map,
    /// Computing speed; none for an existing map.
    pub speed: Option<Speed>,
    /// Lock of the map's files. The caller removes the journal after the last file is written.
    pub journal: Option<Journal>,
    /// Stored cells and how to resume, for a file that cannot be written.
    pub keeps: String,
}

impl MapJob<'_> {
    /// Computes the map, or returns the existing complete one on resume. Stops early once `stop` is set. The caller
    /// writes the file.
    ///
    /// # Errors
    /// An existing file or journal belongs to another map or cannot be used, a cell cannot be run, or the computation
    /// was stopped.
    pub fn run(
        &self,
        stop: &AtomicBool,
        follower: &mut impl MapFollower,
    ) -> Result<Computed, MapJobError> {
        let metadata = metadata::of(self.params, self.part);
        let head = metadata::line(&metadata);
        let journal_path = journal_of(self.out);
        // Lock first, so that no other process changes the files after they are read.
        let found = Journal::open(&journal_path)?;
        if let Some(why) = &found.unlocked {
            follower.is_unlocked(&journal_path, why);
        }
        let mut journal = found.journal;
        if self.is_resumed
            && let Some(map) = complete(self.out, &metadata, self.overwrites)?
        {
            let is_of_another = found.head.is_some_and(|begun| begun != head);
            return Ok(Computed {
                map,
                speed: None,
                journal: Some(journal).filter(|_| !is_of_another),
                keeps: String::new(),
            });
        }
        if !self.is_resumed && !self.overwrites {
            // The file may have been created since the first check.
            check(self.out, Existing::Keep)?;
        }
        let mut done = self.begin_journal(&mut journal, found.head, &found.lines, &head)?;
        let (number, of) = self.part;
        let part = self.params.shard(number, of);
        let whole = part.len();
        let cells: Vec<usize> = part
            .into_iter()
            .filter(|cell| !done.contains_key(&(*cell as u64)))
            .collect();
        let computation = self.compute_cells(&cells, &mut journal, &mut done, stop, follower)?;
        let kept = done.len();
        let keeps = format!(
            "{kept} of {whole} cells are kept in {}; continue with --resume",
            journal_path.display()
        );
        if let Some(error) = computation.fault {
            return Err(MapJobError::Unwritten { error, keeps });
        }
        if computation.ended == Done::Stopped {
            return Err(MapJobError::Stopped(keeps));
        }
        Ok(Computed {
            map: Map {
                metadata,
                rows: done.into_values().flatten().collect(),
            },
            speed: Some(computation.speed),
            journal: Some(journal),
            keeps,
        })
    }

    /// Begins a new journal with `head`, or returns the rows of a resumed one per cell; `begun` and `lines` are its
    /// present first line and the lines after it.
    fn begin_journal(
        &self,
        journal: &mut Journal,
        begun: Option<String>,
        lines: &[String],
        head: &str,
    ) -> Result<CellRows, MapJobError> {
        let journal_path = journal_of(self.out);
        let mut done = BTreeMap::new();
        match begun {
            None => journal.begin(head)?,
            Some(_) if !self.is_resumed => {
                return Err(MapJobError::Other(format!(
                    "{} contains {} cells of an interrupted map; continue with --resume, or delete it",
                    journal_path.display(),
                    lines.len()
                )));
            }
            Some(begun) if begun != head => {
                return Err(MapJobError::Other(format!(
                    "{} is of another map; pass its original arguments, or delete it\n  \
                     begun: {begun}\n  now:   {head}",
                    journal_path.display()
                )));
            }
            Some(_) => {
                for line in lines {
                    let rows = rows_of(line).map_err(|fault| {
                        MapJobError::Other(format!("{}: {fault}", journal_path.display()))
                    })?;
                    if let Some(first) = rows.first() {
                        done.insert(first.cell, rows);
                    }
                }
            }
        }
        Ok(done)
    }

    /// Computes `cells` and adds their rows to the journal and to `done`.
    fn compute_cells(
        &self,
        cells: &[usize],
        journal: &mut Journal,
        done: &mut CellRows,
        stop: &AtomicBool,
        follower: &mut impl MapFollower,
    ) -> Result<Computation, MapJobError> {
        follower.begin(cells.len());
        let start = Instant::now();
        let (mut ticks, mut fault) = (0, None);
        let ended = compute(self.params, cells, self.threads, stop, |result| {
            ticks += result.ticks;
            let rows = result.rows(self.params);
            if let Err(error) = journal.append(&line_of(&rows)) {
                fault = Some(error);
                return ControlFlow::Break(());
            }
            done.insert(result.index as u64, rows);
            follower.advance();
            ControlFlow::Continue(())
        })?;
        let seconds = start.elapsed().as_secs_f64();
        follower.end();
        Ok(Computation {
            ended,
            fault,
            speed: Speed {
                ticks,
                seconds,
                threads: self.threads,
            },
        })
    }
}

/// Rows of each cell, by its index.
type CellRows = BTreeMap<u64, Vec<Row>>;

/// End of a computation of cells.
struct Computation {
    ended: Done,
    /// Reason why a row could not be written to the journal.
    fault: Option<JournalError>,
    speed: Speed,
}

/// Returns the existing map at `out`, if it is this one.
///
/// # Errors
/// The file has other content and must not be overwritten.
fn complete(
    out: &Path,
    metadata: &[(String, String)],
    may_overwrite: bool,
) -> Result<Option<Map>, MapJobError> {
    let Ok(file) = std::fs::File::open(out) else {
        return Ok(None);
    };
    match Map::read(file, &out.display().to_string()) {
        Ok(map) if map.metadata == metadata => Ok(Some(map)),
        _ if may_overwrite => Ok(None),
        Ok(map) if map.format() != Some(Format::BouncesAndStays) => {
            Err(MapJobError::Other(format!(
                "{} was made by an older version and has only bounces; name another file with --out, or replace it \
                 with --overwrite",
                out.display()
            )))
        }
        Ok(_) => Err(MapJobError::Other(format!(
            "{} is another, complete map; name another file with --out, or replace it with --overwrite",
            out.display()
        ))),
        Err(error) => Err(MapJobError::Other(format!(
            "{error}; name another file with --out, or replace it with --overwrite"
        ))),
    }
}

fn journal_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".journal");
    name.into()
}

/// Formats all rows of a cell as one line of a journal.
fn line_of(rows: &[Row]) -> String {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    lines.join(";")
}

fn rows_of(line: &str) -> Result<Vec<Row>, String> {
    line.split(';')
        .map(|row| Row::from_line(row, Format::BouncesAndStays))
        .collect()
}

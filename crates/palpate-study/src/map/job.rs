//! A map that is computed into a file: cells into a journal beside it, and from that into the map.

use std::collections::BTreeMap;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use palpate_files::atomic::{Existing, WriteError, check};
use palpate_files::journal::{Journal, JournalError};
use palpate_record::map::{Format, Map, Row};

use super::report::Speed;
use super::{BounceError, Done, MapParams, compute, receipt};

/// What is computed, and into which file.
#[derive(Clone, Copy, Debug)]
pub struct MapJob<'a> {
    /// The map.
    pub params: &'a MapParams,
    /// Which part of it, counted from 1, of how many.
    pub part: (usize, usize),
    /// Threads.
    pub threads: usize,
    /// The file. A journal beside it keeps what is done.
    pub out: &'a Path,
    /// Whether it goes on with what an interrupted run has left.
    pub is_resumed: bool,
    /// Whether a file that is there is replaced.
    pub overwrites: bool,
}

/// Who follows a map that is computed.
pub trait MapFollower {
    /// The file at `journal` cannot be locked, so somebody else may write into it.
    fn is_unlocked(&mut self, journal: &Path, why: &io::Error);
    /// So many cells are to be computed.
    fn begin(&mut self, cells: usize);
    /// One is.
    fn advance(&mut self);
    /// No more are.
    fn end(&mut self);
}

/// Why a map could not be computed into its file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapJobError {
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// There is a file already.
    #[error(transparent)]
    There(#[from] WriteError),
    /// A file or a journal that is there is of something else.
    #[error("{0}")]
    Other(String),
    /// A cell cannot be run.
    #[error(transparent)]
    Cell(#[from] BounceError),
    /// The journal could not be written to the end.
    #[error("{error}\n{keeps}")]
    Unwritten {
        /// Why.
        error: JournalError,
        /// What is kept, and how to go on.
        keeps: String,
    },
    /// It was stopped.
    #[error("stopped: {0}")]
    Stopped(String),
}

/// A map that is computed, and what its journal keeps.
#[derive(Debug)]
pub struct Computed {
    /// What was asked for.
    pub map: Map,
    /// How fast it came; none of one that was there.
    pub speed: Option<Speed>,
    /// Keeps others from the map's files. It is removed when the last of them is written.
    pub journal: Option<Journal>,
    /// What is kept, and how to go on, where the file cannot be written.
    pub keeps: String,
}

impl MapJob<'_> {
    /// Computes the map, or takes the one that is there complete where it is resumed. It ends early once `stop` is set.
    /// The file itself is for the caller to write.
    ///
    /// # Errors
    /// What is there is of another map or cannot be used, a cell cannot be run, or it was stopped.
    pub fn run(
        &self,
        stop: &AtomicBool,
        follower: &mut impl MapFollower,
    ) -> Result<Computed, MapJobError> {
        let receipt = receipt::of(self.params, self.part);
        let head = receipt::line(&receipt);
        let journal_path = journal_of(self.out);
        let mut done = BTreeMap::new();
        // Nothing is looked at before nobody else can change it.
        let found = Journal::open(&journal_path)?;
        if let Some(why) = &found.unlocked {
            follower.is_unlocked(&journal_path, why);
        }
        let mut journal = found.journal;
        if self.is_resumed
            && let Some(map) = complete(self.out, &receipt, self.overwrites)?
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
            // It may have come since it was looked for.
            check(self.out, Existing::Keep)?;
        }
        match found.head {
            None => journal.begin(&head)?,
            Some(_) if !self.is_resumed => {
                return Err(MapJobError::Other(format!(
                    "{} keeps {} cells of a map that was interrupted; go on with --resume, or delete it",
                    journal_path.display(),
                    found.lines.len()
                )));
            }
            Some(begun) if begun != head => {
                return Err(MapJobError::Other(format!(
                    "{} is of another map; give the arguments it was begun with, or delete it\n  \
                     begun: {begun}\n  now:   {head}",
                    journal_path.display()
                )));
            }
            Some(_) => {
                for line in &found.lines {
                    let rows = rows_of(line).map_err(|fault| {
                        MapJobError::Other(format!("{}: {fault}", journal_path.display()))
                    })?;
                    if let Some(first) = rows.first() {
                        done.insert(first.cell, rows);
                    }
                }
            }
        }

        let (number, of) = self.part;
        let part = self.params.shard(number, of);
        let whole = part.len();
        let cells: Vec<usize> = part
            .into_iter()
            .filter(|cell| !done.contains_key(&(*cell as u64)))
            .collect();
        follower.begin(cells.len());
        let start = Instant::now();
        let (mut ticks, mut fault) = (0, None);
        let ended = compute(self.params, &cells, self.threads, stop, |result| {
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
        let kept = done.len();
        let keeps = format!(
            "{kept} of {whole} cells are kept in {}; go on with --resume",
            journal_path.display()
        );
        if let Some(error) = fault {
            return Err(MapJobError::Unwritten { error, keeps });
        }
        if ended == Done::Stopped {
            return Err(MapJobError::Stopped(keeps));
        }
        Ok(Computed {
            map: Map {
                receipt,
                rows: done.into_values().flatten().collect(),
            },
            speed: Some(Speed {
                ticks,
                seconds,
                threads: self.threads,
            }),
            journal: Some(journal),
            keeps,
        })
    }
}
/// The map that is already at `out`, if it is this one.
///
/// # Errors
/// It is something else, and is not to be overwritten.
fn complete(
    out: &Path,
    receipt: &[(String, String)],
    may_overwrite: bool,
) -> Result<Option<Map>, MapJobError> {
    let Ok(file) = std::fs::File::open(out) else {
        return Ok(None);
    };
    match Map::read(file, &out.display().to_string()) {
        Ok(map) if map.receipt == receipt => Ok(Some(map)),
        _ if may_overwrite => Ok(None),
        Ok(map) if map.format() != Some(Format::BouncesAndStays) => {
            Err(MapJobError::Other(format!(
                "{} is by an older version and has bounces alone; name another file with --out, or replace it \
             with --overwrite",
                out.display()
            )))
        }
        Ok(_) => Err(MapJobError::Other(format!(
            "{} is another map, and complete; name another file with --out, or replace it with \
             --overwrite",
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

/// All rows of a cell on one line of a journal.
fn line_of(rows: &[Row]) -> String {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    lines.join(";")
}

fn rows_of(line: &str) -> Result<Vec<Row>, String> {
    line.split(';')
        .map(|row| Row::from_line(row, Format::BouncesAndStays))
        .collect()
}

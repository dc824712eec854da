//! Cells into a journal, and from it into a file.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use palpate_files::atomic::{Existing, check};
use palpate_files::journal::{Journal, JournalError};
use palpate_record::map::{Format, Map, Row};
use palpate_study::map::receipt;
use palpate_study::map::report::Speed;
use palpate_study::map::{Done, MapParams, compute};

use super::arguments::{Shard, WorkArguments};
use super::files::Files;
use crate::failure::{Failure, tell};
use crate::progress::Progress;

/// Set when the user wants the program to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// A map, or a part.
pub struct Computed {
    /// What was asked for.
    pub map: Map,
    /// How fast it came; none of one that was there.
    pub speed: Option<Speed>,
    /// Keeps others from the map's files. It is removed when the last of them is written.
    pub journal: Option<Journal>,
}

/// Computes a map, or a part, into the file at `out`.
///
/// A journal beside it keeps what is done.
pub fn run(
    params: &MapParams,
    shard: Shard,
    work: &WorkArguments,
    out: &Path,
    files: &Files,
) -> Result<Computed, Failure> {
    let receipt = receipt::of(params, (shard.number, shard.of));
    let head = receipt::line(&receipt);
    let journal_path = journal_of(out);
    let mut done = BTreeMap::new();
    // Nothing is looked at before nobody else can change it.
    let found = Journal::open(&journal_path).map_err(unusable)?;
    if let Some(why) = &found.unlocked {
        tell(format_args!(
            "warning: {} cannot be locked ({why}); see to it that no other map is computed into it",
            journal_path.display()
        ));
    }
    let mut journal = found.journal;
    if work.resume
        && let Some(map) = complete(out, &receipt, files.overwrites())?
    {
        let is_of_another = found.head.is_some_and(|begun| begun != head);
        return Ok(Computed {
            map,
            speed: None,
            journal: Some(journal).filter(|_| !is_of_another),
        });
    }
    if !work.resume && !files.overwrites() {
        // It may have come since it was looked for.
        check(out, Existing::Keep)?;
    }
    match found.head {
        None => journal.begin(&head).map_err(unusable)?,
        Some(_) if !work.resume => {
            return Err(Failure::input(format!(
                "{} keeps {} cells of a map that was interrupted; go on with --resume, or delete it",
                journal_path.display(),
                found.lines.len()
            )));
        }
        Some(begun) if begun != head => {
            return Err(Failure::input(format!(
                "{} is of another map; give the arguments it was begun with, or delete it\n  \
                 begun: {begun}\n  now:   {head}",
                journal_path.display()
            )));
        }
        Some(_) => {
            for line in &found.lines {
                let rows = rows_of(line).map_err(|fault| {
                    Failure::input(format!("{}: {fault}", journal_path.display()))
                })?;
                if let Some(first) = rows.first() {
                    done.insert(first.cell, rows);
                }
            }
        }
    }

    let cells: Vec<usize> = params
        .shard(shard.number, shard.of)
        .into_iter()
        .filter(|cell| !done.contains_key(&(*cell as u64)))
        .collect();
    let threads = work
        .threads
        .map(usize::from)
        .or_else(|| std::thread::available_parallelism().ok().map(Into::into))
        .unwrap_or(1);
    // A second handler cannot be set; there is one map in a run of the program.
    let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));

    let progress = Progress::new(cells.len());
    progress.begin("cells");
    let start = Instant::now();
    let (mut ticks, mut fault) = (0, None);
    let ended = compute(params, &cells, threads, &STOP, |result| {
        ticks += result.ticks;
        let rows = result.rows(params);
        if let Err(error) = journal.append(&line_of(&rows)) {
            fault = Some(error);
            return ControlFlow::Break(());
        }
        done.insert(result.index as u64, rows);
        progress.advance();
        ControlFlow::Continue(())
    })
    .map_err(Failure::input)?;
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);
    let kept = done.len();
    let whole = params.shard(shard.number, shard.of).len();
    let keeps = format!(
        "{kept} of {whole} cells are kept in {}; go on with --resume",
        journal_path.display()
    );
    if let Some(error) = fault {
        return Err(Failure::System(format!("{error}\n{keeps}")));
    }
    if ended == Done::Stopped {
        return Err(Failure::Interrupted(format!("stopped: {keeps}")));
    }
    let map = Map {
        receipt,
        rows: done.into_values().flatten().collect(),
    };
    files
        .write_map(&map)
        .map_err(|error| Failure::System(format!("{}\n{keeps}", error.message())))?;
    let speed = Speed {
        ticks,
        seconds,
        threads,
    };
    Ok(Computed {
        map,
        speed: Some(speed),
        journal: Some(journal),
    })
}

/// The map that is already at `out`, if it is this one.
///
/// # Errors
/// It is something else, and is not to be overwritten.
fn complete(
    out: &Path,
    receipt: &[(String, String)],
    may_overwrite: bool,
) -> Result<Option<Map>, Failure> {
    let Ok(file) = std::fs::File::open(out) else {
        return Ok(None);
    };
    match Map::read(file, &out.display().to_string()) {
        Ok(map) if map.receipt == receipt => Ok(Some(map)),
        _ if may_overwrite => Ok(None),
        Ok(map) if map.format() != Some(Format::BouncesAndStays) => Err(Failure::input(format!(
            "{} is by an older version and has bounces alone; name another file with --out, or replace it \
             with --overwrite",
            out.display()
        ))),
        Ok(_) => Err(Failure::input(format!(
            "{} is another map, and complete; name another file with --out, or replace it with \
             --overwrite",
            out.display()
        ))),
        Err(error) => Err(Failure::input(format!(
            "{error}; name another file with --out, or replace it with --overwrite"
        ))),
    }
}

fn journal_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".journal");
    name.into()
}

/// Why a journal cannot be used, and what to do.
pub fn unusable(error: JournalError) -> Failure {
    match error {
        JournalError::Write(error) => Failure::System(error.to_string()),
        JournalError::Held { .. } => Failure::System(format!(
            "{error}, which computes this map; wait for it, or end it and go on with --resume, or name \
             another file with --out"
        )),
        JournalError::Damaged { .. } => Failure::input(error),
    }
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

//! Cells into a journal, and from it into a file.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use palpate_io::journal::{Journal, JournalError};
use palpate_io::map::{Map, Row};
use palpate_sim::map::{Done, MapParams, compute};

use super::arguments::{Shard, WorkArguments};
use super::receipt;
use crate::failure::Failure;
use crate::progress::Progress;

/// Set when the user wants the program to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// How fast the work was.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// Ticks of plant, renderer and metrics.
    pub ticks: u64,
    /// Time `[s]`.
    pub seconds: f64,
    /// Threads that shared the work.
    pub threads: usize,
}

/// Computes a map, or a part, into the file at `out`.
///
/// A journal beside it keeps what is done; it is removed when the file is complete.
pub fn run(
    params: &MapParams,
    shard: Shard,
    work: &WorkArguments,
    out: &Path,
) -> Result<(Map, Option<Speed>), Failure> {
    let receipt = receipt::of(params, shard);
    let head = receipt::line(&receipt);
    let journal_path = journal_of(out);
    let mut done = BTreeMap::new();
    let found = Journal::open(&journal_path).map_err(unusable)?;
    let mut journal = match found {
        Some(found) if work.resume => {
            if found.head != head {
                return Err(Failure::input(format!(
                    "{} is of another map; give the arguments it was begun with, or delete it\n  \
                     begun: {}\n  now:   {head}",
                    journal_path.display(),
                    found.head
                )));
            }
            for line in &found.lines {
                let rows = rows_of(line).map_err(|fault| {
                    Failure::input(format!("{}: {fault}", journal_path.display()))
                })?;
                if let Some(first) = rows.first() {
                    done.insert(first.cell, rows);
                }
            }
            found.journal
        }
        Some(found) => {
            return Err(Failure::input(format!(
                "{} keeps {} cells of a map that was interrupted; go on with --resume, or delete it",
                journal_path.display(),
                found.lines.len()
            )));
        }
        None => {
            if work.resume
                && let Some(map) = complete(out, &receipt)?
            {
                return Ok((map, None));
            }
            Journal::create(&journal_path, &head).map_err(unusable)?
        }
    };

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
        let rows = rows(params, &result);
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
    palpate_io::atomic::write(out, |writer| map.write(writer))
        .map_err(|error| Failure::System(format!("{error}\n{keeps}")))?;
    journal.remove().map_err(unusable)?;
    let speed = Speed {
        ticks,
        seconds,
        threads,
    };
    Ok((map, Some(speed)))
}

/// The map that is already at `out`, if it is this one.
fn complete(out: &Path, receipt: &[(String, String)]) -> Result<Option<Map>, Failure> {
    let Ok(file) = std::fs::File::open(out) else {
        return Ok(None);
    };
    let map = Map::read(file, &out.display().to_string()).map_err(Failure::input)?;
    if map.receipt == receipt {
        Ok(Some(map))
    } else {
        Err(Failure::input(format!(
            "{} is another map, and complete; name another file with --out",
            out.display()
        )))
    }
}

fn journal_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".journal");
    name.into()
}

fn unusable(error: JournalError) -> Failure {
    match error {
        JournalError::Write(error) => Failure::System(error.to_string()),
        JournalError::Damaged { .. } => Failure::input(error),
    }
}

fn rows(params: &MapParams, result: &palpate_sim::map::CellResult) -> Vec<Row> {
    let cell = params.cell(result.index);
    result
        .entries
        .iter()
        .map(|entry| Row {
            cell: cell.index as u64,
            kappa: cell.kappa,
            object_kappa: cell.object_kappa,
            stiffness: cell.bounce.stiffness,
            object_mass: cell.bounce.object_mass,
            plant: entry.plant.name().to_owned(),
            method: entry.method.name().to_owned(),
            growth: [entry.growth.median, entry.growth.worst],
            error: [entry.error.median, entry.error.worst],
            error_over_floor: [entry.error_over_floor.median, entry.error_over_floor.worst],
            hold_floor: [entry.hold_floor.median, entry.hold_floor.worst],
            classes: entry.classes.map(|count| count as u64),
        })
        .collect()
}

/// All rows of a cell on one line of a journal.
fn line_of(rows: &[Row]) -> String {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    lines.join(";")
}

fn rows_of(line: &str) -> Result<Vec<Row>, String> {
    line.split(';').map(Row::from_line).collect()
}

//! Computes a map into its file, with its progress, its end and its exit codes.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use palpate_record::files::journal::{Journal, JournalError};
use palpate_record::map::Map;
use palpate_study::map::report::Speed;
use palpate_study::map::{MapFollower, MapJob, MapJobError, MapParams};

use super::arguments::{Shard, WorkArguments};
use super::files::Files;
use crate::failure::{Failure, tell};
use crate::progress::Progress;

/// Set if the user ends the program.
static STOP: AtomicBool = AtomicBool::new(false);

/// A map, or a part.
pub struct Computed {
    /// The requested map.
    pub map: Map,
    /// Computation speed; `None` for a map that existed already.
    pub speed: Option<Speed>,
    /// Locks the map's files. It is removed when the last of them is written.
    pub journal: Option<Journal>,
}

/// Shows the progress.
struct Shown(Option<Progress>);

impl MapFollower for Shown {
    fn is_unlocked(&mut self, journal: &Path, why: &io::Error) {
        tell(format_args!(
            "warning: {} cannot be locked ({why}); do not compute another map into it",
            journal.display()
        ));
    }

    fn begin(&mut self, cells: usize) {
        // A second handler cannot be set; one run of the program computes one map.
        let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
        let progress = Progress::new(cells);
        progress.begin("cells");
        self.0 = Some(progress);
    }

    fn advance(&mut self) {
        if let Some(progress) = &self.0 {
            progress.advance();
        }
    }

    fn end(&mut self) {
        self.0 = None;
    }
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
    let threads = work
        .threads
        .map(usize::from)
        .or_else(|| std::thread::available_parallelism().ok().map(Into::into))
        .unwrap_or(1);
    let job = MapJob {
        params,
        part: (shard.number, shard.of),
        threads,
        out,
        is_resumed: work.resume,
        overwrites: files.overwrites(),
    };
    let computed = job.run(&STOP, &mut Shown(None)).map_err(refused)?;
    // An existing map stays unchanged.
    if computed.speed.is_some() {
        files
            .write_map(&computed.map)
            .map_err(|error| Failure::System(format!("{}\n{}", error.message(), computed.keeps)))?;
    }
    Ok(Computed {
        map: computed.map,
        speed: computed.speed,
        journal: computed.journal,
    })
}

/// Converts a failed computation to an exit code.
fn refused(error: MapJobError) -> Failure {
    match error {
        MapJobError::Journal(error) => unusable(error),
        MapJobError::There(error) => error.into(),
        MapJobError::Unwritten { .. } => Failure::System(error.to_string()),
        MapJobError::Stopped(_) => Failure::Interrupted(error.to_string()),
        other => Failure::input(other),
    }
}

/// Explains an unusable journal, with the remedy.
pub fn unusable(error: JournalError) -> Failure {
    match error {
        JournalError::Write(error) => Failure::System(error.to_string()),
        JournalError::Held { .. } => Failure::System(format!(
            "{error}, which computes this map; wait for it, or end it and continue with --resume, or name another file \
             with --out"
        )),
        JournalError::Damaged { .. } => Failure::input(error),
    }
}

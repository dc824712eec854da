//! Parallel computation of cells.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::bounce::BounceError;
use super::cell::CellResult;
use super::grid::MapParams;

/// Outcome of a computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    /// All cells were computed.
    All,
    /// The computation was stopped early.
    Stopped,
}

/// Runs `cells` of a map on `threads` threads, 0 for all cores, and passes each result to `take` in order of
/// completion. Stops early once `stop` is set or `take` breaks, after the running cells have finished.
///
/// # Errors
/// The error of a cell. No further cell is started after it.
///
/// # Panics
/// The system cannot start threads.
pub fn compute(
    params: &MapParams,
    cells: &[usize],
    threads: usize,
    stop: &AtomicBool,
    mut take: impl FnMut(CellResult) -> ControlFlow<()>,
) -> Result<Done, BounceError> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("the system gives threads");
    let over = AtomicBool::new(false);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            pool.install(|| {
                cells
                    .par_iter()
                    .with_max_len(1)
                    .for_each_with(sender, |sender, &cell| {
                        if stop.load(Ordering::Relaxed) || over.load(Ordering::Relaxed) {
                            return;
                        }
                        // The receiver only disconnects when the remaining results are not needed.
                        let _ = sender.send(params.run_cell(cell));
                    });
            });
        });
        let mut taken = 0;
        let mut outcome = Ok(());
        for result in receiver {
            match result {
                Ok(_) if over.load(Ordering::Relaxed) => {}
                Ok(result) => {
                    taken += 1;
                    if take(result).is_break() {
                        over.store(true, Ordering::Relaxed);
                    }
                }
                Err(error) => {
                    over.store(true, Ordering::Relaxed);
                    outcome = Err(error);
                }
            }
        }
        outcome.map(|()| {
            if taken == cells.len() && !over.load(Ordering::Relaxed) {
                Done::All
            } else {
                Done::Stopped
            }
        })
    })
}

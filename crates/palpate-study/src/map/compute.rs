//! Cells on all cores.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::bounce::BounceError;
use super::cell::CellResult;
use super::grid::MapParams;

/// How a computation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    /// With all cells.
    All,
    /// Early, because it was told to.
    Stopped,
}

/// Runs `cells` of a map on so many threads, 0 for all cores, and gives each result to `take` as it
/// comes, in no order. It ends early once `stop` is set or `take` breaks; cells that are being run
/// are then finished first.
///
/// # Errors
/// The error of a cell. No other is begun after it.
///
/// # Panics
/// If the system gives no threads.
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
                        // The receiver leaves only when the rest is not wanted.
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

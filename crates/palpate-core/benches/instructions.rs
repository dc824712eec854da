//! Program for `scripts/instructions.py`, which counts its instructions with valgrind.
//!
//! It repeats the ticks of each class and calls [`lap`] after each part. Callgrind writes its counts there, and the
//! script subtracts them. Before each lap the program prints the name of the part and its number of runs.
#![allow(clippy::print_stdout)] // the script reads it

mod recorded;

use std::hint::black_box;

use recorded::{CLASSES, METHODS, Recorded, Tick};

/// Runs per part, single and double: the difference excludes constant overhead.
const RUN_COUNTS: [usize; 2] = [240, 480];

/// Callgrind writes its counts here and restarts them.
#[inline(never)]
fn lap() {
    black_box(());
}

fn main() {
    if !std::env::args().any(|argument| argument == "--count") {
        println!("run by scripts/instructions.py");
        return;
    }
    let mut parts = Vec::new();
    for method in METHODS {
        let recorded = Recorded::run(method);
        for class in CLASSES {
            let ticks = recorded.of_class(class);
            if !ticks.is_empty() {
                parts.push((format!("{method},{class}"), recorded.renderer, ticks));
            }
        }
    }
    for (name, renderer, ticks) in &parts {
        for run_count in RUN_COUNTS {
            println!("{name},{run_count}");
            let ticks = ticks.iter().cycle().take(run_count);
            let mut ticks: Vec<Tick> = ticks.copied().collect();
            lap();
            for tick in black_box(&mut ticks) {
                tick.take(renderer);
            }
            lap();
        }
    }
}

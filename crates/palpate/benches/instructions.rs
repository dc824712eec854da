//! The program whose instructions `scripts/instructions.py` has valgrind count.
//!
//! It runs the ticks of each class again and again and calls [`lap`] after each part; callgrind
//! writes its counts there, and the script subtracts. Before each lap it prints what was run:
//! a name, and how often.
#![allow(clippy::print_stdout)] // the script reads it

mod recorded;

use std::hint::black_box;

use recorded::{CLASSES, METHODS, Recorded, Tick};

/// Runs per part, once and twice: the difference holds no loop or call overhead but its own.
const RUN_COUNTS: [usize; 2] = [240, 480];

/// Where callgrind writes its counts and begins anew.
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

//! Time per tick: `cargo bench -p palpate-core --bench tick`.
//!
//! Two tables in nanoseconds. Over the Fig. 2 scene: the mean of a run from its first tick to its last, as on a device,
//! then every tick timed by itself, on many prepared copies of its state. By class of tick: the median of the ticks of
//! the class.
#![allow(clippy::print_stdout)] // a benchmark prints

mod recorded;

use std::hint::black_box;
use std::time::Instant;

use recorded::{CLASSES, METHODS, Recorded, Tick};

/// Copies of one tick that run in a row: few enough for the first-level cache.
const COPY_COUNT: usize = 64;
const REPEAT_COUNT: usize = 60;

fn main() {
    // Under `cargo test` the benchmark is only built and started.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let recorded = METHODS.map(|method| (method, Recorded::run(method)));

    println!("ns per tick, whole scene");
    println!(
        "{:16}{:>8}{:>8}{:>8}{:>8}",
        "", "in a row", "median", "p99", "max"
    );
    for (method, recorded) in &recorded {
        let times = sorted(recorded.scene.iter().map(|tick| alone(recorded, tick)));
        let last = times.len() - 1;
        println!(
            "{method:16}{:8.1}{:8.1}{:8.1}{:8.1}",
            in_a_row(recorded),
            times[last / 2],
            times[last * 99 / 100],
            times[last]
        );
    }

    println!("\nns per tick, median of each class");
    print!("{:16}", "");
    for class in CLASSES {
        print!("{class:>8}");
    }
    println!();
    for (method, recorded) in &recorded {
        print!("{method:16}");
        for class in CLASSES {
            let ticks = recorded.of_class(class);
            let times = sorted(ticks.iter().map(|tick| alone(recorded, tick)));
            match times.get(times.len() / 2) {
                Some(median) => print!("{median:8.1}"),
                None => print!("{:>8}", "-"),
            }
        }
        println!();
    }
}

fn sorted(times: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Returns the minimum time of many runs `[ns]`; larger times include other programs.
fn least(mut run: impl FnMut() -> Instant) -> f64 {
    (0..REPEAT_COUNT)
        .map(|_| run().elapsed().as_secs_f64() * 1e9)
        .fold(f64::INFINITY, f64::min)
}

/// Returns the time of one tick by itself `[ns]`.
fn alone(recorded: &Recorded, tick: &Tick) -> f64 {
    let all = least(|| {
        let mut copies = [*tick; COPY_COUNT];
        let copies = black_box(&mut copies);
        let before = Instant::now();
        for copy in copies {
            copy.take(&recorded.renderer);
        }
        before
    });
    all / COPY_COUNT as f64
}

/// Returns the time per tick of the whole scene on one state `[ns]`.
fn in_a_row(recorded: &Recorded) -> f64 {
    let all = least(|| {
        let mut state = black_box(recorded.scene[0].state);
        let before = Instant::now();
        for tick in &recorded.scene {
            black_box(&recorded.renderer.step(&mut state, black_box(tick.sample)));
        }
        black_box(&state);
        before
    });
    all / recorded.scene.len() as f64
}

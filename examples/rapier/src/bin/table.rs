//! What Rapier's own contacts make of a scene, and what palpate's make of it in the same engine.
//!
//! `cargo run --release --bin table` takes 4 steps of the engine in a period, which the engine divides into 4 parts
//! each. `-- 1x4 4x1 10x4` takes each of these.

use palpate_example_rapier::rendered::{Bench, Outcome, Own};
use palpate_example_rapier::scenes::{RATES, scenes};

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let asked = arguments.iter().map(|argument| steps(argument));
    let mut asked = asked.collect::<Result<Vec<_>, _>>()?;
    if asked.is_empty() {
        asked.push((4, 4));
    }
    println!("E in percent, (FRE over the hold bound), time of a step with the contact in us\n");
    println!(
        "| scene | T ms | K N/m | steps | engine | engine, tuned | palpate | palpate, model mass 1.5 times | us, engine | us, palpate | tuned |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|");
    for (period, stiffness) in RATES {
        for scene in scenes(period, stiffness) {
            for (count, parts) in &asked {
                let name = scene.name;
                let bench = Bench::new(scene.clone(), *count, *parts)?;
                let engine = bench.engine(Own::default())?;
                let (best, tuned) = tuned(&bench)?;
                let (palpate, model) = (bench.palpate(1.0)?, bench.palpate(1.5)?);
                println!(
                    "| {name} | {} | {stiffness} | {count}x{parts} | {} | {} | {} | {} | {:.1} | {:.1} | damping ratio {:.2}{} |",
                    1e3 * period,
                    shown(&engine),
                    shown(&tuned),
                    shown(&palpate),
                    shown(&model),
                    1e6 * engine.step,
                    1e6 * palpate.step,
                    best.damping_ratio,
                    if best.moves { ", tool moved on" } else { "" },
                );
            }
        }
    }
    Ok(())
}

/// Steps of the engine in a period, and the parts of each.
fn steps(argument: &str) -> Result<(u32, usize), String> {
    let numbers = argument.split_once('x');
    let numbers =
        numbers.and_then(|(steps, parts)| Some((steps.parse().ok()?, parts.parse().ok()?)));
    numbers
        .filter(|(steps, parts)| (1..=1000).contains(steps) && (1..=100).contains(parts))
        .ok_or_else(|| {
            format!(
                "\"{argument}\" is not STEPSxPARTS: 4x1 is 4 steps of the engine in a period, 1 to 1000, each in 1 \
                 part, 1 to 100"
            )
        })
}

fn shown(outcome: &Outcome) -> String {
    format!("{:.2} ({:.2})", outcome.error, outcome.over_bound)
}

/// The damping and the motion of the tool that give the least E of this scene, found with knowledge of its ideal.
fn tuned(bench: &Bench) -> Result<(Own, Outcome), String> {
    let ratios = (0..17).map(|step| 0.02 * 1.25_f64.powi(step));
    let mut best: Option<(Own, Outcome)> = None;
    for damping_ratio in std::iter::once(0.0).chain(ratios) {
        for moves in [false, true] {
            let own = Own {
                damping_ratio,
                moves,
            };
            let outcome = bench.engine(own)?;
            if best.is_none_or(|(_, best)| outcome.error < best.error) {
                best = Some((own, outcome));
            }
        }
    }
    best.ok_or_else(|| "no damping ratio was evaluated".to_owned())
}

//! Influence of the sensor and the hand on the force error of random worlds.
#![allow(clippy::print_stdout)] // what was measured

use palpate_study::sim::world::{WorldBench, as_rendered};
use palpate_testbed::schedule::{ActuationDelay, ScheduleParams};
use palpate_testbed::timeline::Timeline;
use palpate_testbed::world::Decisive;
use palpate_testbed::world::random_worlds::{RandomHands, RandomWorld, random_worlds};
use palpate_world::{CoupledParams, WorldLoop, WorldRenderer};
use rayon::prelude::*;

/// The loop of the evaluation.
#[derive(Clone, Copy)]
struct Condition {
    period: f64,
    delay_samples: usize,
    quantum: f64,
}

/// Returns the influence of sensor and hand on one world, and E of `coupled` `[%]`.
fn evaluated(world: &RandomWorld, condition: Condition) -> Option<(Decisive, f64)> {
    let Condition {
        period, quantum, ..
    } = condition;
    let mut scene = world.scene.clone();
    scene.devices[0].quantum = [quantum; 3];
    let delay = condition.delay_samples as f64 * period;
    let schedule = ScheduleParams {
        delay: ActuationDelay {
            seconds: delay,
            ..ActuationDelay::default()
        },
        ..ScheduleParams::perfect(period)
    };
    let timeline = Timeline::new(schedule, world.ideal.grid.intervals()).unwrap();
    let loop_params = WorldLoop::new(period).with_actuation(palpate_core::Actuation {
        delay,
        ..palpate_core::Actuation::default()
    });
    let rendered = as_rendered(&scene);
    let bench = WorldBench::of(scene, timeline, world.ideal.clone());
    let model = CoupledParams::new(vec![world.model_mass]).with_encoder_quantum(quantum);
    let renderer = WorldRenderer::new(&rendered, loop_params, model).unwrap();
    let run = bench.run("coupled", &renderer).unwrap();
    let error = run.evaluation.sum?.mean_force_error;
    Some((bench.decisive()[0], error))
}

fn all(conditions: &[Condition], worlds: usize) -> Vec<(Decisive, f64)> {
    let mut reference_worlds = Vec::new();
    for &condition in conditions {
        let drawn = random_worlds(RandomHands::Springs, worlds, condition.period, 7).unwrap();
        let of_condition: Vec<_> = drawn
            .par_iter()
            .filter_map(|world| evaluated(world, condition))
            .collect();
        reference_worlds.extend(of_condition);
    }
    reference_worlds
}

/// Returns and prints median and 90 % quantile of E of the worlds with `measure` in a range.
fn errors(
    name: &str,
    evaluated: &[(Decisive, f64)],
    measure: impl Fn(&Decisive) -> f64,
    range: std::ops::Range<f64>,
) -> [f64; 2] {
    let mut errors: Vec<f64> = evaluated
        .iter()
        .filter(|(decisive, _)| range.contains(&measure(decisive)))
        .map(|(_, error)| *error)
        .collect();
    errors.sort_by(f64::total_cmp);
    assert!(errors.len() >= 20, "{name} {range:?}: {}", errors.len());
    let [median, most] = [50, 90].map(|share| errors[errors.len() * share / 100]);
    println!(
        "{name} {} to {}: {} worlds, E {median:.2} / {most:.2} %",
        range.start,
        range.end,
        errors.len()
    );
    [median, most]
}

#[test]
fn the_sensor_decides_where_a_quantum_is_a_tenth_of_the_force() {
    let conditions = [5e-7, 2e-6, 1e-5, 5e-5].map(|quantum| Condition {
        period: 0.001,
        delay_samples: 0,
        quantum,
    });
    let evaluated = all(&conditions, 60);
    let of = |range| {
        let measure = |it: &Decisive| it.quantum_over_force.unwrap_or(0.0);
        errors("q K/force", &evaluated, measure, range)
    };
    let (fine, between) = (of(0.0..0.01), of(0.01..Decisive::SENSOR));
    let coarse = of(Decisive::SENSOR..f64::INFINITY);
    assert!(fine[1] < 8.0, "{fine:?}");
    assert!(fine[0] < between[0] && between[0] < coarse[0]);
    assert!(coarse[0] > 5.0 * fine[0] && coarse[1] > 20.0, "{coarse:?}");
}

#[test]
fn a_stiff_hand_behind_a_delay_decides() {
    let condition = Condition {
        period: 0.01,
        delay_samples: 1,
        quantum: 2e-6,
    };
    let evaluated = all(&[condition], 200);
    let of = |range| errors("k T^2/m", &evaluated, |it| it.hand_over_mass, range);
    let (soft, stiff) = (of(0.0..0.05), of(Decisive::HAND..f64::INFINITY));
    assert!(stiff[0] > 4.0 * soft[0] && stiff[0] > 5.0, "{stiff:?}");
}

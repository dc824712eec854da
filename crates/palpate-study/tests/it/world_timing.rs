//! Imperfect loops of a world: samples and commands come when they do in the closed form of the same scene.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{ContactFile, Scene};
use palpate_study::seeded::{scores_of_world, world_with_seed};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;
use palpate_study::sim::world::{WorldBench, WorldRun};

/// A point that a hand presses against a wall. The closed form renders it, and the world renderer does if asked.
const WALL: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
axes = ["x"]
mass_kg = 0.2
position_m = [-0.004, 0.0, 0.0]
hand.force_n = [1.0, 0.0, 0.0]
[[body]]
name = "wall"
fixed = true
shape = { half_space = { normal = [-1.0, 0.0, 0.0] } }
[[contact]]
between = ["tool", "wall"]
stiffness_n_per_m = 800.0
[measure]
duration_s = 0.4
"#;

const STIFFNESS: f64 = 800.0;

/// Keys of a loop, each with one imperfection or several.
const IMPERFECT: [&str; 9] = [
    "delay_samples = 2\ndelay_fraction = 0.3",
    "jitter_s = 3e-4",
    "jitter_s = 4e-4\njitter_deviation_s = 2e-4",
    "drop_probability = 0.2",
    "dropped_samples = [40, 41, 42, 90]",
    "collapse = { from_s = 0.1, until_s = 0.25, period_s = 0.0031 }",
    "delay_s = 0.0004\ncommand_jitter_s = 0.0018",
    "lag_s = 0.0007\ngain = 0.9\ndrop_probability = 0.1",
    "delay_samples = 1\njitter_s = 2e-4\ndrop_probability = 0.1\ncommand_jitter_s = 5e-4\n\
     collapse = { from_s = 0.1, until_s = 0.2, period_s = 0.0023 }",
];

fn world(source: &str) -> WorldScene {
    WorldFile::parse("scene.toml", source).unwrap().scene
}

fn of_world(scene: &WorldScene) -> (WorldBench, WorldRun) {
    let bench = WorldBench::new(scene).unwrap();
    let run = bench.run("basic", &scene.renderer("basic").unwrap());
    (bench, run.unwrap())
}

fn of_contact(scene: &Scene) -> Run {
    let bench = Bench::new(scene).unwrap();
    bench.run(MethodName::Basic).unwrap()
}

/// Largest difference between the forces that the two loops held, over the largest force.
fn difference(run: &Run, world: &WorldRun) -> f64 {
    let held = world.delivered[0].iter().map(|force| -force[0]);
    assert_eq!(run.held.len(), held.len());
    let largest = run.held.iter().fold(0.0, |most: f64, held| {
        most.max(held.force_on_object.abs())
    });
    assert!(largest > 1.0, "{largest}");
    let apart = run.held.iter().zip(held);
    let apart = apart.map(|(held, other)| (held.force_on_object - other).abs());
    apart.fold(0.0, f64::max) / largest
}

#[test]
fn an_imperfect_loop_of_a_world_is_that_of_the_closed_form() {
    for keys in IMPERFECT {
        let source = WALL.replace("[loop]", &format!("[loop]\nseed = 7\n{keys}"));
        let contact = of_contact(&ContactFile::parse("scene.toml", &source).unwrap().scene);
        let scene = world(&source);
        let (bench, run) = of_world(&scene);
        let apart = difference(&contact, &run);
        println!("{keys:?}: {apart:.1e} of the largest force");
        assert!(apart < 1e-9, "{keys}: {apart}");
        // The closed form has a sample at the end of the window, too.
        let times = contact.ticks.iter().map(|tick| tick.time);
        assert!(times.take(run.positions.len()).eq(bench.samples().iter().map(|it| it.time)));
        let [one, other] = [contact.force.fidelity, run.evaluation.sum].map(Option::unwrap);
        for (one, other) in [
            (one.mean_force_error, other.mean_force_error),
            (one.force_rendering_error, other.force_rendering_error),
            (one.hold_bound, other.hold_bound),
        ] {
            assert!((one / other - 1.0).abs() < 1e-6, "{keys}: {one} {other}");
        }
        // The comparison sees the imperfection, and the seed where there is one.
        let (_, perfect) = of_world(&world(WALL));
        assert!(perfect.delivered[0].len() != run.delivered[0].len() || difference(&contact, &perfect) > 1e-3);
        if let Some(seed) = scene.random_seed() {
            assert_eq!(seed, 7);
            let (_, another) = of_world(&world_with_seed(&scene, 8, None));
            assert_ne!(another.delivered, run.delivered, "{keys}");
        }
    }
}

/// The energy that held forces create is the work on the tool and the change of what the contact stores, over the
/// measured intervals, however long they are.
#[test]
fn the_books_of_a_world_balance_over_drops_and_jitter() {
    for keys in ["seed = 1", "drop_probability = 0.3", "jitter_s = 4e-4\ndrop_probability = 0.2"] {
        let source = WALL.replace("[loop]", &format!("[loop]\n{keys}"));
        let (bench, run) = of_world(&world(&source));
        let places: Vec<f64> = run.positions.iter().map(|tools| tools[0][0]).collect();
        let steps = places.windows(2).zip(&run.delivered[0]);
        let work: f64 = steps.map(|(x, force)| force[0] * (x[1] - x[0])).sum();
        let stored = |x: f64| 0.5 * STIFFNESS * x.max(0.0).powi(2);
        let created = work + stored(places[places.len() - 1]) - stored(places[0]);
        let (given, samples) = (run.created(), bench.samples().len());
        println!("{keys:?}: created {given} J in {samples} samples");
        assert!(created > 1e-3, "{created}");
        assert!((given / created - 1.0).abs() < 1e-9, "{keys}: {given} {created}");
    }
}

#[test]
fn seeds_of_a_world_give_other_errors() {
    let source = WALL.replace("[loop]", "[loop]\ndrop_probability = 0.2");
    let scene = world(&source);
    let error = |seed| {
        let scores = scores_of_world(&world_with_seed(&scene, seed, None), &["basic"]).unwrap();
        scores[0].unwrap().mean_force_error
    };
    assert_eq!(error(3), error(3));
    assert_ne!(error(3), error(4));
}

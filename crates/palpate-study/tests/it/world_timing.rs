//! Imperfect loops of a world: samples and commands come when they do in the closed form of the same scene.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{ContactFile, Scene};
use palpate_study::seeded::scores;
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;
use palpate_study::sim::world::{WorldBench, WorldRun};
use palpate_study::studied::Studied;

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

/// Keys of a device and its hand.
const HELD: [&str; 9] = [
    "noise_m = 2e-5",
    "quantum_m = 1e-5\nnoise_m = 1e-5",
    "drivetrain.viscous_friction_n_s_per_m = 0.8",
    "drivetrain.coulomb_friction_n = 0.2",
    "drivetrain.motor_limit_n = 1.6",
    "hand.stiffness_n_per_m = 40\nhand.damping_n_s_per_m = 1\nhand.mass_kg = 0.15\nhand.release_s = 0.0931",
    "hand.stiffness_n_per_m = 90\nhand.swing_m = [0.02, 0, 0]\nhand.swing_hz = 4.1",
    "hand.stiffness_n_per_m = 300\nhand.damping_n_s_per_m = 2\nhand.rest_file = \"rest.csv\"",
    "noise_m = 1e-5\nhand.stiffness_n_per_m = 90\nhand.mass_kg = 0.1\nhand.swing_m = [0.02, 0, 0]\n\
     hand.swing_hz = 4.1\nhand.release_s = 0.31\ndrivetrain.coulomb_friction_n = 0.1\nhand.tremor_n = 0.1\n\
     hand.tremor_hz = 9\ndrivetrain.motor_limit_n = 4",
];

/// The recorded rest of a hand along x.
const REST: &str = "t_s,position_m\n2.0,-0.004\n2.05,0.006\n2.13,-0.003\n2.2,0.008\n2.3,0.002\n";

/// The wall with keys of its loop and of its device.
fn with(of_loop: &str, of_device: &str) -> String {
    WALL.replace("[loop]", &format!("[loop]\nseed = 7\n{of_loop}"))
        .replace("mass_kg = 0.2", &format!("mass_kg = 0.2\n{of_device}"))
}

/// A hand with an intention, friction, noise and a limit of the motor do in a world what they do in the closed form, in
/// a perfect loop and in an imperfect one.
#[test]
fn a_held_device_of_a_world_is_that_of_the_closed_form() {
    let folder = std::env::temp_dir().join(format!("palpate-rest-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("rest.csv"), REST).unwrap();
    let bare = of_world(&world(WALL)).1;
    for (keys, of_loop) in HELD
        .into_iter()
        .flat_map(|keys| [(keys, ""), (keys, IMPERFECT[8])])
    {
        let source = with(of_loop, keys);
        let mut rest = |_: &str| Ok(REST.to_owned());
        let file = ContactFile::parse_with("scene.toml", &source, &mut rest).unwrap();
        let contact = of_contact(&file.scene);
        let scene = WorldFile::parse_in("scene.toml", &source, &folder)
            .unwrap()
            .scene;
        let (_, run) = of_world(&scene);
        let apart = difference(&contact, &run);
        println!(
            "{keys:?} {}: {apart:.1e} of the largest force",
            !of_loop.is_empty()
        );
        assert!(apart < 1e-8, "{keys}: {apart}");
        let [one, other] = [contact.force.fidelity, run.evaluation.sum].map(Option::unwrap);
        for (one, other) in [
            (one.mean_force_error, other.mean_force_error),
            (one.force_rendering_error, other.force_rendering_error),
        ] {
            // The ideal of the closed form is integrated in steps.
            assert!((one / other - 1.0).abs() < 1e-4, "{keys}: {one} {other}");
        }
        if of_loop.is_empty() {
            assert!(difference(&contact, &bare) > 1e-3, "{keys}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

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
    let largest = run
        .held
        .iter()
        .fold(0.0, |most: f64, held| most.max(held.force_on_object.abs()));
    assert!(largest > 1.0, "{largest}");
    let apart = run.held.iter().zip(held);
    let apart = apart.map(|(held, other)| (held.force_on_object - other).abs());
    apart.fold(0.0, f64::max) / largest
}

#[test]
fn an_imperfect_loop_of_a_world_is_that_of_the_closed_form() {
    for keys in IMPERFECT {
        let source = with(keys, "");
        let contact = of_contact(&ContactFile::parse("scene.toml", &source).unwrap().scene);
        let scene = world(&source);
        let (bench, run) = of_world(&scene);
        let apart = difference(&contact, &run);
        println!("{keys:?}: {apart:.1e} of the largest force");
        assert!(apart < 1e-9, "{keys}: {apart}");
        // The closed form has a sample at the end of the window, too.
        let times = contact.ticks.iter().map(|tick| tick.time);
        assert!(
            times
                .take(run.positions.len())
                .eq(bench.samples().iter().map(|it| it.time))
        );
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
        assert!(
            perfect.delivered[0].len() != run.delivered[0].len()
                || difference(&contact, &perfect) > 1e-3
        );
        if let Some(seed) = scene.random_seed() {
            assert_eq!(seed, 7);
            let (_, another) = of_world(&scene.with_seed(8, None));
            assert_ne!(another.delivered, run.delivered, "{keys}");
        }
    }
}

/// Held forces create the work on the tool plus the change of the energy stored in the contact, over the measured
/// intervals.
#[test]
fn the_books_of_a_world_balance_over_drops_and_jitter() {
    for keys in [
        "seed = 1",
        "drop_probability = 0.3",
        "jitter_s = 4e-4\ndrop_probability = 0.2",
    ] {
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
        assert!(
            (given / created - 1.0).abs() < 1e-9,
            "{keys}: {given} {created}"
        );
    }
}

#[test]
fn seeds_of_a_world_give_other_errors() {
    let source = WALL.replace("[loop]", "[loop]\ndrop_probability = 0.2");
    let scene = world(&source);
    let error = |seed| {
        let scores = scores(&scene.with_seed(seed, None), &["basic"]).unwrap();
        scores[0].unwrap().mean_force_error
    };
    assert_eq!(error(3), error(3));
    assert_ne!(error(3), error(4));
}

//! Devices whose mobility has axes of its own: in the world's axes it is a matrix.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::world::{WorldBench, WorldRun};
use palpate_world::{CoupledParams, Prior, SubSteps, Vector, WorldLoop, WorldRenderer};

/// Axes along which nothing of the scenes lies: 2/3, 2/3, 1/3 and so on.
const AXES: [Vector; 3] = [
    [2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0],
    [-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0],
    [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
];

/// A tool that falls on a ball that lies on a floor beside a wall. `DEVICE` has its axes and masses.
const BALL: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
DEVICE
position_m = [0.004, 0.003, 0.046]
hand.force_n = [0.2, 0.1, -1.5]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.06
position_m = [0.0, 0.0, 0.0149]
force_n = [0.0, 0.0, -0.6]
shape = { sphere = { radius_m = 0.015 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[body]]
name = "wall"
fixed = true
shape = { half_space = { normal = [1.0, 0.0, 0.0], offset_m = -0.016 } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
friction = 0.3
[measure]
duration_s = 0.2
"#;

const GROOVE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
DEVICE
position_m = [0.004, 0.0, 0.03]
hand.force_n = [0.3, 0.2, -1.5]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "left"
fixed = true
shape = { half_space = { normal = [0.8, 0.0, 0.6] } }
[[body]]
name = "right"
fixed = true
shape = { half_space = { normal = [-0.7, 0.1, 0.7] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 2.0
[measure]
duration_s = 0.2
"#;

const OWN: &str =
    "axes = [[2.0, 2.0, 1.0], [-2.0, 1.0, 2.0], [1.0, -2.0, 2.0]]\nmass_kg = [0.1, 0.16, 0.3]";
const IN_A_PLANE: &str = "axes = [[2.0, 2.0, 1.0], [1.0, -2.0, 2.0]]\nmass_kg = [0.1, 0.3]";

/// A push and a start in that plane.
const PUSH: &str = "[-1.25, 0.4, -1.45]";
const STARTS: [(&str, &str, &str); 2] = [
    ("ball", BALL, "[0.0166, -0.0053, 0.0342]"),
    ("groove", GROOVE, "[0.025, -0.008, 0.035]"),
];

fn in_a_plane(source: &str, start: &str) -> WorldScene {
    let lines = source.lines().map(|line| {
        match line.split_once(" = ") {
            Some(("hand.force_n", _)) => format!("hand.force_n = {PUSH}"),
            // Of the device, which stands first.
            Some(("position_m", place)) if place.contains("0.046") || place.contains("0.03]") => {
                format!("position_m = {start}")
            }
            _ => line.to_owned(),
        }
    });
    let source: Vec<_> = lines.collect();
    parsed(&source.join("\n"), IN_A_PLANE, 0.001)
}

fn parsed(source: &str, device: &str, period: f64) -> WorldScene {
    let source = source.replace("DEVICE", device);
    let mut scene = WorldFile::parse("scene.toml", &source).unwrap().scene;
    scene.timing.period = period;
    scene
}

/// A loop whose integration is as good as exact.
fn fine(loop_params: WorldLoop) -> WorldLoop {
    WorldLoop {
        sub_steps: SubSteps {
            phase: 0.003,
            most: 4096,
            refined: 100,
            ..SubSteps::default()
        },
        ..loop_params
    }
}

/// Coupled rendering that knows the device and gives no offset back.
fn exact(scene: &WorldScene) -> CoupledParams {
    CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(scene.render.device_mass.clone()).with_prior(Prior::of_a_known_mass())
    }
}

fn error(run: &WorldRun) -> f64 {
    run.evaluation.sum.unwrap().mean_force_error
}

/// E of coupled rendering that knows the device `[%]`.
fn known(bench: &WorldBench, scene: &WorldScene) -> f64 {
    let renderer =
        WorldRenderer::new(&scene.world, fine(scene.loop_params()), exact(scene)).unwrap();
    error(&bench.run("coupled", &renderer).unwrap())
}

/// Returns the scene with model masses along the world's axes only: 1/m is the diagonal of the mobility.
fn model_the_diagonal(scene: &WorldScene) -> WorldScene {
    let mut model = scene.clone();
    let own = model.world.tools[0].own_axes.take().unwrap();
    let masses = scene.devices[0].mass;
    model.render.device_mass[0] = [0, 1, 2].map(|axis| {
        let parts = own.iter().zip(masses);
        1.0 / parts
            .map(|(own, mass)| own[axis] * own[axis] / mass)
            .sum::<f64>()
    });
    model
}

#[test]
fn with_the_device_known_each_held_force_is_the_mean_of_the_ideal_one() {
    for (name, source) in [("ball", BALL), ("groove", GROOVE)] {
        for period in [0.001, 0.004] {
            let scene = parsed(source, OWN, period);
            assert_eq!(scene.devices[0].mass, [0.1, 0.16, 0.3]);
            let bench = WorldBench::new(&scene).unwrap();
            assert_eq!(bench.self_check().unwrap().chaotic_from, None);
            let all = known(&bench, &scene);
            let diagonal = known(&bench, &model_the_diagonal(&scene));
            let as_it_comes = |model: &WorldScene, factor: f64, method: &str| {
                let mut model = model.clone();
                model.render.device_mass[0] = model.render.device_mass[0].map(|mass| factor * mass);
                error(&bench.run(method, &model.renderer(method).unwrap()).unwrap())
            };
            let [comes, wrong, of_diagonal, basic] = [
                as_it_comes(&scene, 1.0, "coupled"),
                as_it_comes(&scene, 1.5, "coupled"),
                as_it_comes(&model_the_diagonal(&scene), 1.0, "coupled"),
                as_it_comes(&scene, 1.0, "basic"),
            ];
            println!(
                "{name}, {period} s: E known {all:.4} %, told the diagonal only {diagonal:.2} %; as it comes {comes:.3} %, told 1.5 \
                 times {wrong:.3} %, told the diagonal only {of_diagonal:.2} %, basic {basic:.0} %"
            );
            assert!(all < 0.02, "{name}: {all}");
            assert!(
                diagonal > 8.0 * all && of_diagonal > comes,
                "{name}: {diagonal}"
            );
            assert!(comes < 1.0 && wrong < 2.0 && basic > 10.0 * wrong, "{name}");
        }
    }
}

#[test]
fn a_plane_that_is_not_one_of_the_world() {
    for (name, source, start) in STARTS {
        let scene = in_a_plane(source, start);
        assert_eq!(scene.world.tools[0].axes, [true, true, false]);
        let own = scene.world.tools[0].own_axes.unwrap();
        let bench = WorldBench::new(&scene).unwrap();
        let renderer =
            WorldRenderer::new(&scene.world, fine(scene.loop_params()), exact(&scene)).unwrap();
        let run = bench.run("coupled", &renderer).unwrap();
        println!("{name}: E {:.4} %", error(&run));
        assert!(error(&run) < 0.02, "{name}: {}", error(&run));
        let across = |force: &Vector| own[2].iter().zip(force).map(|(a, f)| a * f).sum::<f64>();
        let most = |forces: &mut dyn Iterator<Item = Vector>| {
            forces.map(|force| across(&force).abs()).fold(0.0, f64::max)
        };
        let commanded = most(&mut run.commanded.iter().map(|forces| forces[0]));
        assert!(commanded < 1e-12, "{name}: {commanded}");
        let states = bench.ideal().states.iter();
        let ideal = most(&mut states.map(|state| state.devices[0].force));
        assert!(ideal > 0.1, "{name}: {ideal}");
        for method in WorldScene::METHODS {
            let mut scene = scene.clone();
            crate::common::set_comparison(&mut scene);
            let run = bench.run(method, &scene.renderer(method).unwrap()).unwrap();
            assert_eq!(run.refused, 0, "{method}");
            let across = most(&mut run.commanded.iter().map(|forces| forces[0]));
            let size = |force: &Vector| force.iter().map(|part| part * part).sum::<f64>();
            let along = run.commanded.iter().map(|forces| size(&forces[0]).sqrt());
            let along = along.fold(0.0, f64::max);
            assert!(
                along > 0.5 && across < 1e-12 * along,
                "{method}: {along} {across}"
            );
        }
    }
}

/// The vectors of the world, of a device of the world's axes, are those of a device of the axes that the world is
/// turned by.
#[test]
fn every_method_pushes_in_a_turned_world_as_it_does_in_the_world() {
    let turned =
        |v: Vector| -> Vector { [0, 1, 2].map(|to| (0..3).map(|of| AXES[of][to] * v[of]).sum()) };
    let mut scene = parsed(BALL, "mass_kg = [0.1, 0.16, 0.3]", 0.002);
    crate::common::set_comparison(&mut scene);
    let mut other = scene.clone();
    other.world.tools[0].own_axes = Some(AXES);
    for device in &mut other.devices {
        device.own_axes = Some(AXES);
        device.position = turned(device.position);
        device.hand.force = turned(device.hand.force);
        device.hand.rest = turned(device.hand.rest);
    }
    for body in &mut other.world.bodies {
        body.position = turned(body.position);
        match &mut body.motion {
            palpate_world::Motion::Free(free) => free.force = turned(free.force),
            palpate_world::Motion::Fixed => {}
        }
        if let palpate_world::Shape::HalfSpace { normal, .. } = &mut body.shape {
            *normal = turned(*normal);
        }
    }
    let [one, two] = [&scene, &other].map(|scene| WorldBench::new(scene).unwrap());
    for method in WorldScene::METHODS {
        let [one, two] = [(&one, &scene), (&two, &other)]
            .map(|(bench, scene)| bench.run(method, &scene.renderer(method).unwrap()).unwrap());
        let apart = one.commanded.iter().zip(&two.commanded).map(|(one, two)| {
            let parts = turned(one[0]).into_iter().zip(two[0]);
            parts
                .map(|(one, two)| (one - two).abs())
                .fold(0.0, f64::max)
        });
        let apart = apart.fold(0.0, f64::max);
        let forces = one.commanded.iter().flat_map(|forces| forces[0]);
        let largest = forces.fold(0.0, |most: f64, part| most.max(part.abs()));
        println!("{method}: {apart:e} of {largest} N apart");
        assert!(largest > 1.0 && apart < 1e-9 * largest, "{method}: {apart}");
        let [one_error, two_error] = [error(&one), error(&two)];
        // The ideals themselves agree to some 1e-10 of the force: of a small E that is a larger part.
        let tolerance = 1e-6 * one_error.max(0.01);
        assert!(
            (one_error - two_error).abs() < tolerance,
            "{method}: {one_error} {two_error}"
        );
        let ledger = |run: &WorldRun| run.ledger.created();
        assert!((ledger(&one) - ledger(&two)).abs() < 1e-9, "{method}");
    }
}

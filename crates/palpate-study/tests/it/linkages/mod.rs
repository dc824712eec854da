//! Devices whose mass is another at each place: linkages.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

mod formulas;

use formulas::{arm, five_bar};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::world::{WorldBench, WorldRun};
use palpate_world::{CoupledParams, Prior, SubSteps, WorldLoop, WorldRenderer};

/// A five-bar in a plane. Its tool goes along a channel of two walls that lean, pushes a ball, and stops at a wall.
const CHANNEL: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
axes = ["x", "y"]
MASSES
position_m = [-0.045, 0.105, 0.0]
velocity_m_per_s = [0.35, -0.25, 0.0]
hand.force_n = [0.6, -0.5, 0.0]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "ball"
mass_kg = 0.03
position_m = [0.0, 0.0999, 0.0]
shape = { sphere = { radius_m = 0.01 } }
[[body]]
name = "lower"
fixed = true
shape = { half_space = { normal = [0.1, 1.0, 0.0], offset_m = 0.0895 } }
[[body]]
name = "right"
fixed = true
shape = { half_space = { normal = [-1.0, 0.0, 0.0], offset_m = -0.045 } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 3000.0
damping_n_s_per_m = 4.0
friction = 0.2
[measure]
duration_s = 0.25
"#;

/// An arm of three joints. Its tool slides down a slope onto a ball that lies between a floor and a wall.
const SLOPE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
MASSES
position_m = [-0.06, -0.03, 0.075]
velocity_m_per_s = [0.25, 0.2, -0.2]
hand.force_n = [0.9, 0.25, -1.2]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.06
position_m = [0.035, 0.01, 0.0149]
force_n = [0.0, 0.0, -0.6]
shape = { sphere = { radius_m = 0.015 } }
[[body]]
name = "slope"
fixed = true
shape = { half_space = { normal = [0.6, 0.0, 0.8], offset_m = 0.0 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[body]]
name = "wall"
fixed = true
shape = { half_space = { normal = [-1.0, 0.0, 0.0], offset_m = -0.06 } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 4.0
friction = 0.2
[measure]
duration_s = 0.25
"#;

fn parsed(source: &str, masses: &str, period: f64) -> WorldScene {
    let source = source.replace("MASSES", masses);
    let mut scene = WorldFile::parse("scene.toml", &source).unwrap().scene;
    scene.timing.period = period;
    scene
}

fn scenes(period: f64) -> [(&'static str, WorldScene); 2] {
    [
        ("five-bar", parsed(CHANNEL, &five_bar(), period)),
        ("arm", parsed(SLOPE, &arm(), period)),
    ]
}

/// A loop whose integration is as good as exact.
fn fine(loop_params: WorldLoop) -> WorldLoop {
    WorldLoop {
        sub_steps: SubSteps {
            least: 64,
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

/// Returns the scene with only the initial mass matrix as its model value.
fn model_the_start(scene: &WorldScene) -> WorldScene {
    let mut model = scene.clone();
    model.world.tools[0].mass_table = None;
    model
}

#[test]
fn a_known_linkage_is_rendered_through_its_table() {
    for period in [0.001, 0.004] {
        for (name, scene) in scenes(period) {
            let bench = WorldBench::new(&scene).unwrap();
            assert_eq!(bench.self_check().unwrap().chaotic_from, None);
            let places = bench.ideal().states.iter();
            let along = places.map(|state| state.devices[0].position[0]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            assert!(high - low > 0.08, "{name}: {low} to {high}");
            let all = known(&bench, &scene);
            let start = known(&bench, &model_the_start(&scene));
            let as_it_comes = |model: &WorldScene, factor: f64, method: &str| {
                let mut model = model.clone();
                model.render.device_mass[0] = model.render.device_mass[0].map(|mass| factor * mass);
                error(&bench.run(method, &model.renderer(method).unwrap()).unwrap())
            };
            let [comes, wrong, of_start, basic] = [
                as_it_comes(&scene, 1.0, "coupled"),
                as_it_comes(&scene, 1.5, "coupled"),
                as_it_comes(&model_the_start(&scene), 1.0, "coupled"),
                as_it_comes(&scene, 1.0, "basic"),
            ];
            println!(
                "{name}, {period} s: E known {all:.3} %, told the start only {start:.2} %; as it comes {comes:.3} %, told 1.5 times \
                 {wrong:.3} %, told the start only {of_start:.2} %, basic {basic:.0} %"
            );
            let most = if period == 0.001 { 0.15 } else { 1.0 };
            assert!(all < most && start > 10.0 * all, "{name}: {all} {start}");
            assert!(
                basic > 5.0 * comes && basic > 5.0 * wrong,
                "{name}: {comes} {wrong}"
            );
            if period == 0.001 {
                assert!(
                    of_start > 3.0 * comes && of_start > 3.0 * wrong,
                    "{name}: {of_start}"
                );
            }
        }
    }
}

#[test]
fn a_table_of_one_matrix_is_a_device_of_that_mass() {
    let table = "mass_table = { places_m = [[0.0], [0.0]], mass_kg = [[0.12, 0.09, 0.02]] }";
    let scene = parsed(CHANNEL, table, 0.002);
    let bench = WorldBench::new(&scene).unwrap();
    let run = |scene: &WorldScene| bench.run("coupled", &scene.renderer("coupled").unwrap());
    let [one, other] = [scene.clone(), model_the_start(&scene)].map(|scene| run(&scene).unwrap());
    let forces = |run: &WorldRun| -> Vec<f64> {
        run.commanded.iter().flat_map(|forces| forces[0]).collect()
    };
    let (one, other) = (forces(&one), forces(&other));
    let largest = other
        .iter()
        .fold(0.0_f64, |most, part| most.max(part.abs()));
    let apart = one
        .iter()
        .zip(&other)
        .map(|(one, other)| (one - other).abs());
    let apart = apart.fold(0.0, f64::max);
    println!("{apart:e} of {largest} N");
    assert!(largest > 1.0 && apart < 1e-6 * largest, "{apart:e}");
}

#[test]
fn ledger_of_linkage_closes() {
    let turning = "
inertia_kg_m2 = [2e-5, 3e-5, 4e-5]
angular_velocity_rad_per_s = [3.0, 1.0, -2.0]
hand.torque_n_m = [1e-3, 0.0, 2e-3]
";
    let turned = format!("{}{turning}", arm());
    let led = format!("{turned}gives_torque = false\n");
    let [five_bar, arm] = scenes(0.002);
    let six_axes = ("arm of six axes", parsed(SLOPE, &turned, 0.002));
    let stylus = ("arm with a stylus", parsed(SLOPE, &led, 0.002));
    for (name, scene) in [five_bar, arm, six_axes, stylus] {
        let bench = WorldBench::new(&scene).unwrap();
        let run = bench
            .run("coupled", &scene.renderer("coupled").unwrap())
            .unwrap();
        assert_eq!(run.refused, 0, "{name}");
        let entry = &run.ledger.devices[0];
        let work: f64 = run
            .ledger
            .contacts
            .iter()
            .map(|entry| entry.work_on_proxy)
            .sum();
        let leak = entry.held - work;
        let off = leak - (entry.offset - entry.velocity_offset + entry.unpaid);
        let at_port = entry.port_work + entry.carried - entry.held - entry.unforeseen;
        println!("{name}: leak {leak:e} J, off by {off:e} J and {at_port:e} J");
        assert!(work.abs() > 1e-3 && off.abs() < 1e-12 && at_port.abs() < 1e-12);
    }
}

#[test]
fn model_mass_factor_scales_only_model_mass() {
    let source = format!("{CHANNEL}\n[model]\ndevice_mass_factor = 1.5\n");
    let (model, scene) = (parsed(&source, &five_bar(), 0.001), &scenes(0.001)[0].1);
    for axis in 0..2 {
        let true_mass = scene.devices[0].mass[axis];
        assert_eq!(model.devices[0].mass[axis], true_mass);
        assert_eq!(model.render.device_mass[0][axis], 1.5 * true_mass);
    }
}

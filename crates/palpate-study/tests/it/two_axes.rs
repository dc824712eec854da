//! Devices that lack an axis, in contacts whose normals leave their plane.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::world::{WorldBench, WorldRun};
use palpate_testbed::world::LedPath;
use palpate_world::{CoupledParams, Prior, SubSteps, WorldLoop, WorldMethod, WorldRenderer};

/// A device in the plane x, y, pushed by a constant force: nothing about it is unknown but what its observer has to
/// find.
const DEVICE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
axes = ["x", "y"]
mass_kg = [0.12, 0.2]
"#;

/// A ball that lies lower than the tool on a table: the tool pushes it down as it pushes it on.
const BALL: &str = r#"
position_m = [-0.024, 0.002, 0.042]
hand.force_n = [1.2, 0.0, 0.0]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.08
position_m = [0.0, 0.0, 0.0198]
force_n = [0.0, 0.0, -0.8]
shape = { sphere = { radius_m = 0.02 } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["ball", "table"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 2.0
friction = 0.3
[[contact]]
between = ["tool", "ball"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
"#;

/// A groove across the plane: both of its walls lean, so each pushes the tool out of the plane.
const GROOVE: &str = r#"
position_m = [0.004, 0.03, 0.0]
hand.force_n = [0.2, -1.5, 0.0]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "left"
fixed = true
shape = { half_space = { normal = [0.6, 0.64, 0.48] } }
[[body]]
name = "right"
fixed = true
shape = { half_space = { normal = [-0.6, 0.48, 0.64] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
"#;

/// A capsule that lies lower than the tool on a fixed ridge and rolls away, with friction.
const CAPSULE: &str = r#"
position_m = [-0.02, 0.004, 0.022]
hand.force_n = [1.0, 0.1, 0.0]
tool = { sphere = { radius_m = 0.008 } }
[[body]]
name = "log"
mass_kg = 0.1
position_m = [0.0, 0.0, 0.0098]
orientation = [0.7071067811865476, 0.7071067811865476, 0.0, 0.0]
force_n = [0.0, 0.0, -0.98]
shape = { capsule = { radius_m = 0.01, length_m = 0.04 } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["log", "table"]
stiffness_n_per_m = 6000.0
damping_n_s_per_m = 4.0
friction = 0.4
[[contact]]
between = ["tool", "log"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
friction = 0.4
"#;

/// A slope that a heavy block lies on, and slides down along: friction pulls the tool out of its plane.
const SLIDING: &str = r#"
position_m = [-0.031, 0.0, 0.0]
hand.force_n = [1.0, 0.0, 0.0]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "block"
mass_kg = 0.4
position_m = [0.0, 0.0, 0.01]
velocity_m_per_s = [0.0, 0.0, -0.1]
shape = { box = { size_m = [0.04, 0.04, 0.08] } }
[[body]]
name = "wall"
fixed = true
shape = { half_space = { normal = [-1.0, 0.0, 0.0], offset_m = -0.02 } }
[[contact]]
between = ["tool", "block"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
friction = 0.4
[[contact]]
between = ["block", "wall"]
stiffness_n_per_m = 8000.0
damping_n_s_per_m = 4.0
"#;

/// A bumpy ball of triangles, beside which the tool is led by its hand's force.
const MESH: &str = r#"
position_m = [-0.06, 0.0, 0.02]
hand.force_n = [1.5, 0.3, 0.0]
tool = { sphere = { radius_m = 0.006 } }
[[body]]
name = "bumps"
fixed = true
shape = { mesh = { bumpy_sphere = { radius_m = 0.05, height_m = 0.001, waves = 6, cells = 20 } } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 3000.0
damping_n_s_per_m = 2.0
"#;

/// Each with the least E in percent of the old description, which tells a mass along z.
const SCENES: [(&str, &str, f64); 5] = [
    ("ball", BALL, 0.2),
    ("groove", GROOVE, 0.2),
    ("capsule", CAPSULE, 0.2),
    ("sliding", SLIDING, 0.1),
    ("mesh", MESH, 0.2),
];

/// The scene in a loop of this period `[s]`.
fn scene(of: &str, period: f64) -> WorldScene {
    let source = format!("{DEVICE}{of}[measure]\nduration_s = 0.248\n");
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

/// Coupled rendering that knows the devices and gives no offset back.
fn exact(scene: &WorldScene) -> CoupledParams {
    let inertia = scene.render.device_inertia.iter();
    let inertia = inertia.map(|inertia| inertia.unwrap_or([1.0; 3]));
    CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(scene.render.device_mass.clone())
            .with_device_inertia(inertia.collect())
            .with_prior(Prior::of_a_known_mass())
    }
}

fn run(bench: &WorldBench, scene: &WorldScene, method: impl Into<WorldMethod>) -> WorldRun {
    let renderer = WorldRenderer::new(&scene.world, fine(scene.loop_params()), method).unwrap();
    bench.run("coupled", &renderer).unwrap()
}

fn error(run: &WorldRun) -> f64 {
    run.evaluation.sum.unwrap().mean_force_error
}

/// Returns the equivalent scene without the missing axis: with a mass along z.
fn with_a_mass_along_z(scene: &WorldScene, mass: f64) -> WorldScene {
    let mut model = scene.clone();
    model.world.tools[0].axes = [true; 3];
    model.devices[0].mass[2] = mass;
    model.render.device_mass[0][2] = mass;
    model
}

#[test]
fn with_the_device_known_each_held_force_is_the_mean_of_the_ideal_one() {
    let scenes = SCENES.into_iter();
    for ((name, of, least), period) in scenes.flat_map(|it| [(it, 0.001), (it, 0.004)]) {
        let scene = scene(of, period);
        let bench = WorldBench::new(&scene).unwrap();
        assert_eq!(bench.self_check().unwrap().chaotic_from, None);
        let known = run(&bench, &scene, exact(&scene));
        let as_before = with_a_mass_along_z(&scene, 0.16);
        let before = run(&bench, &as_before, exact(&as_before));
        let [basic, coupled, model] = [
            ("basic", scene.clone()),
            ("coupled", scene.clone()),
            ("coupled", {
                let mut model = scene.clone();
                model.render.device_mass[0] = model.render.device_mass[0].map(|mass| 1.5 * mass);
                model
            }),
        ]
        .map(|(method, model)| {
            error(&bench.run(method, &model.renderer(method).unwrap()).unwrap())
        });
        let (known_error, before) = (error(&known), error(&before));
        println!(
            "{name}, {period} s: E known {known_error:.4} %, told a mass along z {before:.2} %; as it comes {coupled:.3} %, told 1.5 \
             times the masses {model:.3} %, basic {basic:.0} %"
        );
        assert!(known_error < 0.01, "{name}: {known_error}");
        assert!(
            before > least && before > 50.0 * known_error,
            "{name}: {before}"
        );
        assert!(
            coupled < 0.5 && model < 1.5 && basic > 10.0 * model,
            "{name}"
        );
        // No motor acts along z, and no force is evaluated there.
        assert!(known.commanded.iter().all(|forces| forces[0][2] == 0.0));
        let ideal = &bench.ideal().devices[0];
        assert!(ideal.impulses.iter().all(|impulse| impulse[2] == 0.0));
        assert!(known.evaluation.devices[0].axes[2].is_none());
        // The contact does push there.
        let states = &bench.ideal().states;
        let across = |force: &[f64; 3]| force[2].abs();
        let most = states.iter().map(|state| across(&state.devices[0].force));
        assert!(most.fold(0.0, f64::max) > 0.2, "{name}");
        let starts = &scene.devices[0].position;
        assert!(
            states
                .iter()
                .all(|state| state.devices[0].position[2] == starts[2])
        );
    }
}

/// A box that turns about all axes and moves along two falls on a slope that leans out of its plane.
#[test]
fn a_device_that_turns_may_lack_an_axis() {
    let source = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
axes = ["x", "z"]
mass_kg = 0.2
inertia_kg_m2 = [2e-5, 4e-5, 5e-5]
position_m = [0.0, 0.0, 0.03]
orientation = [0.9, 0.2, 0.1, 0.05]
hand.force_n = [0.2, 0.0, -1.0]
tool = { box = { size_m = [0.04, 0.03, 0.02] } }
[[body]]
name = "slope"
fixed = true
shape = { half_space = { normal = [0.1, 0.5, 0.86] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 4.0
friction = 0.3
[measure]
duration_s = 0.25
"#;
    let all = source.replace("axes = [\"x\", \"z\"]\n", "");
    let [known, with_all] = [source, &all].map(|source| {
        let scene = WorldFile::parse("scene.toml", source).unwrap().scene;
        let bench = WorldBench::new(&scene).unwrap();
        let basic = bench.run("basic", &scene.renderer("basic").unwrap());
        let basic = error(&basic.unwrap());
        let known = run(&bench, &scene, exact(&scene));
        println!("box: E {:.4} %, basic {basic:.0} %", error(&known));
        assert!(basic > 10.0, "{basic}");
        known
    });
    let (own, of_all) = (error(&known), error(&with_all));
    assert!(own < 0.1 && own < 2.0 * of_all, "{own} {of_all}");
    assert!(known.commanded.iter().all(|forces| forces[0][1] == 0.0));
    let torque = known
        .commanded_torques
        .iter()
        .map(|torques| torques[0][0].abs());
    assert!(torque.fold(0.0, f64::max) > 0.005);
}

/// A device that has all axes and can hardly be moved along z is one that lacks z, within what still moves it: 10 N on
/// 1e6 kg go 0.3 um in 0.25 s, which is 1 mN at 4 kN/m.
#[test]
fn a_huge_mass_along_the_third_axis_gives_the_same_forces_in_the_plane() {
    for (name, of, _) in SCENES {
        let scene = scene(of, 0.001);
        let heavy = with_a_mass_along_z(&scene, 1e6);
        let [own, huge] = [&scene, &heavy].map(|scene| {
            let bench = WorldBench::new(scene).unwrap();
            run(&bench, scene, exact(scene)).delivered
        });
        let forces = || own[0].iter().zip(&huge[0]);
        let most = forces().map(|(own, _)| own[0].hypot(own[1]));
        let most = most.fold(0.0, f64::max);
        let apart = forces().map(|(own, huge)| (own[0] - huge[0]).hypot(own[1] - huge[1]));
        let apart = apart.fold(0.0, f64::max);
        println!("{name}: {apart:e} of {most} N apart");
        assert!(most > 0.5 && apart < 2e-3 * most, "{name}: {apart} {most}");
    }
}

/// Replayed along a motion that also goes along z, as a passive slide there would: nothing is commanded along z, and
/// the tool is where the motion has it.
#[test]
fn a_recorded_motion_along_an_axis_without_a_motor_is_followed() {
    let scene = scene(BALL, 0.001).led();
    let times: Vec<f64> = (0..=300).map(|sample| f64::from(sample) * 0.001).collect();
    let place = |time: &f64| vec![[-0.024 + 0.03 * time, 0.002, 0.042 - 0.02 * time]];
    let path = LedPath::new(times.clone(), times.iter().map(place).collect()).unwrap();
    let bench = WorldBench::led(&scene, path).unwrap();
    let [coupled, basic] = ["coupled", "basic"]
        .map(|method| bench.run(method, &scene.renderer(method).unwrap()).unwrap());
    for run in [&coupled, &basic] {
        assert!(run.delivered[0].iter().all(|force| force[2] == 0.0));
        assert!(run.delivered[0].iter().any(|force| force[0] < -0.3));
    }
    println!(
        "led: E coupled {} %, basic {} %",
        error(&coupled),
        error(&basic)
    );
    assert!(error(&coupled) < 0.3 * error(&basic));
    let last = bench.ideal().states.last().unwrap();
    assert!((last.devices[0].position[2] - 0.036).abs() < 1e-9);
}

/// A scene with one axis is a device along a line.
#[test]
fn a_device_of_one_axis_is_rendered_too() {
    let source = format!("{DEVICE}{BALL}[measure]\nduration_s = 0.25\n")
        .replace(r#"["x", "y"]"#, r#"["x"]"#)
        .replace("[0.12, 0.2]", "0.12");
    let scene = WorldFile::parse("scene.toml", &source).unwrap().scene;
    let bench = WorldBench::new(&scene).unwrap();
    let known = run(&bench, &scene, exact(&scene));
    println!("one axis: E {} %", error(&known));
    assert!(error(&known) < 0.01);
    assert!(
        known.delivered[0]
            .iter()
            .all(|force| force[1] == 0.0 && force[2] == 0.0)
    );
}

/// The methods that are there for comparison push in the plane as the ideal does, more or less: their springs stand for
/// the same stiffness, whichever way the contact's normal points.
#[test]
fn every_method_pushes_in_the_plane_only() {
    let mut scene = scene(BALL, 0.001);
    crate::common::set_comparison(&mut scene);
    let bench = WorldBench::new(&scene).unwrap();
    let size = |force: &[f64; 3]| force[0].hypot(force[1]);
    let ideal = bench.ideal().devices[0].mean_forces(&bench.ideal().grid);
    let ideal = ideal.iter().map(size).fold(0.0, f64::max);
    for method in WorldScene::METHODS {
        let run = bench.run(method, &scene.renderer(method).unwrap());
        let run = run.unwrap();
        assert_eq!(run.refused, 0, "{method}");
        assert!(run.commanded.iter().all(|forces| forces[0][2] == 0.0));
        let most = run.delivered[0].iter().map(size).fold(0.0, f64::max);
        println!("{method}: {most} N at most, the ideal {ideal} N");
        assert!(
            (0.5..2.0).contains(&(most / ideal)),
            "{method}: {most} {ideal}"
        );
    }
}

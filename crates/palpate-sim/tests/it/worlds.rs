//! Worlds in closed loop, judged by their ideal.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::world::{WorldFile, WorldScene, usual_guard};
use palpate_sim::world::{WorldBench, WorldRun, as_judged};
use palpate_testbed::world::{LedPath, PlantParams};
use palpate_world::WorldGuard;

/// A tool that a constant force presses into a groove of two planes: nothing about the device is unknown but what
/// its observer has to find.
const GROOVE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = [0.1, 0.16, 0.25]
position_m = [0.004, 0.0, 0.03]
hand_force_n = [0.1, 0.2, -1.5]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "left"
fixed = true
shape = { half_space = { normal = [0.6, 0.0, 0.8] } }
[[body]]
name = "right"
fixed = true
shape = { half_space = { normal = [-0.6, 0.0, 0.8] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 1.0
[measure]
duration_s = 0.3
"#;

/// The runs of a scene by these methods, and its bench.
fn runs<const N: usize>(source: &str, methods: [&str; N]) -> ([WorldRun; N], WorldBench) {
    let scene = WorldFile::parse("scene.toml", source).unwrap().scene;
    let bench = WorldBench::new(&scene).unwrap();
    let run = |method| {
        let renderer = scene.renderer(method).unwrap();
        bench.run(method, &renderer).unwrap()
    };
    (methods.map(run), bench)
}

/// The loop of a scene without an actuator of its own.
fn plant(scene: &WorldScene) -> PlantParams {
    let actuator = scene.timing.actuator;
    assert_eq!((actuator.lag, actuator.gain), (0.0, 1.0));
    PlantParams {
        delay: actuator.delay,
        ..PlantParams::perfect(scene.timing.period)
    }
}

/// E with the masses known, at most, where friction on a light body holds and lets go by turns `[%]`: of nine starts some micrometres apart
/// the largest has 0.145 %.
const LOOSE: f64 = 0.3;

fn error(run: &WorldRun) -> f64 {
    run.judgement.sum.unwrap().mean_force_error
}

#[test]
fn with_the_masses_known_coupled_rendering_is_at_the_hold_floor_of_a_groove() {
    let ([coupled, basic], _) = runs(GROOVE, ["coupled", "basic"]);
    println!(
        "E: coupled {} %, basic {} %",
        error(&coupled),
        error(&basic)
    );
    assert!(error(&coupled) < 0.1, "{}", error(&coupled));
    assert!(error(&basic) > 20.0, "{}", error(&basic));
    assert_eq!((coupled.refused, coupled.limited), (0, 0));
}

/// The tool overlaps both planes at the start: the energy of that is nobody's doing.
#[test]
fn what_overlaps_at_the_start_is_not_created_by_a_held_force() {
    let source = GROOVE.replace("0.004, 0.0, 0.03", "0.0, 0.0, 0.0105");
    let ([coupled, basic], _) = runs(&source, ["coupled", "basic"]);
    let stored = 2.0 * 0.5 * 4000.0 * (0.01_f64 - 0.8 * 0.0105).powi(2);
    for run in [coupled, basic] {
        let found = run.found_at_start;
        println!(
            "{}: {found} J at the start, created {} J",
            run.method,
            run.created()
        );
        assert!((found / stored - 1.0).abs() < 1e-6, "{found} of {stored} J");
        if run.method == "coupled" {
            assert!(run.created().abs() < 0.02 * found, "{} J", run.created());
        }
    }
}

#[test]
fn a_wrong_mass_costs_little_and_a_known_delay_too() {
    let told = GROOVE.replace(
        "[measure]",
        "[render]\ndevice_mass_kg = [0.15, 0.24, 0.375]\n[measure]",
    );
    let ([wrong], _) = runs(&told, ["coupled"]);
    let late = GROOVE.replace("period_s = 0.001", "period_s = 0.001\ndelay_s = 0.001");
    let ([late], _) = runs(&late, ["coupled"]);
    let (wrong, late) = (error(&wrong), error(&late));
    println!("E: told 1.5 times the mass {wrong} %, a sample of delay {late} %");
    assert!(wrong < 3.0 && late < 3.0, "{wrong} {late}");
}

#[test]
fn the_judge_and_the_renderer_see_the_same_world() {
    // A tool that no force of a renderer can move (its mass is huge) falls at constant speed onto a plane: the force
    // at each sample is that of the ideal at that time, for every method.
    let source = GROOVE
        .replace("[0.1, 0.16, 0.25]", "1e9")
        .replace(
            "hand_force_n = [0.1, 0.2, -1.5]",
            "velocity_m_per_s = [0.0, 0.0, -0.1]",
        )
        .replace("[0.004, 0.0, 0.03]", "[0.0, 0.0, 0.0145]");
    let ([run], bench) = runs(&source, ["coupled"]);
    let ideal = bench.ideal();
    let mean = ideal.devices[0].mean_forces(&ideal.grid);
    assert_eq!(run.delivered[0].len(), 300);
    let largest = mean
        .iter()
        .flatten()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(largest > 50.0, "{largest}");
    for (held, mean) in run.delivered[0].iter().zip(&mean).skip(60) {
        for (held, mean) in held.iter().zip(mean) {
            assert!((held - mean).abs() < 1e-3 * largest, "{held} {mean}");
        }
    }
}

/// A tool that is led into a floor and along it, and out again, by a hand that no force moves.
#[test]
fn on_a_recorded_motion_the_ideal_is_that_of_the_motion_and_coupled_is_nearer_to_it_than_basic() {
    let source = GROOVE.replace("normal = [0.6, 0.0, 0.8]", "normal = [0.0, 0.0, 1.0]");
    let source = source.replace(
        "normal = [-0.6, 0.0, 0.8]",
        "normal = [0.0, 0.0, 1.0], offset_m = -1.0",
    );
    let scene = WorldFile::parse("scene.toml", &source).unwrap().scene.led();
    let times: Vec<f64> = (0..=400).map(|sample| f64::from(sample) * 0.0005).collect();
    let place = |time: &f64| {
        let turn = std::f64::consts::TAU * 5.0 * time;
        vec![[0.1 * time, 0.0, 0.012 - 0.006 * (1.0 - turn.cos()) / 2.0]]
    };
    let positions: Vec<_> = times.iter().map(place).collect();
    let path = LedPath::new(times.clone(), positions).unwrap();
    let bench = WorldBench::led(&scene, path).unwrap();
    let ideal = bench.ideal();
    // K p + B p' of straight lines, over each sample of two of them.
    let mean = ideal.devices[0].mean_forces(&ideal.grid);
    assert_eq!(mean.len(), 200);
    for (sample, force) in mean.iter().enumerate() {
        let mut expected = 0.0;
        for line in 0..2 {
            let [from, to] = [0, 1].map(|end| place(&times[2 * sample + line + end])[0][2]);
            let (depth, rate) = (0.01 - 0.5 * (from + to), (from - to) / 0.0005);
            // A line that crosses the surface is not looked at.
            if (from < 0.01) != (to < 0.01) {
                expected = f64::NAN;
            } else if depth > 0.0 {
                expected += 0.5 * (4000.0 * depth + rate);
            }
        }
        assert!(
            expected.is_nan() || (force[2] - expected).abs() < 1e-8,
            "{sample}: {} {expected}",
            force[2]
        );
        assert!(force[0].abs() < 1e-9 && force[1].abs() < 1e-9);
    }
    let run = |method| bench.run(method, &scene.renderer(method).unwrap()).unwrap();
    let [coupled, basic] = ["coupled", "basic"].map(run);
    let (coupled, basic) = (error(&coupled), error(&basic));
    println!("led: E basic {basic} %, coupled {coupled} %");
    assert!(coupled < 0.5 * basic && basic > 1.0, "{coupled} {basic}");
}

/// The committed worlds of three axes, each by its file's name; `six_axes.rs` has the others, and `hard_worlds.rs` the bowl.
fn committed() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/worlds");
    let mut worlds: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .collect();
    worlds.retain(|(name, source)| name != "bowl" && !source.contains("quantum_rad"));
    worlds.sort();
    assert_eq!(worlds.len(), 24);
    worlds
}

/// With the masses known, E below a tenth of a percent. A guard that is asked for as the program asks for one does not act
/// where devices are known well enough: every commanded force stays the same to the last bit.
#[test]
fn in_the_committed_worlds_coupled_is_near_the_floor_and_at_it_with_the_masses_known_and_no_guard_acts()
 {
    let bits = |run: &WorldRun| -> Vec<u64> {
        let all = run.commanded.iter().flatten().flatten();
        all.map(|force| force.to_bits()).collect()
    };
    for (name, source) in committed() {
        let ([told, basic], bench) = runs(&source, ["coupled", "basic"]);
        let mut guarded = WorldFile::parse(&name, &source).unwrap().scene;
        assert!(matches!(guarded.render.guard, WorldGuard::Off), "{name}");
        guarded.render.guard = WorldGuard::Limit(usual_guard());
        let guarded = guarded.renderer("coupled").unwrap();
        let guarded = bench.run("coupled", &guarded).unwrap();
        let unknown =
            |line: &&str| !line.starts_with("device_mass_kg") && !line.starts_with("quantum_m");
        let known: Vec<&str> = source.lines().filter(unknown).collect();
        assert!(known.len() < source.lines().count(), "{name}");
        let known = WorldFile::parse(&name, &known.join("\n")).unwrap().scene;
        let renderer = known.renderer("coupled").unwrap();
        // The ideal has no sensor, and nobody tells it a mass.
        let alone = WorldBench::of(as_judged(&known), plant(&known), bench.ideal().clone());
        let known = alone.run("coupled", &renderer).unwrap();
        println!(
            "{name}: E basic {:.1} %, coupled told 1.5 times the mass {:.3} %, told the mass {:.3} %",
            error(&basic),
            error(&told),
            error(&known)
        );
        let most = match &*name {
            "cans" => LOOSE,
            // Sub-steps go over the edges between small triangles without being refined there.
            "bumpy-13k" | "bumpy-99k" => 0.2,
            _ => 0.1,
        };
        assert!(error(&told) < 1.0 && error(&known) < most, "{name}");
        assert!(error(&basic) > 5.0, "{name}");
        assert_eq!(bench.self_check().unwrap().chaotic_from, None, "{name}");
        assert_eq!(guarded.guarded, 0, "{name}");
        assert_eq!(bits(&told), bits(&guarded), "{name}");
    }
}

/// A pop is a sample at which a tool that has overlapped the wall is not pushed back to its own side any more. The wall
/// of the pocket is thinner than the overlap.
#[test]
fn a_probe_in_a_pocket_does_not_pop_through_its_thin_wall() {
    let (_, source) = committed()
        .into_iter()
        .find(|(name, _)| name == "pocket")
        .unwrap();
    let ([coupled, basic], bench) = runs(&source, ["coupled", "basic"]);
    // Of the wall's inside and of the probe, and K.
    let (wall, radius, stiffness) = (0.004, 0.001, 1500.0);
    for run in [&coupled, &basic] {
        let (mut deepest, mut most, mut pops) = (0.0_f64, 0.0_f64, 0);
        for (position, force) in run.positions.iter().zip(&run.delivered[0]) {
            let [x, y, _] = position[0];
            let out = x.hypot(y);
            let overlap = out + radius - wall;
            let inwards = -(force[0] * x + force[1] * y) / out;
            deepest = deepest.max(overlap);
            most = most.max(inwards);
            pops += usize::from(overlap > 2e-4 && inwards <= 0.0);
        }
        println!(
            "{}: {:.2} mm deep, force over stiffness {:.2} mm, {pops} pops",
            run.method,
            1e3 * deepest,
            1e3 * most / stiffness
        );
        assert!(deepest > 0.0012);
        if run.method == "coupled" {
            assert_eq!(pops, 0);
            assert!((deepest - most / stiffness).abs() < 0.1 * deepest);
        }
    }
    assert!(bench.ideal().deepest() > 0.0012);
}

/// E of a scene of `experiments/worlds`, whose file tells half as much again as the mass: with the device and its hand known,
/// which is a constant force then, and a perfect sensor; and as its file has it.
fn known_and_told(name: &str) -> [f64; 2] {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/worlds/");
    let told = std::fs::read_to_string(format!("{path}{name}.toml")).unwrap();
    let known = known(&told);
    let each = [known, told].map(|source| {
        let ([run], bench) = runs(&source, ["coupled"]);
        assert_eq!(bench.self_check().unwrap().chaotic_from, None);
        error(&run)
    });
    println!(
        "{name}: E known {:.3} %, told 1.5 times the mass {:.3} %",
        each[0], each[1]
    );
    each
}

/// The scene without what the renderer does not know.
fn known(told: &str) -> String {
    let of_file = [
        "device_mass",
        "quantum",
        "hand_stiffness",
        "hand_damping",
        "hand_rest",
    ];
    let kept = |line: &&str| !of_file.iter().any(|key| line.starts_with(key));
    let known: Vec<&str> = told.lines().filter(kept).collect();
    assert_eq!(known.len() + of_file.len(), told.lines().count());
    known.join("\n")
}

#[test]
fn several_spheres_of_a_tool_touch_a_mesh_that_moves() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../experiments/worlds/knob.toml"
    );
    let source = known(&std::fs::read_to_string(path).unwrap()).replace(
        "{ sphere = { radius_m = 0.005 } }",
        "{ spheres = [{ centre_m = [0.0, 0.003, 0.0], radius_m = 0.005 }, { centre_m = [0.001, -0.003, 0.001], \
         radius_m = 0.004 }] }",
    );
    assert!(source.contains("spheres"));
    let ([run], bench) = runs(&source, ["coupled"]);
    println!("several spheres on the knob: E {} %", error(&run));
    assert!(error(&run) < 0.1, "{}", error(&run));
    let last = bench.ideal().states.last().unwrap();
    assert_eq!(last.contacts.len(), 2 * 4 + 24);
}

#[test]
fn a_mesh_that_moves_is_rendered_as_its_ideal_moves() {
    let [known, told] = known_and_told("knob");
    assert!(known < 0.1 && told < 1.0, "{known} {told}");
}

#[test]
fn a_hull_is_rendered_as_its_ideal_moves() {
    for name in ["gem", "cairn"] {
        let [known, told] = known_and_told(name);
        assert!(known < 0.1 && told < 1.0, "{known} {told}");
    }
}

#[test]
fn capsules_on_a_box_on_each_other_and_on_a_hull_are_rendered_as_their_ideal_moves() {
    let [known, told] = known_and_told("logs");
    assert!(known < 0.1 && told < 1.0, "{known} {told}");
}

#[test]
fn cylinders_on_a_box_and_on_each_other_are_rendered_as_their_ideal_moves() {
    let [known, told] = known_and_told("cans");
    assert!(known < LOOSE && told < 1.0, "{known} {told}");
}

#[test]
fn points_on_a_grid_of_distances_are_rendered_as_their_ideal_moves() {
    let [known, told] = known_and_told("angle");
    assert!(known < 0.1 && told < 1.0, "{known} {told}");
}

/// Of two meshes that both have a shell and a grid, the points of the smaller one touch, for renderer and judge alike.
#[test]
fn of_two_meshes_the_points_of_the_smaller_one_touch() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../experiments/worlds/angle.toml"
    );
    let one = known(&std::fs::read_to_string(path).unwrap())
        .replace("duration_s = 0.3", "duration_s = 0.1");
    let (shell, grid) = (
        "shell = { points = 40 }",
        "distance_grid = { spacing_m = 0.001 }",
    );
    let both = one
        .replace(grid, &format!("{grid}\nshell = {{ points = 20 }}"))
        .replace(
            shell,
            &format!("{shell}\ndistance_grid = {{ spacing_m = 0.00125 }}"),
        );
    let [alone, together] = [one, both].map(|source| {
        let ([run], bench) = runs(&source, ["coupled"]);
        let contacts = bench.ideal().states.last().unwrap().contacts.len();
        assert_eq!(
            contacts,
            4 + 40,
            "four of the tool, and the points of the angle"
        );
        error(&run)
    });
    assert!((alone - together).abs() < 1e-9, "{alone} {together}");
}

/// A point slides deep across an edge of a cube of triangles, where the force turns from the normal of one face to that of
/// another. Without finer sub-steps there, E is 4 %.
#[test]
fn a_point_that_slides_across_a_sharp_edge_is_rendered_as_its_ideal_moves() {
    let source = r#"
format = 2
[loop]
period_s = 0.004
[[device]]
name = "tool"
mass_kg = [0.1, 0.16, 0.25]
position_m = [-0.0029, -0.0103, 0.05]
velocity_m_per_s = [0.048, 0.076, -0.1]
hand_force_n = [-0.531, 0.09, -2.0]
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "cube"
fixed = true
orientation = [-0.457, -0.381, 0.426, 0.682]
shape = { mesh = { vertices_m = [
    [-0.02, -0.02, -0.02], [0.02, -0.02, -0.02], [-0.02, 0.02, -0.02], [0.02, 0.02, -0.02],
    [-0.02, -0.02, 0.02], [0.02, -0.02, 0.02], [-0.02, 0.02, 0.02], [0.02, 0.02, 0.02],
], faces = [
    [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
    [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
] } }
[[contact]]
between = "*"
stiffness_n_per_m = 1500.0
damping_n_s_per_m = 3.0
[measure]
duration_s = 0.3
"#;
    let ([run], bench) = runs(source, ["coupled"]);
    assert_eq!(bench.self_check().unwrap().chaotic_from, None);
    println!("across an edge: E {} %", error(&run));
    assert!(error(&run) < 0.5, "{}", error(&run));
}

/// A disc of 24 sides that lies on a table, onto whose rim a tool comes down: it tips and falls back.
#[test]
fn a_prism_in_place_of_a_cylinder_is_rendered_as_its_ideal_moves() {
    let source = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = [0.1, 0.16, 0.25]
position_m = [0.017, 0.004, 0.0165]
velocity_m_per_s = [0.0, 0.0, -0.1]
hand_force_n = [0.0, 0.0, -1.0]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "disc"
mass_kg = 0.1
position_m = [0.0, 0.0, 0.005]
force_n = [0.0, 0.0, -0.981]
shape = { hull = { prism = { sides = 24, radius_m = 0.02, length_m = 0.01 } } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = "*"
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 3.0
friction = 0.4
[measure]
duration_s = 0.3
"#;
    let ([run], bench) = runs(source, ["coupled"]);
    assert_eq!(bench.self_check().unwrap().chaotic_from, None);
    println!("a disc that is tipped: E {} %", error(&run));
    assert!(error(&run) < 0.1, "{}", error(&run));
}

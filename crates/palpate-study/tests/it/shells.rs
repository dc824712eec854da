//! Meshes in contact with hulls by a shell of points, evaluated against their ideal.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // what was measured

use palpate_scene::world::WorldFile;
use palpate_study::sim::world::WorldBench;

/// A sphere pushes an angle of 24 points over a fixed ridge and against a stone, which is a hull of its own.
const RIDGE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = [0.1, 0.16, 0.25]
position_m = [0.0015, 0.001, 0.0145]
hand.force_n = [-0.8, 0.05, -0.3]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "angle"
mass_kg = 0.06
position_m = [-0.009, 0.0, 0.0005]
force_n = [0.0, 0.0, -0.5886]
[body.shape.mesh]
vertices_m = [
    [0.0, -0.008, 0.0], [0.018, -0.008, 0.0], [0.018, -0.008, 0.005],
    [0.005, -0.008, 0.005], [0.005, -0.008, 0.02], [0.0, -0.008, 0.02],
    [0.0, 0.008, 0.0], [0.018, 0.008, 0.0], [0.018, 0.008, 0.005],
    [0.005, 0.008, 0.005], [0.005, 0.008, 0.02], [0.0, 0.008, 0.02],
]
faces = [
    [0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5],
    [6, 8, 7], [6, 9, 8], [6, 10, 9], [6, 11, 10],
    [0, 7, 1], [0, 6, 7], [1, 8, 2], [1, 7, 8], [2, 9, 3], [2, 8, 9],
    [3, 10, 4], [3, 9, 10], [4, 11, 5], [4, 10, 11], [5, 6, 0], [5, 11, 6],
]
shell = { points = 24 }
[[body]]
name = "ridge"
fixed = true
shape = { hull = { points_m = [
    [-0.03, -0.03, -0.01], [0.03, -0.03, -0.01], [0.03, 0.03, -0.01], [-0.03, 0.03, -0.01],
    [-0.02, -0.02, 0.0], [0.02, -0.02, 0.0], [0.02, 0.02, 0.0], [-0.02, 0.02, 0.0],
] } }
[[body]]
name = "stone"
mass_kg = 0.04
position_m = [-0.0185, 0.002, 0.012]
shape = { hull = { points_m = [
    [-0.006, -0.006, -0.008], [0.006, -0.008, -0.006], [0.005, 0.007, -0.007], [-0.006, 0.006, -0.008],
    [0.0, 0.0, 0.009], [0.007, 0.0, 0.004],
] } }
[[contact]]
between = ["angle", "*"]
stiffness_n_per_m = 4000.0
damping_n_s_per_m = 3.0
friction = 0.3
[measure]
duration_s = 0.12
"#;

#[test]
fn an_angle_on_hulls_is_rendered_as_its_ideal_moves() {
    let scene = WorldFile::parse("scene.toml", RIDGE).unwrap().scene;
    let bench = WorldBench::new(&scene).unwrap();
    assert_eq!(bench.self_check().unwrap().chaotic_from, None);
    let [coupled, basic] = ["coupled", "basic"].map(|method| {
        let run = bench.run(method, &scene.renderer(method).unwrap()).unwrap();
        run.evaluation.sum.unwrap().mean_force_error
    });
    // Whether the angle has touched both.
    let ideal = bench.ideal();
    let touched = |body: usize| {
        let with = |member| member == palpate_testbed::world::Member::Body(body);
        let each = ideal.encounters.iter();
        each.filter(|met| met.between.into_iter().any(with)).count()
    };
    let balance = ideal.states.iter().map(|state| state.ledger.balance());
    let (least, most) = balance.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), now| {
        (now.min(low), now.max(high))
    });
    println!(
        "an angle on hulls: E {coupled:.3} %, basic {basic:.0} %; {} touches of the ridge, {} of the stone; the ideal's energy is off by \
         {:e} J",
        touched(1),
        touched(2),
        most - least
    );
    assert!(touched(1) > 3 && touched(2) > 0);
    assert!(most - least < 1e-9, "{}", most - least);
    assert!(coupled < 0.2 && basic > 10.0 * coupled, "{coupled} {basic}");
}

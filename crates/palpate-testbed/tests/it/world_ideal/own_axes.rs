//! Devices whose axes are not those of the world: the same as devices of the world's axes in a world that is turned.

use palpate_testbed::grid::Grid;
use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world::{
    ContactLaw, Member, Pair, PlantParams, Shape, Tool, Vector, WorldEvaluation, WorldHand,
    WorldIdeal, WorldPlant, WorldScene,
};

use super::{body, device, half_space};

/// Unit vectors at right angles, along which nothing of the scene lies: 2/3, 2/3, 1/3 and so on.
const AXES: [Vector; 3] = [
    [2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0],
    [-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0],
    [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
];

/// Turns the world's axes into `AXES`.
fn turned(v: Vector) -> Vector {
    std::array::from_fn(|to| (0..3).map(|of| AXES[of][to] * v[of]).sum())
}

fn apart(a: Vector, b: Vector) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// A device that falls on a ball in a corner of two walls.
fn scene(masses: Vector) -> WorldScene {
    let sine = |amplitude, frequency_hz| Sinusoid {
        amplitude,
        frequency_hz,
        phase: 0.4,
    };
    let mut tool = device(0.1, [0.002, 0.001, 0.041]);
    tool.tool = Tool::sphere(0.01);
    tool.mass = masses;
    tool.quantum = [1e-6, 0.0, 1e-5];
    tool.velocity = [0.0, 0.0, -0.2];
    tool.hand = WorldHand {
        force: [0.3, 0.2, -1.5],
        stiffness: 60.0,
        damping: 1.5,
        rest: [0.001, 0.003, 0.03],
        tremor: [vec![sine(0.1, 9.0)], vec![], vec![sine(0.05, 11.0)]],
        ..WorldHand::default()
    };
    if masses[1].is_infinite() {
        tool.hand.tremor[1].clear();
    }
    let mut ball = body(Shape::Sphere { radius: 0.015 }, 0.05, [0.0, 0.0, 0.0151]);
    ball.name = "ball".into();
    let law = ContactLaw::spring(3000.0).damped(1.0).rough(0.4, 3000.0);
    let pairs = [
        [Member::Device(0), Member::Body(0)],
        [Member::Body(0), Member::Body(1)],
        [Member::Body(0), Member::Body(2)],
        [Member::Device(0), Member::Body(2)],
    ];
    WorldScene {
        devices: vec![tool],
        bodies: vec![
            ball,
            half_space([0.0, 0.0, 1.0], 0.0),
            half_space([1.0, 0.0, 0.0], -0.0149),
        ],
        pairs: pairs.map(|between| Pair { between, law }).to_vec(),
        ..WorldScene::default()
    }
}

/// The scene in a world that is turned, its device with it.
fn turned_scene(scene: &WorldScene) -> WorldScene {
    let mut turned_scene = scene.clone();
    for device in &mut turned_scene.devices {
        device.own_axes = Some(AXES);
        device.position = turned(device.position);
        device.velocity = turned(device.velocity);
        device.hand.force = turned(device.hand.force);
        device.hand.rest = turned(device.hand.rest);
    }
    for body in &mut turned_scene.bodies {
        body.position = turned(body.position);
        if let Shape::HalfSpace { normal, .. } = &mut body.shape {
            *normal = turned(*normal);
        }
    }
    turned_scene
}

#[test]
fn a_turned_world_moves_and_pushes_as_the_world_does() {
    for masses in [[0.1, 0.16, 0.25], [0.1, f64::INFINITY, 0.25]] {
        let scene = scene(masses);
        let grid = Grid::even(0.0, 0.004, 60);
        let straight = WorldIdeal::new(&scene, grid.clone()).unwrap();
        let other = WorldIdeal::new(&turned_scene(&scene), grid.clone()).unwrap();
        let pairs = straight.states.iter().zip(&other.states);
        let way = pairs
            .flat_map(|(one, two)| {
                let [one, two] = [one, two].map(|state| &state.devices[0]);
                [
                    apart(turned(one.position), two.position),
                    apart(turned(one.velocity), two.velocity),
                    apart(turned(one.hand_force), two.hand_force),
                ]
            })
            .fold(0.0, f64::max);
        let largest: f64 = straight.devices[0]
            .peaks
            .iter()
            .copied()
            .fold(0.0, f64::max);
        assert!(largest > 1.0 && way < 1e-6, "{largest} N, {way}");
        for interval in 0..60 {
            let [one, two] = [&straight, &other].map(|ideal| &ideal.devices[0]);
            // Along the device's own axes, not the world's.
            let impulses = apart(one.impulses[interval], two.impulses[interval]);
            let squares = apart(one.squares[interval], two.squares[interval]);
            assert!(impulses < 1e-8 && squares < 1e-6, "{impulses} {squares}");
        }
    }
}

#[test]
fn held_force_moves_plant_and_is_evaluated_along_own_axes() {
    for masses in [[0.1, 0.16, 0.25], [0.1, f64::INFINITY, 0.25]] {
        let scenes = [scene(masses), turned_scene(&scene(masses))];
        let ideals = scenes
            .each_ref()
            .map(|scene| WorldIdeal::new(scene, Grid::even(0.0, 0.004, 60)).unwrap());
        let params = PlantParams::perfect(0.004);
        let mut plants = scenes
            .each_ref()
            .map(|scene| WorldPlant::new(scene, params).unwrap());
        let held: Vec<Vector> = (0..60)
            .map(|sample| {
                let time = f64::from(sample) * 0.004;
                [(40.0 * time).sin(), 0.3, 2.0 * (25.0 * time).cos()]
            })
            .collect();
        for &force in &held {
            let [straight, other] = &mut plants;
            assert!(apart(turned(straight.measure()[0]), other.measure()[0]) < 1e-12);
            assert!(apart(turned(straight.velocities()[0]), other.velocities()[0]) < 1e-12);
            straight.hold(&[force]);
            other.hold(&[turned(force)]);
        }
        let [straight, other] = plants.each_ref().map(|plant| plant.delivered(0));
        for (one, two) in straight.iter().zip(&other) {
            assert!(apart(turned(*one), *two) < 1e-12);
        }
        let turned_held: Vec<Vector> = held.iter().map(|force| turned(*force)).collect();
        let of = |number: usize, held: Vec<Vector>| {
            WorldEvaluation::new(&scenes[number], &ideals[number], &[held]).unwrap()
        };
        let [one, two] = [of(0, held.clone()), of(1, turned_held)];
        let error = |evaluated: &WorldEvaluation| evaluated.sum.unwrap().mean_force_error;
        assert!(error(&one) > 10.0);
        assert!((error(&one) - error(&two)).abs() < 1e-4 * error(&one));
        for axis in 0..3 {
            let [one, two] = [&one, &two].map(|evaluated| evaluated.devices[0].axes[axis]);
            assert_eq!(one.is_some(), two.is_some());
            let Some((one, two)) = one.zip(two) else {
                continue;
            };
            assert!((one.mean_force_error / two.mean_force_error - 1.0).abs() < 1e-4);
        }
        let [one, two] = [one, two].map(|evaluated| evaluated.devices[0].touches[0].ideal_impulse);
        assert!(apart(turned(one), two) < 1e-8);
    }
}

#[test]
fn axes_that_are_not_at_right_angles_are_refused() {
    let mut scene = scene([0.1; 3]);
    let mut oblique = AXES;
    oblique[2] = oblique[1];
    scene.devices[0].own_axes = Some(oblique);
    let message = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 1)).unwrap_err();
    let message = message.to_string();
    assert!(
        message.contains("devices[0].own_axes") && message.contains("right angles"),
        "{message}"
    );
    // Along an axis that is not there nothing moves.
    let mut moved = turned_scene(&scene_in_a_plane());
    moved.devices[0].velocity = AXES[1];
    let message = WorldIdeal::new(&moved, Grid::even(0.0, 0.01, 1)).unwrap_err();
    assert!(
        message.to_string().contains("devices[0].velocity"),
        "{message}"
    );
}

fn scene_in_a_plane() -> WorldScene {
    scene([0.1, f64::INFINITY, 0.25])
}

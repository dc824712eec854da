//! Moving meshes and hulls: comparison with the equivalent box, and mass properties.
#![allow(clippy::print_stdout)] // prints the measured values

use std::sync::Arc;

use palpate_world::{
    Body, ContactLaw, CoupledParams, Free, Hull, IDENTITY, MassProperties, Mesh, Motion, Sample,
    Shape, Vector, WorldLoop, WorldRenderer,
};

use super::common::{block, plane, world};
use crate::balance::{Balance, of_bodies};

const HALF: Vector = [0.03, 0.02, 0.015];
/// Pose of the block in its file: no file axis is principal, and its centre is not at the origin.
const TURN: [f64; 4] = [0.5, 0.1, -0.7, 0.5];
const OFF: Vector = [0.04, -0.02, 0.07];

fn turned([w, x, y, z]: [f64; 4], [a, b, c]: Vector) -> Vector {
    let cross = [y * c - z * b, z * a - x * c, x * b - y * a];
    let twice = [
        y * cross[2] - z * cross[1],
        z * cross[0] - x * cross[2],
        x * cross[1] - y * cross[0],
    ];
    let v = [a, b, c];
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * cross[i] + twice[i]))
}

/// Returns the block as drawn in a file.
fn drawn() -> Mesh {
    let block = block(HALF, 3);
    let vertices: Vec<Vector> = block
        .vertices()
        .into_iter()
        .map(|vertex| {
            let at = turned(TURN, vertex);
            [0, 1, 2].map(|axis| at[axis] + OFF[axis])
        })
        .collect();
    Mesh::new(&vertices, block.faces()).unwrap()
}

fn inverse([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

fn free() -> Free {
    Free {
        angular_velocity: [3.0, -2.0, 4.0],
        velocity: [0.1, 0.05, -0.2],
        ..Free::of_mass(0.1).pulled_by([0.0, 0.0, -0.981])
    }
}

/// Returns the tool forces, the block positions and the final balance.
fn run(falls: Body, friction: f64) -> (Vec<Vector>, Vec<Vector>, Balance) {
    let law = ContactLaw::spring(5000.0)
        .with_damping(4.0)
        .with_friction(friction);
    let ball = Motion::Free(Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.4905]));
    let ball = Body::new("ball", Shape::Sphere { radius: 0.01 }, ball);
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0], 0.0),
        ball.at([0.012, 0.004, 0.065]),
        falls,
    ];
    let method = CoupledParams::new(vec![[0.1; 3]]);
    let world = world(0.006, bodies, law);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
    let mut state = renderer.start();
    let start = of_bodies(&state);
    let (mut forces, mut places) = (Vec::new(), Vec::new());
    for sample in 0..300 {
        let x = -0.06 + 0.3 * 0.001 * f64::from(sample);
        let output = renderer.step(&mut state, &Sample::at(&[[x, 0.003, 0.02]]));
        assert_eq!((output.fault, output.effort.left_out), (None, 0));
        forces.push(output.forces[0]);
        places.push(state.bodies()[2].position);
    }
    (forces, places, Balance::since(start, &state))
}

fn apart(a: &[Vector], b: &[Vector]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn a_block_of_triangles_that_moves_and_its_hull_are_a_box() {
    let at = [0.002, 0.001, 0.035];
    let half_extents = HALF;
    let of_box = Body::new("falls", Shape::Box { half_extents }, Motion::Free(free())).at(at);
    // File axes, rotated so that the block has the orientation of the box.
    let back = inverse(TURN);
    let to = turned(back, OFF);
    let drawn = drawn();
    let hull = Hull::around(&drawn.vertices()).unwrap();
    assert_eq!((hull.corners().len(), hull.faces().len()), (8, 6));
    let shapes = [Shape::Mesh(Arc::new(drawn)), Shape::Hull(Arc::new(hull))];
    let [of_mesh, of_hull] = shapes.map(|shape| {
        Body::new("falls", shape, Motion::Free(free()))
            .at([0, 1, 2].map(|axis| at[axis] - to[axis]))
            .turned(back)
            .balanced()
    });
    assert!(apart(&[of_mesh.position], &[at]) < 1e-14);
    for (friction, allowed) in [(0.0, 1e-9), (0.3, 1e-5)] {
        let one = run(of_box.clone(), friction);
        for (word, body) in [("mesh", &of_mesh), ("hull", &of_hull)] {
            let other = run(body.clone(), friction);
            let (force, place) = (apart(&one.0, &other.0), apart(&one.1, &other.1));
            let most = apart(&one.0, &[[0.0; 3]; 300]);
            println!(
                "a falling box and its {word}, friction {friction}: {force:.1e} of {most:.1} N and {place:.1e} m apart"
            );
            assert!(most > 1.0 && force < allowed * most, "{force} {most}");
            // With friction, rounding decides in which sub-step sticking becomes sliding.
            assert!(place < 1e-3 * allowed, "{place}");
        }
    }
}

#[test]
fn ledger_of_falling_mesh_closes() {
    let falls = Body::new(
        "falls",
        Shape::Mesh(Arc::new(drawn())),
        Motion::Free(free()),
    );
    let (_, _, balance) = run(
        falls
            .turned(inverse(TURN))
            .balanced()
            .at([0.002, 0.001, 0.035]),
        0.3,
    );
    println!("a block that falls: {balance}");
    assert!(balance.turned_over > 0.005, "{}", balance.turned_over);
    balance.holds_to(1e-14, 2e-3);
}

#[test]
fn a_closed_mesh_has_the_centre_and_the_moments_of_its_solid() {
    let MassProperties {
        centre,
        orientation,
        moments,
    } = drawn().mass_properties(0.3).unwrap();
    let half_extents = HALF;
    let expected = Shape::Box { half_extents }.moments(0.3).unwrap();
    for axis in 0..3 {
        assert!((centre[axis] - OFF[axis]).abs() < 1e-14, "{centre:?}");
        // Each principal axis is parallel to one of the block's, with the same moment.
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        let own = turned(inverse(TURN), turned(orientation, unit));
        let along = (0..3).max_by(|&a, &b| own[a].abs().total_cmp(&own[b].abs()));
        let along = along.unwrap();
        assert!((own[along].abs() - 1.0).abs() < 1e-12, "{own:?}");
        assert!((moments[axis] / expected[along] - 1.0).abs() < 1e-12);
    }
    // Axes that are already principal are kept.
    let plain = block(HALF, 2).mass_properties(0.3).unwrap();
    assert_eq!((plain.centre, plain.orientation), ([0.0; 3], IDENTITY));
    for (one, other) in plain.moments.into_iter().zip(expected) {
        assert!((one / other - 1.0).abs() < 1e-12);
    }
}

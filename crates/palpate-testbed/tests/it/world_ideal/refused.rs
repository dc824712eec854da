//! Scenes without an ideal, and their error messages.

use std::sync::Arc;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::mesh::TriangleMesh;
use palpate_testbed::world::{ContactLaw, Member, Shape, Tool, WorldIdeal, WorldScene};

use super::{body, device, half_space, pair};

const BOX: Shape = Shape::Box {
    half_extents: [0.01; 3],
};
const CYLINDER: Shape = Shape::Cylinder {
    radius: 0.01,
    half_length: 0.02,
};

fn refused(scene: &WorldScene) -> String {
    let error = WorldIdeal::new(scene, Grid::even(0.0, 0.001, 2)).unwrap_err();
    error.to_string()
}

/// A mesh without points.
fn tetrahedron() -> Shape {
    let corners = [
        [0.0, 0.0, 0.0],
        [0.01, 0.0, 0.0],
        [0.0, 0.01, 0.0],
        [0.0, 0.0, 0.01],
    ];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    Shape::Mesh(Arc::new(TriangleMesh::new(&corners, &triangles).unwrap()))
}

fn scene() -> WorldScene {
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device(0.1, [0.0; 3]), device(0.1, [0.1, 0.0, 0.0])],
        bodies: vec![
            body(BOX, 0.1, [0.0, 0.1, 0.0]),
            body(BOX, 0.1, [0.0, 0.2, 0.0]),
            body(CYLINDER, 0.1, [0.0, 0.3, 0.0]),
            half_space([0.0, 0.0, 1.0], -1.0),
            half_space([0.0, 1.0, 0.0], -1.0),
            body(CYLINDER, 0.1, [0.0, 0.4, 0.0]),
            body(tetrahedron(), 0.1, [0.0, 0.5, 0.0]),
        ],
        pairs: vec![],
    }
}

#[test]
fn pairs_without_a_contact_are_named() {
    use Member::{Body, Device};
    let law = ContactLaw::spring(1000.0);
    for (one, other, reason) in [
        (Body(6), Body(2), "the cylinder \"body\""),
        (Body(2), Body(6), "the mesh \"body\""),
        (Device(0), Device(1), "both tools"),
        (Device(0), Device(0), "cannot touch itself"),
    ] {
        let mut scene = scene();
        scene.pairs = vec![pair(Device(0), Body(0), law), pair(one, other, law)];
        let message = refused(&scene);
        assert!(message.starts_with("pairs[1]: "), "{message}");
        assert!(message.contains(reason), "{message}");
        assert!(message.contains("a sphere with a sphere"), "{message}");
    }
    for (one, other) in [(Body(2), Body(0)), (Body(3), Body(2)), (Body(2), Body(5))] {
        let mut scene = scene();
        scene.pairs = vec![pair(one, other, law)];
        assert!(WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 2)).is_ok());
    }
    // Two that do not move have nothing to do with each other.
    let mut scene = scene();
    scene.pairs = vec![pair(Body(3), Body(4), law)];
    assert!(WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 2)).is_ok());
}

#[test]
fn parameters_outside_their_range_are_named() {
    type Change = fn(&mut WorldScene);
    let changes: [(Change, &str); 9] = [
        (|s| s.devices[1].mass[2] = 0.0, "devices[1].mass = 0"),
        (
            |s| s.devices[0].tool = Tool::sphere(-1.0),
            "devices[0].tool = -1",
        ),
        (
            |s| s.devices[0].hand.damping = f64::NAN,
            "devices[0].hand.damping = NaN",
        ),
        (
            |s| s.bodies[0].orientation = [2.0, 0.0, 0.0, 0.0],
            "bodies[0].orientation = 2",
        ),
        (
            |s| s.bodies[3].motion = s.bodies[0].motion,
            "bodies[3].motion = 0.1",
        ),
        (
            |s| s.bodies[2].motion.as_mut().unwrap().inertia[1] = -1.0,
            "bodies[2].motion.inertia = -1",
        ),
        (
            |s| s.bodies[2].position[0] = f64::INFINITY,
            "bodies[2].position = inf",
        ),
        (
            |s| s.pairs[0].law.stiffness = 0.0,
            "pairs[0].law.stiffness = 0 is not allowed; allowed: finite and above 0",
        ),
        (
            |s| s.pairs[0].between[1] = Member::Body(7),
            "pairs[0].between = 7",
        ),
    ];
    for (change, expected) in changes {
        let mut scene = scene();
        let law = ContactLaw::spring(1000.0);
        scene.pairs = vec![pair(Member::Device(0), Member::Body(0), law)];
        change(&mut scene);
        let message = refused(&scene);
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn a_window_begins_where_its_scene_does() {
    let late = WorldIdeal::new(&scene(), Grid::even(0.5, 0.001, 2)).unwrap_err();
    assert_eq!(
        late.to_string(),
        "grid.start = 0.5 is not allowed; allowed: 0 s, the start of the scene"
    );
    let grid = Grid::even(0.0, 0.001, 2);
    assert!(WorldIdeal::with_tolerance(&scene(), grid, 0.0).is_err());
}

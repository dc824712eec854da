//! Rejected meshes and their messages.

use std::sync::Arc;

use palpate_world::{
    BasicParams, Body, ContactLaw, Free, Hull, Mesh, MeshError, Motion, Shape, Vector, WorldLoop,
    WorldRenderer,
};

use super::common::{block, fixed, patch, plane, world};

const SQUARE: [Vector; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
];

#[test]
fn what_is_wrong_with_a_mesh_is_named() {
    let refused = |vertices: &[Vector], faces: &[[u32; 3]]| {
        Mesh::new(vertices, faces).unwrap_err().to_string()
    };
    let message = refused(&SQUARE, &[[0, 1, 2], [0, 2, 4]]);
    assert_eq!(
        message,
        "triangle 1 has corner 4, and there are 4 vertices, counted from 0"
    );
    let mut bad = SQUARE;
    bad[2][1] = f64::NAN;
    assert_eq!(
        refused(&bad, &[[0, 1, 2]]),
        "vertex 2 of the mesh is not three finite numbers within 1e100 m of 0"
    );
    assert_eq!(
        refused(&SQUARE, &[[0, 1, 1], [0, 0, 0]]),
        "the mesh has no triangle with an area; it needs at least one"
    );
    assert!(refused(&SQUARE, &[]).contains("no triangle"));
    assert!(
        refused(&SQUARE, &[[0, 1, 2], [0, 3, 2]]).starts_with("triangles 0 and 1 share an edge")
    );
    let mut vertices = SQUARE.to_vec();
    vertices.push([0.5, 0.5, 1.0]);
    let message = refused(&vertices, &[[0, 1, 2], [0, 2, 3], [0, 2, 4]]);
    assert!(
        message.contains("triangles 0, 1 and 2 share an edge"),
        "{message}"
    );
    let many = vec![[0, 1, 2]; Mesh::MAX_TRIANGLES + 1];
    assert_eq!(
        Mesh::new(&SQUARE, &many),
        Err(MeshError::TooMany(1_000_001))
    );
}

#[test]
fn triangles_without_an_area_and_doubles_are_dropped_and_counted() {
    let mesh = Mesh::new(
        &[SQUARE.as_slice(), &[[0.5, 0.5, 0.0]]].concat(),
        &[[0, 1, 2], [1, 2, 0], [0, 4, 2], [0, 2, 3], [3, 3, 1]],
    );
    let mesh = mesh.unwrap();
    assert_eq!((mesh.faces().len(), mesh.dropped()), (2, 3));
    assert!(!mesh.is_closed());
}

#[test]
fn a_closed_mesh_that_is_inside_out_is_turned() {
    let block = block([0.1, 0.2, 0.3], 2);
    let turned: Vec<_> = block.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    let mesh = Mesh::new(&block.vertices(), &turned).unwrap();
    assert!(mesh.is_closed());
    assert!((mesh.volume() - 0.048).abs() < 1e-12, "{}", mesh.volume());
}

#[test]
fn a_mesh_that_moves_has_to_have_an_inertia_and_to_meet_what_it_can() {
    let law = ContactLaw::spring(1000.0);
    let made = |world| WorldRenderer::new(&world, WorldLoop::new(0.001), BasicParams::default());
    let faults = |world| made(world).map(|_| ()).unwrap_err();
    let free = |mesh: Mesh, inertia: Option<Vector>| {
        let free = Free {
            inertia,
            ..Free::of_mass(0.1)
        };
        Body::new("part", Shape::Mesh(Arc::new(mesh)), Motion::Free(free))
    };
    let open = || Mesh::new(&SQUARE, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let said = faults(world(0.01, vec![free(open(), None)], law))
        .first()
        .to_string();
    assert!(
        said.starts_with("body \"part\": the mesh has open edges"),
        "{said}"
    );
    assert!(said.contains("give three moments of inertia"), "{said}");
    assert!(made(world(0.01, vec![free(open(), Some([1e-5; 3]))], law)).is_ok());
    // Displaced from its centre of mass.
    let beside = block([0.01; 3], 2).vertices().into_iter();
    let beside: Vec<Vector> = beside.map(|[x, y, z]| [x + 0.002, y, z]).collect();
    let beside = || Mesh::new(&beside, block([0.01; 3], 2).faces()).unwrap();
    let said = faults(world(0.01, vec![free(beside(), None)], law))
        .first()
        .to_string();
    assert!(said.contains("centre of mass at [0.002"), "{said}");
    assert!(made(world(0.01, vec![free(beside(), None).balanced()], law)).is_ok());
    // A cavity that extends outside the part: a hollow without material.
    let (part, hollow) = (block([0.01; 3], 1), block([0.008; 3], 1));
    let mut vertices = part.vertices();
    let first = u32::try_from(vertices.len()).unwrap();
    let mut faces = part.faces().to_vec();
    vertices.extend(
        hollow
            .vertices()
            .iter()
            .map(|[x, y, z]| [x + 0.015, *y, *z]),
    );
    faces.extend(hollow.faces().iter().map(|face| {
        let [a, b, c] = face.map(|corner| first + corner);
        [a, c, b]
    }));
    let odd = || Mesh::new(&vertices, &faces).unwrap();
    for part in [free(odd(), None), free(odd(), None).balanced()] {
        let said = faults(world(0.01, vec![part], law)).first().to_string();
        assert!(said.contains("the mesh intersects itself"), "{said}");
    }
    assert!(made(world(0.01, vec![free(odd(), Some([1e-5; 3]))], law)).is_ok());
    // Round parts have a hull with many corners, and flat parts have none.
    let floor = || plane("floor", [0.0, 0.0, 1.0], 0.0);
    let ball = patch(1.0, 12, |u, v| {
        let (u, v) = (3.0 * u, 1.5 * v);
        [
            0.01 * u.cos() * v.cos(),
            0.01 * u.sin() * v.cos(),
            0.01 * v.sin(),
        ]
    });
    let said = faults(world(0.01, vec![floor(), free(ball, Some([1e-5; 3]))], law));
    assert!(
        said.first().to_string().contains("more than 64 corners"),
        "{said:?}"
    );
    let said = faults(world(
        0.01,
        vec![floor(), free(open(), Some([1e-5; 3]))],
        law,
    ));
    assert!(
        said.first()
            .to_string()
            .contains("it is flat or nearly flat"),
        "{said:?}"
    );
    let ball = Free::of_mass(0.1);
    let cube = Body::new(
        "cube",
        Shape::Box {
            half_extents: [0.01; 3],
        },
        Motion::Free(ball),
    );
    let both = world(0.01, vec![fixed("part", block([0.01; 3], 2)), cube], law);
    let said = faults(both).first().to_string();
    assert!(
        said.contains("there is no contact of a mesh with a box yet"),
        "{said}"
    );
}

#[test]
fn what_is_wrong_with_the_points_of_a_hull_is_named() {
    let refused = |points: &[Vector], tolerance: f64| {
        Hull::within(points, tolerance).unwrap_err().to_string()
    };
    assert!(refused(&SQUARE, 0.0).contains("lie in a plane"));
    assert!(refused(&[], 0.0).contains("lie in a plane"));
    let mut points = SQUARE.to_vec();
    points.push([0.0, 0.0, f64::INFINITY]);
    assert!(refused(&points, 0.0).starts_with("point 4 of the hull is not"));
    points[4][2] = 1.0;
    assert!(refused(&points, -1.0).contains("is -1 m"));
    assert_eq!(Hull::around(&points).unwrap().faces().len(), 5);
    let round: Vec<Vector> = (0..200)
        .map(|k| {
            let (u, z) = (2.4 * f64::from(k), f64::from(k) / 100.0 - 0.995);
            let r = (1.0 - z * z).sqrt();
            [r * u.cos(), r * u.sin(), z]
        })
        .collect();
    assert!(refused(&round, 0.0).contains("more than 64 corners, and at most 64 are allowed"));
    let simplified = Hull::simplified(&round).unwrap();
    assert!(simplified.corners().len() <= Hull::SIMPLIFIED_CORNERS);
    assert!(
        simplified.left_out() > 0.01 && simplified.left_out() < 0.1,
        "{simplified:?}"
    );
    // Its corners are kept exactly, and the reported distance of an outside point is correct.
    let again = Hull::around(&simplified.corners()).unwrap();
    assert_eq!(again.corners().len(), simplified.corners().len());
    assert!(again.left_out() < 1e-5);
    let coarse = Hull::within(&round, 0.1).unwrap();
    assert!(coarse.corners().len() < 60, "{coarse:?}");
}

/// Plates, discs and chamfered boxes in any orientation have corners that are coplanar up to rounding.
#[test]
fn plates_discs_and_chamfered_boxes_have_hulls_however_they_are_turned() {
    let turned = |points: &[Vector], turn: f64, rounding: f64| -> Vec<Vector> {
        let ((s, c), (t, d)) = (turn.sin_cos(), (1.7 * turn).sin_cos());
        let round = |x: f64| (x / rounding).round() * rounding;
        let turn = |[x, y, z]: Vector| {
            let (x, y) = (c * x - s * y, s * x + c * y);
            [x, d * y - t * z, t * y + d * z]
        };
        points.iter().map(|&point| turn(point).map(round)).collect()
    };
    let disc = |sides: u32, radius: f64, height: f64| {
        (0..sides).flat_map(move |k| {
            let (y, x) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
            [-height, height].map(|z| [radius * x, radius * y, z])
        })
    };
    let grid = (0..21 * 21).map(|k| [k % 21, k / 21].map(|x| 0.005 * f64::from(x)));
    let plate: Vec<Vector> = grid
        .flat_map(|[x, y]| [[x, y, 0.0], [x, y, 0.002]])
        .collect();
    let chamfered = |k: u32| {
        let at = |axis: u32| if k >> axis & 1 == 1 { 0.02 } else { -0.02 };
        [
            [0.018, 0.02, 0.02],
            [0.02, 0.018, 0.02],
            [0.02, 0.02, 0.018],
        ]
        .map(|by| {
            let axis = [0, 1, 2];
            axis.map(|n| at(n) * by[n as usize] / 0.02)
        })
    };
    let solids: [(Vec<Vector>, usize, usize); 4] = [
        (plate, 8, 6),
        (disc(32, 0.03, 0.005).collect(), 64, 34),
        (disc(20, 0.03, 0.0005).collect(), 40, 22),
        ((0..8).flat_map(chamfered).collect(), 24, 14),
    ];
    for (points, corners, faces) in &solids {
        for turn in 0..20_u32 {
            for rounding in [1e-30, 1e-9, 1e-8] {
                let hull = Hull::around(&turned(points, 0.3 * f64::from(turn), rounding)).unwrap();
                assert_eq!(hull.corners().len(), *corners, "{turn} {rounding}");
                assert_eq!(hull.faces().len(), *faces, "{turn} {rounding}");
            }
        }
    }
}

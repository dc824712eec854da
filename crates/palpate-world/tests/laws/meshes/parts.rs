//! Meshes of several parts: inverted parts, and touching parts.

use palpate_world::{Mesh, MeshError, Vector};

type Triangles = (Vec<Vector>, Vec<[u32; 3]>);

/// Returns a cube of this side with its lowest corner at `place`, with the same diagonals on opposite sides.
fn cube(place: Vector, side: f64) -> Triangles {
    let corners =
        (0..8_u32).map(|k| [0, 1, 2].map(|axis| place[axis] + side * f64::from(k >> axis & 1)));
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 7, 6],
        [4, 5, 7],
        [0, 1, 5],
        [0, 5, 4],
        [2, 7, 3],
        [2, 6, 7],
        [0, 4, 6],
        [0, 6, 2],
        [1, 7, 5],
        [1, 3, 7],
    ];
    (corners.collect(), faces.into())
}

fn inside_out((vertices, faces): Triangles) -> Triangles {
    (vertices, faces.iter().map(|&[a, b, c]| [a, c, b]).collect())
}

fn together(all: &[Triangles]) -> Result<Mesh, MeshError> {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (more, triangles) in all {
        let first = u32::try_from(vertices.len()).unwrap();
        vertices.extend(more);
        faces.extend(
            triangles
                .iter()
                .map(|face| face.map(|corner| corner + first)),
        );
    }
    Mesh::new(&vertices, &faces)
}

#[track_caller]
fn assert_is_solid(mesh: &Mesh, volume: f64, triangles: usize) {
    assert!(mesh.is_closed());
    assert!(
        (mesh.volume() - volume).abs() < 1e-9 * volume,
        "{}",
        mesh.volume()
    );
    assert_eq!(mesh.faces().len(), triangles);
}

#[test]
fn solids_that_touch_along_a_face_an_edge_or_a_corner_are_one_mesh() {
    let first = cube([0.0; 3], 1.0);
    for (place, triangles) in [
        // The two triangles of the face between them are not needed.
        ([1.0, 0.0, 0.0], 20),
        ([0.0, 0.0, -1.0], 20),
        ([1.0, 1.0, 0.0], 24),
        ([-1.0, 0.0, 1.0], 24),
        ([1.0, 1.0, 1.0], 24),
    ] {
        let mesh = together(&[first.clone(), cube(place, 1.0)]).unwrap();
        assert_is_solid(&mesh, 2.0, triangles);
        assert_eq!(mesh.turned(), 0);
    }
    // Four cubes around an edge; two opposite ones may be missing.
    let about = [
        [0.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [-1.0, -1.0, 0.0],
        [0.0, -1.0, 0.0],
    ];
    let all = about.map(|place| cube(place, 1.0));
    assert_is_solid(&together(&all).unwrap(), 4.0, 32);
    // A small cube on the centre of a face of a large one.
    let mesh = together(&[cube([0.0; 3], 3.0), cube([1.0, 1.0, 3.0], 1.0)]).unwrap();
    assert_is_solid(&mesh, 28.0, 24);
}

#[test]
fn parts_that_are_inside_out_are_turned_and_cavities_are_not() {
    let (one, other) = (cube([0.0; 3], 1.0), cube([2.0, 0.0, 0.0], 1.0));
    let mesh = together(&[one.clone(), inside_out(other)]).unwrap();
    assert_is_solid(&mesh, 2.0, 24);
    assert_eq!(mesh.turned(), 1);
    // Hollow, with a solid in its cavity.
    let hollow = [
        cube([-2.0; 3], 5.0),
        inside_out(cube([-1.0; 3], 3.0)),
        one.clone(),
    ];
    let mesh = together(&hollow).unwrap();
    assert_is_solid(&mesh, 125.0 - 27.0 + 1.0, 36);
    assert_eq!(mesh.turned(), 0);
    let mesh = together(&hollow.map(inside_out)).unwrap();
    assert_is_solid(&mesh, 125.0 - 27.0 + 1.0, 36);
    assert_eq!(mesh.turned(), 3);
    // Overlapping solids remain solids.
    let mesh = together(&[cube([-1.0; 3], 3.0), one]).unwrap();
    assert_is_solid(&mesh, 28.0, 24);
}

#[test]
fn what_is_given_from_both_sides_has_its_outside_only_or_is_refused() {
    let solid = cube([0.0; 3], 1.0);
    let mesh = together(&[inside_out(solid.clone()), solid.clone()]).unwrap();
    assert_is_solid(&mesh, 1.0, 12);
    let (vertices, faces) = solid;
    let sheet = (vertices, faces[..2].to_vec());
    let both = [sheet.clone(), inside_out(sheet)];
    assert_eq!(together(&both).unwrap_err(), MeshError::TwoSided([0, 2]));
}

#[test]
fn a_part_far_from_the_origin_keeps_its_steps() {
    // 20 mm of steps of 1 mm, 5 km away.
    let steps: Vec<_> = (0..20)
        .map(|k| cube([5e3 + 0.002 * f64::from(k), 5e3, -5e3], 0.001))
        .collect();
    assert_eq!(together(&steps).unwrap().faces().len(), 240);
}

use super::kept::MAGIC;
use super::*;

/// A block of 20 x 14 x 12 mm with a groove of 6 mm along x in its top: a solid with hollow edges.
fn grooved() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [14.0, 0.0],
        [14.0, 12.0],
        [10.0, 12.0],
        [10.0, 6.0],
        [4.0, 6.0],
        [4.0, 12.0],
        [0.0, 12.0],
    ];
    let count = u32::try_from(outline.len()).unwrap();
    let at = |x: f64| outline.map(|[y, z]| [1e-3 * x, 1e-3 * y, 1e-3 * z]);
    let vertices: Vec<Vector> = at(0.0).into_iter().chain(at(20.0)).collect();
    // Three rectangles of the outline, by its corners.
    let parts = [[0, 1, 4, 5], [1, 2, 3, 4], [0, 5, 6, 7]];
    let mut faces = Vec::new();
    for [a, b, c, d] in parts {
        faces.extend([[a, c, b], [a, d, c]]);
        let [a, b, c, d] = [a, b, c, d].map(|corner| corner + count);
        faces.extend([[a, b, c], [a, c, d]]);
    }
    for corner in 0..count {
        let next = (corner + 1) % count;
        faces.push([corner, next, next + count]);
        faces.push([corner, next + count, corner + count]);
    }
    Mesh::new(&vertices, &faces).unwrap()
}

fn spread(number: u32) -> Vector3 {
    let part = |prime: f64| (f64::from(number) * prime).fract();
    Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160))
}

/// Places in and about the block.
fn places() -> impl Iterator<Item = Vector3> {
    (1..3000).map(|number| {
        let low = Vector3::repeat(-1.2e-3);
        low + spread(number).component_mul(&Vector3::new(22.4e-3, 16.4e-3, 14.4e-3))
    })
}

#[test]
fn the_mesh_of_these_tests_is_a_block_with_a_groove() {
    let mesh = grooved();
    assert!(mesh.is_closed());
    let volume = 20e-3 * (14e-3 * 12e-3 - 6e-3 * 6e-3);
    assert!(
        (mesh.volume() - volume).abs() < 1e-12 * 1e-3,
        "{}",
        mesh.volume()
    );
}

#[test]
fn the_spline_passes_through_the_distances_at_the_nodes() {
    let mesh = grooved();
    let spacing = 0.8e-3;
    let grid = DistanceGrid::of(&mesh, spacing).unwrap();
    let nodes = &*grid.nodes;
    let mut checked = 0;
    for z in 2..nodes.counts[2] - 2 {
        for y in 2..nodes.counts[1] - 2 {
            for x in 2..nodes.counts[0] - 2 {
                let place = nodes.least + Vector3::new(x as f64, y as f64, z as f64) * spacing;
                let (value, _) = grid.distance(place.into()).unwrap();
                assert!((value - mesh.signed_distance(&place)).abs() < 1e-9);
                checked += 1;
            }
        }
    }
    assert!(checked > 5000, "{checked}");
}

/// Away from edges the distance is that from a plane. The spline swings about it by a quarter as much from node to node.
#[test]
fn a_flat_side_is_flat() {
    let grid = DistanceGrid::of(&grooved(), 0.5e-3).unwrap();
    for number in 1..500 {
        let [x, y, z]: Vector = spread(number).into();
        let place = [4e-3 + 12e-3 * x, 4e-3 + 6e-3 * y, -1e-3 + 1.5e-3 * z];
        let (distance, gradient) = grid.distance(place).unwrap();
        assert!((distance + place[2]).abs() < 5e-7, "{place:?} {distance}");
        let off = Vector3::from(gradient) + Vector3::z();
        assert!(off.norm() < 2e-3, "{place:?} {gradient:?}");
    }
}

/// Value and gradient belong to one smooth function: a point that is led around gets back what it gave.
#[test]
fn the_gradient_is_that_of_the_distance_and_does_not_jump() {
    let grid = DistanceGrid::of(&grooved(), 0.7e-3).unwrap();
    let h = 1e-7;
    let mut bent = 0;
    for place in places() {
        let (distance, gradient) = grid.distance(place.into()).unwrap();
        assert!(distance.is_finite());
        let slopes = Vector3::from_fn(|axis, _| {
            let step = Vector3::ith(axis, h);
            let at = |place: Vector3| grid.distance(place.into()).unwrap().0;
            (at(place + step) - at(place - step)) / (2.0 * h)
        });
        let off = (slopes - Vector3::from(gradient)).norm();
        assert!(off < 1e-5, "{place:?} {off}");
        bent += u32::from((slopes.norm() - 1.0).abs() > 0.05);
    }
    assert!(bent > 20, "places where the distance has a bend: {bent}");
}

#[test]
fn the_surface_is_as_near_to_the_mesh_as_it_says() {
    let mesh = grooved();
    let mut before = f64::INFINITY;
    for spacing in [1.2e-3, 0.6e-3, 0.3e-3] {
        let error = DistanceGrid::of(&mesh, spacing).unwrap().error();
        assert!(error.root_mean_square <= error.largest);
        // Corners are rounded by a part of the spacing.
        assert!(
            error.largest < 0.7 * spacing && error.largest < 0.8 * before,
            "{spacing} {error:?}"
        );
        before = error.largest;
    }
}

#[test]
fn in_turned_axes_the_distances_are_the_same() {
    let grid = DistanceGrid::of(&grooved(), 0.8e-3).unwrap();
    let centre = Vector3::new(3e-3, -2e-3, 5e-3);
    let turned = Rotation::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7));
    let seen = grid.seen_from(&centre, &turned);
    for place in places() {
        let there = turned.inverse() * (place - centre);
        let (one, of_one) = grid.distance(place.into()).unwrap();
        let (other, of_other) = seen.distance(there.into()).unwrap();
        assert!((one - other).abs() < 1e-15);
        let back = turned * Vector3::from(of_other);
        assert!((back - Vector3::from(of_one)).norm() < 1e-12);
    }
}

/// What is left out because it is far really is: inside, near, and beyond the grid.
#[test]
fn nothing_within_reach_is_called_far() {
    let mesh = grooved();
    let grid = DistanceGrid::of(&mesh, 0.6e-3).unwrap();
    let mut far = 0;
    for number in 1..4000 {
        let place = (spread(number) - Vector3::repeat(0.5)) * 60e-3 + Vector3::repeat(7e-3);
        let exact = mesh.signed_distance(&place);
        for reach in [0.0, 0.4e-3, 3e-3, 10e-3] {
            let found = grid.nearest_within(&place, reach);
            if found.distance > reach {
                assert!(exact > reach - 1e-4, "{place:?} {exact} {reach}");
                far += u32::from(found.distance.is_infinite());
            }
            assert!((found.normal.norm() - 1.0).abs() < 1e-9);
        }
        let outside = grid.distance(place.into()).is_none();
        assert!(!outside || grid.nearest(&place).distance <= exact + 1e-12);
    }
    assert!(far > 3000, "{far}");
    let nowhere = grid.nearest(&Vector3::repeat(f64::NAN));
    assert_eq!(nowhere.distance, f64::INFINITY);
}

#[test]
fn what_is_kept_is_the_grid_and_nothing_else_is_taken_for_it() {
    let mesh = grooved();
    let grid = DistanceGrid::of(&mesh, 1e-3).unwrap();
    let bytes = grid.to_bytes();
    let back = |bytes: &[u8], spacing| DistanceGrid::from_bytes(bytes, &mesh, spacing);
    assert_eq!(back(&bytes, 1e-3), Ok(Some(grid.clone())));
    assert_eq!(back(&bytes, 1.1e-3), Ok(None), "another spacing");
    let mut moved = mesh.vertices();
    moved[0][0] -= 1e-6;
    let other = Mesh::new(&moved, mesh.faces()).unwrap();
    assert_eq!(DistanceGrid::from_bytes(&bytes, &other, 1e-3), Ok(None));
    assert_eq!(back(b"solid", 1e-3), Err(GridBytesError::NotAGrid));
    for length in [
        MAGIC.len(),
        MAGIC.len() + 30,
        bytes.len() / 2,
        bytes.len() - 1,
    ] {
        assert_eq!(back(&bytes[..length], 1e-3), Err(GridBytesError::Broken));
    }
    let mut changed = bytes.clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 4;
    assert_eq!(back(&changed, 1e-3), Err(GridBytesError::Broken));
    assert!(other.with_grid(grid).is_err(), "a grid of another mesh");
}

#[test]
fn a_spacing_that_does_not_fit_is_refused() {
    let mesh = grooved();
    let refused = |spacing| DistanceGrid::of(&mesh, spacing).unwrap_err();
    assert_eq!(refused(0.0), InvalidGrid::Spacing(0.0));
    assert!(matches!(refused(f64::NAN), InvalidGrid::Spacing(_)));
    assert!(matches!(refused(4e-3), InvalidGrid::Coarse { .. }));
    let InvalidGrid::Fine { least, .. } = refused(1e-5) else {
        panic!("too fine");
    };
    assert!(laid_out(&mesh, least).is_ok(), "{least}");
    let open = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
    assert_eq!(DistanceGrid::of(&open, 0.1), Err(InvalidGrid::Open));
}

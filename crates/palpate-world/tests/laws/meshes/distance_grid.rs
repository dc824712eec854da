//! Distance grid alone: accuracy with respect to its mesh, and serialisation.

use palpate_world::{DistanceGrid, GridBytesError, InvalidGrid, Mesh, Vector};

use super::common::drawn_out;

type Vector3 = nalgebra::Vector3<f64>;

/// Returns a block of 14 x 12 x 20 mm with a groove of 6 mm along z in its top: a solid with concave edges.
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
    let triangles = [
        [0, 1, 4],
        [0, 4, 5],
        [1, 2, 3],
        [1, 3, 4],
        [0, 5, 6],
        [0, 6, 7],
    ];
    drawn_out(
        &outline.map(|place| place.map(|x| 1e-3 * x)),
        &triangles,
        10e-3,
    )
}

fn spread(number: u32) -> Vector3 {
    let part = |prime: f64| (f64::from(number) * prime).fract();
    Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160))
}

/// Returns positions in and around the block.
fn places() -> impl Iterator<Item = Vector3> {
    (1..3000).map(|number| {
        let low = Vector3::new(-1.2e-3, -1.2e-3, -11.2e-3);
        low + spread(number).component_mul(&Vector3::new(16.4e-3, 14.4e-3, 22.4e-3))
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

/// Away from edges the distance is that from a plane. The spline's overshoot decreases by a factor of four per node.
#[test]
fn a_flat_side_is_flat() {
    let grid = DistanceGrid::new(&grooved(), 0.5e-3).unwrap();
    for number in 1..500 {
        let [x, y, z]: Vector = spread(number).into();
        let place = [4e-3 + 6e-3 * x, -1e-3 + 1.5e-3 * y, -6e-3 + 12e-3 * z];
        let (distance, gradient) = grid.distance(place).unwrap();
        assert!((distance + place[1]).abs() < 5e-7, "{place:?} {distance}");
        let off = Vector3::from(gradient) + Vector3::y();
        assert!(off.norm() < 2e-3, "{place:?} {gradient:?}");
    }
}

/// Value and gradient belong to one smooth function: the work over a closed path is zero.
#[test]
fn the_gradient_is_that_of_the_distance_and_does_not_jump() {
    let grid = DistanceGrid::new(&grooved(), 0.7e-3).unwrap();
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
        let error = DistanceGrid::new(&mesh, spacing).unwrap().error();
        assert!(error.root_mean_square <= error.largest);
        // Corners are rounded over a fraction of the spacing.
        assert!(
            error.largest < 0.7 * spacing && error.largest < 0.8 * before,
            "{spacing} {error:?}"
        );
        before = error.largest;
    }
}

#[test]
fn what_is_kept_is_the_grid_and_nothing_else_is_taken_for_it() {
    let mesh = grooved();
    let grid = DistanceGrid::new(&mesh, 1e-3).unwrap();
    let bytes = grid.to_bytes();
    let back = |bytes: &[u8], spacing| DistanceGrid::from_bytes(bytes, &mesh, spacing);
    assert_eq!(back(&bytes, 1e-3), Ok(Some(grid.clone())));
    assert_eq!(back(&bytes, 1.1e-3), Ok(None), "another spacing");
    let mut moved = mesh.vertices();
    moved[0][0] -= 1e-6;
    let other = Mesh::new(&moved, mesh.faces()).unwrap();
    assert_eq!(DistanceGrid::from_bytes(&bytes, &other, 1e-3), Ok(None));
    assert_eq!(back(b"solid", 1e-3), Err(GridBytesError::NotAGrid));
    let line = bytes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    for length in [line, line + 30, bytes.len() / 2, bytes.len() - 1] {
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
    let refused = |spacing| DistanceGrid::new(&mesh, spacing).unwrap_err();
    assert_eq!(refused(0.0), InvalidGrid::Spacing(0.0));
    assert!(matches!(refused(f64::NAN), InvalidGrid::Spacing(_)));
    assert!(matches!(refused(4e-3), InvalidGrid::Coarse { .. }));
    assert!(matches!(refused(1e-5), InvalidGrid::Fine { .. }));
    let open = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
    assert_eq!(DistanceGrid::new(&open, 0.1), Err(InvalidGrid::Open));
}

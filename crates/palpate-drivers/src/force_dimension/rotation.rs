//! Orientation of the handle.

/// Largest deviation of a rotation matrix from an orthogonal one.
const TOLERANCE: f64 = 1e-3;

/// Returns the unit quaternion `[w, x, y, z]` of a rotation matrix, or `None` for another matrix.
#[must_use]
pub fn quaternion(matrix: &[[f64; 3]; 3]) -> Option<[f64; 4]> {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = *matrix;
    // Four times the squares of w, x, y and z; the largest is at least 1.
    let squares = [
        1.0 + xx + yy + zz,
        1.0 + xx - yy - zz,
        1.0 - xx + yy - zz,
        1.0 - xx - yy + zz,
    ];
    let [w, x, y, z] = squares;
    let found = if w >= x.max(y).max(z) {
        [w, zy - yz, xz - zx, yx - xy]
    } else if x >= y.max(z) {
        [zy - yz, x, xy + yx, xz + zx]
    } else if y >= z {
        [xz - zx, xy + yx, y, yz + zy]
    } else {
        [yx - xy, xz + zx, yz + zy, z]
    };
    let length = found.iter().map(|part| part * part).sum::<f64>().sqrt();
    let quaternion = found.map(|part| part / length);
    let [w, x, y, z] = quaternion;
    let again = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let mut off = again
        .iter()
        .flatten()
        .zip(matrix.iter().flatten())
        .map(|(again, given)| (again - given).abs());
    // A comparison with NaN is false.
    off.all(|off| off < TOLERANCE).then_some(quaternion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_about_each_axis_is_found_and_other_matrices_are_not() {
        for angle in [-3.1, -1.0, 0.0, 0.4, 2.0, 3.1_f64] {
            let (sin, cos) = angle.sin_cos();
            let about_z = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
            let about_x = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
            let about_y = [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]];
            for (axis, matrix) in [(1, about_x), (2, about_y), (3, about_z)] {
                let found = quaternion(&matrix).unwrap();
                let mut expected = [(angle / 2.0).cos(), 0.0, 0.0, 0.0];
                expected[axis] = (angle / 2.0).sin();
                let same: f64 = found.iter().zip(expected).map(|(a, b)| a * b).sum();
                assert!((same.abs() - 1.0).abs() < 1e-12, "{angle} {found:?}");
            }
        }
        let reflection = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for wrong in [[[0.0; 3]; 3], reflection, [[f64::NAN; 3]; 3]] {
            assert_eq!(quaternion(&wrong), None);
        }
    }
}

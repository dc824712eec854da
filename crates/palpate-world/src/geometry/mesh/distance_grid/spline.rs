//! Cubic spline through the values at the nodes of a grid.

/// Converts the values at the nodes to the coefficients of the interpolating spline, which has zero curvature at its
/// ends.
pub(super) fn through(values: &mut [f64], counts: [usize; 3]) {
    let [nx, ny, nz] = counts;
    let strides = [1, nx, nx * ny];
    let mut line = vec![0.0; nx.max(ny).max(nz)];
    let mut ratios = line.clone();
    for axis in 0..3 {
        let (stride, count) = (strides[axis], counts[axis]);
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        for i in 0..counts[across[0]] {
            for j in 0..counts[across[1]] {
                let first = i * strides[across[0]] + j * strides[across[1]];
                for (number, value) in line[..count].iter_mut().enumerate() {
                    *value = values[first + number * stride];
                }
                spline(&mut line[..count], &mut ratios);
                for (number, value) in line[..count].iter().enumerate() {
                    values[first + number * stride] = *value;
                }
            }
        }
    }
}

/// Solves c[k - 1] + 4 c[k] + c[k + 1] = 6 f[k] in place, with c = f at both ends (Thomas algorithm).
fn spline(line: &mut [f64], ratios: &mut [f64]) {
    let last = line.len() - 1;
    ratios[0] = 0.0;
    for k in 1..last {
        let pivot = 1.0 / (4.0 - ratios[k - 1]);
        ratios[k] = pivot;
        line[k] = (6.0 * line[k] - line[k - 1]) * pivot;
    }
    for k in (1..last).rev() {
        line[k] -= ratios[k] * line[k + 1];
    }
}

/// Returns the weights of four neighbouring B-splines at a relative position in a cell, and their derivatives with
/// respect to it.
pub(super) fn weights(share: f64) -> ([f64; 4], [f64; 4]) {
    let rest = 1.0 - share;
    let (square, cube) = (share * share, share * share * share);
    (
        [
            rest * rest * rest / 6.0,
            (3.0 * cube - 6.0 * square + 4.0) / 6.0,
            (3.0 * (share + square - cube) + 1.0) / 6.0,
            cube / 6.0,
        ],
        [
            -0.5 * rest * rest,
            1.5 * square - 2.0 * share,
            -1.5 * square + share + 0.5,
            0.5 * square,
        ],
    )
}

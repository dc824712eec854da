//! A mesh with fewer triangles, for the eye: vertices that lie close together become one.

use std::collections::{HashMap, HashSet};

/// Initial number of cells along the longest side of the mesh, and the factor of each coarser grid.
const FINEST: f64 = 512.0;
const COARSER: f64 = 0.8;

/// Vertices `[m]` and faces of at most `most` triangles: those of the mesh itself, or of the finest grid whose cells
/// have a vertex each, the mean of theirs, that leaves no more.
#[expect(clippy::cast_possible_truncation, reason = "for the eye")]
pub fn coarse(vertices: &[[f64; 3]], faces: &[[u32; 3]], most: usize) -> (Vec<f32>, Vec<[u32; 3]>) {
    if faces.len() <= most {
        let same = vertices.iter().flatten().map(|&x| x as f32).collect();
        return (same, faces.to_vec());
    }
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for vertex in vertices {
        for axis in 0..3 {
            low[axis] = low[axis].min(vertex[axis]);
            high[axis] = high[axis].max(vertex[axis]);
        }
    }
    let longest = (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(f64::MIN_POSITIVE, f64::max);
    let mut cells = FINEST;
    loop {
        let cell = longest / cells;
        let found = clustered(vertices, faces, low, cell);
        // One cell holds all, and so no triangle: this ends.
        if found.1.len() <= most || cells < 1.0 {
            return found;
        }
        cells *= COARSER;
    }
}

/// The mesh whose vertices are the means of those in each cell of a grid that begins at `low`.
#[expect(
    clippy::cast_possible_truncation,
    reason = "places in a grid, and numbers for the eye"
)]
fn clustered(
    vertices: &[[f64; 3]],
    faces: &[[u32; 3]],
    low: [f64; 3],
    cell: f64,
) -> (Vec<f32>, Vec<[u32; 3]>) {
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut sums: Vec<([f64; 3], f64)> = Vec::new();
    let of_vertex: Vec<u32> = vertices
        .iter()
        .map(|vertex| {
            let place = std::array::from_fn(|axis| ((vertex[axis] - low[axis]) / cell) as i64);
            let number = *numbers.entry(place).or_insert_with(|| {
                sums.push(([0.0; 3], 0.0));
                sums.len() as u32 - 1
            });
            let (sum, count) = &mut sums[number as usize];
            for axis in 0..3 {
                sum[axis] += vertex[axis];
            }
            *count += 1.0;
            number
        })
        .collect();
    let mut seen = HashSet::new();
    let kept = faces
        .iter()
        .map(|face| face.map(|corner| of_vertex[corner as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .filter(|face| {
            let mut sorted = *face;
            sorted.sort_unstable();
            seen.insert(sorted)
        })
        .collect();
    let means = sums
        .iter()
        .flat_map(|(sum, count)| sum.map(|x| (x / count) as f32))
        .collect();
    (means, kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `cells` by `cells`, with a wave, 1 m wide.
    fn waves(cells: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let row = cells + 1;
        let at = |i: u32| f64::from(i) / f64::from(cells);
        let vertices = (0..row * row)
            .map(|i| {
                let (x, y) = (at(i % row), at(i / row));
                [x, y, 0.1 * (6.0 * x).sin()]
            })
            .collect();
        let faces = (0..cells * cells)
            .flat_map(|i| {
                let first = i % cells + i / cells * row;
                [
                    [first, first + 1, first + row],
                    [first + 1, first + row + 1, first + row],
                ]
            })
            .collect();
        (vertices, faces)
    }

    #[test]
    fn a_mesh_that_is_small_enough_stays_as_it_is() {
        let (vertices, faces) = waves(10);
        let (same, kept) = coarse(&vertices, &faces, 200);
        assert_eq!((same.len(), kept), (3 * 121, faces));
    }

    #[test]
    fn a_large_mesh_keeps_its_shape_with_fewer_triangles() {
        let (vertices, faces) = waves(200);
        let (fewer, kept) = coarse(&vertices, &faces, 5000);
        assert!((2500..=5000).contains(&kept.len()), "{}", kept.len());
        for vertex in fewer.chunks(3) {
            let height = 0.1 * (6.0 * vertex[0]).sin();
            assert!((vertex[2] - height).abs() < 2e-3, "{vertex:?}");
        }
        let reaches = |axis: usize| {
            let along = fewer.iter().skip(axis).step_by(3);
            along.fold((1.0_f32, 0.0_f32), |(low, high), &x| {
                (low.min(x), high.max(x))
            })
        };
        for (low, high) in [reaches(0), reaches(1)] {
            assert!(low < 0.02 && high > 0.98, "{low} to {high}");
        }
        let count = u32::try_from(fewer.len() / 3).unwrap();
        assert!(kept.iter().flatten().all(|&corner| corner < count));
        assert!(kept.iter().all(|[a, b, c]| a != b && b != c && c != a));
    }
}

//! Mass matrix of a device as a function of the tool position.
//!
//! Along each axis the matrix is a piecewise cubic. Its slope at a grid point is that of the parabola through the
//! point and its neighbours. The matrix and the forces from its change are therefore continuous inside the grid.

use nalgebra::SMatrix;

use crate::Vector;
use crate::geometry::axes::OwnAxes;
use crate::geometry::rigid::{Matrix3, Vector3};

/// Position-dependent mass of a device: a linkage such as a pantograph has a mass matrix M that depends on the tool
/// position.
///
/// ```text
/// (M v)' = f + grad (v^T M v/2)      under the sum f of contacts and hand, at the velocity v
/// ```
///
/// Created by [`Tool::with_mass_table`](crate::Tool::with_mass_table). Outside the grid the nearest point of its
/// boundary is used.
#[derive(Clone, Debug, PartialEq)]
pub struct MassTable {
    axes: OwnAxes,
    has: [bool; 3],
    places: [Vec<f64>; 3],
    masses: Vec<[f64; 6]>,
    principal: Principal,
}

/// Fault of a mass table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MassTableError {
    /// The number of coordinate lists differs from the number of axes.
    #[error("there are places along {given} axes, and the device has {axes}; give a list for each")]
    Axes {
        /// Number of given lists.
        given: usize,
        /// Number of axes of the device.
        axes: usize,
    },
    /// A coordinate that is not finite or not above the previous one, or an empty list.
    #[error(
        "the places along axis {axis} are {places:?}, and have to be one or more finite numbers in increasing order"
    )]
    Places {
        /// Index of the axis, from 1.
        axis: usize,
        /// Given coordinates `[m]`.
        places: Vec<f64>,
    },
    /// The number of matrices differs from the number of grid points.
    #[error(
        "there are {given} matrices, and the grid has {places} places; give one for each, with the last axis varying \
         fastest"
    )]
    Count {
        /// Number of given matrices.
        given: usize,
        /// Number of grid points.
        places: usize,
    },
    /// A matrix of the wrong size.
    #[error("matrix {number} has {given} numbers; a device of {axes} axes has {size}")]
    Size {
        /// Index of the matrix, from 1.
        number: usize,
        /// Number of given values.
        given: usize,
        /// Number of axes of the device.
        axes: usize,
        /// Required number of values.
        size: &'static str,
    },
    /// A matrix that is not finite and positive definite.
    #[error("matrix {number} is {matrix:?}, and has to be finite and positive definite")]
    Matrix {
        /// Index of the matrix, from 1.
        number: usize,
        /// Given matrix `[kg]`.
        matrix: Vec<f64>,
    },
    /// Matrices with an interpolated matrix between them that is not positive definite.
    #[error(
        "the masses change too much between the places {from:?} and {to:?} m: an interpolated mass is not positive \
         definite; give more places there"
    )]
    Between {
        /// First corner of the grid cell, along the device's axes `[m]`.
        from: Vector,
        /// Last corner of the grid cell.
        to: Vector,
    },
}

/// Principal axes of a matrix, and its values along them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Principal {
    axes: OwnAxes,
    /// 1 along an axis that the device lacks.
    masses: Vector3,
}

/// Mass matrix at a position and its slopes along the table's axes, in these axes.
pub(crate) struct LocalMass {
    pub mass: Matrix3,
    pub slopes: [Matrix3; 3],
}

/// Maximum number of nodes that contribute along an axis.
const NEAR: usize = 4;
type Weights = [f64; NEAR];

impl MassTable {
    /// Creates a table for a device with these of its axes, which are its own or those of the world: see
    /// [`Tool::with_mass_table`](crate::Tool::with_mass_table).
    pub(crate) fn new<P: AsRef<[f64]>, M: AsRef<[f64]>>(
        (has, axes): ([bool; 3], OwnAxes),
        places: &[P],
        masses: &[M],
        reference: Vector,
    ) -> Result<Self, MassTableError> {
        let there: Vec<usize> = (0..3).filter(|&axis| has[axis]).collect();
        if places.len() != there.len() {
            return Err(MassTableError::Axes {
                given: places.len(),
                axes: there.len(),
            });
        }
        let mut all = [vec![0.0], vec![0.0], vec![0.0]];
        for ((number, &axis), places) in there.iter().enumerate().zip(places) {
            let places = places.as_ref();
            let increase = places.windows(2).all(|pair| pair[0] < pair[1]);
            if places.is_empty() || !increase || !places.iter().all(|place| place.is_finite()) {
                return Err(MassTableError::Places {
                    axis: number + 1,
                    places: places.to_vec(),
                });
            }
            all[axis] = places.to_vec();
        }
        let count: usize = all.iter().map(Vec::len).product();
        if masses.len() != count {
            return Err(MassTableError::Count {
                given: masses.len(),
                places: count,
            });
        }
        let masses = masses.iter().enumerate();
        let masses = masses.map(|(number, mass)| whole(&there, number + 1, mass.as_ref()));
        let mut table = Self {
            axes,
            has,
            places: all,
            masses: masses.collect::<Result<_, _>>()?,
            principal: Principal {
                axes,
                masses: Vector3::repeat(1.0),
            },
        };
        table.check_between()?;
        let there = table.at(&table.own(&Vector3::from(reference))).mass;
        let (masses, turn) = principal(&there);
        if turn != Matrix3::identity() {
            table.principal.axes = Some(axes.map_or(turn, |axes| axes * turn));
        }
        table.principal.masses = masses;
        Ok(table)
    }

    /// Returns the masses at the reference along the tool's axes, those of the mobility there `[kg]`; infinite along
    /// an axis that the device lacks.
    #[must_use]
    pub fn masses_at_reference(&self) -> Vector {
        [0, 1, 2].map(|axis| {
            if self.has[axis] {
                self.principal.masses[axis]
            } else {
                f64::INFINITY
            }
        })
    }

    /// Returns the axes of the grid and the matrices: orthogonal unit vectors.
    #[must_use]
    pub fn axes(&self) -> [Vector; 3] {
        let axes = self.axes.unwrap_or_else(Matrix3::identity);
        [0, 1, 2].map(|axis| axes.column(axis).into_owned().into())
    }

    /// Returns the grid coordinates along each of these axes `[m]`; one along an axis that the device lacks.
    #[must_use]
    pub fn places(&self) -> &[Vec<f64>; 3] {
        &self.places
    }

    /// Returns the matrix of each grid point as xx, yy, zz, xy, xz and yz, last axis fastest `[kg]`; it is the unit
    /// matrix along an axis that the device lacks.
    #[must_use]
    pub fn matrices(&self) -> &[[f64; 6]] {
        &self.masses
    }

    /// Returns the axes of the matrix at the reference and the masses along them; 1 kg along an axis that the device
    /// lacks.
    pub(crate) fn principal(&self) -> (OwnAxes, Vector3) {
        (self.principal.axes, self.principal.masses)
    }

    /// Transforms a vector from the world's axes to the table's axes.
    pub(crate) fn own(&self, vector: &Vector3) -> Vector3 {
        crate::geometry::axes::own(&self.axes, vector)
    }

    /// Evaluates the table at a position along its axes `[m]`.
    pub(crate) fn at(&self, place: &Vector3) -> LocalMass {
        let near = [0, 1, 2].map(|axis| Near::at(&self.places[axis], place[axis]));
        let sum = |of: [&Weights; 3]| matrix(&self.sum(&near, of));
        let [x, y, z] = near.each_ref().map(|near| &near.weights);
        let [dx, dy, dz] = near.each_ref().map(|near| &near.slopes);
        LocalMass {
            mass: sum([x, y, z]),
            slopes: [sum([dx, y, z]), sum([x, dy, z]), sum([x, y, dz])],
        }
    }

    /// Returns the sum of the nearby matrices, each times the product of its weights along the axes.
    fn sum(&self, near: &[Near; 3], [x, y, z]: [&Weights; 3]) -> [f64; 6] {
        let mut sum = [0.0; 6];
        let rows = self.places[1].len();
        let columns = self.places[2].len();
        for (i, x) in x.iter().enumerate().take(near[0].count) {
            for (j, y) in y.iter().enumerate().take(near[1].count) {
                let row = ((near[0].first + i) * rows + near[1].first + j) * columns;
                for (k, z) in z.iter().enumerate().take(near[2].count) {
                    let weight = x * y * z;
                    let mass = &self.masses[row + near[2].first + k];
                    for (sum, mass) in sum.iter_mut().zip(mass) {
                        *sum += weight * mass;
                    }
                }
            }
        }
        sum
    }

    /// In each cell every matrix is a weighted mean of control matrices (Bézier form), which must all be positive
    /// definite.
    fn check_between(&self) -> Result<(), MassTableError> {
        let cells = |axis: usize| 0..(self.places[axis].len() - 1).max(1);
        for x in cells(0) {
            for y in cells(1) {
                for z in cells(2) {
                    let cell = [x, y, z];
                    let near = [0, 1, 2].map(|axis| Near::of_cell(&self.places[axis], cell[axis]));
                    let controls = near.each_ref().map(Near::controls);
                    let of = |x: &Weights, y: &Weights, z: &Weights| {
                        is_of_masses(&matrix(&self.sum(&near, [x, y, z])))
                    };
                    let [x, y, z] = &controls;
                    let fits = x
                        .iter()
                        .all(|x| y.iter().all(|y| z.iter().all(|z| of(x, y, z))));
                    if !fits {
                        let end = |by: usize| {
                            [0, 1, 2].map(|axis| {
                                let places = &self.places[axis];
                                places[(cell[axis] + by).min(places.len() - 1)]
                            })
                        };
                        return Err(MassTableError::Between {
                            from: end(0),
                            to: end(1),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Expands a matrix of the available axes to three axes.
fn whole(there: &[usize], number: usize, given: &[f64]) -> Result<[f64; 6], MassTableError> {
    let size = match there.len() {
        1 => "1: [xx]",
        2 => "3: [xx, yy, xy]",
        _ => "6: [xx, yy, zz, xy, xz, yz]",
    };
    let axes = there.len();
    if given.len() != axes * (axes + 1) / 2 {
        return Err(MassTableError::Size {
            number,
            given: given.len(),
            axes,
            size,
        });
    }
    let mut mass = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let mut given_parts = given.iter();
    for (&axis, part) in there.iter().zip(given_parts.by_ref()) {
        mass[axis] = *part;
    }
    let pairs = there
        .iter()
        .enumerate()
        .flat_map(|(place, one)| there[place + 1..].iter().map(move |other| one + other));
    for (sum, part) in pairs.zip(given_parts) {
        // x and y are 0 and 1, so their sum identifies the pair.
        mass[2 + sum] = *part;
    }
    if is_of_masses(&matrix(&mass)) {
        Ok(mass)
    } else {
        Err(MassTableError::Matrix {
            number,
            matrix: given.to_vec(),
        })
    }
}

/// Smallest mass along any direction, relative to the trace.
const LIGHTEST: f64 = 1e-9;

fn is_of_masses(mass: &Matrix3) -> bool {
    let less = mass - Matrix3::from_diagonal_element(LIGHTEST * mass.trace());
    mass.iter().all(|part| part.is_finite()) && less.cholesky().is_some()
}

fn matrix([xx, yy, zz, xy, xz, yz]: &[f64; 6]) -> Matrix3 {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
}

/// Grid points along an axis that contribute in a cell, and their weights at a position.
struct Near {
    first: usize,
    count: usize,
    /// Weights of the value.
    weights: Weights,
    /// Weights of the slope.
    slopes: Weights,
    /// Values at the ends of the cell, and slopes times the cell's length.
    ends: [[Weights; 2]; 2],
}

impl Near {
    /// Returns the weights of a cell; `weights` are those at its beginning.
    fn of_cell(places: &[f64], cell: usize) -> Self {
        let last = places.len() - 1;
        let count = places.len().min(NEAR);
        let first = cell.saturating_sub(1).min(places.len() - count);
        let mut ends = [[[0.0; NEAR]; 2]; 2];
        if last == 0 {
            ends[0][0][0] = 1.0;
            ends[1][0][0] = 1.0;
        } else {
            let length = places[cell + 1] - places[cell];
            for (node, [value, slope]) in (cell..).zip(&mut ends) {
                value[node - first] = 1.0;
                // The slope is that of the parabola through the neighbours, a combination of two line segments.
                let middle = node.clamp(1, last.max(2) - 1);
                let mut line = |from: usize, part: f64| {
                    let by = part * length / (places[from + 1] - places[from]);
                    slope[from + 1 - first] += by;
                    slope[from - first] -= by;
                };
                if last == 1 {
                    line(0, 1.0);
                } else {
                    let [a, b, c] = [middle - 1, middle, middle + 1].map(|near| places[near]);
                    let part = (2.0 * places[node] - a - b) / (c - a);
                    line(middle - 1, 1.0 - part);
                    line(middle, part);
                }
            }
        }
        Self {
            first,
            count,
            weights: ends[0][0],
            slopes: [0.0; NEAR],
            ends,
        }
    }

    fn at(places: &[f64], at: f64) -> Self {
        let last = places.len() - 1;
        if last == 0 {
            return Self::of_cell(places, 0);
        }
        let after = places.partition_point(|place| *place <= at);
        let cell = after.clamp(1, last) - 1;
        let near = Self::of_cell(places, cell);
        let length = places[cell + 1] - places[cell];
        let beyond = (at - places[cell]) / length;
        let t = beyond.clamp(0.0, 1.0);
        let rate = if beyond == t { 1.0 / length } else { 0.0 };
        // Cubic Hermite polynomials of t, and their slopes.
        let rise = t * t * (3.0 - 2.0 * t);
        let of = [
            [1.0 - rise, t * (1.0 - t) * (1.0 - t)],
            [rise, t * t * (t - 1.0)],
        ];
        let steep = 6.0 * t * (1.0 - t);
        let slope_of = [
            [-steep, (1.0 - t) * (1.0 - 3.0 * t)],
            [steep, t * (3.0 * t - 2.0)],
        ];
        let sum = |factors: [[f64; 2]; 2]| {
            let mut sum = [0.0; NEAR];
            for (end, factors) in near.ends.iter().zip(factors) {
                for (weights, factor) in end.iter().zip(factors) {
                    for (sum, weight) in sum.iter_mut().zip(weights) {
                        *sum += factor * weight;
                    }
                }
            }
            sum
        };
        Self {
            weights: sum(of),
            slopes: sum(slope_of).map(|slope| rate * slope),
            ..near
        }
    }

    /// Returns the four control values of the cell.
    fn controls(&self) -> [Weights; 4] {
        let [[start, rise], [end, fall]] = &self.ends;
        let beside = |value: &Weights, slope: &Weights, third: f64| {
            let mut control = *value;
            for (control, slope) in control.iter_mut().zip(slope) {
                *control += third * slope;
            }
            control
        };
        [
            *start,
            beside(start, rise, 1.0 / 3.0),
            beside(end, fall, -1.0 / 3.0),
            *end,
        ]
    }
}

/// Number of sweeps of Jacobi rotations; each squares the remaining off-diagonal part.
const SWEEPS: usize = 6;

/// Returns the principal values of a symmetric matrix and its principal axes as columns, each approximately the
/// nearest to the axis of the same index.
pub(crate) fn principal(of: &Matrix3) -> (Vector3, Matrix3) {
    let (mut left, mut axes) = (*of, Matrix3::identity());
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let beside = left[(p, q)];
            if beside == 0.0 {
                continue;
            }
            let cotangent = (left[(q, q)] - left[(p, p)]) / (2.0 * beside);
            let root = (cotangent * cotangent + 1.0).sqrt();
            let tangent = 1.0_f64.copysign(cotangent) / (cotangent.abs() + root);
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let mut turn = SMatrix::<f64, 3, 3>::identity();
            turn[(p, p)] = cosine;
            turn[(q, q)] = cosine;
            turn[(p, q)] = tangent * cosine;
            turn[(q, p)] = -tangent * cosine;
            left = turn.tr_mul(&(left * turn));
            left[(p, q)] = 0.0;
            left[(q, p)] = 0.0;
            axes *= turn;
        }
    }
    (left.diagonal(), axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Shape, Tool};

    fn point() -> Tool {
        Tool::new("tool", Shape::Sphere { radius: 0.0 })
    }

    /// Quadratic along each axis, which the table represents exactly.
    fn quadratic([x, y]: [f64; 2]) -> [f64; 3] {
        [
            0.2 + 0.5 * x + 3.0 * x * x * (1.0 + y),
            0.3 - 0.4 * y + 2.0 * y * y,
            0.05 + 0.3 * x * y - x * x,
        ]
    }

    #[test]
    fn a_matrix_of_second_order_is_met_between_uneven_places_and_its_slopes_too() {
        let places = [vec![-0.1, -0.04, 0.05, 0.07], vec![-0.1, 0.02, 0.08]];
        let mut masses = Vec::new();
        for &x in &places[0] {
            masses.extend(places[1].iter().map(|&y| quadratic([x, y])));
        }
        let tool = point().along([true, false, true]);
        let tool = tool.with_mass_table(&places, &masses, [0.0; 3]).unwrap();
        let table = tool.mass_table.unwrap();
        for place in [[-0.08, 0.03], [0.0, -0.06], [0.06, 0.0], [0.05, 0.08]] {
            let local = table.at(&Vector3::new(place[0], 7.0, place[1]));
            let [xx, zz, xz] = quadratic(place);
            let expected = Matrix3::new(xx, 0.0, xz, 0.0, 1.0, 0.0, xz, 0.0, zz);
            assert!((local.mass - expected).norm() < 1e-14, "{place:?}");
            assert_eq!(local.slopes[1], Matrix3::zeros());
            let inside = place[1] < 0.08;
            for (axis, number) in [(0, 0), (2, 1)] {
                let mut beyond = place;
                beyond[number] += 1e-7;
                let mut before = place;
                before[number] -= 1e-7;
                let [a, b] = [before, beyond].map(quadratic);
                let slope = local.slopes[axis];
                let rates = [0, 1, 2].map(|part: usize| (b[part] - a[part]) / 2e-7);
                let off = (slope[(0, 0)] - rates[0]).abs() + (slope[(0, 2)] - rates[2]).abs();
                assert!(!inside || off < 1e-7, "{place:?} {axis}: {off:e}");
            }
        }
        // The matrix is constant outside the grid.
        let [edge, far] = [0.08, 0.5].map(|z| table.at(&Vector3::new(0.0, 0.0, z)));
        assert_eq!(edge.mass, far.mass);
        assert_eq!(far.slopes[2], Matrix3::zeros());
    }

    #[test]
    fn principal_axes_are_those_of_the_matrix_and_near_its_own() {
        let of = matrix(&[0.3, 0.2, 0.25, 0.05, -0.04, 0.03]);
        let (masses, axes) = principal(&of);
        let again = axes * Matrix3::from_diagonal(&masses) * axes.transpose();
        assert!((again - of).norm() < 1e-15);
        assert!((axes.tr_mul(&axes) - Matrix3::identity()).norm() < 1e-15);
        let diagonal = Matrix3::from_diagonal(&Vector3::new(3.0, 1.0, 2.0));
        assert_eq!(
            principal(&diagonal),
            (diagonal.diagonal(), Matrix3::identity())
        );
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let refused = |places: &[&[f64]], masses: &[&[f64]]| {
            let tool = point().along([true, true, false]);
            let refused = tool.with_mass_table(places, masses, [0.0; 3]);
            refused.unwrap_err().to_string()
        };
        let unit = [1.0, 1.0, 0.0];
        let x = [0.0, 0.1];
        for (places, masses, says) in [
            (
                vec![&x[..]],
                vec![&unit[..]; 2],
                "places along 1 axes, and the device has 2",
            ),
            (vec![&x[..], &[][..]], vec![], "along axis 2 are []"),
            (
                vec![&x[..], &[0.1, 0.1][..]],
                vec![&unit[..]; 4],
                "along axis 2 are [0.1, 0.1]",
            ),
            (
                vec![&x[..], &[f64::NAN][..]],
                vec![&unit[..]; 2],
                "along axis 2 are [NaN]",
            ),
            (
                vec![&x[..], &x[..]],
                vec![&unit[..]; 3],
                "3 matrices, and the grid has 4",
            ),
            (
                vec![&x[..], &[0.0][..]],
                vec![&unit[..], &[1.0][..]],
                "matrix 2 has 1 numbers; a device of 2 axes has 3: [xx, yy, xy]",
            ),
            (
                vec![&x[..], &[0.0][..]],
                vec![&unit[..], &[1.0, 1.0, 2.0][..]],
                "matrix 2 is [1.0, 1.0, 2.0]",
            ),
            (
                vec![&[0.0, 0.1, 0.2, 0.3][..], &[0.0][..]],
                vec![
                    &[9.0, 1.0, 0.0][..],
                    &unit[..],
                    &[0.01, 1.0, 0.0][..],
                    &[0.05, 1.0, 0.0][..],
                ],
                "between the places [0.1, 0.0, 0.0] and [0.2, 0.0, 0.0]",
            ),
        ] {
            let message = refused(&places, &masses);
            assert!(message.contains(says), "{message}");
        }
    }
}

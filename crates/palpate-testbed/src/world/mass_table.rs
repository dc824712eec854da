//! A device whose mass is another at each place of its tool: a linkage.
//!
//! ```text
//! (M v)′ = f + grad (vᵀ M v/2)     so     M v′ = f + vᵀ (grad M) v/2 − (v · grad M) v
//! ```
//!
//! The mass matrix M of a place is interpolated: in each cell of a grid it is a cubic along each axis, in Bézier's
//! form. From place to place along an axis its slope is that of the parabola through three neighbours, so M has no kink
//! between cells. All control matrices are positive definite, and so is each matrix between them, which is a mean of
//! them.

use std::array::from_fn;

use super::scene::{InvalidScene, Vector, WorldDevice, all_finite};
use super::vector::Vec3;
use crate::InvalidParameter;

/// A symmetric matrix: xx, yy, zz, xy, xz and yz.
type Symmetric = [f64; 6];
type Matrix = [Vector; 3];

/// The mass matrix of a device by the place of its tool.
#[derive(Debug, Clone, PartialEq)]
pub struct MassTable {
    axes: [Vector; 3],
    places: [Vec<f64>; 3],
    /// Bézier's control matrices, those of the last axis side by side.
    controls: Vec<Symmetric>,
}

/// The mass matrix at a place, and its slopes along the table's axes, in these axes.
struct Local {
    mass: Matrix,
    slopes: [Matrix; 3],
}

impl MassTable {
    /// Creates a table along `axes`, perpendicular unit vectors in world axes. `places`: increasing coordinates along
    /// each of them, from the world's origin `[m]`; a single one if the mass does not vary along an axis. `masses`: a
    /// matrix for each grid point along `axes`, as xx, yy, zz, xy, xz and yz `[kg]`, the last axis first. Beyond the
    /// grid the nearest point of its boundary applies. Entries of an axis that a device lacks are ignored.
    ///
    /// # Errors
    ///
    /// The places do not increase, the number of matrices is wrong, a number is not finite, a matrix is not positive
    /// definite, or neighbouring matrices differ so much that an interpolated one is not positive definite.
    pub fn new(
        axes: [Vector; 3],
        places: [Vec<f64>; 3],
        masses: Vec<Symmetric>,
    ) -> Result<Self, InvalidScene> {
        for along in &places {
            all_finite("mass_table.places", along)?;
            let increases = !along.is_empty() && along.windows(2).all(|pair| pair[0] < pair[1]);
            let first = along.first().copied().unwrap_or(f64::NAN);
            let allowed = "at least one place along each axis, in increasing order";
            InvalidParameter::unless(increases, "mass_table.places".to_owned(), first, allowed)?;
        }
        let count = places.iter().map(Vec::len).product::<usize>();
        InvalidParameter::unless(
            masses.len() == count,
            "mass_table.masses".to_owned(),
            masses.len() as f64,
            "one for each place",
        )?;
        for mass in &masses {
            all_finite("mass_table.masses", mass)?;
        }
        let mut controls = masses;
        let mut counts = places.each_ref().map(Vec::len);
        for (axis, along) in places.iter().enumerate() {
            controls = refined(&controls, counts, axis, along);
            counts[axis] = controls_along(along);
        }
        for control in &controls {
            let allowed = "positive definite, at each place and in between";
            let lower = cholesky(&matrix(control));
            let name = "mass_table.masses".to_owned();
            InvalidParameter::unless(lower.is_some(), name, control[0], allowed)?;
        }
        Ok(Self {
            axes,
            places,
            controls,
        })
    }

    fn at(&self, place: Vector) -> Local {
        let along: [Along; 3] = from_fn(|axis| Along::new(&self.places[axis], place[axis]));
        let counts = self.places.each_ref().map(|places| controls_along(places));
        let mut sums = [[0.0; 6]; 4];
        for (i, (wx, dx)) in along[0].weights() {
            for (j, (wy, dy)) in along[1].weights() {
                for (k, (wz, dz)) in along[2].weights() {
                    let control = &self.controls[(i * counts[1] + j) * counts[2] + k];
                    let weights = [wx * wy * wz, dx * wy * wz, wx * dy * wz, wx * wy * dz];
                    for (sum, weight) in sums.iter_mut().zip(weights) {
                        for (sum, part) in sum.iter_mut().zip(control) {
                            *sum += weight * part;
                        }
                    }
                }
            }
        }
        let [mass, slopes @ ..] = sums.map(|sum| matrix(&sum));
        Local { mass, slopes }
    }

    fn own(&self, vector: Vec3) -> Vector {
        self.axes.map(|axis| Vec3(axis).dot(vector))
    }

    /// Acceleration in the world `[m/s²]` of `device`, whose table it is, at a place with a velocity, under a force of
    /// everything.
    pub(super) fn acceleration(
        &self,
        device: &WorldDevice,
        [position, velocity, push]: [Vec3; 3],
    ) -> Vec3 {
        let Local { mass, slopes } = self.at(self.own(position));
        let velocity = self.own(velocity);
        let by_slopes = slopes.map(|slope| times(&slope, velocity));
        // Along the table's axes: the applied force, and the effect of the varying mass.
        let pushed: Vector = from_fn(|axis| {
            let by_change: f64 = (0..3).map(|k| velocity[k] * by_slopes[k][axis]).sum();
            0.5 * Vec3(velocity).dot(Vec3(by_slopes[axis])) - by_change
        });
        let pushed = Vec3(pushed) + Vec3(self.own(push));
        // Along those of the device, of which it may lack some.
        let axes: [Vector; 3] = from_fn(|axis| {
            let unit = from_fn(|one| if one == axis { 1.0 } else { 0.0 });
            self.own(device.out(Vec3(unit)))
        });
        let has: [bool; 3] = from_fn(|axis| device.moves_along(axis));
        let own_mass: Matrix = from_fn(|row| {
            from_fn(|column| {
                if has[row] && has[column] {
                    Vec3(axes[row]).dot(Vec3(times(&mass, axes[column])))
                } else if row == column {
                    1.0
                } else {
                    0.0
                }
            })
        });
        let own_push = from_fn(|axis| {
            if has[axis] {
                Vec3(axes[axis]).dot(pushed)
            } else {
                0.0
            }
        });
        let lower = cholesky(&own_mass).unwrap_or([[f64::NAN; 3]; 3]);
        device.out(Vec3(solved(&lower, own_push)))
    }

    /// vᵀ M v/2 at a place `[J]`.
    pub(super) fn kinetic_energy(&self, position: Vec3, velocity: Vec3) -> f64 {
        let velocity = self.own(velocity);
        let momentum = times(&self.at(self.own(position)).mass, velocity);
        0.5 * Vec3(velocity).dot(Vec3(momentum))
    }
}

/// Number of control matrices along an axis with these places: the ends of cells, and two within each.
fn controls_along(places: &[f64]) -> usize {
    3 * places.len() - 2
}

/// Returns the control points along one axis of a grid of matrices.
fn refined(of: &[Symmetric], counts: [usize; 3], axis: usize, places: &[f64]) -> Vec<Symmetric> {
    let inner: usize = counts[axis + 1..].iter().product();
    let outer: usize = counts[..axis].iter().product();
    let mut all = Vec::with_capacity(outer * inner * controls_along(places));
    for outer in 0..outer {
        let at =
            |place: usize, inner_at: usize| of[(outer * places.len() + place) * inner + inner_at];
        for control in 0..controls_along(places) {
            all.extend((0..inner).map(|inner_at| {
                let node = (control + 1) / 3;
                let value = at(node, inner_at);
                // Before a place, at it, or after it, by a third of the cell there.
                let step = match control % 3 {
                    0 => return value,
                    1 => (places[node + 1] - places[node]) / 3.0,
                    _ => (places[node - 1] - places[node]) / 3.0,
                };
                let slope = slope(places, node, |place| at(place, inner_at));
                from_fn(|part| value[part] + step * slope[part])
            }));
        }
    }
    all
}

/// Returns the slope at a grid point of the parabola through it and its neighbours; at an end, through the three
/// outermost points; for two points, of the line.
fn slope(places: &[f64], node: usize, value: impl Fn(usize) -> Symmetric) -> Symmetric {
    let secant = |from: usize| -> Symmetric {
        let (one, other) = (value(from), value(from + 1));
        let length = places[from + 1] - places[from];
        from_fn(|part| (other[part] - one[part]) / length)
    };
    if places.len() == 2 {
        return secant(0);
    }
    let middle = node.clamp(1, places.len() - 2);
    let (before, after) = (secant(middle - 1), secant(middle));
    let [h, k] = [middle - 1, middle].map(|from| places[from + 1] - places[from]);
    // The slope of the parabola changes by this per length.
    let bend: Symmetric = from_fn(|part| 2.0 * (after[part] - before[part]) / (h + k));
    let from_middle_of_cell = places[node] - 0.5 * (places[middle - 1] + places[middle]);
    from_fn(|part| before[part] + bend[part] * from_middle_of_cell)
}

/// A coordinate in its cell.
struct Along {
    /// The first of the cell's controls.
    first: usize,
    count: usize,
    weights: [f64; 4],
    slopes: [f64; 4],
}

impl Along {
    fn new(places: &[f64], at: f64) -> Self {
        if places.len() == 1 {
            return Self {
                first: 0,
                count: 1,
                weights: [1.0, 0.0, 0.0, 0.0],
                slopes: [0.0; 4],
            };
        }
        let after = places.partition_point(|place| *place <= at);
        let cell = after.clamp(1, places.len() - 1) - 1;
        let length = places[cell + 1] - places[cell];
        let t = (at - places[cell]) / length;
        let is_within = (0.0..=1.0).contains(&t);
        let t = t.clamp(0.0, 1.0);
        let s = 1.0 - t;
        let rate = if is_within { 3.0 / length } else { 0.0 };
        Self {
            first: 3 * cell,
            count: 4,
            weights: [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
            slopes: [-s * s, s * s - 2.0 * s * t, 2.0 * s * t - t * t, t * t]
                .map(|slope| rate * slope),
        }
    }

    /// The number of each control with its weight and that of its slope.
    fn weights(&self) -> impl Iterator<Item = (usize, (f64, f64))> {
        let weights = self.weights.iter().copied().zip(self.slopes);
        weights
            .take(self.count)
            .enumerate()
            .map(|(number, weights)| (self.first + number, weights))
    }
}

fn matrix([xx, yy, zz, xy, xz, yz]: &Symmetric) -> Matrix {
    [[*xx, *xy, *xz], [*xy, *yy, *yz], [*xz, *yz, *zz]]
}

fn times(matrix: &Matrix, vector: Vector) -> Vector {
    matrix.map(|row| Vec3(row).dot(Vec3(vector)))
}

/// L of L Lᵀ; `None` if the matrix is not positive definite.
fn cholesky(of: &Matrix) -> Option<Matrix> {
    let mut lower = [[0.0; 3]; 3];
    for row in 0..3 {
        for column in 0..=row {
            let before: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let left = of[row][column] - before;
            lower[row][column] = if row == column {
                if left <= 0.0 || left.is_nan() {
                    return None;
                }
                left.sqrt()
            } else {
                left / lower[column][column]
            };
        }
    }
    Some(lower)
}

/// x of L Lᵀ x = b.
fn solved(lower: &Matrix, mut b: Vector) -> Vector {
    for row in 0..3 {
        let before: f64 = (0..row).map(|k| lower[row][k] * b[k]).sum();
        b[row] = (b[row] - before) / lower[row][row];
    }
    for row in (0..3).rev() {
        let after: f64 = (row + 1..3).map(|k| lower[k][row] * b[k]).sum();
        b[row] = (b[row] - after) / lower[row][row];
    }
    b
}

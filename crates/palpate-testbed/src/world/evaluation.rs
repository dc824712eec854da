//! Metrics of a rendered world: the forces held on each tool compared with those of the ideal.

use thiserror::Error;

use super::contact::WorldError;
use super::ideal::WorldIdeal;
use super::record::DeviceProfile;
use super::scene::{Member, Vector, WorldDevice, WorldScene};
use super::vector::Vec3;
use crate::grid::Grid;
use crate::metrics::collisions::{relative_error, separated};
use crate::metrics::fidelity::ErrorSums;
use crate::metrics::{Fidelity, WindowMismatch};

/// Accuracy of held forces in a world.
///
/// Each [`Fidelity`] is of one component or of several. Errors in sum are weighted by the mobility 1/m of the device's
/// axis, torques by the mobility about the axis at t = 0: ∫ e·W e over ∫ f·W f. Axes of unequal masses, forces and
/// torques thus count by their motion. The mean over intervals is the same projection for each weight. Hence
/// FRE² = floor² + E² holds for all of them.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WorldEvaluation {
    /// All devices and axes together; `None` if no tool is touched.
    pub sum: Option<Fidelity>,
    /// Each device.
    pub devices: Vec<DeviceEvaluation>,
}

/// Accuracy of the forces on one tool.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DeviceEvaluation {
    /// All axes together, torques too; `None` if the tool is not touched.
    pub sum: Option<Fidelity>,
    /// The forces alone.
    pub force: Option<Fidelity>,
    /// The torques alone; `None` for a device that gives none.
    pub torque: Option<TorqueEvaluation>,
    /// Along each of the device's axes; `None` where the ideal force is 0 or rounding, below 1e-8 of the force along
    /// all axes.
    pub axes: [Option<Fidelity>; 3],
    /// Each ideal touch that the held forces can show apart, in order.
    pub touches: Vec<ContactEvaluation>,
    /// Number of rendered touches.
    pub rendered_touches: usize,
    /// Largest held force `[N]`.
    pub peak_force: f64,
}

/// Accuracy of the torque on one tool.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TorqueEvaluation {
    /// All axes together; `None` if the ideal torque is 0.
    pub sum: Option<Fidelity>,
    /// About each axis of the world; `None` where the ideal torque is 0 or rounding, as for forces.
    pub axes: [Option<Fidelity>; 3],
    /// Largest held torque `[N m]`.
    pub peak_torque: f64,
}

/// An ideal touch of a tool, and the rendered one of the same number.
///
/// A touch is a run of intervals with a force; two are apart if the force between them falls to 0 or to a
/// twentieth of the smaller of their peaks. The same rule is applied to the held forces and to the interval means
/// of the ideal force.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactEvaluation {
    /// Begin of its first interval `[s]`.
    pub start: f64,
    /// End of its last interval `[s]`.
    pub end: f64,
    /// ∫ f dt of the ideal on the tool `[N s]`.
    pub ideal_impulse: Vector,
    /// Largest |f| of the ideal `[N]`.
    pub ideal_peak: f64,
    /// Values of the held forces; `None` if there are fewer touches.
    pub rendered: Option<RenderedTouch>,
}

/// A touch of held forces.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RenderedTouch {
    /// Begin of its first interval `[s]`.
    pub start: f64,
    /// ∫ f dt on the tool `[N s]`.
    pub impulse: Vector,
    /// Largest |f| `[N]`.
    pub peak: f64,
    /// |rendered − ideal| of the impulse over |ideal|; `None` if that is not a finite number.
    pub impulse_error: Option<f64>,
    /// (rendered − ideal)/ideal of the peak; `None` if that is not a finite number.
    pub peak_error: Option<f64>,
}

/// Mismatch between recorded forces and the ideal that they are evaluated against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// Not one record of forces for each device.
    #[error("the record has forces of {given} devices, but the ideal has {expected}")]
    Devices {
        /// Records given.
        given: usize,
        /// Devices of the ideal.
        expected: usize,
    },
    /// Not one force for each interval.
    #[error("device {device}: {mismatch}")]
    Intervals {
        /// Number of the device, from 0.
        device: usize,
        /// The lengths.
        mismatch: WindowMismatch,
    },
}

impl WorldEvaluation {
    /// Evaluates the force `held` on each tool over each interval of the ideal's grid `[N]`: `held[device][interval]`.
    ///
    /// # Errors
    ///
    /// The number of records differs from the devices of `ideal`, or the number of forces from the intervals.
    ///
    /// # Panics
    ///
    /// `ideal` does not belong to `scene` and has more devices.
    pub fn new(
        scene: &WorldScene,
        ideal: &WorldIdeal,
        held: &[Vec<Vector>],
    ) -> Result<Self, EvaluationError> {
        Self::of_wrenches(scene, ideal, held, &[])
    }

    /// Evaluates forces and the torque held on each tool about its mass centre `[N m]`: `torques[device][interval]`. A
    /// missing torque counts as 0; the torques of a device that gives none are ignored.
    ///
    /// # Errors
    ///
    /// Those of [`of`](Self::new).
    ///
    /// # Panics
    ///
    /// `ideal` does not belong to `scene` and has more devices.
    pub fn of_wrenches(
        scene: &WorldScene,
        ideal: &WorldIdeal,
        held: &[Vec<Vector>],
        torques: &[Vec<Vector>],
    ) -> Result<Self, EvaluationError> {
        Self::of_lines(scene, ideal, held, None, torques)
    }

    /// Evaluates lines: forces, the mean of each over its interval, with their `slopes` along the axes of each device
    /// `[N/s]`, as the forces; without slopes, constants. The bound is that of lines or of constants.
    ///
    /// # Errors
    ///
    /// Those of [`of`](Self::new).
    ///
    /// # Panics
    ///
    /// `ideal` does not belong to `scene` and has more devices, or there are fewer slopes than forces.
    pub fn of_lines(
        scene: &WorldScene,
        ideal: &WorldIdeal,
        held: &[Vec<Vector>],
        slopes: Option<&[Vec<Vector>]>,
        torques: &[Vec<Vector>],
    ) -> Result<Self, EvaluationError> {
        if held.len() != ideal.devices.len() {
            return Err(EvaluationError::Devices {
                given: held.len(),
                expected: ideal.devices.len(),
            });
        }
        let mut sum = ErrorSums::default();
        let mut devices = Vec::with_capacity(held.len());
        for (number, (profile, held)) in ideal.devices.iter().zip(held).enumerate() {
            WindowMismatch::unless_equal(held.len(), profile.impulses.len()).map_err(
                |mismatch| EvaluationError::Intervals {
                    device: number,
                    mismatch,
                },
            )?;
            let device = &scene.devices[number];
            let torques = torques.get(number).map_or(&[][..], Vec::as_slice);
            devices.push(DeviceEvaluation::new(
                &ideal.grid,
                device,
                profile,
                [held, torques],
                slopes.map(|slopes| &slopes[number][..]),
                &mut sum,
            ));
        }
        Ok(Self {
            sum: sum.fidelity(ideal.grid.period()),
            devices,
        })
    }
}

impl DeviceEvaluation {
    fn new(
        grid: &Grid,
        device: &WorldDevice,
        profile: &DeviceProfile,
        [held, torques]: [&[Vector]; 2],
        slopes: Option<&[Vector]>,
        sum_of_all: &mut ErrorSums,
    ) -> Self {
        let mass = device.mass;
        let period = grid.period();
        let mut axes = [ErrorSums::default(); 3];
        let mut sum = ErrorSums::default();
        for (interval, force) in held.iter().enumerate() {
            let duration = grid.duration(interval);
            let force = device.own(Vec3(*force)).0;
            for axis in (0..3).filter(|&axis| device.moves_along(axis)) {
                let impulse = profile.impulses[interval][axis];
                let squared = profile.squares[interval][axis];
                let line = slopes.map(|slopes| {
                    let (slope, moment) = (slopes[interval][axis], profile.moments[interval][axis]);
                    move |sums: &mut ErrorSums, root: f64| {
                        sums.add_slope(root * slope, root * moment, duration, period);
                    }
                });
                axes[axis].add(force[axis], impulse, squared, duration, period);
                if let Some(line) = &line {
                    line(&mut axes[axis], 1.0);
                }
                // Forces times the root of the weight: their squares have the weight.
                let root = mass[axis].recip().sqrt();
                for sum in [&mut sum, sum_of_all] {
                    sum.add(
                        root * force[axis],
                        root * impulse,
                        squared / mass[axis],
                        duration,
                        period,
                    );
                    if let Some(line) = &line {
                        line(sum, root);
                    }
                }
            }
        }
        let force = sum.fidelity(period);
        let turning = device.turning.as_ref();
        let torque = turning.filter(|it| it.gives_torque).map(|turning| {
            let weights = turning.mobility();
            reference_torque(grid, weights, profile, torques, [&mut sum, sum_of_all])
        });
        let along_all = axes.iter().map(ErrorSums::ideal).sum();
        let means = profile.mean_forces(grid).into_iter();
        let means: Vec<Vector> = means.map(|own| device.out(Vec3(own)).0).collect();
        let (touches, rendered_touches) = touches(grid, profile, &means, held);
        Self {
            sum: sum.fidelity(period),
            force,
            torque,
            axes: axes.map(|sums| sums.fidelity_beside(period, along_all)),
            touches,
            rendered_touches,
            peak_force: held
                .iter()
                .map(|force| Vec3(*force).norm())
                .fold(0.0, larger),
        }
    }
}

/// Evaluates torques with the weights `weights`, and adds their errors to the sums.
fn reference_torque(
    grid: &Grid,
    weights: Vector,
    profile: &DeviceProfile,
    torques: &[Vector],
    mut sums: [&mut ErrorSums; 2],
) -> TorqueEvaluation {
    let period = grid.period();
    let (mut axes, mut own) = ([ErrorSums::default(); 3], ErrorSums::default());
    let mut peak = 0.0_f64;
    let profiles = profile.torque_impulses.iter().zip(&profile.torque_squares);
    for (interval, (impulse, squared)) in profiles.enumerate() {
        let duration = grid.duration(interval);
        let torque = torques.get(interval).copied().unwrap_or_default();
        peak = larger(peak, Vec3(torque).norm());
        for axis in 0..3 {
            let (impulse, squared) = (impulse[axis], squared[axis]);
            axes[axis].add(torque[axis], impulse, squared, duration, period);
            let weight = weights[axis];
            let root = weight.sqrt();
            let all = sums.iter_mut().map(|sum| &mut **sum).chain([&mut own]);
            for sum in all {
                let (torque, impulse) = (root * torque[axis], root * impulse);
                sum.add(torque, impulse, weight * squared, duration, period);
            }
        }
    }
    let about_all = axes.iter().map(ErrorSums::ideal).sum();
    TorqueEvaluation {
        sum: own.fidelity(period),
        axes: axes.map(|sums| sums.fidelity_beside(period, about_all)),
        peak_torque: peak,
    }
}

/// Returns the larger of two values; infinite if `b` is not finite.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_finite() {
        a.max(b)
    } else {
        f64::INFINITY
    }
}

fn touches(
    grid: &Grid,
    profile: &DeviceProfile,
    means: &[Vector],
    held: &[Vector],
) -> (Vec<ContactEvaluation>, usize) {
    let sizes = |forces: &[Vector]| -> Vec<f64> {
        forces.iter().map(|force| Vec3(*force).norm()).collect()
    };
    let rendered_sizes = sizes(held);
    let ideal_runs = separated(&sizes(means), grid);
    let rendered_runs = separated(&rendered_sizes, grid);
    let impulse_of = |forces: &[Vector], run: &std::ops::Range<usize>| {
        run.clone().fold(Vec3::ZERO, |sum, interval| {
            sum + Vec3(forces[interval]) * grid.duration(interval)
        })
    };
    let touches = ideal_runs
        .iter()
        .enumerate()
        .map(|(number, run)| {
            let ideal_impulse = impulse_of(means, run);
            let ideal_peak = profile.peaks[run.clone()]
                .iter()
                .copied()
                .fold(0.0, f64::max);
            let rendered = rendered_runs.get(number).map(|run| {
                let impulse = impulse_of(held, run);
                let peak = rendered_sizes[run.clone()]
                    .iter()
                    .copied()
                    .fold(0.0, larger);
                let apart = (impulse - ideal_impulse).norm() / ideal_impulse.norm();
                RenderedTouch {
                    start: grid.edge(run.start),
                    impulse: impulse.0,
                    peak,
                    impulse_error: apart.is_finite().then_some(apart),
                    peak_error: relative_error(peak, ideal_peak),
                }
            });
            ContactEvaluation {
                start: grid.edge(run.start),
                end: grid.edge(run.end),
                ideal_impulse: ideal_impulse.0,
                ideal_peak,
                rendered,
            }
        })
        .collect();
    (touches, rendered_runs.len())
}

impl DeviceProfile {
    /// The best that can be held: the mean force on the tool over each interval, along the device's axes `[N]`.
    #[must_use]
    pub fn mean_forces(&self, grid: &Grid) -> Vec<Vector> {
        self.impulses
            .iter()
            .zip(grid.durations())
            .map(|(impulse, duration)| impulse.map(|j| j / duration))
            .collect()
    }
}

/// Evaluation window of a world.
///
/// Undamped contacts ring indefinitely, and the force error becomes a phase error. The window therefore ends with a
/// touch or after a time, whichever comes first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRule {
    /// The window ends half a period after this touch of a tool ends, counted from 1 over all tools; `None` for
    /// no such end.
    pub touches: Option<usize>,
    /// Longest window `[s]`.
    pub longest: f64,
}

impl WindowRule {
    /// The window in whole periods `[s]`, at least one.
    ///
    /// # Errors
    ///
    /// The scene has no ideal, see [`WorldIdeal::new`].
    pub fn intervals(&self, scene: &WorldScene, period: f64) -> Result<usize, WorldError> {
        let longest = whole(self.longest / period);
        let Some(number) = self.touches else {
            return Ok(longest);
        };
        let ideal = WorldIdeal::new(scene, Grid::even(0.0, period, longest))?;
        let mut ends: Vec<f64> = (0..scene.devices.len())
            .flat_map(|device| ideal.touches_of(device))
            .filter_map(|(_, end)| end)
            .collect();
        ends.sort_by(f64::total_cmp);
        Ok(number
            .checked_sub(1)
            .and_then(|index| ends.get(index))
            .map_or(longest, |end| {
                whole(((end + 0.5 * period) / period).ceil()).min(longest)
            }))
    }
}

/// Converts to a whole number of periods, at least one; a rounding error just below a whole number is compensated.
fn whole(periods: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of u32"
    )]
    let whole = (periods * (1.0 + 1e-12)).clamp(1.0, f64::from(u32::MAX)) as usize;
    whole
}

impl WorldIdeal {
    /// Returns start and end of each contact with the tool of a device `[s]`; the end is `None` if it is beyond the
    /// window.
    #[must_use]
    pub fn touches_of(&self, device: usize) -> Vec<(f64, Option<f64>)> {
        let mut touches: Vec<(f64, Option<f64>)> = Vec::new();
        for encounter in &self.encounters {
            if !encounter.between.contains(&Member::Device(device)) {
                continue;
            }
            match touches.last_mut() {
                // Encounters are ordered by their start, so an overlapping one extends the last.
                Some((_, last)) if last.is_none_or(|last| encounter.start <= last) => {
                    *last = match (*last, encounter.end) {
                        (Some(a), Some(b)) => Some(a.max(b)),
                        _ => None,
                    };
                }
                _ => touches.push((encounter.start, encounter.end)),
            }
        }
        touches
    }
}

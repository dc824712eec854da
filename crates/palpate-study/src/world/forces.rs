//! Forces and positions of a world's devices over time, beside those of the ideal: as series and as CSV.

use std::io::Write;
use std::ops::Range;

use crate::sim::world::{WorldBench, WorldRun};
use palpate_scene::world::WorldScene;
use palpate_testbed::world::WorldIdeal;
use palpate_world::{Tool, Vector};

/// The times between the samples of a run: the intervals of the ideal's grid that begin in each.
pub struct Periods<'a> {
    scene: &'a WorldScene,
    ideal: &'a WorldIdeal,
    intervals: Vec<Range<usize>>,
}

impl<'a> Periods<'a> {
    /// Finds the periods of the loop in the ideal's grid.
    #[must_use]
    pub fn new(scene: &'a WorldScene, bench: &'a WorldBench) -> Self {
        let (ideal, samples) = (bench.ideal(), bench.samples());
        let grid = &ideal.grid;
        // Edges are at samples only to rounding.
        let near = 1e-6 * grid.period();
        let edges: Vec<f64> = (0..grid.intervals()).map(|at| grid.edge(at)).collect();
        let first_from = |time: f64| edges.partition_point(|edge| *edge < time - near);
        let ends = samples.iter().skip(1).map(|next| first_from(next.time));
        let mut first = 0;
        let intervals = ends.chain([grid.intervals()]).map(|end| {
            let before = first;
            first = end;
            before..end
        });
        let intervals = intervals.collect();
        Self {
            scene,
            ideal,
            intervals,
        }
    }

    /// Returns the intervals of the grid in the period of a sample; `None` beyond the window.
    fn of(&self, sample: usize) -> Option<Range<usize>> {
        let intervals = self.intervals.get(sample)?.clone();
        (!intervals.is_empty()).then_some(intervals)
    }

    /// Returns the sum of impulses over a period, over its duration.
    fn mean(&self, sample: usize, impulse: impl Fn(usize) -> Vector) -> Option<Vector> {
        let intervals = self.of(sample)?;
        let grid = &self.ideal.grid;
        let duration = grid.edge(intervals.end) - grid.edge(intervals.start);
        let mut sum = [0.0; 3];
        for interval in intervals {
            for (sum, part) in sum.iter_mut().zip(impulse(interval)) {
                *sum += part;
            }
        }
        Some(sum.map(|sum| sum / duration))
    }

    /// Returns the mean over a period of a value that is given for each interval.
    fn mean_held(&self, sample: usize, held: Option<&Vec<Vector>>) -> Option<Vector> {
        let held = held?;
        self.mean(sample, |interval| {
            let duration = self.ideal.grid.duration(interval);
            let value = held.get(interval).copied().unwrap_or_default();
            value.map(|part| part * duration)
        })
    }

    /// Returns the mean force of the actuator on a device over the period of a sample `[N]`.
    #[must_use]
    pub fn force(&self, run: &WorldRun, sample: usize, device: usize) -> Option<Vector> {
        self.mean_held(sample, run.delivered.get(device))
    }

    /// Returns the mean force of the ideal on a device over the period of a sample `[N]`.
    #[must_use]
    pub fn ideal_force(&self, sample: usize, device: usize) -> Option<Vector> {
        let impulses = &self.ideal.devices[device].impulses;
        let own = self.mean(sample, |interval| impulses[interval])?;
        Some(self.scene.devices[device].out(own))
    }

    /// Returns the mean torque of the ideal on a device over the period of a sample `[N m]`; `None` for a device that
    /// does not turn.
    #[must_use]
    pub fn ideal_torque(&self, sample: usize, device: usize) -> Option<Vector> {
        let impulses = &self.ideal.devices[device].torque_impulses;
        if impulses.is_empty() {
            return None;
        }
        self.mean(sample, |interval| impulses[interval])
    }

    /// Returns the position of a device of the ideal at a sample `[m]`.
    #[must_use]
    pub fn ideal_position(&self, sample: usize, device: usize) -> Option<Vector> {
        let first = self.of(sample)?.start;
        Some(self.ideal.states.get(first)?.devices[device].position)
    }

    /// Returns the number of contacts of the ideal at a sample.
    #[must_use]
    pub fn ideal_contacts(&self, sample: usize) -> Option<usize> {
        let first = self.of(sample)?.start;
        let contacts = self.ideal.states.get(first)?.contacts.iter();
        Some(contacts.filter(|contact| contact.penetration > 0.0).count())
    }

    /// Returns the deepest penetration of the ideal's contacts at a sample `[m]`; 0 without contact.
    #[must_use]
    pub fn ideal_penetration(&self, sample: usize) -> Option<f64> {
        let first = self.of(sample)?.start;
        let contacts = self.ideal.states.get(first)?.contacts.iter();
        Some(
            contacts
                .map(|contact| contact.penetration)
                .fold(0.0, f64::max),
        )
    }
}

/// Writes a row per method, sample and device: its position and the commanded force, also the slope of that force if
/// commands are lines, its orientation if it rotates, and its torque if it has one; then the mean force over the period
/// from the sample, of its actuator and of the ideal, the ideal's position at the sample, and the ideal's mean torque.
/// Cells beyond the ideal's window are empty.
///
/// # Errors
/// The writer fails.
pub fn write(
    writer: &mut dyn Write,
    scene: &WorldScene,
    bench: &WorldBench,
    runs: &[WorldRun],
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let turns = scene.devices.iter().any(|device| device.turning.is_some());
    let mut header = vec![
        "method", "device", "t_s", "x_m", "y_m", "z_m", "fx_n", "fy_n", "fz_n",
    ];
    let holds_lines = !scene.render.actuation.hold.is_constant();
    if holds_lines {
        header.extend(["slope_x_n_per_s", "slope_y_n_per_s", "slope_z_n_per_s"]);
    }
    if turns {
        header.extend(["qw", "qx", "qy", "qz"]);
    }
    let gives_torque = scene.world.tools.iter().any(Tool::feels_torque);
    if gives_torque {
        header.extend(["tx_n_m", "ty_n_m", "tz_n_m"]);
    }
    header.extend(["mean_fx_n", "mean_fy_n", "mean_fz_n"]);
    header.extend(["ideal_fx_n", "ideal_fy_n", "ideal_fz_n"]);
    header.extend(["ideal_x_m", "ideal_y_m", "ideal_z_m"]);
    if gives_torque {
        header.extend(["ideal_tx_n_m", "ideal_ty_n_m", "ideal_tz_n_m"]);
    }
    csv.write_record(header)?;
    let periods = Periods::new(scene, bench);
    for run in runs {
        for (sample, positions) in run.positions.iter().enumerate() {
            let time = bench.samples()[sample].time;
            for (device, (tool, position)) in scene.world.tools.iter().zip(positions).enumerate() {
                let forces = &run.commanded[sample][device];
                let mut row = vec![run.method.clone(), tool.name.clone(), time.to_string()];
                row.extend(position.iter().chain(forces).map(ToString::to_string));
                if holds_lines {
                    let slopes = &run.commanded_slopes[sample][device];
                    row.extend(slopes.iter().map(ToString::to_string));
                }
                if turns {
                    let orientation = &run.orientations[sample][device];
                    row.extend(orientation.iter().map(ToString::to_string));
                }
                if gives_torque {
                    let torques = &run.commanded_torques[sample][device];
                    row.extend(torques.iter().map(ToString::to_string));
                }
                let mut further = vec![
                    periods.force(run, sample, device),
                    periods.ideal_force(sample, device),
                    periods.ideal_position(sample, device),
                ];
                if gives_torque {
                    further.push(periods.ideal_torque(sample, device));
                }
                row.extend(further.into_iter().flat_map(|vector| {
                    let text =
                        |axis: usize| vector.map_or_else(String::new, |it| it[axis].to_string());
                    [0, 1, 2].map(text)
                }));
                csv.write_record(row)?;
            }
        }
    }
    csv.flush()
}

//! How fast device and object part after a collision, whatever the device.

use crate::metrics::WindowMismatch;
use crate::metrics::collisions::{ideal_collisions, least_push, parted, relative_error, separated};
use crate::profile::{ForceProfile, Snapshot};

/// The speeds at which device and object part after a collision, ideal and rendered.
///
/// Unlike a rebound's [energy](crate::metrics::Rebound) this asks nothing of the device: friction
/// and the hand are in the ideal's speed as they are in the rendered one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReboundSpeed {
    /// Speed at the end of the ideal collision `[m/s]`.
    pub ideal: f64,
    /// Speed of the rendered one `[m/s]`; `None` if there was no rendered collision of this number,
    /// or device and object had not parted by the next one or by the window's end.
    ///
    /// Samples see them part late by up to a period, in which gravity and the hand have changed the
    /// speed. So it is carried back to where they touched: with the gap −p and the relative velocity
    /// v at the first sample out of contact, and the relative acceleration a of the free interval
    /// nearest to it, those after it first, the speed is √(v² − 2 a p).
    pub rendered: Option<f64>,
    /// (rendered − ideal)/ideal; `None` if that is not a finite number.
    pub error: Option<f64>,
}

impl ReboundSpeed {
    /// The rebound after each ideal collision that ends within the window, from the record of a
    /// perfect closed loop as for [`EnergyEvaluation`](crate::metrics::EnergyEvaluation::new).
    ///
    /// # Errors
    ///
    /// `record` does not have one entry more than `profile` has intervals.
    pub fn new(profile: &ForceProfile, record: &[Snapshot]) -> Result<Vec<Self>, WindowMismatch> {
        let window = profile.intervals();
        WindowMismatch::unless_equal(record.len(), window + 1)?;
        let held: Vec<f64> = record[..window]
            .iter()
            .map(|snapshot| snapshot.force_on_object)
            .collect();
        Self::sampled(profile, &held, record)
    }

    /// The same of a loop by the force it `held` over each interval `[N]` and the `record` of its
    /// states at the samples, as for [`EnergyEvaluation`](crate::metrics::EnergyEvaluation::sampled).
    ///
    /// # Errors
    ///
    /// `held` does not have one force for each interval of `profile`, or `record` no entry.
    pub fn sampled(
        profile: &ForceProfile,
        held: &[f64],
        record: &[Snapshot],
    ) -> Result<Vec<Self>, WindowMismatch> {
        WindowMismatch::unless_equal(held.len(), profile.intervals())?;
        WindowMismatch::unless_equal(record.len().min(1), 1)?;
        let runs = separated(held, profile.grid());
        Ok(ideal_collisions(profile)
            .into_iter()
            .filter_map(|collision| collision.release_speed)
            .enumerate()
            .map(|(number, ideal)| {
                let rendered = (number < runs.len())
                    .then(|| parted(record, held, profile.grid(), &runs, number))
                    .and_then(|(sample, until)| {
                        Some(parting_speed(
                            record,
                            sample?,
                            until,
                            least_push(held, &runs[number]),
                        ))
                    })
                    .filter(|speed| speed.is_finite());
                Self {
                    ideal,
                    rendered,
                    error: rendered.and_then(|speed| relative_error(speed, ideal)),
                }
            })
            .collect())
    }
}

/// Returns the speed `[m/s]` at which device and object parted before `sample`, the first sample out of contact. The
/// next collision begins at `until`. A force below `least` `[N]` counts as zero.
fn parting_speed(record: &[Snapshot], sample: usize, until: usize, least: f64) -> f64 {
    let velocity = |at: &Snapshot| at.device_velocity - at.object_velocity;
    let is_free = |&i: &usize| {
        let (begin, end) = (&record[i], &record[i + 1]);
        begin.force_on_object.abs() <= least
            && begin.penetration() <= 0.0
            && end.penetration() <= 0.0
    };
    let mut near = (sample..until).chain((0..sample).rev());
    let acceleration = near.find(is_free).map_or(0.0, |i| {
        let (begin, end) = (&record[i], &record[i + 1]);
        (velocity(end) - velocity(begin)) / (end.time - begin.time)
    });
    let here = &record[sample];
    (velocity(here).powi(2) - 2.0 * acceleration * here.penetration())
        .max(0.0)
        .sqrt()
}

//! Errors of energy in a closed loop.

use crate::ideal::Ideal;
use crate::metrics::WindowMismatch;
use crate::metrics::collisions::{ideal_collisions, parted, separated};
use crate::profile::{Collision, ForceProfile, Snapshot};

/// Energy rise above the start, in impact energies, at which a loop counts as diverged. With the initial impact energy
/// the total is ten.
const DIVERGED_ABOVE: f64 = 9.0;

/// The energy with which device and object part after a collision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rebound {
    /// Energy at the first sample out of contact after the rendered collision, less the energy at
    /// the start, over the ideal's kinetic energy at the impact of the same number.
    ///
    /// 0 for an ideal rebound, −1 for none, positive if the collision has generated energy.
    EnergyError(f64),
    /// There was no rendered collision of this number.
    NotRendered,
    /// Device and object had not parted at any sample up to the next rendered collision or the end
    /// of the window.
    NotReleased,
    /// The ratio is not a finite number: the ideal collision began without speed, or the loop
    /// diverged.
    Undefined,
}

/// Effect of a closed loop on the energy of device and object.
///
/// The energy H is that of [`Ideal::energy`], which includes the work of the user's and the virtual force, so only the
/// rendering can change it. All ratios except those of the rebounds refer to the impact energy of the first ideal
/// collision. If that collision begins at zero speed, they refer to the spring energy K p²/2 at its peak.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyEvaluation {
    /// The rebound after each ideal collision that ends within the window.
    pub rebounds: Vec<Rebound>,
    /// (H at the window's end − H at its start)/reference, the spring's energy included in both.
    ///
    /// `None` if the ideal has no contact in the window or the ratio is not a finite number.
    pub energy_drift: Option<f64>,
    /// Whether anything in the record is not finite or, at any sample, H exceeds its start by more
    /// than 9 references.
    ///
    /// The reference is what the relative motion brings to the surface in the first place, so this
    /// asks whether that has grown tenfold. Without an ideal contact there is no reference, and only
    /// what is not finite counts.
    pub diverged: bool,
}

impl EnergyEvaluation {
    /// Evaluates the record of a perfect closed loop: the states at all samples 0 to W of a window of W intervals, each
    /// with the force held from that sample on. The force of the last sample is ignored.
    ///
    /// # Errors
    ///
    /// `record` does not have one entry more than `profile` has intervals.
    pub fn new(
        ideal: &Ideal,
        profile: &ForceProfile,
        record: &[Snapshot],
    ) -> Result<Self, WindowMismatch> {
        let window = profile.intervals();
        WindowMismatch::unless_equal(record.len(), window + 1)?;
        let held: Vec<f64> = record[..window]
            .iter()
            .map(|snapshot| snapshot.force_on_object)
            .collect();
        Self::sampled(ideal, profile, &held, record)
    }

    /// Evaluates a closed loop from the force `held` over each interval `[N]` and the `record` of its states at the
    /// samples, from the first one to the one at the window's end. Samples need not coincide with the changes of the
    /// held force.
    ///
    /// # Errors
    ///
    /// `held` does not have one force for each interval of `profile`, or `record` no entry.
    pub fn sampled(
        ideal: &Ideal,
        profile: &ForceProfile,
        held: &[f64],
        record: &[Snapshot],
    ) -> Result<Self, WindowMismatch> {
        WindowMismatch::unless_equal(held.len(), profile.intervals())?;
        WindowMismatch::unless_equal(record.len().min(1), 1)?;
        let last = record.len() - 1;
        let at_start = ideal.energy(&record[0]);
        let reference = profile
            .collisions()
            .first()
            .map(|collision| reference_energy(ideal, collision))
            .filter(|&energy| energy > 0.0);
        let gain = |snapshot: &Snapshot| ideal.energy(snapshot) - at_start;
        let finite = record[..last].iter().all(Snapshot::is_finite)
            && record.iter().all(|snapshot| gain(snapshot).is_finite());
        Ok(Self {
            rebounds: rebounds(ideal, profile, held, record),
            energy_drift: reference
                .map(|reference| gain(&record[last]) / reference)
                .filter(|drift| drift.is_finite()),
            diverged: !finite
                || reference.is_some_and(|reference| {
                    record
                        .iter()
                        .any(|snapshot| gain(snapshot) > DIVERGED_ABOVE * reference)
                }),
        })
    }
}

/// Impact energy of a collision, or that of its spring at the peak if it begins without speed.
fn reference_energy(ideal: &Ideal, collision: &Collision) -> f64 {
    let impact = ideal.impact_energy(collision);
    if impact > 0.0 {
        impact
    } else {
        0.5 * collision.peak_force * collision.peak_force / ideal.scene().stiffness
    }
}

fn rebounds(
    ideal: &Ideal,
    profile: &ForceProfile,
    held: &[f64],
    record: &[Snapshot],
) -> Vec<Rebound> {
    let runs = separated(held, profile.grid());
    ideal_collisions(profile)
        .iter()
        .enumerate()
        .map(|(number, collision)| {
            if number >= runs.len() {
                return Rebound::NotRendered;
            }
            let (Some(sample), _) = parted(record, held, profile.grid(), &runs, number) else {
                return Rebound::NotReleased;
            };
            let gain = ideal.energy_without_spring(&record[sample]) - ideal.energy(&record[0]);
            let error = gain / ideal.impact_energy(collision);
            if error.is_finite() {
                Rebound::EnergyError(error)
            } else {
                Rebound::Undefined
            }
        })
        .collect()
}

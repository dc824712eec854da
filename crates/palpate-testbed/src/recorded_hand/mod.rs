//! The hand of a recording: the force that it must have had on the device.

use crate::InvalidParameter;
use crate::recorded_path::{PathError, RecordedPath, to_nanoseconds};

mod device;
mod smoother;

pub use device::HeldByRecording;
use smoother::{MeasuredTrajectory, Smoothed};

/// Fewest samples from which a force can be estimated.
const FEWEST_SAMPLES: usize = 8;

/// A position is never taken to be known better than this `[m]`.
const MIN_NOISE: f64 = 1e-9;

/// Recorded motion and motor forces of a device in a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording<'a> {
    /// Times `[s]`, increasing; steps need not be even.
    pub times: &'a [f64],
    /// Positions of the device `[m]`, NaN where none was measured; at both ends one was.
    pub positions: &'a [f64],
    /// Force on the device, held by its motor from each sample to the next `[N]`, whether a position
    /// was measured there or not; `None` if it was off.
    pub forces_on_device: Option<&'a [f64]>,
}

/// The device of a recording, and how its hand is to be understood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandModel {
    /// Mass that the force of motor and hand moved `[kg]`.
    pub device_mass: f64,
    /// Quantum of the position sensor, 0 if it is not known to have one `[m]`.
    pub encoder_quantum: f64,
    /// Bandwidth of the hand's force `[Hz]`; `None` takes the one under which the recording is most
    /// likely.
    pub bandwidth: Option<f64>,
    /// Stiffness of the hand about its recorded motion `[N/m]`; with 0 the hand applies the recorded force at any
    /// position of the device.
    pub stiffness: f64,
    /// Damping of the hand about its recorded motion `[N s/m]`.
    pub damping: f64,
}

impl HandModel {
    /// Stiffness of an unknown hand `[N/m]`: about the middle, by ratio, of the 10 to 300 N/m of the random plants'
    /// hands.
    pub const USUAL_STIFFNESS: f64 = 60.0;

    /// Damping of an unknown hand `[N s/m]`: about the middle, by ratio, of the random plants' 0.5 to 5 N s/m.
    pub const USUAL_DAMPING: f64 = 2.0;

    /// A hand on a device of this mass `[kg]` that holds on to its recorded motion as hands usually do.
    #[must_use]
    pub fn holding_on(device_mass: f64) -> Self {
        Self {
            stiffness: Self::USUAL_STIFFNESS,
            damping: Self::USUAL_DAMPING,
            ..Self::force_on(device_mass)
        }
    }

    /// Creates a hand that applies the recorded force at any position of the device of this mass `[kg]`.
    #[must_use]
    pub fn force_on(device_mass: f64) -> Self {
        Self {
            device_mass,
            encoder_quantum: 0.0,
            bandwidth: None,
            stiffness: 0.0,
            damping: 0.0,
        }
    }

    fn check(&self) -> Result<(), InvalidParameter> {
        let refused = |name, value, allowed| {
            Err(InvalidParameter {
                name,
                value,
                allowed,
            })
        };
        let above_zero = "finite and greater than 0";
        let mass = self.device_mass;
        if !(mass.is_finite() && mass > 0.0) {
            return refused("device_mass", mass, above_zero);
        }
        for (name, value) in [
            ("encoder_quantum", self.encoder_quantum),
            ("hand_stiffness", self.stiffness),
            ("hand_damping", self.damping),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return refused(name, value, "finite and not below 0");
            }
        }
        match self.bandwidth {
            Some(bandwidth) if !(bandwidth.is_finite() && bandwidth > 0.0) => {
                refused("hand_bandwidth", bandwidth, above_zero)
            }
            _ => Ok(()),
        }
    }
}

/// Uncertainty of the force of a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandUncertainty {
    /// Bandwidth of the estimate `[Hz]`: what the hand did faster than this is not in it.
    pub bandwidth: f64,
    /// Standard deviation of a recorded position, as the recording shows it `[m]`.
    pub position_noise: f64,
    /// Standard deviation of the force, root mean square over the recording `[N]`.
    pub force_deviation: f64,
    /// The force itself, root mean square `[N]`.
    pub force: f64,
    /// Largest distance between the recorded positions and those of a device that the estimated and the recorded force
    /// move from its start to the end of the recording `[m]`.
    pub given_back_within: f64,
}

/// Reason for a failed estimate of the hand.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HandError {
    /// The recording is not a valid motion.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A value of the model is out of range.
    #[error(transparent)]
    Model(#[from] InvalidParameter),
    /// Not as many forces as positions.
    #[error("the recording has {positions} positions but {forces} forces")]
    UnequalLengths {
        /// Positions.
        positions: usize,
        /// Forces.
        forces: usize,
    },
    /// A force is not a finite number.
    #[error("the force of sample {index} is {value} N, but must be finite")]
    ForceNotFinite {
        /// Index of the sample.
        index: usize,
        /// The force `[N]`.
        value: f64,
    },
    /// Too few samples.
    #[error("the force of a hand needs at least {FEWEST_SAMPLES} samples with a position, not {0}")]
    TooFewSamples(usize),
    /// The recording is shorter than a period.
    #[error("the recording lasts {} s, less than one period of {period} s", to_nanoseconds(*recorded))]
    TooShort {
        /// Length of the recording `[s]`.
        recorded: f64,
        /// Period of the loop `[s]`.
        period: f64,
    },
    /// The estimate overflows.
    #[error("the force of the hand is not a finite number: a position or a force is too large")]
    Overflow,
}

/// The force of a hand at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandForce {
    /// Time since the first sample `[s]`.
    pub time: f64,
    /// Force of the hand on the device `[N]`, friction of the device included.
    pub force: f64,
    /// Its standard deviation `[N]`.
    pub deviation: f64,
}

/// The hand of a recording, and the motion in which it was recorded.
///
/// Between two samples the hand's force is a straight line and the recorded one is held, so the motion
/// is a cubic in closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedHand {
    model: HandModel,
    /// Since the first sample `[s]`.
    times: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    /// Due to the hand `[m/s²]`.
    accelerations: Vec<f64>,
    /// Their standard deviations `[m/s²]`.
    deviations: Vec<f64>,
    /// Due to the recorded force, held from each sample on `[m/s²]`.
    held: Vec<f64>,
    /// Samples without a position.
    unmeasured: usize,
    uncertainty: HandUncertainty,
}

impl RecordedHand {
    /// Estimates the hand's force from all samples of `recording` at once.
    ///
    /// # Errors
    /// The recording is not a valid motion, has too few samples, or has a different number of forces than positions; or
    /// a model value is out of range.
    pub fn estimate(recording: &Recording, model: &HandModel) -> Result<Self, HandError> {
        model.check()?;
        let path = RecordedPath::new(recording.times, &bridged(recording.positions))?;
        let samples = recording.times.len();
        let unmeasured = recording.positions.iter().filter(|x| x.is_nan()).count();
        if samples - unmeasured < FEWEST_SAMPLES {
            return Err(HandError::TooFewSamples(samples - unmeasured));
        }
        let times: Vec<f64> = path.times().iter().map(|t| t - path.start()).collect();
        let held = held_accelerations(recording, model.device_mass)?;
        let motion = MeasuredTrajectory {
            times: &times,
            positions: recording.positions,
            known: &held,
            // Evenly spread within the quantum.
            least_noise: (model.encoder_quantum / 12.0_f64.sqrt()).max(MIN_NOISE),
        };
        let Smoothed {
            states,
            deviations,
            noise,
            bandwidth,
        } = motion.smoothed(
            model
                .bandwidth
                .unwrap_or_else(|| motion.likeliest_bandwidth()),
        );
        let of = |from: &[[f64; 3]], which: usize| from.iter().map(|one| one[which]).collect();
        let mut hand = Self {
            model: *model,
            positions: of(&states, 0),
            velocities: of(&states, 1),
            accelerations: of(&states, 2),
            deviations: of(&deviations, 2),
            times,
            held,
            unmeasured,
            uncertainty: HandUncertainty {
                bandwidth,
                position_noise: noise,
                force_deviation: 0.0,
                force: 0.0,
                given_back_within: 0.0,
            },
        };
        let mean_square = |values: &[f64]| {
            let sum: f64 = values.iter().map(|value| value * value).sum();
            model.device_mass * (sum / samples as f64).sqrt()
        };
        hand.uncertainty.force = mean_square(&hand.accelerations);
        hand.uncertainty.force_deviation = mean_square(&hand.deviations);
        hand.uncertainty.given_back_within = hand.given_back_within(recording.positions);
        let found = &hand.uncertainty;
        let sound = [found.force, found.force_deviation, found.given_back_within];
        if !(sound.into_iter().all(f64::is_finite)) {
            return Err(HandError::Overflow);
        }
        Ok(hand)
    }

    /// Returns the uncertainty of the force.
    #[must_use]
    pub fn uncertainty(&self) -> &HandUncertainty {
        &self.uncertainty
    }

    /// The device, and how the hand holds it.
    #[must_use]
    pub fn model(&self) -> &HandModel {
        &self.model
    }

    /// Samples that had no position: there the force follows from those around them, and is known less
    /// well.
    #[must_use]
    pub fn unmeasured(&self) -> usize {
        self.unmeasured
    }

    /// Returns the range of the recorded motion, from its least to its greatest position `[m]`.
    #[must_use]
    pub fn span(&self) -> f64 {
        let positions = self.positions.iter().copied();
        let (least, greatest) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), |ends, x| {
            (ends.0.min(x), ends.1.max(x))
        });
        greatest - least
    }

    /// Returns the sample times, relative to the first `[s]`.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Length of the recording `[s]`.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// The force of the hand at every sample.
    pub fn forces(&self) -> impl Iterator<Item = HandForce> + '_ {
        let mass = self.model.device_mass;
        let of = self.accelerations.iter().zip(&self.deviations);
        self.times
            .iter()
            .zip(of)
            .map(move |(&time, (acceleration, deviation))| HandForce {
                time,
                force: mass * acceleration,
                deviation: mass * deviation,
            })
    }

    /// The recorded motion without its noise at `time` since the first sample `[s]`: position `[m]`
    /// and velocity `[m/s]`.
    #[must_use]
    pub fn motion(&self, time: f64) -> (f64, f64) {
        let piece = self.piece(time);
        let (position, velocity, _) = self.along(piece, time - self.times[piece]);
        (position, velocity)
    }

    /// Step between the last two samples `[s]`.
    #[must_use]
    pub fn last_step(&self) -> f64 {
        self.duration() - self.times[self.times.len() - 2]
    }

    /// Returns the time of sample `piece` `[s]`.
    pub(super) fn start_of(&self, piece: usize) -> f64 {
        self.times[piece]
    }

    /// Force that was recorded on the device from sample `piece` on `[N]`.
    pub(super) fn held_force(&self, piece: usize) -> f64 {
        self.model.device_mass * self.held[piece]
    }

    /// Returns the end of the interval that begins with sample `piece` `[s]`; infinite for the last.
    pub(super) fn end_of(&self, piece: usize) -> f64 {
        match self.times.get(piece + 1) {
            Some(end) if piece + 2 < self.times.len() => *end,
            _ => f64::INFINITY,
        }
    }

    /// Position `[m]`, velocity `[m/s]` and the hand's acceleration `[m/s²]`, `after` sample `piece`
    /// `[s]`.
    pub(super) fn along(&self, piece: usize, after: f64) -> (f64, f64, f64) {
        let jerk = self.jerk(piece);
        let from = (self.positions[piece], self.velocities[piece]);
        moved(
            from,
            self.accelerations[piece],
            jerk,
            self.held[piece],
            after,
        )
    }

    fn jerk(&self, piece: usize) -> f64 {
        (self.accelerations[piece + 1] - self.accelerations[piece])
            / (self.times[piece + 1] - self.times[piece])
    }

    fn piece(&self, time: f64) -> usize {
        let after = self.times.partition_point(|&sample| sample <= time);
        after.clamp(1, self.times.len() - 1) - 1
    }

    /// Moves a device from the first state to the end by the forces alone, and returns its largest distance from
    /// `recorded` `[m]`.
    fn given_back_within(&self, recorded: &[f64]) -> f64 {
        let mut state = (self.positions[0], self.velocities[0]);
        let mut farthest = (state.0 - recorded[0]).abs();
        for piece in 0..self.times.len() - 1 {
            let step = self.times[piece + 1] - self.times[piece];
            let (position, velocity, _) = moved(
                state,
                self.accelerations[piece],
                self.jerk(piece),
                self.held[piece],
                step,
            );
            state = (position, velocity);
            // A NaN position is skipped: `max` ignores NaN.
            farthest = farthest.max((position - recorded[piece + 1]).abs());
        }
        farthest
    }
}

/// Positions with the last one that was measured where none was, to check the others by; a first or last
/// one that is missing stays so.
fn bridged(positions: &[f64]) -> Vec<f64> {
    let mut last = f64::NAN;
    let between = positions.iter().enumerate().map(|(index, &position)| {
        if !position.is_nan() || index + 1 == positions.len() {
            last = position;
        }
        last
    });
    between.collect()
}

/// Returns position, velocity and acceleration after a time `after` `[s]` with a constant jerk and an additional held
/// acceleration.
fn moved(
    (position, velocity): (f64, f64),
    acceleration: f64,
    jerk: f64,
    held: f64,
    after: f64,
) -> (f64, f64, f64) {
    let all = acceleration + held;
    (
        position + after * (velocity + after * (0.5 * all + after * jerk / 6.0)),
        velocity + after * (all + 0.5 * after * jerk),
        acceleration + after * jerk,
    )
}

fn held_accelerations(recording: &Recording, mass: f64) -> Result<Vec<f64>, HandError> {
    let positions = recording.positions.len();
    let Some(forces) = recording.forces_on_device else {
        return Ok(vec![0.0; positions]);
    };
    if forces.len() != positions {
        return Err(HandError::UnequalLengths {
            positions,
            forces: forces.len(),
        });
    }
    if let Some(index) = forces.iter().position(|force| !force.is_finite()) {
        return Err(HandError::ForceNotFinite {
            index,
            value: forces[index],
        });
    }
    Ok(forces.iter().map(|force| force / mass).collect())
}

//! Motor gain from a source other than the motion.

use crate::calibrate::{Calibration, Known};

/// Source of the gain.
#[derive(Debug, Clone, Copy)]
pub enum GainFrom<'a> {
    /// Measured gain: force of the motor over the command.
    Given(f64),
    /// Stiffness of a spring `[N/m]` that the device was fixed to, without a hand.
    Spring(f64),
    /// Mass `[kg]` that was fixed to the device after this calibration, without a hand.
    AddedMass(f64, &'a Calibration),
}

/// The gain is too uncertain.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the gain is not known to 20 % from {0}: the measured change is too small")]
pub struct GainUnknown(&'static str);

impl GainFrom<'_> {
    /// Returns the motor gain of a device with the calibration `found`.
    ///
    /// # Errors
    /// The gain is not known to 20 %.
    pub fn gain(&self, found: &Calibration) -> Result<Known, GainUnknown> {
        match *self {
            Self::Given(gain) => Ok(Known::given(gain, "given")),
            Self::Spring(stiffness) => {
                let gain = found.gain_by_spring(stiffness);
                gain.ok_or(GainUnknown("the spring"))
            }
            Self::AddedMass(mass, before) => {
                let gain = found.gain_by_added_mass(before, mass);
                gain.ok_or(GainUnknown("the added mass"))
            }
        }
    }
}

//! The gain of the motor, where something beside the motion says it.

use palpate_calibrate::{Calibration, Known};

/// What says the gain.
#[derive(Debug, Clone, Copy)]
pub enum GainFrom<'a> {
    /// It was measured: force of the motor over the command.
    Given(f64),
    /// A spring of this stiffness `[N/m]` that the device was fixed to, with no hand on it.
    Spring(f64),
    /// A mass `[kg]` that was fixed to the device after this calibration, with no hand on it.
    AddedMass(f64, &'a Calibration),
}

/// The gain is not known well enough to be said.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the gain is not known to 20 % from {0}: it was found to change too little")]
pub struct GainUnknown(&'static str);

impl GainFrom<'_> {
    /// The gain of the motor of a device of which this was `found`.
    ///
    /// # Errors
    /// It is known to less than 20 %.
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

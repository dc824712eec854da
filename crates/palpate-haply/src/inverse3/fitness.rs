//! Whether a device may be commanded, and what to do if not.

use super::frame::{DeviceFrame, Model, Status};

/// Why a device is not commanded a force, with what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// Its motors have no power.
    #[error("its motors have no power: plug in its power supply")]
    NoPower,
    /// The service does not talk to it.
    #[error("the service has not started it: wait until its light is steady, or plug it in again")]
    NotStarted,
    /// It does not know where its arms are.
    #[error("it is not calibrated: put its arms into the calibration pose and wait for its light")]
    NotCalibrated,
    /// It takes no commands.
    #[error("it is not ready: wait until its light is steady, or restart the service")]
    NotReady,
    /// Somebody else commands it, and forces of two programs add up.
    #[error("another program commands it: end that one first")]
    InUse,
    /// Not a device whose limits are known here.
    #[error("it is no Inverse3, and its limits are not known here")]
    OtherModel,
}

impl Unfit {
    /// Why not, if so, from what is said in every frame.
    #[must_use]
    pub fn of(status: &Status) -> Option<Self> {
        let no = Some(false);
        [
            (status.power_supply == no, Self::NoPower),
            (status.started == no, Self::NotStarted),
            (status.calibrated == no, Self::NotCalibrated),
            (status.ready == no, Self::NotReady),
        ]
        .into_iter()
        .find_map(|(holds, unfit)| holds.then_some(unfit))
    }

    /// Why not, if so, from the first frame: nothing has been commanded yet, and so whoever uses the
    /// device is somebody else.
    #[must_use]
    pub fn at_first(device: &DeviceFrame) -> Option<Self> {
        let known = matches!(
            device.model(),
            None | Some(Model::Inverse3 | Model::Inverse3x)
        );
        (!known)
            .then_some(Self::OtherModel)
            .or(Self::of(&device.status))
            .or((device.status.in_use == Some(true)).then_some(Self::InUse))
    }

    /// In words that need no memory, for the loop.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NoPower => "the Inverse3 lost the power of its motors",
            Self::NotStarted => "the service no longer talks to the Inverse3",
            Self::NotCalibrated => "the Inverse3 is no longer calibrated",
            Self::NotReady => "the Inverse3 is no longer ready",
            Self::InUse => "another program commands the Inverse3",
            Self::OtherModel => "the device is no Inverse3",
        }
    }
}

//! Readiness of a device for commands, and the remedy otherwise.

use super::frame::{DeviceFrame, Model, Status};

/// Reason why a device cannot be commanded, with the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// The motors have no power.
    #[error("its motors have no power: plug in its power supply")]
    NoPower,
    /// The service has not started the device.
    #[error("the service has not started it: wait until its light is steady, or plug it in again")]
    NotStarted,
    /// The position of the arms is not calibrated.
    #[error("it is not calibrated: put its arms into the calibration pose and wait for its light")]
    NotCalibrated,
    /// The device accepts no commands.
    #[error("it is not ready: wait until its light is steady, or restart the service")]
    NotReady,
    /// Another program commands the device, and forces of two programs add up.
    #[error("another program commands it: end that program first")]
    InUse,
    /// A device model with unknown limits.
    #[error("it is not an Inverse3; its limits are unknown")]
    OtherModel,
}

impl Unfit {
    /// Returns the reason by the status in every frame, or `None` if the device is ready.
    #[must_use]
    pub fn new(status: &Status) -> Option<Self> {
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

    /// Returns the reason by the first frame, or `None` if the device is ready. This program has sent no command yet,
    /// so a device in use is used by another program.
    #[must_use]
    pub fn at_first(device: &DeviceFrame) -> Option<Self> {
        let known = matches!(
            device.model(),
            None | Some(Model::Inverse3 | Model::Inverse3x)
        );
        (!known)
            .then_some(Self::OtherModel)
            .or(Self::new(&device.status))
            .or((device.status.in_use == Some(true)).then_some(Self::InUse))
    }

    /// Returns a static text for the loop, which must not allocate.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NoPower => "the Inverse3 lost the power of its motors",
            Self::NotStarted => "the service has stopped the Inverse3",
            Self::NotCalibrated => "the Inverse3 is no longer calibrated",
            Self::NotReady => "the Inverse3 is no longer ready",
            Self::InUse => "another program commands the Inverse3",
            Self::OtherModel => "the device is not an Inverse3",
        }
    }
}

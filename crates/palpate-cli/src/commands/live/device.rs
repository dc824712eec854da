//! Devices of a live session.

use palpate_device::clock::MonotonicClock;
use palpate_live::{Devices, Placed};
use palpate_scene::Scene;
use palpate_study::sim::device::{PointerDevice, PointerHand, PointerParams};

use crate::devices::{DeviceArguments, DeviceName, Opened, open};
use crate::failure::Failure;
use crate::reports::Guarding;

/// Whether any number of this device can exist.
fn is_virtual(device: DeviceName) -> bool {
    matches!(
        device,
        DeviceName::Simulated | DeviceName::Replay | DeviceName::Null | DeviceName::Pointer
    )
}

/// Returns the largest number of loops on a device. Two loops on one board would command it alternately.
pub fn most_lanes(device: DeviceName) -> usize {
    if is_virtual(device) { 2 } else { 1 }
}

/// The devices that `--device` names.
pub struct Named {
    arguments: DeviceArguments,
    scene: Scene,
    clock: MonotonicClock,
    guarding: Guarding,
    hand: Option<PointerHand>,
    /// Opened early, so that errors are reported at once.
    first: Option<Placed>,
}

impl Named {
    /// Opens the first device.
    pub fn new(
        arguments: &DeviceArguments,
        scene: &Scene,
        clock: &MonotonicClock,
        guarding: &Guarding,
    ) -> Result<Self, Failure> {
        let is_pointer = arguments.kind() == DeviceName::Pointer;
        let mut devices = Self {
            arguments: arguments.clone(),
            scene: scene.clone(),
            clock: *clock,
            guarding: guarding.clone(),
            hand: is_pointer.then(|| PointerHand::at(scene.device.position())),
            first: None,
        };
        devices.first = Some(devices.make(None)?);
        Ok(devices)
    }

    /// Returns the hand that the page moves, if there is one.
    pub fn hand(&self) -> Option<PointerHand> {
        self.hand.clone()
    }

    fn make(&self, at: Option<f64>) -> Result<Placed, Failure> {
        let Opened { mut device, axis } =
            open(&self.arguments, &self.scene, &self.clock, &self.guarding)?;
        if let Some(hand) = &self.hand {
            let usual = PointerParams::new(&self.scene);
            let params = PointerParams {
                position: at.unwrap_or(usual.position),
                ..usual
            };
            let led = PointerDevice::new(params, hand, self.clock).map_err(Failure::input)?;
            device = Box::new(led);
        }
        Ok(Placed { device, axis })
    }
}

impl Devices for Named {
    fn most_lanes(&self) -> usize {
        most_lanes(self.arguments.kind())
    }

    fn resume(&self) -> bool {
        // Scene and recording restart with the loop.
        !matches!(
            self.arguments.kind(),
            DeviceName::Simulated | DeviceName::Replay
        )
    }

    fn any_period(&self) -> bool {
        // A driver waits for its board for at most the period for which it was opened.
        is_virtual(self.arguments.kind())
    }

    fn open(&mut self, at: Option<f64>) -> Result<Placed, String> {
        if let (Some(first), None) = (self.first.take(), at) {
            return Ok(first);
        }
        self.make(at).map_err(|failure| failure.message())
    }
}

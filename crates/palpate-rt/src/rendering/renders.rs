//! Interface between a loop and its rendering: poses in, wrenches out.

use palpate_core::{Actuation, Fault};
use palpate_device::{Line, Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};

use super::{Parameters, Rendering};

/// Rendering of a loop: [`OneContact`](super::OneContact), a [`RenderedWorld`](super::RenderedWorld), or a
/// [`LocalWorld`](super::LocalWorld) with the models of a low-rate simulator. No function may allocate, lock or
/// panic, because all are part of a tick.
///
/// Positions and forces are in the frames of their devices. Devices have the same indices from 0 in all functions.
pub trait Renders: Send {
    /// Returns the number of devices.
    fn devices(&self) -> usize {
        1
    }

    /// Returns the name of a device, if the rendering has names for devices.
    fn device_name(&self, device: usize) -> Option<&str> {
        let _ = device;
        None
    }

    /// Returns the nominal sampling period `[s]`.
    fn period(&self) -> f64;

    /// Returns the name of the current method.
    fn method(&self) -> &'static str;

    /// Returns the other end of the parameters on the first call; `None` if parameters cannot change.
    fn parameters(&mut self) -> Option<Parameters> {
        None
    }

    /// Applies a pending change of parameters. Returns its number and the new rendering.
    fn take_change(&mut self) -> Option<(u32, Rendering)> {
        None
    }

    /// Switches to a pending world. Returns its number.
    fn take_other_world(&mut self) -> Option<u32> {
        None
    }

    /// Returns the number of the parameters in force.
    fn generation(&self) -> u32 {
        0
    }

    /// Renders a fresh sample of all devices. Writes the requested line of each device, before the limits of its
    /// safety, to `asked`; its duration is that of the loop.
    fn step(&mut self, sample: &DeviceSamples<'_>, asked: &mut [Line]) -> Answer;

    /// Reports the line that a device holds from now on, and the line sent to its motors if the device reports it
    /// separately.
    fn report_written(&mut self, device: usize, held: Line, sent: Option<Line>);

    /// Prepares the data of tick number `sequence`, at which the first device holds `delivered` `[N]`.
    fn account(&mut self, sequence: u64, delivered: Vector);

    /// Returns the contacts prepared by [`account`](Self::account).
    fn contacts(&self) -> &[ContactTick];

    /// Returns the moving bodies of a world, prepared by [`account`](Self::account).
    fn bodies(&self) -> &[BodyTick] {
        &[]
    }

    /// Returns the flags of the last sample, without those of each contact.
    fn flags(&self) -> Flags {
        Flags::default()
    }

    /// Returns whether the method compares the samples with the modelled timing of the loop.
    fn checks_timing(&self) -> bool {
        false
    }

    /// Returns the estimated actuation delay minus its model value `[s]`.
    fn learned_lateness(&self) -> f64 {
        0.0
    }

    /// Returns the model of the actuator, from a command to the force on the device.
    fn actuation(&self) -> Actuation<f64>;

    /// Returns the largest rate of change of the force that the rendering allows `[N/s]`; infinite: unlimited.
    fn slew_limit(&self) -> f64 {
        f64::INFINITY
    }

    /// Returns the energy that held forces have generated since the start with the motors on `[J]`, up to the last
    /// sample.
    fn created_energy(&self) -> f64;
}

/// A fresh sample of all devices, for the renderer.
#[derive(Clone, Copy, Debug)]
pub struct DeviceSamples<'a> {
    /// Time since the last fresh sample `[s]`; `None` for the first.
    pub elapsed: Option<f64>,
    /// Whether a safety stop has kept the motors off since the last sample.
    pub was_off: bool,
    /// Sample of each device.
    pub devices: &'a [DeviceSample],
}

/// Fresh sample of one device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceSample {
    /// Position `[m]`.
    pub position: Vector,
    /// Orientation, a unit quaternion `[w, x, y, z]`, if the device measures it.
    pub orientation: Option<[f64; 4]>,
    /// Mean of the wrench held since the last sample; `None` before the first command.
    pub held: Option<Wrench>,
}

/// Result of a renderer for a sample.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Coordinate of the device along the axis of a contact `[m]`; 0 without an axis.
    pub coordinate: f64,
    /// Reason for rejecting the sample, if any.
    pub fault: Option<Fault>,
    /// Whether a world had more triangles or shell points near its tools and bodies than it has room for, and ignored
    /// the furthest ones.
    pub is_crowded: bool,
}

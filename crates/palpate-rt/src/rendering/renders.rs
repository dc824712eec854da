//! What the loop asks of what it renders: a pose in, a wrench out.

use palpate::{Actuation, Fault};
use palpate_device::{Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};

use super::{Parameters, Rendering};

/// What a loop renders: [`OneContact`](super::OneContact), a [`RenderedWorld`](super::RenderedWorld), or what a slow host
/// publishes, a [`LocalWorld`](super::LocalWorld). Nothing here may allocate, lock or panic: all of it is part of a tick.
///
/// Positions and forces are in the frames of their devices. Devices are numbered in one order from 0, the same in all
/// that follows.
pub trait Renders: Send {
    /// How many devices it is rendered on.
    fn devices(&self) -> usize {
        1
    }

    /// The name of a device, where what is rendered has names for them.
    fn device_name(&self, device: usize) -> Option<&str> {
        let _ = device;
        None
    }

    /// Nominal time from sample to sample `[s]`.
    fn period(&self) -> f64;

    /// Name of the method that renders now.
    fn method(&self) -> &'static str;

    /// The other end of the parameters, for whoever asks first; `None` where nothing can change.
    fn parameters(&mut self) -> Option<Parameters> {
        None
    }

    /// Takes a change of parameters, if one has come in: its number, and what is rendered then.
    fn take_change(&mut self) -> Option<(u32, Rendering)> {
        None
    }

    /// Lets another world take the place of the one that is rendered, if one has come in: its number.
    fn take_other_world(&mut self) -> Option<u32> {
        None
    }

    /// Number of the parameters in force.
    fn generation(&self) -> u32 {
        0
    }

    /// Renders a fresh sample of all devices. Puts what each is asked to give, before the limits of its safety, into
    /// `asked`.
    fn step(&mut self, sample: &Fresh<'_>, asked: &mut [Wrench]) -> Answer;

    /// Hears what a device holds from now on by its own account, and what was sent to its motors where the device says
    /// that apart.
    fn report_written(&mut self, device: usize, held: Wrench, sent: Option<Wrench>);

    /// Makes ready what is to be said of tick number `sequence`, at which the first device holds `delivered` `[N]`.
    fn account(&mut self, sequence: u64, delivered: Vector);

    /// The contacts, as [`account`](Self::account) has made them ready.
    fn contacts(&self) -> &[ContactTick];

    /// The bodies of a world that move, as [`account`](Self::account) has made them ready.
    fn bodies(&self) -> &[BodyTick] {
        &[]
    }

    /// What is to be said of the last sample, besides what is said of each contact.
    fn flags(&self) -> Flags {
        Flags::default()
    }

    /// By how much later than told the commands begin, by what the method has learned so far `[s]`.
    fn learned_lateness(&self) -> f64 {
        0.0
    }

    /// Model of the way from a command to the force on the device.
    fn actuation(&self) -> Actuation<f64>;

    /// Fastest change of the force that the rendering allows `[N/s]`; infinite: none.
    fn slew_limit(&self) -> f64 {
        f64::INFINITY
    }

    /// Energy that held forces created since the start while the motors were on `[J]`, as of the last sample.
    fn created_energy(&self) -> f64;
}

/// A fresh sample of all devices, for the renderer.
#[derive(Clone, Copy, Debug)]
pub struct Fresh<'a> {
    /// Time since the last fresh sample `[s]`; `None` for the first.
    pub elapsed: Option<f64>,
    /// Whether a trip kept the motors off since the last sample.
    pub was_off: bool,
    /// Each device.
    pub devices: &'a [FreshDevice],
}

/// What a fresh sample says of one device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FreshDevice {
    /// Where it is `[m]`.
    pub position: Vector,
    /// How it is turned, a unit quaternion `[w, x, y, z]`, if it measures that.
    pub orientation: Option<[f64; 4]>,
    /// Mean of what it held since the last sample; `None` before the first command.
    pub held: Option<Wrench>,
}

/// What a renderer answers to a sample.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Where the device is along the axis of a contact `[m]`; 0 where there is no axis.
    pub coordinate: f64,
    /// Why the sample was refused, if it was.
    pub fault: Option<Fault>,
}

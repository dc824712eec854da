//! A loop by one of the built-in methods, tick by tick, for a study that keeps nothing of its runs.
//!
//! The ticks are compiled in this crate, which is optimised, because a study runs millions of them and is itself built
//! without optimisation.

use palpate_core::{AnyMethod, AnyRenderer, ObjectState, Output};
use palpate_scene::{Delay, Scene};
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};
use palpate_testbed::device::PointMass;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::measure::Sampler;
use palpate_testbed::sprung_mass::SprungMass;
use palpate_testbed::viscous_mass::ViscousMass;

use crate::impedance::ImposedMotion;
use crate::sim::closed_loop::LoopError;
use crate::sim::plant::Plant;
use crate::sim::sampled_loop::{LoopDevice, SampledLoop};

/// A loop in progress.
pub trait Ticks {
    /// Samples the device, renders, and advances by a period.
    fn tick(&mut self) -> Tick;
}

/// Result of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Position of the device where it was sampled `[m]`.
    pub device_position: f64,
    /// Its velocity then `[m/s]`.
    pub device_velocity: f64,
    /// The renderer's answer.
    pub output: Output<f64>,
    /// Mean force on the object over the period that followed `[N]`.
    pub held: f64,
}

/// Parameters of a loop, except its device. The renderer uses its nominal period.
#[derive(Clone, Debug)]
pub struct TicksParams<'a> {
    /// The renderer.
    pub renderer: &'a AnyRenderer<f64>,
    /// The object at the start.
    pub object: ObjectState<f64>,
    /// Force f_V on the object `[N]`.
    pub virtual_force: f64,
    /// Sensor of devices without their own.
    pub sampler: Sampler,
    /// The way of a command to the device.
    pub way: Way,
    /// Period `[s]`.
    pub period: f64,
}

/// A device, of the kinds that a loop is compiled for.
#[derive(Clone, Debug)]
pub struct TickedDevice(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Free(PointMass),
    Viscous(ViscousMass),
    Sprung(SprungMass),
    Imposed(ImposedMotion),
    General(Box<Plant>),
}

impl From<PointMass> for TickedDevice {
    fn from(device: PointMass) -> Self {
        Self(Kind::Free(device))
    }
}

impl From<ViscousMass> for TickedDevice {
    fn from(device: ViscousMass) -> Self {
        Self(Kind::Viscous(device))
    }
}

impl From<SprungMass> for TickedDevice {
    fn from(device: SprungMass) -> Self {
        Self(Kind::Sprung(device))
    }
}

impl From<ImposedMotion> for TickedDevice {
    fn from(device: ImposedMotion) -> Self {
        Self(Kind::Imposed(device))
    }
}

impl TickedDevice {
    /// The device of a checked `scene` on the canonical side, as of [`crate::sim::sampled_loop::device_of`].
    ///
    /// # Errors
    /// A quantity of the device or the hand outside its range.
    pub fn new(scene: &Scene) -> Result<Self, InvalidParameter> {
        Ok(Self(Kind::General(Box::new(Plant::of(scene, 1.0)?))))
    }
}

impl<'a> TicksParams<'a> {
    /// The loop on `device`, before its first tick.
    ///
    /// # Errors
    /// A position or a velocity of the object that the renderer refuses.
    pub fn on(self, device: TickedDevice) -> Result<Box<dyn Ticks + 'a>, LoopError> {
        Ok(match device.0 {
            Kind::Free(device) => Box::new(self.in_progress(device)?),
            Kind::Viscous(device) => Box::new(self.in_progress(device)?),
            Kind::Sprung(device) => Box::new(self.in_progress(device)?),
            Kind::Imposed(device) => Box::new(self.in_progress(device)?),
            Kind::General(device) => Box::new(self.in_progress(*device)?),
        })
    }

    fn in_progress<D: LoopDevice>(self, device: D) -> Result<InProgress<'a, D>, LoopError> {
        Ok(InProgress {
            sampled: SampledLoop {
                sampler: self.sampler,
                virtual_force: self.virtual_force,
                actuator: self.way.actuator,
                ..SampledLoop::new(self.renderer, self.object, device)
                    .map_err(|error| LoopError::Setup(error.into()))?
            },
            way: self.way,
            period: self.period,
        })
    }
}

struct InProgress<'a, D> {
    sampled: SampledLoop<'a, AnyMethod<f64>, D>,
    way: Way,
    period: f64,
}

impl<D: LoopDevice> Ticks for InProgress<'_, D> {
    fn tick(&mut self) -> Tick {
        let output = self.sampled.sample(self.period, None).output;
        let device = &self.sampled.device;
        Tick {
            device_position: device.position(),
            device_velocity: device.velocity(),
            output,
            held: self.drive(output.force_on_object),
        }
    }
}

/// The way of a command to the device: a delay of any number of periods, and the actuator's lag.
#[derive(Clone, Debug)]
pub struct Way {
    hold: DelayedHold,
    /// Fraction of a period in the delay, beyond whole samples.
    fraction: f64,
    /// Command that acts until the next one arrives `[N]`.
    before: f64,
    /// Model from an arrived command to the delivered force.
    actuator: Actuator,
}

impl Way {
    /// A way with a `delay` of any number of periods and a `lag`, the time constant of the force after that
    /// `[s]`, on which no command is yet.
    ///
    /// # Errors
    /// A delay or a lag outside its range.
    pub fn new(delay: f64, lag: f64) -> Result<Self, InvalidParameter> {
        let delay = Delay::of_periods(delay);
        Ok(Self {
            hold: DelayedHold::new(delay.whole_samples())?,
            fraction: delay.fraction(),
            before: 0.0,
            actuator: Actuator::new(ActuatorParams {
                lag,
                ..ActuatorParams::default()
            })?,
        })
    }
}

impl<D: LoopDevice> InProgress<'_, D> {
    /// Sends `command`, advances by a period, and returns the mean force on the object `[N]`.
    fn drive(&mut self, command: f64) -> f64 {
        let Self {
            sampled,
            way,
            period,
        } = self;
        if way.fraction == 0.0 && way.actuator.params().lag == 0.0 {
            // The force is constant over the whole period, and is reported to the renderer.
            let held = sampled.given_force(way.hold.exchange(command));
            sampled.report_held(held);
            sampled.advance(held, *period);
            return held;
        }
        let sent = sampled.given_force(command);
        sampled.report_sent(sent);
        let next = way.hold.exchange(sent);
        let (early, late) = (way.fraction, 1.0 - way.fraction);
        let of_before = sampled.drive(way.before, early * *period).mean_force;
        let of_next = sampled.drive(next, late * *period).mean_force;
        way.before = next;
        early * of_before + late * of_next
    }
}

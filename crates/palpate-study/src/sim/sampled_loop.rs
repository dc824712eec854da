//! One step of the sampled-data loop: sample, render, hold, advance.
//!
//! [`Bench`](crate::sim::closed_loop::Bench) takes these steps over a whole window and keeps every tick. A study that
//! needs less of a run takes the steps itself. [`SampledLoop`] has no clock: its caller determines the sample instants
//! and the durations of the held forces.

use palpate_core::{Method, ObjectState, Output, ParameterError, Renderer, Sample, State};
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, Delivered};
use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::measure::{Sampler, SensorNoise};
use palpate_testbed::sprung_mass::SprungMass;
use palpate_testbed::viscous_mass::ViscousMass;

use std::fmt;

use palpate_scene::Scene;

use crate::sim::plant::{Plant, noisy};

/// A device with the parts that lie between it and a renderer: its sensor and its motor.
pub trait LoopDevice: DevicePlant {
    /// Position as the loop's sensor reports it, with its `noise` `[m]`.
    #[inline]
    fn measured(&self, sampler: &Sampler, noise: f64) -> f64 {
        sampler.sample(noisy(self.position(), noise))
    }

    /// Returns the force on the object that is sent to the motor for a commanded `force` `[N]`, after the motor's
    /// limit. The actuator model is applied separately.
    #[inline]
    fn given_force(&self, force: f64) -> f64 {
        force
    }
}

impl LoopDevice for PointMass {}
impl LoopDevice for ViscousMass {}
impl LoopDevice for SprungMass {}

impl LoopDevice for Plant {
    fn measured(&self, sampler: &Sampler, noise: f64) -> f64 {
        Plant::measured(self, sampler, noise)
    }

    fn given_force(&self, force: f64) -> f64 {
        Plant::given_force(self, force)
    }
}

/// The device of a checked `scene` and the hand that holds it, at the start. `sign` mirrors positions and
/// forces to the canonical side, where the object is above the device: the scene's
/// [`Side::sign`](palpate_core::Side::sign), or 1 for a scene that is on that side.
///
/// # Errors
/// A quantity of the device or the hand outside its range.
pub fn device_of(
    scene: &Scene,
    sign: f64,
) -> Result<impl LoopDevice + Clone + fmt::Debug + use<>, InvalidParameter> {
    Plant::of(scene, sign)
}

/// A loop in progress. The device lives on the canonical side, the renderer in the user's frame.
pub struct SampledLoop<'a, M: Method<f64>, D> {
    /// The renderer.
    pub renderer: &'a Renderer<f64, M>,
    /// Its state.
    pub state: State<f64, M::Memory>,
    /// The device, with what holds it.
    pub device: D,
    /// Sensor of devices without their own.
    pub sampler: Sampler,
    /// The noise of that sensor.
    pub noise: SensorNoise,
    /// Model from a command to the delivered force.
    pub actuator: Actuator,
    /// 1 or -1: mirrors the device's positions and forces to the user's frame.
    pub sign: f64,
    /// Force f_V on the object `[N]`, in the user's frame.
    pub virtual_force: f64,
}

/// Result of a sample, in the user's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// Position as the renderer saw it `[m]`.
    pub measured: f64,
    /// The renderer's answer.
    pub output: Output<f64>,
}

impl<'a, M: Method<f64>, D: LoopDevice> SampledLoop<'a, M, D> {
    /// A loop before its first sample, with an ideal sensor and a perfect actuator, on the canonical side, without f_V.
    ///
    /// # Errors
    /// A position or a velocity of `object` that the renderer refuses.
    pub fn new(
        renderer: &'a Renderer<f64, M>,
        object: ObjectState<f64>,
        device: D,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            renderer,
            state: renderer.start(object)?,
            device,
            sampler: Sampler::Ideal,
            noise: SensorNoise::none(),
            actuator: Actuator::default(),
            sign: 1.0,
            virtual_force: 0.0,
        })
    }

    /// Samples the device `elapsed` `[s]` after the last sample, and renders. The renderer receives `measured_time`;
    /// for `None` it uses its nominal period.
    #[inline]
    pub fn sample(&mut self, elapsed: f64, measured_time: Option<f64>) -> Sampled {
        self.device.sample(elapsed);
        let noise = self.noise.draw();
        let measured = self.sign * self.device.measured(&self.sampler, noise);
        let taken = Sample {
            elapsed: measured_time,
            ..Sample::at(measured).with_virtual_force(self.virtual_force)
        };
        Sampled {
            measured,
            output: self.renderer.step(&mut self.state, taken),
        }
    }

    /// Force on the object that is sent to the motor where `command` is to be `[N]`.
    #[inline]
    pub fn given_force(&self, command: f64) -> f64 {
        self.sign * self.device.given_force(self.sign * command)
    }

    /// Returns the line on the object that is sent to the motor for an output: its mean `[N]`, and the slope `[N/s]`
    /// with which its ends stay within the motor's limit.
    #[inline]
    pub fn given_line(&self, output: &Output<f64>) -> (f64, f64) {
        let mean = self.given_force(output.force_on_object);
        let slope = -output.slope_on_device;
        if slope == 0.0 {
            return (mean, 0.0);
        }
        let room = self.given_force(f64::INFINITY).abs() - mean.abs();
        let steepest = room / (0.5 * self.renderer.loop_params().period);
        (mean, slope.clamp(-steepest, steepest))
    }

    /// Tells the renderer the line that was sent for its last output: its mean `[N]` and its slope `[N/s]`.
    #[inline]
    pub fn report_sent_line(&mut self, mean: f64, slope: f64) {
        self.renderer.report_sent_line(&mut self.state, mean, slope);
    }

    /// Tells the renderer the force that was sent for its last output `[N]`.
    #[inline]
    pub fn report_sent(&mut self, force: f64) {
        self.renderer.report_sent(&mut self.state, force);
    }

    /// Tells the renderer the force, or its mean, that is held from its last sample to its next `[N]`.
    #[inline]
    pub fn report_held(&mut self, force: f64) {
        self.renderer.report_held(&mut self.state, force);
    }

    /// Moves the device while `force` is held for `duration` `[s]`, and returns the work through the port `[J]`. The
    /// force acts directly, without the actuator.
    #[inline]
    pub fn advance(&mut self, force: f64, duration: f64) -> f64 {
        self.device.advance(self.sign * force, duration)
    }

    /// Lets the device move while `sent` is held at the actuator's input for `duration` `[s]`: the mean of
    /// the force on the object that was delivered `[N]`, and the work through the port `[J]`.
    #[inline]
    pub fn drive(&mut self, sent: f64, duration: f64) -> Delivered {
        let delivered = self
            .actuator
            .drive(&mut self.device, self.sign * sent, duration);
        Delivered {
            mean_force: self.sign * delivered.mean_force,
            ..delivered
        }
    }

    /// The same for a line with a mean of `sent` `[N]` over this duration and a `slope` `[N/s]`.
    #[inline]
    pub fn drive_line(&mut self, sent: f64, slope: f64, duration: f64) -> Delivered {
        let (mean, slope) = (self.sign * sent, self.sign * slope);
        let delivered = self
            .actuator
            .drive_line(&mut self.device, mean, slope, duration);
        Delivered {
            mean_force: self.sign * delivered.mean_force,
            ..delivered
        }
    }

    /// Force on the object that acts now, where `sent` is at the actuator's input `[N]`.
    #[inline]
    pub fn acting_force(&self, sent: f64) -> f64 {
        self.sign * self.actuator.force_on(self.sign * sent)
    }
}

//! One step of the sampled-data loop: sample, render, hold, advance. Every study of closed loops
//! takes its steps here.

use palpate::{AnyMemory, AnyRenderer, ObjectState, Output, ParameterError, Sample, State};
use palpate_testbed::device::{Device, PointMass};
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::measure::Sampler;
use palpate_testbed::viscous_mass::ViscousMass;

use crate::plant::Plant;

/// A device, as the loop meets it.
pub(crate) trait LoopDevice: Device {
    /// Position as the loop's sensor reports it `[m]`.
    #[inline]
    fn measured(&self, sampler: &Sampler) -> f64 {
        sampler.sample(self.position())
    }

    /// Force on the object that the motor really holds when it is to hold `force` `[N]`.
    #[inline]
    fn given_force(&self, force: f64) -> f64 {
        force
    }
}

impl LoopDevice for PointMass {}
impl LoopDevice for ViscousMass {}

impl LoopDevice for Plant {
    fn measured(&self, sampler: &Sampler) -> f64 {
        Plant::measured(self, sampler)
    }

    fn given_force(&self, force: f64) -> f64 {
        Plant::given_force(self, force)
    }
}

/// A loop in progress. The device lives on the canonical side, the renderer in the user's frame;
/// `sign` is between them.
pub(crate) struct SampledLoop<'a, D> {
    pub renderer: &'a AnyRenderer<f64>,
    pub state: State<f64, AnyMemory<f64>>,
    pub device: D,
    pub hold: DelayedHold,
    pub sampler: Sampler,
    pub sign: f64,
    /// Period at which the device is really sampled `[s]`.
    pub period: f64,
    pub virtual_force: f64,
}

/// What a sample showed, and what is held from it on, in the user's frame.
pub(crate) struct Sampled {
    /// Position as the renderer saw it `[m]`.
    pub measured: f64,
    pub output: Output<f64>,
    /// Force on the object that is really held `[N]`.
    pub held: f64,
}

impl<'a, D: LoopDevice> SampledLoop<'a, D> {
    /// A loop before its first sample.
    pub fn new(
        renderer: &'a AnyRenderer<f64>,
        object: ObjectState<f64>,
        device: D,
        hold: DelayedHold,
        period: f64,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            renderer,
            state: renderer.start(object)?,
            device,
            hold,
            sampler: Sampler::Ideal,
            sign: 1.0,
            period,
            virtual_force: 0.0,
        })
    }

    /// Samples, renders, and takes the force to hold.
    #[inline]
    pub fn sample(&mut self) -> Sampled {
        self.device.sample(self.period);
        let measured = self.sign * self.device.measured(&self.sampler);
        let output = self.renderer.step(
            &mut self.state,
            Sample::at(measured).with_virtual_force(self.virtual_force),
        );
        let command = self.hold.exchange(output.force_on_object);
        let held = self.sign * self.device.given_force(self.sign * command);
        self.renderer.report_held(&mut self.state, held);
        Sampled {
            measured,
            output,
            held,
        }
    }

    /// Lets the device move until the next sample while the force of `sampled` is held; the work
    /// through the port `[J]`.
    #[inline]
    pub fn advance(&mut self, sampled: &Sampled) -> f64 {
        self.device.advance(self.sign * sampled.held, self.period)
    }
}

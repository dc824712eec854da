//! Impedance that a hand feels in a rendered contact, by frequency.
//!
//! A hand imposes a sinusoidal displacement on the device while it presses into the contact. The ratio of the
//! fundamental of the delivered force to that of the displacement is the dynamic stiffness. Its parts are the effective
//! stiffness, damping and mass (after Colonnese and Okamura; as derived here).

use std::f64::consts::TAU;

use nalgebra::Complex;
use palpate_core::ObjectState;
use palpate_scene::method::{MethodName, Settings};
use palpate_testbed::device::DevicePlant;
use palpate_testbed::measure::Sampler;

use crate::map::{Bounce, BounceError, PRESSED_WITH};
use crate::sim::sampled_loop::LoopDevice;
use crate::sim::ticks::{TicksParams, Way};

/// Amplitude of the ideal force over the pressing force: below 1, so that the contact never opens.
const FORCE_SHARE: f64 = 0.4;

/// Largest amplitude of the imposed displacement `[m]`: a light object yields to any displacement.
const MAX_AMPLITUDE: f64 = 0.01;

/// Cycles before the evaluated ones, with the least time `[s]`, and cycles that are evaluated.
const SETTLING: (f64, f64) = (5.0, 0.5);
const EVALUATED_CYCLES: f64 = 20.0;

/// Least number of samples per cycle.
pub const MIN_SAMPLES_PER_CYCLE: f64 = 5.0;

/// Dynamic stiffness, as the parts that a hand feels at a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveImpedance {
    /// Real part of force over displacement `[N/m]`. Positive: effective stiffness. Negative: effective mass times ω².
    pub stiffness: f64,
    /// Imaginary part of force over displacement, over ω `[N s/m]`. Negative: the contact gives out energy.
    pub damping: f64,
}

impl EffectiveImpedance {
    fn new(dynamic_stiffness: Complex<f64>, omega: f64) -> Self {
        Self {
            stiffness: dynamic_stiffness.re,
            damping: dynamic_stiffness.im / omega,
        }
    }

    /// Returns the effective mass at `frequency` `[Hz]` `[kg]`: −stiffness/ω², 0 for a positive stiffness.
    #[must_use]
    pub fn mass(&self, frequency: f64) -> f64 {
        (-self.stiffness).max(0.0) / (TAU * frequency).powi(2)
    }
}

/// Impedance of a contact at a frequency: the wanted one and that by a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltImpedance {
    /// Frequency of the hand's motion `[Hz]`.
    pub frequency: f64,
    /// Impedance of the contact in continuous time, without the device.
    pub wanted: EffectiveImpedance,
    /// Impedance of the delivered force, without the device.
    pub rendered: EffectiveImpedance,
    /// Impedance of the delivered force, the device's mass, and its viscous friction.
    pub with_device: EffectiveImpedance,
}

impl Bounce {
    /// Returns the impedance of this contact at `frequency` `[Hz]`, rendered by `method` and pressed with 3 N; `None`
    /// if the renderer rejects a sample or the contact opens, so that there is no steady oscillation. The forces that
    /// drive device and object together, and the gap, have no effect.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
    pub fn impedance(
        &self,
        method: MethodName,
        settings: Settings,
        frequency: f64,
    ) -> Result<Option<FeltImpedance>, BounceError> {
        let renderer = self.renderer(method, settings)?;
        let omega = TAU * frequency;
        let wanted = self.wanted_stiffness(omega);
        let amplitude = (FORCE_SHARE * PRESSED_WITH / wanted.abs()).min(MAX_AMPLITUDE);
        // The object in the steady oscillation: its displacement over the device's.
        let transmitted = 1.0 - wanted / self.stiffness;
        let quantum = self.device.encoder_quantum;
        let params = TicksParams {
            renderer: &renderer,
            object: ObjectState::at_rest(-PRESSED_WITH / self.stiffness + transmitted * amplitude),
            virtual_force: if self.is_wall() { 0.0 } else { -PRESSED_WITH },
            sampler: if quantum > 0.0 {
                Sampler::quantum(quantum)?
            } else {
                Sampler::Ideal
            },
            way: Way::new(self.delay, self.lag)?,
            period: self.period,
        };
        let motion = ImposedMotion {
            amplitude,
            omega,
            time: 0.0,
        };
        let mut ticks = params.on(motion.into())?;
        let per_cycle = 1.0 / (frequency * self.period);
        let settling = (SETTLING.0 * per_cycle)
            .max(SETTLING.1 / self.period)
            .ceil();
        let evaluated = (EVALUATED_CYCLES * per_cycle).round();
        let mut transform = Transform::default();
        let mut time = 0.0;
        let mut i = 0.0;
        while i < settling + evaluated {
            let tick = ticks.tick();
            let force = tick.output.force_on_object;
            if tick.output.fault.is_some() || !force.is_finite() {
                return Ok(None);
            }
            if i >= settling {
                // A Hann window suppresses the free oscillation of an object.
                let weight = 1.0 - libm::cos(TAU * (i - settling + 0.5) / evaluated);
                let weighted = rotation(-omega * time) * weight;
                transform.add(weighted, force, tick.device_position);
            }
            i += 1.0;
            time = i * self.period;
        }
        let Some(sampled) = transform.ratio() else {
            return Ok(None);
        };
        let rendered = sampled * self.delivery(omega);
        let device = Complex::new(
            -self.device.mass * omega * omega,
            self.device.viscous_friction * omega,
        );
        let effective = |stiffness: Complex<f64>| EffectiveImpedance::new(stiffness, omega);
        Ok(Some(FeltImpedance {
            frequency,
            wanted: effective(wanted.into()),
            rendered: effective(rendered),
            with_device: effective(rendered + device),
        }))
    }

    /// Returns the dynamic stiffness of the ideal contact: K in series with the object's −M ω².
    fn wanted_stiffness(&self, omega: f64) -> f64 {
        if self.is_wall() {
            return self.stiffness;
        }
        let inertia = -self.object_mass * omega * omega;
        self.stiffness * inertia / (self.stiffness + inertia)
    }

    /// Returns the frequency response from the sampled commands to the fundamental of the delivered force: hold, delay
    /// and lag.
    fn delivery(&self, omega: f64) -> Complex<f64> {
        let half = 0.5 * omega * self.period;
        let hold = rotation(-half) * (libm::sin(half) / half);
        let delay = rotation(-omega * self.delay * self.period);
        hold * delay / Complex::new(1.0, omega * self.lag)
    }
}

/// Returns e^(j angle).
fn rotation(angle: f64) -> Complex<f64> {
    let (sine, cosine) = libm::sincos(angle);
    Complex::new(cosine, sine)
}

/// Weighted fundamentals of force and displacement.
#[derive(Default)]
struct Transform {
    force: Complex<f64>,
    displacement: Complex<f64>,
    has_opened: bool,
}

impl Transform {
    /// Adds a sample. `weighted` is its weight times e^(−jωt).
    fn add(&mut self, weighted: Complex<f64>, force: f64, displacement: f64) {
        self.force += weighted * (force - PRESSED_WITH);
        self.displacement += weighted * displacement;
        self.has_opened |= force <= 0.0;
    }

    /// Returns the force over the displacement `[N/m]`; `None` if the contact opened.
    fn ratio(&self) -> Option<Complex<f64>> {
        (!self.has_opened).then(|| self.force / self.displacement)
    }
}

/// A device that a hand moves along a cosine, whatever the force.
#[derive(Clone, Copy, Debug)]
pub struct ImposedMotion {
    /// Amplitude `[m]`.
    amplitude: f64,
    /// Angular frequency `[rad/s]`.
    omega: f64,
    time: f64,
}

impl DevicePlant for ImposedMotion {
    fn position(&self) -> f64 {
        self.amplitude * libm::cos(self.omega * self.time)
    }

    fn velocity(&self) -> f64 {
        -self.amplitude * self.omega * libm::sin(self.omega * self.time)
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let before = self.position();
        self.time += duration;
        force_on_object * (self.position() - before)
    }

    fn stored_energy(&self) -> f64 {
        0.0
    }
}

impl LoopDevice for ImposedMotion {}

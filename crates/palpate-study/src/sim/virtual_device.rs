//! The device and the hand of a scene, to be driven from outside: by a loop in real time.

use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::DevicePlant;
use palpate_testbed::measure::{Sampler, SensorNoise};

use crate::sim::plant::Plant;
use palpate_scene::Scene;

/// The device of a scene with its hand, in the user's frame. It is independent of a loop: each call passes the held
/// force and its duration.
#[derive(Clone, Debug)]
pub struct VirtualDevice {
    plant: Plant,
    sampler: Sampler,
    noise: SensorNoise,
    actuator: Actuator,
    sign: f64,
}

impl VirtualDevice {
    /// The device of `scene`, where it is at the start.
    ///
    /// # Errors
    /// A quantity of the device or the hand outside its range.
    pub fn new(scene: &Scene) -> Result<Self, InvalidParameter> {
        let sign: f64 = scene.contact.side.sign();
        Ok(Self {
            plant: Plant::of(scene, sign)?,
            sampler: if scene.device.encoder_quantum() > 0.0 {
                Sampler::quantum(scene.device.encoder_quantum())?
            } else {
                Sampler::Ideal
            },
            noise: SensorNoise::normal(scene.device.noise(), scene.timing.seed)?,
            actuator: Actuator::new(scene.actuator)?,
            sign,
        })
    }

    /// A sample instant, `elapsed` `[s]` after the last one: the device's own controllers run, and
    /// its sensor reports this position along the contact's axis `[m]`.
    pub fn sample(&mut self, elapsed: f64) -> f64 {
        self.plant.sample(elapsed);
        let noise = self.noise.draw();
        self.sign * self.plant.measured(&self.sampler, noise)
    }

    /// Advances by `duration` `[s]` under a commanded `force` on the device `[N]`. The force is limited, and acts
    /// through the scene's gain and lag. Returns the work of the delivered force `[J]`.
    pub fn hold(&mut self, force: f64, duration: f64) -> f64 {
        let sent = -self.sign * self.given_force(force);
        let delivered = self.actuator.drive(&mut self.plant, sent, duration);
        -delivered.work
    }

    /// Force on the device that is sent to the motor where it is to hold `force` `[N]`.
    #[must_use]
    pub fn given_force(&self, force: f64) -> f64 {
        -self.sign * self.plant.given_force(-self.sign * force)
    }

    /// True position along the contact's axis `[m]`.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.sign * self.plant.position()
    }

    /// True velocity along the contact's axis `[m/s]`.
    #[must_use]
    pub fn velocity(&self) -> f64 {
        self.sign * self.plant.velocity()
    }

    /// Whether a linkage's own safety box has switched its motors off.
    #[must_use]
    pub fn is_disconnected(&self) -> bool {
        self.plant.has_left_box()
    }
}

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

    /// Advances by `duration` `[s]` under a line on the device: its mean over this duration `[N]` and its slope
    /// `[N/s]`, as [`given_line`](Self::given_line) limits them. Returns the work of the delivered force `[J]`.
    pub fn hold_line(&mut self, mean: f64, slope: f64, duration: f64) -> f64 {
        let (mean, slope) = (-self.sign * mean, -self.sign * slope);
        let delivered = self
            .actuator
            .drive_line(&mut self.plant, mean, slope, duration);
        -delivered.work
    }

    /// Line on the device that is sent to the motor where it is to hold a line of this `mean` `[N]` and `slope` `[N/s]`
    /// over `period` `[s]`: the mean is limited, then the slope such that both ends are within the limit.
    #[must_use]
    pub fn given_line(&self, mean: f64, slope: f64, period: f64) -> (f64, f64) {
        let given = self.given_force(mean);
        if slope == 0.0 || period <= 0.0 {
            return (given, 0.0);
        }
        let room = (self.given_force(f64::INFINITY).abs() - given.abs()).max(0.0);
        let steepest = room / (0.5 * period);
        (given, slope.clamp(-steepest, steepest))
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

//! Plant of a sampled loop: the devices in their hands, between measurement and actuation.

use super::contact::WorldError;
use super::held_axis::HeldAxis;
use super::held_linkage::HeldLinkage;
use super::held_turning::HeldTurning;
use super::motion::Grasp;
use super::scene::{Vector, WorldDevice, WorldScene};
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::actuator::{Actuator, ActuatorParams};
use crate::device::DevicePlant;
use crate::error::positive;
use crate::measure::{Sampler, SensorNoise};

/// Period of a loop, and its actuators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantParams {
    /// Period T, finite and above 0 `[s]`.
    pub period: f64,
    /// Gain and lag of every axis.
    pub actuator: ActuatorParams,
    /// Seed of the noise of the sensors.
    pub seed: u64,
}

impl PlantParams {
    /// A loop of that period `[s]` that gives what is commanded at once.
    #[must_use]
    pub fn perfect(period: f64) -> Self {
        Self {
            period,
            actuator: ActuatorParams::default(),
            seed: 0,
        }
    }
}

/// The devices of a scene in a sampled loop.
///
/// At each sample, call [`measure`](Self::measure) for the sensor values, compute a force on each tool, and
/// [`hold`](Self::hold) it. Each axis moves exactly under the force that its actuator delivers. A loop with another
/// [timeline](crate::timeline::Timeline) calls [`advance`](Self::advance) for each of its stretches.
///
/// ```
/// use palpate_testbed::world::{PlantParams, Tool, WorldDevice, WorldHand, WorldPlant, WorldScene};
///
/// # fn main() -> Result<(), palpate_testbed::world::WorldError> {
/// let device = WorldDevice {
///     name: "tool".into(),
///     own_axes: None,
///     mass_table: None,
///     drivetrain: palpate_testbed::world::Drivetrain::default(),
///     mass: [0.25; 3],
///     position: [0.0; 3],
///     velocity: [0.0; 3],
///     tool: Tool::sphere(0.01),
///     turning: None,
///     hand: WorldHand::default(),
///     quantum: [2e-6; 3],
/// };
/// let scene = WorldScene { devices: vec![device], ..WorldScene::default() };
/// let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.001))?;
/// for _ in 0..100 {
///     let height = plant.measure()[0][2];
///     plant.hold(&[[0.0, 0.0, 1.0 - 50.0 * height]]);
/// }
/// assert!(plant.velocities()[0][2] > 0.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct WorldPlant {
    period: f64,
    /// `[s]`
    now: f64,
    devices: Vec<PlantDevice>,
    samples: usize,
    durations: Vec<f64>,
}

/// A line on a tool.
#[derive(Debug, Clone, Copy)]
struct HeldLine {
    /// Mean over a period `[N]`.
    force: Vector,
    /// `[N/s]`
    slope: Vector,
    /// Time since the middle of that period; negative before it `[s]`.
    since_middle: f64,
}

#[derive(Debug, Clone)]
struct PlantDevice {
    /// The simulated device, which determines the axes along which it moves.
    device: WorldDevice,
    axes: [HeldAxis; 3],
    actuators: [Actuator; 3],
    /// Moves it in place of them, where its mass depends on its place.
    linkage: Option<HeldLinkage>,
    samplers: [Sampler; 3],
    noises: [SensorNoise; 3],
    /// How the hand holds it now.
    grasp: Grasp,
    /// Along its axes.
    impulses: Vec<Vector>,
    /// Slopes of the delivered lines over the same intervals.
    slopes: Vec<Vector>,
    turning: Option<HeldTurning>,
    angular_impulses: Vec<Vector>,
}

impl PlantDevice {
    fn given(&self, force: Vector) -> Vector {
        let largest = self.device.drivetrain.largest_force;
        if largest == f64::INFINITY {
            return force;
        }
        let own = self.device.own(Vec3(force)).0;
        let given = own.map(|along| along.clamp(-largest, largest));
        self.device.out(Vec3(given)).0
    }

    /// Records the slope of a line on its tool `[N/s]`, as its actuators deliver it.
    fn hold_slope(&mut self, slope: Vector) {
        let own = self.device.own(Vec3(slope)).0;
        if let Some(last) = self.slopes.last_mut() {
            *last = std::array::from_fn(|axis| self.actuators[axis].params().gain * own[axis]);
        }
    }

    /// Moves for a `duration` `[s]` from `time` `[s]` on under a line and a torque on its tool.
    fn advance(&mut self, mut line: HeldLine, torque: Vector, mut time: f64, duration: f64) {
        let mut left = duration;
        while self.grasp.until < time + left {
            let part = (self.grasp.until - time).max(0.0);
            if part > 0.0 {
                self.move_on(line, torque, part);
                line.since_middle += part;
            }
            (time, left) = (self.grasp.until, left - part);
            self.grasp.go_on(&self.device.hand, time);
            if let (false, Some(turning)) = (self.grasp.holds, &mut self.turning) {
                turning.release();
            }
        }
        self.move_on(line, torque, left);
    }

    /// The same without an event of its hand.
    fn move_on(&mut self, line: HeldLine, torque: Vector, duration: f64) {
        if let Some(turning) = &mut self.turning
            && let Some(angular_impulse) = self.angular_impulses.last_mut()
        {
            let delivered = turning.advance(torque, duration);
            for (sum, part) in angular_impulse.iter_mut().zip(delivered) {
                *sum += part;
            }
        }
        let Some(impulse) = self.impulses.last_mut() else {
            return;
        };
        if let (Some(linkage), Some(table)) = (&mut self.linkage, &self.device.mass_table) {
            let force = line.force;
            let delivered = linkage.advance((&self.device, table, &self.grasp), force, duration);
            for (sum, part) in impulse.iter_mut().zip(delivered) {
                *sum += part;
            }
            return;
        }
        let [force, slope] =
            [line.force, line.slope].map(|on_tool| self.device.own(Vec3(on_tool)).0);
        let since_middle = line.since_middle + 0.5 * duration;
        for axis in 0..3 {
            if self.axes[axis].stays() {
                continue;
            }
            // A force on the tool is the opposite of the force on the object.
            let (actuator, moved) = (&mut self.actuators[axis], &mut self.axes[axis]);
            let delivered = if slope[axis] == 0.0 {
                actuator.drive(moved, -force[axis], duration)
            } else {
                let mean = force[axis] + slope[axis] * since_middle;
                actuator.drive_line(moved, -mean, -slope[axis], duration)
            };
            impulse[axis] -= delivered.mean_force * duration;
        }
    }

    /// Along one of its axes.
    fn position(&self, axis: usize) -> f64 {
        self.linkage.as_ref().map_or_else(
            || self.axes[axis].position(),
            |linkage| self.device.own(linkage.position()).0[axis],
        )
    }

    fn velocity(&self, axis: usize) -> f64 {
        self.linkage.as_ref().map_or_else(
            || self.axes[axis].velocity(),
            |linkage| self.device.own(linkage.velocity()).0[axis],
        )
    }
}

impl WorldPlant {
    /// The devices of `scene` at t = 0, no force on their tools.
    ///
    /// # Errors
    ///
    /// A parameter of the scene or of the loop outside its range.
    pub fn new(scene: &WorldScene, params: PlantParams) -> Result<Self, WorldError> {
        scene.check()?;
        let of_loop = |invalid: InvalidParameter| {
            WorldError::Parameter(InvalidParameter {
                name: format!("loop.{}", invalid.name),
                value: invalid.value,
                allowed: invalid.allowed,
            })
        };
        positive("period", params.period, "finite and above 0 s").map_err(of_loop)?;
        let actuator = Actuator::new(params.actuator).map_err(of_loop)?;
        let mut devices = Vec::new();
        // A device with one axis alone has the noise of the seed itself.
        let mut sensors = params.seed..;
        for (number, device) in scene.devices.iter().enumerate() {
            let name = format!("devices[{number}]");
            let mut noises = [SensorNoise::none(); 3];
            for (axis, noise) in noises.iter_mut().enumerate() {
                if device.moves_along(axis) {
                    let seed = sensors.next().unwrap_or_default();
                    *noise = SensorNoise::normal(device.drivetrain.noise, seed).map_err(of_loop)?;
                }
            }
            let axis = |axis| HeldAxis::new(device, axis, &name);
            devices.push(PlantDevice {
                device: device.clone(),
                axes: [axis(0)?, axis(1)?, axis(2)?],
                actuators: [actuator; 3],
                linkage: device
                    .mass_table
                    .as_ref()
                    .map(|_| HeldLinkage::new(device, params.actuator)),
                samplers: device.quantum.map(Sampler::Quantum),
                noises,
                grasp: Grasp::new(&device.hand, 0.0),
                impulses: Vec::new(),
                slopes: Vec::new(),
                turning: device
                    .turning
                    .as_ref()
                    .map(|turning| HeldTurning::new(turning, params.actuator)),
                angular_impulses: Vec::new(),
            });
        }
        Ok(Self {
            period: params.period,
            now: 0.0,
            devices,
            samples: 0,
            durations: Vec::new(),
        })
    }

    /// Time of this sample of a loop that holds every force for a period `[s]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.samples as f64 * self.period
    }

    /// Returns the measured positions, with the noise of a sample and rounded along each of a device's axes to its
    /// quantum `[m]`.
    pub fn measure(&mut self) -> Vec<Vector> {
        let devices = self.devices.iter_mut();
        let measured = devices.map(|device| {
            let noises = device.noises.each_mut().map(SensorNoise::draw);
            let own = std::array::from_fn(|axis| {
                let (position, noise) = (device.position(axis), noises[axis]);
                // Without any, it is the position to the last bit.
                let noisy = if noise == 0.0 {
                    position
                } else {
                    position + noise
                };
                device.samplers[axis].sample(noisy)
            });
            device.device.out(Vec3(own)).0
        });
        measured.collect()
    }

    /// Returns the force that the motors of a device take from a command `[N]`: along each of its axes at most their
    /// largest force.
    ///
    /// # Panics
    ///
    /// There is no device of that number.
    #[must_use]
    pub fn given_force(&self, device: usize, force: Vector) -> Vector {
        self.devices[device].given(force)
    }

    /// Whether a motor of a device has a largest force.
    #[must_use]
    pub fn has_limits(&self) -> bool {
        let mut devices = self.devices.iter();
        devices.any(|it| it.device.drivetrain.largest_force < f64::INFINITY)
    }

    /// Returns the present positions of the tools' centres `[m]`.
    #[must_use]
    pub fn positions(&self) -> Vec<Vector> {
        self.each(PlantDevice::position)
    }

    /// Returns the present velocities `[m/s]`.
    #[must_use]
    pub fn velocities(&self) -> Vec<Vector> {
        self.each(PlantDevice::velocity)
    }

    /// Returns the measured orientations of the tools: the rotation vector of each from the start, rounded to its
    /// quantum, as a unit quaternion `[w, x, y, z]`; the identity for a device that does not turn.
    #[must_use]
    pub fn measure_orientations(&self) -> Vec<[f64; 4]> {
        self.turned(HeldTurning::measured)
    }

    /// Returns the present orientations of the tools.
    #[must_use]
    pub fn orientations(&self) -> Vec<[f64; 4]> {
        self.turned(HeldTurning::orientation)
    }

    fn turned(&self, of: impl Fn(&HeldTurning) -> [f64; 4]) -> Vec<[f64; 4]> {
        let turnings = self.devices.iter().map(|device| device.turning.as_ref());
        turnings
            .map(|turning| turning.map_or([1.0, 0.0, 0.0, 0.0], &of))
            .collect()
    }

    /// Returns the present angular velocities of the tools in world axes `[rad/s]`.
    #[must_use]
    pub fn angular_velocities(&self) -> Vec<Vector> {
        let turnings = self.devices.iter().map(|device| device.turning.as_ref());
        turnings
            .map(|turning| turning.map_or([0.0; 3], HeldTurning::angular_velocity))
            .collect()
    }

    fn each(&self, value: impl Fn(&PlantDevice, usize) -> f64) -> Vec<Vector> {
        self.devices
            .iter()
            .map(|device| {
                let own = Vec3(std::array::from_fn(|axis| value(device, axis)));
                device.device.out(own).0
            })
            .collect()
    }

    /// Applies the force on each tool `[N]` computed from this sample, one for each device, and advances by a period.
    /// A missing force counts as 0 N, an excess one is ignored.
    pub fn hold(&mut self, forces: &[Vector]) {
        self.hold_wrenches(forces, &[]);
    }

    /// Applies forces as [`hold`](Self::hold) does, and a torque on each tool about its mass centre `[N m]`; a device
    /// that does not turn ignores it.
    pub fn hold_wrenches(&mut self, forces: &[Vector], torques: &[Vector]) {
        self.begin_interval();
        self.advance(forces, &[], torques, self.period);
        self.samples += 1;
    }

    /// Begins an interval of [`delivered`](Self::delivered).
    pub fn begin_interval(&mut self) {
        self.durations.push(0.0);
        for device in &mut self.devices {
            device.impulses.push([0.0; 3]);
            device.slopes.push([0.0; 3]);
            device.angular_impulses.push([0.0; 3]);
        }
    }

    /// Advances by a `duration` `[s]` under forces `[N]` and torques `[N m]`, as
    /// [`hold_wrenches`](Self::hold_wrenches) does, within the interval that has begun. Each force is the mean over a
    /// period, from the beginning of that interval on, of a line with the slope of the same device `[N/s]`; a missing
    /// slope counts as 0. A slope needs actuators without lag, motors without a largest force, and a device without a
    /// mass table.
    pub fn advance(
        &mut self,
        forces: &[Vector],
        slopes: &[Vector],
        torques: &[Vector],
        duration: f64,
    ) {
        let of = |list: &[Vector], number: usize| list.get(number).copied().unwrap_or_default();
        let age = self.durations.last().copied().unwrap_or_default();
        for (number, device) in self.devices.iter_mut().enumerate() {
            let line = HeldLine {
                force: device.given(of(forces, number)),
                slope: of(slopes, number),
                since_middle: age - 0.5 * self.period,
            };
            device.hold_slope(line.slope);
            device.advance(line, of(torques, number), self.now, duration);
        }
        self.now += duration;
        if let Some(last) = self.durations.last_mut() {
            *last += duration;
        }
    }

    /// Forgets what was delivered up to now, but for the interval in progress: a loop without an end has no room for
    /// it.
    pub fn forget_delivered(&mut self) {
        let forgotten = self.durations.len().saturating_sub(1);
        self.durations.drain(..forgotten);
        for device in &mut self.devices {
            device.impulses.drain(..forgotten);
            device.slopes.drain(..forgotten);
            device.angular_impulses.drain(..forgotten);
        }
    }

    /// Mean force on the tool of a device `[N]` over each interval up to now.
    ///
    /// # Panics
    ///
    /// There is no device of that number.
    #[must_use]
    pub fn delivered(&self, device: usize) -> Vec<Vector> {
        let PlantDevice {
            device, impulses, ..
        } = &self.devices[device];
        let own = self.means(impulses).into_iter();
        own.map(|mean| device.out(Vec3(mean)).0).collect()
    }

    /// Slope of the force on the tool of a device over each interval up to now, along the device's axes `[N/s]`.
    ///
    /// # Panics
    ///
    /// There is no device of that number.
    #[must_use]
    pub fn delivered_slopes(&self, device: usize) -> &[Vector] {
        &self.devices[device].slopes
    }

    /// Returns the mean torque on the tool of a device over each interval `[N m]`.
    ///
    /// # Panics
    ///
    /// There is no device of that number.
    #[must_use]
    pub fn delivered_torque(&self, device: usize) -> Vec<Vector> {
        self.means(&self.devices[device].angular_impulses)
    }

    fn means(&self, impulses: &[Vector]) -> Vec<Vector> {
        impulses
            .iter()
            .zip(&self.durations)
            .map(|(impulse, duration)| impulse.map(|j| j / duration))
            .collect()
    }
}

#[cfg(test)]
#[path = "plant_tests.rs"]
mod tests;

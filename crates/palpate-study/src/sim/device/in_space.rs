//! The device of a world, which moves along three axes, each by itself.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Cut, Device, DeviceError, Line, Pose, Vector, Wrench, ZeroWriter,
};
use palpate_scene::world::{WorldDevice, WorldScene};
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::DevicePlant as Moved;
use palpate_testbed::held_mass::HeldMass;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::measure::{Sampler, SensorNoise};
use palpate_testbed::world::HeldTurning;

use super::turning_pointer::{TurningPointer, TurningWish};
use super::{PointerDevice, PointerHand, PointerParams};
use crate::sim::plant::noisy;
use crate::sim::world::{reference_point, reference_turning};

/// Most forces that begin later: those of the longest delay that a scene can state.
const MAX_LATER: usize = DelayedHold::LONGEST_DELAY + 1;

/// The device of a world with its hand, simulated on the loop's clock. Along each of its axes it is a mass in a hand,
/// with the parameters of the scene. The hand also turns a six-axis device.
#[derive(Clone, Debug)]
pub struct SpatialDevice<C> {
    clock: C,
    capabilities: Capabilities,
    /// The device in the scene, which defines its axes.
    device: WorldDevice,
    axes: [Axis; 3],
    /// Rotation of a six-axis device.
    turning: Option<HeldTurning>,
    /// Time until the hand releases the rotation; `None`: never, or it has.
    releases_after: Option<Duration>,
    moved_until: Option<Duration>,
    /// Line that the motors hold on the device.
    held: Line,
    /// Instant at which that line began.
    begun: Duration,
    /// Last written line.
    written: Line,
    /// Time from a write to the beginning of its force.
    late: Duration,
    /// Lines that begin later, with the instant of each, oldest first.
    later: VecDeque<(Duration, Line)>,
    cut: Cut,
}

/// One axis.
#[derive(Clone, Debug)]
enum Axis {
    /// The mass in its hand, its motor and its sensor.
    Moves {
        mass: Box<HeldMass>,
        motor: Actuator,
        sensor: Sampler,
        noise: SensorNoise,
    },
    /// The device lacks it: its mechanism holds it at this place `[m]`.
    Stays(f64),
}

impl Axis {
    fn position(&self) -> f64 {
        match self {
            Self::Moves { mass, .. } => mass.position(),
            Self::Stays(position) => *position,
        }
    }

    fn measured(&mut self) -> f64 {
        match self {
            Self::Moves {
                mass,
                sensor,
                noise,
                ..
            } => sensor.sample(noisy(mass.position(), noise.draw())),
            Self::Stays(position) => *position,
        }
    }
}

impl<C: Clock> SpatialDevice<C> {
    /// Creates the device of a scene at the index `number`, and its hand. Its motors have the lag, the gain and the
    /// delay of the scene, without a fraction of a period and the jitter of commands; its noise follows the seed of the
    /// scene.
    ///
    /// # Errors
    /// There is no such device, or a quantity of the device, the hand or the motors is out of range.
    pub fn new(scene: &WorldScene, number: usize, clock: C) -> Result<Self, InvalidParameter> {
        let device = device_of(scene, number)?;
        let motors = scene.timing.actuator;
        let turning = device.turning.as_ref().map(reference_turning);
        let turning = turning
            .map(|turning| HeldTurning::checked(&turning, motors))
            .transpose()?;
        let held = reference_point("", device);
        let seeds = noise_seeds(scene, number);
        let axis = |number: usize| -> Result<Axis, InvalidParameter> {
            if !device.moves_along(number) {
                return Ok(Axis::Stays(device.own(device.position)[number]));
            }
            let mass = held.held_along(number)?;
            let limited = mass.with_largest_force(device.drivetrain.largest_force)?;
            Ok(Axis::Moves {
                mass: Box::new(limited),
                noise: SensorNoise::normal(device.drivetrain.noise, seeds[number])?,
                motor: Actuator::new(motors)?,
                sensor: sensor(device.quantum[number])?,
            })
        };
        Ok(Self {
            clock,
            capabilities: Capabilities {
                // Torques are constants, and neither a lag nor a limited motor delivers a line.
                holds_lines: turning.is_none()
                    && motors.lag == 0.0
                    && device.drivetrain.largest_force == f64::INFINITY,
                ..capabilities("simulated", device)
            },
            device: device.clone(),
            axes: [axis(0)?, axis(1)?, axis(2)?],
            turning,
            releases_after: device
                .hand
                .release
                .and_then(|release| Duration::try_from_secs_f64(release).ok()),
            moved_until: None,
            held: Line::NONE,
            begun: Duration::ZERO,
            written: Line::NONE,
            late: Duration::try_from_secs_f64(scene.timing.device_delay()).unwrap_or_default(),
            later: VecDeque::with_capacity(MAX_LATER),
            cut: Cut::none(),
        })
    }

    /// True position `[m]`, at the last call.
    #[must_use]
    pub fn position(&self) -> Vector {
        self.device.out(self.axes.each_ref().map(Axis::position))
    }

    /// Returns the true orientation at the last call, a unit quaternion `[w, x, y, z]`; `None` for a three-axis device.
    #[must_use]
    pub fn orientation(&self) -> Option<[f64; 4]> {
        self.turning.as_ref().map(HeldTurning::orientation)
    }

    /// Moves on to now, and returns that.
    fn move_on(&mut self) -> Duration {
        let now = self.clock.now();
        let mut from = *self.moved_until.get_or_insert(now);
        if let Some(cut) = self.cut.between(from, now) {
            self.hold(from, cut);
            self.held = Line::NONE;
            self.later.clear();
            from = cut;
        }
        self.hold(from, now);
        self.moved_until = Some(now);
        now
    }

    /// Moves under what is held, and under what begins on the way.
    fn hold(&mut self, mut from: Duration, until: Duration) {
        while let Some(&(begins, line)) = self.later.front()
            && begins <= until
        {
            self.drive(from, begins);
            from = from.max(begins);
            (self.held, self.begun) = (line, begins);
            self.later.pop_front();
        }
        self.drive(from, until);
    }

    /// Moves under the line that the motors hold: to its end, then under its last value.
    fn drive(&mut self, mut from: Duration, until: Duration) {
        let over = self.begun.saturating_add(self.held.duration);
        if !self.held.is_constant() && from < over.min(until) {
            let ends = until.min(over);
            let middle = ((from + ends) / 2).saturating_sub(self.begun);
            let (wrench, slope) = (self.held.at(middle), self.held.slope);
            self.advance(wrench, slope, ends - from);
            from = ends;
        }
        self.advance(self.held.end(), [0.0; 3], until.saturating_sub(from));
    }

    /// Moves under a wrench, the mean over `duration`, and the `slope` of its force `[N/s]`.
    fn advance(&mut self, wrench: Wrench, slope: Vector, duration: Duration) {
        self.turn_on(wrench.torque, duration);
        let duration = duration.as_secs_f64();
        if duration > 0.0 {
            let [held, slope] = [wrench.force, slope].map(|vector| self.device.own(vector));
            for ((axis, force), slope) in self.axes.iter_mut().zip(held).zip(slope) {
                if let Axis::Moves { mass, motor, .. } = axis {
                    // The testbed has the force on the object, which is the other one.
                    if slope == 0.0 {
                        motor.drive(&mut **mass, -force, duration);
                    } else {
                        motor.drive_line(&mut **mass, -force, -slope, duration);
                    }
                }
            }
        }
    }

    /// Commands a line, and returns what the motors hold.
    fn command(&mut self, line: Line) -> Line {
        let now = self.move_on();
        self.cut.is_over();
        self.written = self.given(line);
        if self.late > Duration::ZERO {
            if self.later.len() == MAX_LATER {
                self.later.pop_front();
            }
            self.later.push_back((now + self.late, self.written));
        } else {
            (self.held, self.begun) = (self.written, now);
        }
        self.held
    }

    /// Advances the rotation under the held torque. The hand releases the rotation at its time.
    fn turn_on(&mut self, torque: Vector, duration: Duration) {
        let Some(turning) = &mut self.turning else {
            return;
        };
        let turn_for = |part: Duration, turning: &mut HeldTurning| {
            if !part.is_zero() {
                let _ = turning.advance(torque, part.as_secs_f64());
            }
        };
        let Some(until) = self.releases_after else {
            return turn_for(duration, turning);
        };
        turn_for(duration.min(until), turning);
        self.releases_after = until.checked_sub(duration);
        if duration >= until {
            turning.release();
            self.releases_after = None;
            turn_for(duration - until, turning);
        }
    }

    /// Returns the line that the motors hold in answer to a command: along each axis at most their largest force. A device
    /// that holds lines has no such limit.
    fn given(&self, line: Line) -> Line {
        let largest = self.device.drivetrain.largest_force;
        let own = self.device.own(line.wrench.force);
        let given = own.map(|along| along.clamp(-largest, largest));
        Line {
            wrench: Wrench {
                // Without a change it is the command to the last bit.
                force: if given == own {
                    line.wrench.force
                } else {
                    self.device.out(given)
                },
                torque: if self.capabilities.torque_axes == 0 {
                    [0.0; 3]
                } else {
                    line.wrench.torque
                },
            },
            ..line
        }
    }
}

impl<C: Clock> Device for SpatialDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let time = self.move_on();
        let position = self.device.out(self.axes.each_mut().map(Axis::measured));
        Ok(Pose {
            orientation: self.turning.as_ref().map(HeldTurning::measured),
            ..Pose::at(position, time)
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        Ok(self.command(wrench.into()).wrench)
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        Ok(self.command(line))
    }

    fn last_sent(&self) -> Option<Line> {
        Some(self.written)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        Some(self.cut.writer(&self.clock))
    }
}

/// Target position and orientation of a pointer's hand in a world; any thread may set them at any time.
#[derive(Clone, Debug)]
pub struct SpatialHand {
    along: [PointerHand; 3],
    turned: TurningWish,
    /// The device that it holds, which has axes. The loop does not look at it.
    device: Arc<Mutex<Option<WorldDevice>>>,
}

impl SpatialHand {
    /// Creates a hand that holds its device at a target `[m]`.
    #[must_use]
    pub fn at(target: Vector) -> Self {
        Self {
            along: target.map(PointerHand::at),
            turned: TurningWish::none(),
            device: Arc::new(Mutex::new(None)),
        }
    }

    /// The device that it holds, where one is known.
    fn device(&self) -> Option<WorldDevice> {
        let device = self.device.lock();
        device.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Holds this device from now on, where it wanted to hold one.
    fn take(&self, device: &WorldDevice) {
        let target = self.target();
        *self.device.lock().unwrap_or_else(PoisonError::into_inner) = Some(device.clone());
        if let Some(target) = target {
            self.move_to(target);
        }
    }

    /// Whether it holds a device.
    fn holds(&self) -> bool {
        self.along.iter().all(|hand| hand.target().is_some())
    }

    /// Sets the target position `[m]`, and grips the device again if the hand had released it. Non-finite coordinates
    /// are ignored.
    pub fn move_to(&self, target: Vector) {
        let target = self.device().map_or(target, |device| device.own(target));
        for (hand, target) in self.along.iter().zip(target) {
            hand.move_to(target);
        }
    }

    /// Lets go of the device.
    pub fn disable_output(&self) {
        for hand in &self.along {
            hand.disable_output();
        }
    }

    /// Sets the target orientation of a six-axis device, a quaternion `[w, x, y, z]` of any length above 0. Invalid
    /// quaternions are ignored.
    pub fn turn_to(&self, orientation: [f64; 4]) {
        self.turned.turn_to(orientation);
    }

    /// Wants it to be turned as it begins.
    pub fn turn_back(&self) {
        self.turned.forget();
    }

    /// Returns the target orientation of the device, a unit quaternion `[w, x, y, z]`; `None`: the initial orientation.
    #[must_use]
    pub fn orientation(&self) -> Option<[f64; 4]> {
        self.turned.get()
    }

    /// Returns the target position `[m]`; `None` if the hand has released the device.
    #[must_use]
    pub fn target(&self) -> Option<Vector> {
        let [x, y, z] = self.along.each_ref().map(PointerHand::target);
        let own = [x?, y?, z?];
        Some(self.device().map_or(own, |device| device.out(own)))
    }
}

/// A device in a [`SpatialHand`]: along each of its axes a [`PointerDevice`] with the mass that the device has
/// along it. One of six axes is turned by the hand, too.
#[derive(Clone, Debug)]
pub struct SpatialPointer<C> {
    capabilities: Capabilities,
    device: WorldDevice,
    hand: SpatialHand,
    axes: [PointerAxis<C>; 3],
    turning: Option<TurningPointer<C>>,
}

impl<C: Clock> SpatialPointer<C> {
    /// The device of a scene at the index `number` in a pointer's hand: its masses, sensors, noise, motors and place at
    /// the start are the scene's, and so are delay, lag and gain, as [`SpatialDevice::new`] has them. Its friction is
    /// that of the scene, but at least that of [`PointerParams::default`], whose hand it has; the hand turns the device
    /// with the stiffness and damping of the scene's hand, or 0.3 N m/rad.
    ///
    /// # Errors
    /// There is no such device, or a quantity is out of range.
    pub fn new(
        scene: &WorldScene,
        number: usize,
        hand: &SpatialHand,
        clock: C,
    ) -> Result<Self, InvalidParameter> {
        let device = device_of(scene, number)?;
        hand.take(device);
        let (usual, drivetrain) = (PointerParams::default(), &device.drivetrain);
        let seeds = noise_seeds(scene, number);
        let axis = |number: usize| -> Result<_, InvalidParameter> {
            let position = device.own(device.position)[number];
            if !device.moves_along(number) {
                return Ok(PointerAxis::Stays(position));
            }
            let params = PointerParams {
                device_mass: device.mass[number],
                viscous_friction: drivetrain.viscous_friction.max(usual.viscous_friction),
                dry_friction: drivetrain.coulomb_friction.max(usual.dry_friction),
                encoder_quantum: device.quantum[number],
                noise: drivetrain.noise,
                seed: seeds[number],
                position,
                largest_force: Some(drivetrain.largest_force).filter(|force| force.is_finite()),
                delay_seconds: scene.timing.device_delay(),
                actuator: scene.timing.actuator,
                ..usual
            };
            let pointer = PointerDevice::new(params, &hand.along[number], clock.clone())?;
            Ok(PointerAxis::Moves(Box::new(pointer)))
        };
        let turning = device.turning.as_ref();
        let turning = turning
            .map(|turning| TurningPointer::new(turning, &scene.timing, &hand.turned, clock.clone()))
            .transpose()?;
        Ok(Self {
            capabilities: capabilities("pointer", device),
            hand: hand.clone(),
            device: device.clone(),
            axes: [axis(0)?, axis(1)?, axis(2)?],
            turning,
        })
    }
}

impl<C: Clock> Device for SpatialPointer<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        // The clocks are read within microseconds: by less than the quantum of any sensor.
        let mut position = [0.0; 3];
        let mut last = Duration::ZERO;
        for (axis, position) in self.axes.iter_mut().zip(&mut position) {
            match axis {
                PointerAxis::Moves(pointer) => {
                    let read = pointer.read()?;
                    [*position, ..] = read.position;
                    last = read.time;
                }
                PointerAxis::Stays(place) => *position = *place,
            }
        }
        let is_held = self.hand.holds();
        let turning = self.turning.as_mut();
        Ok(Pose {
            orientation: turning.map(|turning| turning.read(is_held)),
            ..Pose::at(self.device.out(position), last)
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let mut held = [0.0; 3];
        let force = self.device.own(wrench.force);
        for ((axis, force), held) in self.axes.iter_mut().zip(force).zip(&mut held) {
            if let PointerAxis::Moves(pointer) = axis {
                [*held, ..] = pointer.write([force, 0.0, 0.0].into())?.force;
            }
        }
        let is_held = self.hand.holds();
        let torque = match &mut self.turning {
            Some(turning) if self.capabilities.torque_axes > 0 => {
                turning.write(wrench.torque, is_held)
            }
            _ => [0.0; 3],
        };
        Ok(Wrench {
            force: self.device.out(held),
            torque,
        })
    }

    fn last_sent(&self) -> Option<Line> {
        let mut sent = [0.0; 3];
        for (axis, sent) in self.axes.iter().zip(&mut sent) {
            if let PointerAxis::Moves(pointer) = axis {
                [*sent, ..] = pointer.last_sent()?.wrench.force;
            }
        }
        let turning = self.turning.as_ref();
        let sent = Wrench {
            force: self.device.out(sent),
            torque: turning.map_or([0.0; 3], TurningPointer::last_sent),
        };
        Some(sent.into())
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        let pointers = self.axes.iter_mut().filter_map(|axis| match axis {
            PointerAxis::Moves(pointer) => Some(pointer.zero_writer()),
            PointerAxis::Stays(_) => None,
        });
        let mut all = pointers.collect::<Option<Vec<_>>>()?;
        all.extend(self.turning.as_mut().map(TurningPointer::zero_writer));
        Some(Box::new(AllZero(all)))
    }
}

/// One axis of a [`SpatialPointer`].
#[derive(Clone, Debug)]
enum PointerAxis<C> {
    Moves(Box<PointerDevice<C>>),
    /// The device lacks it: its mechanism holds it at this place `[m]`.
    Stays(f64),
}

/// Commands no force along all axes, and no torque.
struct AllZero(Vec<Box<dyn ZeroWriter>>);

impl ZeroWriter for AllZero {
    fn write_zero(&mut self) {
        for axis in &mut self.0 {
            axis.write_zero();
        }
    }
}

fn device_of(scene: &WorldScene, number: usize) -> Result<&WorldDevice, InvalidParameter> {
    scene.devices.get(number).ok_or(InvalidParameter {
        name: "device",
        value: number as f64,
        allowed: "the index of a device of the scene",
    })
}

/// Returns the seed of each axis of a device: the axes that move count on from the scene's seed, over all devices, as
/// in [`WorldPlant`](palpate_testbed::world::WorldPlant).
fn noise_seeds(scene: &WorldScene, number: usize) -> [u64; 3] {
    let axes = scene.devices.iter().flat_map(|device| {
        let axes = 0..device.mass.len();
        axes.map(|axis| u64::from(device.moves_along(axis)))
    });
    let mut counted = scene.timing.imperfections.seed;
    let mut seeds = axes.map(|moves| {
        let seed = counted;
        counted = counted.wrapping_add(moves);
        seed
    });
    let mut own = seeds.by_ref().skip(3 * number);
    [0, 1, 2].map(|_| own.next().unwrap_or_default())
}

fn capabilities(name: &str, device: &WorldDevice) -> Capabilities {
    let mut masses = device.mass.into_iter().filter(|mass| mass.is_finite());
    let first = masses.next();
    let turning = device.turning.as_ref();
    let gives_torque = turning.is_some_and(|turning| turning.gives_torque);
    Capabilities {
        torque_axes: if gives_torque { 3 } else { 0 },
        measures_orientation: turning.is_some(),
        largest_force: Some(device.drivetrain.largest_force).filter(|force| force.is_finite()),
        effective_mass: first.filter(|first| masses.all(|mass| mass == *first)),
        encoder_quantum: Some(device.quantum.into_iter().fold(0.0, f64::max)),
        ..Capabilities::unknown(name, 3)
    }
}

fn sensor(quantum: f64) -> Result<Sampler, InvalidParameter> {
    if quantum > 0.0 {
        Sampler::quantum(quantum)
    } else {
        Ok(Sampler::Ideal)
    }
}

#[cfg(test)]
#[path = "in_space_tests.rs"]
mod tests;

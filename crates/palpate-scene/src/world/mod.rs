//! Scenes that the world renderer renders: several devices, bodies and contacts in space.

pub(crate) mod device;
pub(crate) mod field;
mod file;
mod guard;
mod hand;
pub(crate) mod joint;
pub(crate) mod mass_table;
mod mesh;
mod mesh_contact;
mod numbers;
mod obj;
pub(crate) mod pair;
pub(crate) mod per_axis;
mod place;
mod rendering;
pub(crate) mod shape;
mod stl;

pub use file::WorldFile;
pub use guard::{GUARD_TURNING, WORLD_GUARD_ALLOWANCE, hand_guard, usual_guard};
pub use rendering::WorldSettings;

use std::collections::HashMap;
use std::sync::Arc;

use palpate_core::Actuation;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::timeline::Timeline;
pub use palpate_testbed::world::{Drivetrain, LedPath, Swing};
use palpate_world::{Quaternion, Vector, World, WorldGuard};

use crate::delay::Delay;
use crate::timing::Timing;

/// A closed loop of devices and a world, to simulate or to render.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldScene {
    /// A line for tables and figures.
    pub title: String,
    /// Tools, bodies and contacts; one tool for each device.
    pub world: World,
    /// The devices, in the order of their tools.
    pub devices: Vec<WorldDevice>,
    /// The loop.
    pub timing: WorldTiming,
    /// Method, settings and model values of the renderer.
    pub render: WorldRender,
    /// Duration `[s]`.
    pub duration: f64,
}

/// A device and its hand. Its axes are those of the world or its own.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldDevice {
    /// Its axes, unit vectors at right angles along the world's: mass, quantum and tremor are along them, positions,
    /// velocities and forces along the world's. `None`: the world's own. Those of its tool are the same
    /// ([`Tool::own_axes`](palpate_world::Tool::own_axes)).
    pub own_axes: Option<[Vector; 3]>,
    /// Effective mass along each axis, each above 0 `[kg]`; infinite along an axis that the device lacks
    /// ([`Tool::axes`](palpate_world::Tool::axes)), along which its mechanism holds it.
    pub mass: Vector,
    /// Position at the start `[m]`.
    pub position: Vector,
    /// Velocity at the start `[m/s]`.
    pub velocity: Vector,
    /// Quantum of the position sensor along each axis, 0 for an ideal one `[m]`.
    pub quantum: Vector,
    /// Friction, motors and noise of the sensors.
    pub drivetrain: Drivetrain,
    /// The hand.
    pub hand: WorldHand,
    /// Rotation; `None` for a three-axis device.
    pub turning: Option<DeviceTurning>,
}

impl WorldDevice {
    /// Whether the device has a motor along one of its axes; its mechanism holds it along the others.
    #[must_use]
    pub fn moves_along(&self, axis: usize) -> bool {
        self.mass[axis].is_finite()
    }

    /// A vector of the world along the device's axes.
    #[must_use]
    pub fn own(&self, vector: Vector) -> Vector {
        self.own_axes.map_or(vector, |axes| {
            axes.map(|axis| {
                axis.iter()
                    .zip(vector)
                    .map(|(axis, part)| axis * part)
                    .sum()
            })
        })
    }

    /// A vector along the device's axes in the world.
    #[must_use]
    pub fn out(&self, own: Vector) -> Vector {
        self.own_axes.map_or(own, |axes| {
            [0, 1, 2].map(|to| {
                axes.iter()
                    .zip(own)
                    .map(|(axis, part)| axis[to] * part)
                    .sum()
            })
        })
    }
}

/// Rotation of a six-axis device about its centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceTurning {
    /// Moments of inertia along the tool's axes, each above 0 `[kg m^2]`.
    pub inertia: Vector,
    /// Orientation at the start.
    pub orientation: Quaternion,
    /// Angular velocity at the start, along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// Quantum of the measured angles, 0 for an ideal sensor `[rad]`.
    pub quantum: f64,
    /// Whether the device gives a torque. If not, its hand alone turns the tool, and feels no torque.
    pub gives_torque: bool,
    /// The hand.
    pub hand: TurningHand,
}

/// Torque, spring and damper of a hand that turns its device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningHand {
    /// Constant torque along the world's axes `[N m]`.
    pub torque: Vector,
    /// Stiffness of the hand's spring, at least 0 `[N m/rad]`.
    pub stiffness: f64,
    /// Damping of the hand, at least 0 `[N m s/rad]`.
    pub damping: f64,
    /// The orientation that the spring turns to.
    pub rest: Quaternion,
    /// Tremor, its amplitude in `[N m]`.
    pub tremor: Tremor,
}

/// A hand that pushes, and that may pull its device to a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldHand {
    /// Constant force on the device `[N]`.
    pub force: Vector,
    /// Stiffness of the hand's spring, at least 0 `[N/m]`.
    pub stiffness: f64,
    /// Damping of the hand, at least 0 `[N s/m]`.
    pub damping: f64,
    /// Rest position of the spring `[m]`.
    pub rest: Vector,
    /// Swing of the rest position.
    pub swing: Option<Swing>,
    /// Recorded rest position, in place of `rest` and swing.
    pub path: Option<Arc<LedPath>>,
    /// Mass that moves with the device, at least 0; no method counts it `[kg]`.
    pub mass: f64,
    /// Time at which the hand releases the device permanently `[s]`.
    pub release: Option<f64>,
    /// Tremor of the hand.
    pub tremor: Tremor,
}

/// A sine force along each axis, of the same amplitude and frequency; along y and z it is a third and two
/// thirds of a turn behind x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tremor {
    /// Amplitude along each axis `[N]`.
    pub amplitude: f64,
    /// Frequency `[Hz]`.
    pub frequency_hz: f64,
}

/// Sampling of the loop, and timing of its commands.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldTiming {
    /// Nominal time between two samples, above 0 `[s]`.
    pub period: f64,
    /// Delay from a sample to the start of its command.
    pub delay: Delay,
    /// Lag and gain of the actuators.
    pub actuator: ActuatorParams,
    /// Imperfections of the loop besides.
    pub imperfections: Timing,
}

impl WorldTiming {
    /// Returns the delay that a simulated device has in a loop in time, and that the renderer models: without a
    /// fraction of a period, which stands for the computing time of a loop `[s]`.
    #[must_use]
    pub fn device_delay(&self) -> f64 {
        self.delay.without_fraction().time(self.period)
    }

    /// Whether every sample is on time and every command acts at its sample.
    #[must_use]
    pub fn is_perfect(&self) -> bool {
        self.delay.time(self.period) == 0.0 && self.imperfections.is_perfect()
    }

    /// The samples and commands of the loop over a number of `periods`.
    ///
    /// # Errors
    /// There is no period, or a number is out of its range.
    pub fn timeline(&self, periods: usize) -> Result<Timeline, InvalidParameter> {
        Timeline::new(
            self.imperfections.schedule(self.period, self.delay),
            periods,
        )
    }
}

impl WorldScene {
    /// Seed of the random numbers of timing and sensor noise; none if nothing is random.
    #[must_use]
    pub fn random_seed(&self) -> Option<u64> {
        let timing = &self.timing.imperfections;
        let mut devices = self.devices.iter();
        let is_noisy = devices.any(|device| device.drivetrain.noise > 0.0);
        (timing.is_random() || is_noisy).then_some(timing.seed)
    }
}

/// A virtual coupling between device and proxy; missing keys are `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coupling {
    /// Stiffness, of `god-object` too `[N/m]`.
    pub stiffness: Option<f64>,
    /// Proxy mass `[kg]`.
    pub mass: Option<f64>,
    /// Stiffness of its turning `[N m/rad]`.
    pub rotational_stiffness: Option<f64>,
    /// Moment of inertia of the proxy about any axis `[kg m^2]`.
    pub inertia: Option<f64>,
}

/// Method, settings and model values of the renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldRender {
    /// Name of the method to run when none is named.
    pub method: String,
    /// Model value of each device's mass along each axis `[kg]`; by default the true one.
    pub device_mass: Vec<Vector>,
    /// Model value of the moments of inertia of each six-axis device `[kg m^2]`; by default the true ones.
    pub device_inertia: Vec<Option<Vector>>,
    /// Model value of the quantum of the position sensors `[m]`; `None`: the largest of the true ones.
    pub sensor_quantum: Option<f64>,
    /// Settings of the methods for comparison, by their names; one without an entry has none.
    pub settings: HashMap<&'static str, WorldSettings>,
    /// Largest speed of a device that is believed `[m/s]`; `None`: the default of the loop.
    pub speed_limit: Option<f64>,
    /// Longest time between two samples that is bridged `[s]`; `None`: the default of the loop.
    pub largest_gap: Option<f64>,
    /// Largest force on each device, as a length `[N]`.
    pub force_limit: Option<f64>,
    /// Largest torque on each device, as a length `[N m]`.
    pub torque_limit: Option<f64>,
    /// Model of the actuators; by default the true delay, lag and gain, without a fraction of a period.
    pub actuation: Actuation<f64>,
    /// Bound on the energy that the forces on all devices give out.
    pub guard: WorldGuard,
}

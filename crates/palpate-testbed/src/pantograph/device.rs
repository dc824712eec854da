//! The pantograph as a device: motors, encoders, controller and safety box.

use super::dynamics::Dynamics;
use super::kinematics::{ArmPose, dot};
use super::motion::{HeldInputs, State};
use super::parameter::PantographParameter as Parameter;
use super::params::{Actuation, PantographParams};
use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::error::{finite, positive};

/// Controller that holds the end-point at one x. It runs at the samples and its force is held.
///
/// With the measured x, e = target − x and the period T it asks for the force along x
/// k_p e + Σ k_i e T − k_d Δx/T, in which the sum and the whole stay within ± `max_force`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid {
    /// x to hold `[m]`.
    pub target: f64,
    /// Proportional gain k_p `[N/m]`.
    pub proportional: f64,
    /// Integral gain k_i `[N/(m s)]`.
    pub integral: f64,
    /// Derivative gain k_d `[N s/m]`.
    pub derivative: f64,
    /// Limit of the force `[N]`.
    pub max_force: f64,
}

/// The region in which the motors stay connected, bounds included `[m]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SafetyBox {
    /// Lowest and highest x.
    pub x: [f64; 2],
    /// Lowest and highest y.
    pub y: [f64; 2],
}

impl SafetyBox {
    fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.x[0]..=self.x[1]).contains(&x) && (self.y[0]..=self.y[1]).contains(&y)
    }
}

/// State of the PID controller.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct PidMemory {
    integral_force: f64,
    previous_x: Option<f64>,
    force: f64,
}

/// A pantograph whose contact direction is y.
///
/// # Forces
///
/// The force to render, −f along y, and the controller's along x become torques by the transpose
/// of the Jacobian **at the last [`sample`](DevicePlant::sample)**, each limited to the motor's range,
/// and the torques are held, however often [`advance`](DevicePlant::advance) is called. Before the
/// first sample every advance counts as a sample of its own, without the controller. The user's
/// constant force acts on the end-point itself
/// ([`with_user_force`](Pantograph::with_user_force)), or comes from the motors as the other forces
/// do ([`with_user_force_by_motors`](Pantograph::with_user_force_by_motors)).
///
/// # Energy
///
/// `advance` returns the work ∫ f y′ dt of the commanded force. The work of the motors,
/// [`motor_work`](Pantograph::motor_work), differs because the motors hold torques, saturate and may be disconnected;
/// the two agree under [`Actuation::Ideal`] without a controller. Within the integration's tolerance the balance is
/// always
///
/// ```text
/// stored_energy + dissipated − motor_work = constant
/// ```
///
/// # When it stops
///
/// If a sample finds the measured end-point outside the safety box, the motors are disconnected until
/// [`reset`](Pantograph::reset). Motion into a singular pose ends there, because the motor angles no longer determine
/// the subsequent motion (a mechanism whose elbows meet changes its assembly). The device jams, loses its kinetic
/// energy and stays; [`starting_at`](Pantograph::starting_at) frees it. Free arms do reach such poses: without a stop,
/// motion towards meeting elbows passes through them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pantograph {
    params: PantographParams,
    dynamics: Dynamics,
    pid: Option<Pid>,
    safety_box: Option<SafetyBox>,
    user_force: [f64; 2],
    /// The part of the user's force that the motors give.
    motor_user_force: [f64; 2],
    state: State,
    /// The pose of `state`.
    pose: ArmPose,
    /// The pose whose Jacobian the motors use, once there was a sample.
    sampled: Option<ArmPose>,
    memory: PidMemory,
    torques: [f64; 2],
    saturated: bool,
    disconnected: bool,
    jammed: bool,
    motor_work: f64,
}

impl Pantograph {
    /// A device at rest in its home pose, without user, controller and safety box.
    ///
    /// # Errors
    ///
    /// A parameter is outside its range, or the home pose does not exist or is singular.
    pub fn new(params: PantographParams) -> Result<Self, InvalidParameter<Parameter>> {
        let params = params.checked()?;
        let pose = regular_pose(&params, params.home, Parameter::Home)?;
        Ok(Self {
            params,
            dynamics: Dynamics::new(&params),
            pid: None,
            safety_box: None,
            user_force: [0.0, 0.0],
            motor_user_force: [0.0, 0.0],
            state: State {
                angles: params.home,
                rates: [0.0, 0.0],
                dissipated: 0.0,
            },
            pose,
            sampled: None,
            memory: PidMemory::default(),
            torques: [0.0, 0.0],
            saturated: false,
            disconnected: false,
            jammed: false,
            motor_work: 0.0,
        })
    }

    /// Returns the same device with other motor angles `[rad]` and rates `[rad/s]`, free to move.
    ///
    /// # Errors
    ///
    /// The pose does not exist or is singular, or a rate is not finite.
    pub fn starting_at(
        self,
        angles: [f64; 2],
        rates: [f64; 2],
    ) -> Result<Self, InvalidParameter<Parameter>> {
        let pose = regular_pose(&self.params, angles, Parameter::Angles)?;
        for rate in rates {
            finite(Parameter::Rates, rate, "finite [rad/s]")?;
        }
        Ok(Self {
            state: State {
                angles,
                rates,
                ..self.state
            },
            pose,
            sampled: None,
            memory: PidMemory::default(),
            jammed: false,
            ..self
        })
    }

    /// Returns the same device pushed by a constant force (x, y) `[N]` at its end-point.
    ///
    /// # Errors
    ///
    /// A component is not finite.
    pub fn with_user_force(mut self, force: [f64; 2]) -> Result<Self, InvalidParameter<Parameter>> {
        for component in force {
            finite(Parameter::UserForce, component, "finite [N]")?;
        }
        self.user_force = force;
        Ok(self)
    }

    /// Returns the same device pushed by a constant force (x, y) `[N]` that its motors give, as if it were a
    /// part of the force to render: torques by the Jacobian at the last sample, held, within the motors'
    /// range together with the other forces, and none once the motors are disconnected. Under
    /// [`Actuation::Ideal`] the force itself acts on the end-point.
    ///
    /// # Errors
    ///
    /// A component is not finite.
    pub fn with_user_force_by_motors(
        mut self,
        force: [f64; 2],
    ) -> Result<Self, InvalidParameter<Parameter>> {
        for component in force {
            finite(Parameter::UserForce, component, "finite [N]")?;
        }
        self.motor_user_force = force;
        Ok(self)
    }

    /// Returns the same device with a controller along x.
    ///
    /// # Errors
    ///
    /// The target or a gain is not finite, or the limit is not finite and positive.
    pub fn with_pid(mut self, pid: Pid) -> Result<Self, InvalidParameter<Parameter>> {
        finite(Parameter::Target, pid.target, "finite [m]")?;
        finite(Parameter::Proportional, pid.proportional, "finite [N/m]")?;
        finite(Parameter::Integral, pid.integral, "finite [N/(m s)]")?;
        finite(Parameter::Derivative, pid.derivative, "finite [N s/m]")?;
        positive(Parameter::MaxForce, pid.max_force, "finite and above 0 N")?;
        self.pid = Some(pid);
        Ok(self)
    }

    /// Returns the same device with a safety box.
    ///
    /// # Errors
    ///
    /// A bound is a NaN, or a lower bound is not below its upper bound.
    pub fn with_safety_box(
        mut self,
        safety_box: SafetyBox,
    ) -> Result<Self, InvalidParameter<Parameter>> {
        for [low, high] in [safety_box.x, safety_box.y] {
            InvalidParameter::unless(
                low < high,
                Parameter::SafetyBox,
                low,
                "below its upper bound [m]",
            )?;
        }
        self.safety_box = Some(safety_box);
        Ok(self)
    }

    /// Returns the parameters of the device.
    #[must_use]
    pub fn params(&self) -> &PantographParams {
        &self.params
    }

    /// The mechanism's equations of motion.
    #[must_use]
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// The true pose.
    #[must_use]
    pub fn pose(&self) -> &ArmPose {
        &self.pose
    }

    /// Rates of the motor joints `[rad/s]`.
    #[must_use]
    pub fn rates(&self) -> [f64; 2] {
        self.state.rates
    }

    /// True end-point (x, y) `[m]`.
    #[must_use]
    pub fn end_point(&self) -> [f64; 2] {
        self.pose.position
    }

    /// Velocity of the end-point `[m/s]`.
    #[must_use]
    pub fn end_point_velocity(&self) -> [f64; 2] {
        self.pose.jacobian().map(|row| dot(row, self.state.rates))
    }

    /// The pose that the encoders report; `None` if no such pose exists.
    ///
    /// An encoder reports the last count below the angle, so on average half a count too little.
    #[must_use]
    pub fn measured_pose(&self) -> Option<ArmPose> {
        let angles = match self.params.counts_per_rev {
            None => return Some(self.pose),
            Some(counts) => {
                let quantum = std::f64::consts::TAU / counts;
                self.state
                    .angles
                    .map(|angle| (angle / quantum).floor() * quantum)
            }
        };
        self.params.geometry.forward(angles).ok()
    }

    /// Mass `[kg]` that a force along y feels in the present pose: 1 / (J M⁻¹ Jᵀ)_yy.
    #[must_use]
    pub fn effective_mass_y(&self) -> f64 {
        self.dynamics.effective_mass_y(&self.pose)
    }

    /// Motor torques of the last advance `[N m]`; zero under [`Actuation::Ideal`].
    #[must_use]
    pub fn motor_torques(&self) -> [f64; 2] {
        self.torques
    }

    /// Whether a motor was at its limit in the last advance.
    #[must_use]
    pub fn is_saturated(&self) -> bool {
        self.saturated
    }

    /// Whether the end-point has left the safety box and the motors are off.
    #[must_use]
    pub fn is_disconnected(&self) -> bool {
        self.disconnected
    }

    /// Whether the mechanism has run into a singular pose.
    #[must_use]
    pub fn is_jammed(&self) -> bool {
        self.jammed
    }

    /// Connects the motors again and clears the controller's memory.
    pub fn reset(&mut self) {
        self.disconnected = false;
        self.memory = PidMemory::default();
    }

    /// Work the motors have done on the mechanism so far `[J]`.
    #[must_use]
    pub fn motor_work(&self) -> f64 {
        self.motor_work
    }

    /// Energy lost so far to friction and to running into a singular pose `[J]`.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        self.state.dissipated
    }

    /// The user's constant force at the end-point `[N]`, without what the motors give of it.
    #[must_use]
    pub fn user_force(&self) -> [f64; 2] {
        self.user_force
    }

    /// Advances by `duration` `[s]` under motor torques `[N m]`, limited to the motors' range, and the user's force.
    /// Use it to emulate the board that drives the motors. The controller and the safety box act only in
    /// [`advance`](DevicePlant::advance).
    ///
    /// A non-finite torque counts as 0. A duration that is not finite and positive has no effect.
    pub fn turn(&mut self, torques: [f64; 2], duration: f64) {
        if self.jammed || !duration.is_finite() || duration <= 0.0 {
            return;
        }
        let limit = self.params.max_torque;
        let finite = torques.map(|torque| if torque.is_finite() { torque } else { 0.0 });
        self.saturated = finite.iter().any(|torque| torque.abs() > limit);
        self.torques = finite.map(|torque| torque.clamp(-limit, limit));
        self.move_on([0.0, 0.0], duration);
    }

    /// Moves on under the torques and a force on the end-point `[N]` beside the user's; how far the
    /// end-point came `[m]`.
    fn move_on(&mut self, direct: [f64; 2], duration: f64) -> [f64; 2] {
        let torques = self.torques;
        let (before, angles) = (self.pose.position, self.state.angles);
        let motion = HeldInputs {
            dynamics: &self.dynamics,
            torques,
            force: [
                direct[0] + self.user_force[0],
                direct[1] + self.user_force[1],
            ],
            viscous: self.params.viscous_friction,
            coulomb: self.params.coulomb_friction,
        };
        let moved = motion.advance(&mut self.state, &mut self.pose, duration);
        if moved.is_err() {
            self.jammed = true;
            let lost = self.dynamics.kinetic_energy(&self.pose, self.state.rates);
            self.state.dissipated += lost;
            self.state.rates = [0.0, 0.0];
        }
        // Forces and torques are held, so their work is force times travel.
        let after = self.pose.position;
        let travel = [after[0] - before[0], after[1] - before[1]];
        let turned = [0, 1].map(|i| self.state.angles[i] - angles[i]);
        self.motor_work += dot(direct, travel) + dot(torques, turned);
        travel
    }

    /// Disconnects the motors if the end-point is seen outside the box. What cannot be seen is
    /// outside.
    fn check_box(&mut self, measured: Option<&ArmPose>) {
        if let Some(safety_box) = self.safety_box {
            let inside = measured.is_some_and(|pose| safety_box.contains(pose.position));
            self.disconnected |= !inside;
        }
    }

    fn run_pid(&mut self, x: f64, period: f64) {
        let Some(pid) = self.pid else { return };
        let error = pid.target - x;
        let memory = &mut self.memory;
        let within = |force: f64| force.clamp(-pid.max_force, pid.max_force);
        let mut force = pid.proportional * error;
        if period.is_finite() && period > 0.0 {
            memory.integral_force = within(memory.integral_force + pid.integral * error * period);
            let travel = x - memory.previous_x.unwrap_or(x);
            force -= pid.derivative * travel / period;
        }
        memory.previous_x = Some(x);
        memory.force = within(force + memory.integral_force);
    }
}

impl DevicePlant for Pantograph {
    /// True y of the end-point `[m]`.
    fn position(&self) -> f64 {
        self.pose.position[1]
    }

    fn velocity(&self) -> f64 {
        self.end_point_velocity()[1]
    }

    /// Reads the encoders, checks the safety box, takes the Jacobian for the torques and runs the
    /// controller.
    fn sample(&mut self, period: f64) {
        let measured = self.measured_pose();
        self.check_box(measured.as_ref());
        self.sampled = match self.params.actuation {
            Actuation::MotorsAtMeasuredPose => measured.or(self.sampled),
            Actuation::Ideal | Actuation::MotorsAtTruePose => Some(self.pose),
        };
        if let Some(pose) = measured
            && !self.disconnected
        {
            self.run_pid(pose.position[0], period);
        }
    }

    /// A force that is not finite is not applied, and a duration that is not finite and positive
    /// moves nothing.
    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        if self.jammed || !duration.is_finite() || duration <= 0.0 {
            return 0.0;
        }
        let sampled = self.sampled.unwrap_or_else(|| {
            let measured = self.measured_pose();
            self.check_box(measured.as_ref());
            match self.params.actuation {
                Actuation::MotorsAtMeasuredPose => measured.unwrap_or(self.pose),
                Actuation::Ideal | Actuation::MotorsAtTruePose => self.pose,
            }
        });
        let asked = if force_on_object.is_finite() {
            force_on_object
        } else {
            0.0
        };
        let user = self.motor_user_force;
        let mut wanted = [self.memory.force + user[0], user[1] - asked];
        if self.disconnected {
            wanted = [0.0, 0.0];
        }
        let limit = self.params.max_torque;
        let (direct, torques) = if self.params.actuation == Actuation::Ideal {
            self.saturated = false;
            (wanted, [0.0, 0.0])
        } else {
            let ideal = sampled.torques(wanted);
            self.saturated = ideal.iter().any(|torque| torque.abs() > limit);
            ([0.0, 0.0], ideal.map(|torque| torque.clamp(-limit, limit)))
        };
        self.torques = torques;

        let travel = self.move_on(direct, duration);
        asked * travel[1]
    }

    /// Returns the kinetic energy, gravity, and minus the user's force at the end-point times its position `[J]`. The
    /// part of the user's force that the motors deliver is in [`motor_work`](Pantograph::motor_work).
    fn stored_energy(&self) -> f64 {
        self.dynamics.kinetic_energy(&self.pose, self.state.rates)
            + self.dynamics.potential_energy(&self.pose)
            - dot(self.user_force, self.pose.position)
    }
}

fn regular_pose(
    params: &PantographParams,
    angles: [f64; 2],
    name: Parameter,
) -> Result<ArmPose, InvalidParameter<Parameter>> {
    params
        .geometry
        .forward(angles)
        .map_err(|_| InvalidParameter {
            name,
            value: angles[0],
            allowed: "motor angles [rad] of a pose that is in reach and not singular",
        })
}

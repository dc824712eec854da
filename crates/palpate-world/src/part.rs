//! A tool or body in motion.

use crate::axes::{OwnAxes, out, own, scaled};
use crate::rigid::{Mobility, Rigid, Vector3};
use crate::turning::TurningDrive;

/// What pushes a tool or body from outside of the contacts, over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive {
    /// Acceleration at the interval's start `[m/s^2]`.
    pub acceleration: Vector3,
    /// The axes of what follows; `None`: those of the mobility.
    pub axes: OwnAxes,
    /// By how much it falls with the velocity gained since, along each axis `[1/s]`,
    pub damping_rate: Vector3,
    /// and with the way made since `[1/s^2]`.
    pub spring_rate: Vector3,
    /// Position at the start `[m]`,
    pub position: Vector3,
    /// and velocity `[m/s]`.
    pub velocity: Vector3,
    /// Velocity that only the damping of contacts sees, of a tool that is held between samples `[m/s]`.
    pub apparent_velocity: Vector3,
}

impl Drive {
    pub fn constant(acceleration: Vector3) -> Self {
        let none = Vector3::zeros();
        Self {
            acceleration,
            axes: None,
            damping_rate: none,
            spring_rate: none,
            position: none,
            velocity: none,
            apparent_velocity: none,
        }
    }

    /// Acceleration at a place but for what the velocity itself takes from it `[m/s^2]`.
    fn at(&self, axes: &OwnAxes, position: &Vector3) -> Vector3 {
        self.acceleration + scaled(axes, &self.damping_rate, &self.velocity)
            - scaled(axes, &self.spring_rate, &(position - self.position))
    }
}

/// Velocity of the centre of mass `[m/s]` and angular velocity `[rad/s]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twist {
    pub velocity: Vector3,
    pub turning: Vector3,
}

impl Twist {
    pub fn none() -> Self {
        Self {
            velocity: Vector3::zeros(),
            turning: Vector3::zeros(),
        }
    }
}

/// A tool or body in motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Whether it is a fixed body: nothing of it ever changes.
    pub is_fixed: bool,
    pub rigid: Rigid,
    pub mobility: Mobility,
    pub drive: Drive,
    pub turning_drive: TurningDrive,
    /// Whether the torques of contacts count.
    pub has_torque: bool,
    /// Whether its hand alone turns it: the torques of contacts do work on it and do not turn it. That work is the hand's, from
    /// outside, so its rotation has no energy here.
    pub led: bool,
    /// How it moves now.
    pub twist: Twist,
    /// How it is expected to move at the end of a sub-step: what the damping of contacts sees.
    pub ahead: Twist,
    /// Sum of the contacts' forces on it `[N]`.
    pub force: Vector3,
    /// Sum of the contacts' torques about its centre of mass `[N m]`.
    pub torque: Vector3,
    /// Change of its velocity over the last half of a sub-step `[m/s]`.
    pub gained: Vector3,
    /// How it moved in the mean of the last half of a sub-step: the power of a constant force over it.
    pub mean: Twist,
    /// Work of its drive since the interval began `[J]`.
    pub driven: f64,
    /// Energy of rotation that the sub-steps have made out of nothing since the interval began `[J]`.
    pub turning_error: f64,
    /// Length of the way of its mass centre since the interval began `[m]`,
    pub way: f64,
    /// and how far it has turned since at most `[rad]`.
    pub turned: f64,
}

impl Part {
    pub fn new(rigid: Rigid, mobility: Mobility, drive: Drive) -> Self {
        let none = Vector3::zeros();
        Self {
            is_fixed: false,
            rigid,
            mobility,
            drive,
            turning_drive: TurningDrive::none(),
            has_torque: !mobility.does_not_turn(),
            led: false,
            twist: Twist::none(),
            ahead: Twist::none(),
            force: none,
            torque: none,
            gained: none,
            mean: Twist::none(),
            driven: 0.0,
            turning_error: 0.0,
            way: 0.0,
            turned: 0.0,
        }
    }

    /// A fixed body.
    pub fn fixed(rigid: Rigid) -> Self {
        let at_rest = Drive::constant(Vector3::zeros());
        Self {
            is_fixed: true,
            ..Self::new(rigid, Mobility::none(), at_rest)
        }
    }

    /// Goes on as a body of the same name in another world did: from where that is, as that moves. Mass, force and whether
    /// it is fixed are its own.
    pub fn goes_on_from(&mut self, before: &Self) {
        if self.is_fixed != before.is_fixed {
            return;
        }
        let Self {
            mobility,
            drive,
            has_torque,
            ..
        } = *self;
        *self = Self {
            mobility,
            drive,
            has_torque,
            ..*before
        };
        if mobility != before.mobility {
            // The same velocities with another mass, so another momentum.
            let turning = before.turning(&before.rigid.spin);
            self.set_turning(&turning);
        }
    }

    /// Comes to move as `other`, the same part at another time of the same interval. What a sub-step sets before it reads it stays.
    pub fn copy_motion_from(&mut self, other: &Self) {
        self.rigid = other.rigid;
        self.twist = other.twist;
        self.force = other.force;
        self.torque = other.torque;
        self.gained = other.gained;
        self.driven = other.driven;
        self.turning_error = other.turning_error;
        self.way = other.way;
        self.turned = other.turned;
    }

    /// Turns with an angular velocity along the world's axes `[rad/s]` from now on.
    pub fn set_turning(&mut self, turning: &Vector3) {
        self.rigid.spin = self.mobility.spin(&self.rigid.orientation, turning);
    }

    fn turning(&self, spin: &Vector3) -> Vector3 {
        if self.mobility.does_not_turn() {
            Vector3::zeros()
        } else {
            self.mobility.turning(&self.rigid.orientation, spin)
        }
    }

    fn update_twist(&mut self) {
        self.twist = Twist {
            velocity: self.rigid.velocity,
            turning: self.turning(&self.rigid.spin),
        };
    }

    /// An interval begins.
    pub fn begin(&mut self) {
        self.drive.position = self.rigid.position;
        self.drive.velocity = self.rigid.velocity;
        self.turning_drive.begin(&self.rigid);
        self.driven = 0.0;
        self.turning_error = 0.0;
        self.way = 0.0;
        self.turned = 0.0;
    }

    /// Work that the drive's acceleration at the interval's start does on it over its way since, as a constant force
    /// `[J]`.
    pub fn work_of_constant_force(&self) -> f64 {
        let way = self.rigid.position - self.drive.position;
        self.mobility.weighted(&self.drive.acceleration, &way)
    }

    /// Its contacts are to be looked at as it is.
    pub fn settle(&mut self) {
        self.update_twist();
        self.ahead = self.twist;
        self.ahead.velocity += self.drive.apparent_velocity;
        self.ahead.turning += self.turning_drive.apparent_turning;
    }

    fn axes_of_drive(&self) -> &OwnAxes {
        match &self.drive.axes {
            None => &self.mobility.linear_axes,
            axes => axes,
        }
    }

    /// The first half of a sub-step's push.
    pub fn first_push(&mut self, half: f64) {
        let before = self.rigid.velocity;
        let axes = self.axes_of_drive();
        let slowed = scaled(axes, &self.drive.damping_rate, &before);
        let by_drive = (self.drive.at(axes, &self.rigid.position) - slowed) * half;
        let by_contacts = self.mobility.acceleration(&self.force) * half;
        let torque = self.turning_drive.first_torque(&self.rigid);
        self.push(before, by_drive, by_contacts, torque, half);
    }

    /// The second half: with the damping of the drive at its end, so that both halves together are of second order.
    pub fn second_push(&mut self, half: f64) {
        let before = self.rigid.velocity;
        let axes = self.axes_of_drive();
        let by_contacts = self.mobility.acceleration(&self.force) * half;
        let sum = before + by_contacts + self.drive.at(axes, &self.rigid.position) * half;
        let after =
            own(axes, &sum).zip_map(&self.drive.damping_rate, |v, rate| v / (1.0 + half * rate));
        let after = out(axes, &after);
        let torque = self
            .turning_drive
            .second_torque(&self.rigid, &self.torque, half);
        let by_drive = after - before - by_contacts;
        self.push(before, by_drive, by_contacts, torque, half);
    }

    fn push(
        &mut self,
        before: Vector3,
        by_drive: Vector3,
        by_contacts: Vector3,
        torque: Vector3,
        half: f64,
    ) {
        self.gained = by_drive + by_contacts;
        self.rigid.velocity += self.gained;
        let spun = (self.torque + torque) * half;
        self.rigid.spin += spun;
        let mean = before + self.gained * 0.5;
        self.driven += self.mobility.weighted(&by_drive, &mean);
        self.update_twist();
        self.mean = Twist {
            velocity: self.rigid.velocity - self.gained * 0.5,
            turning: self.twist.turning,
        };
        if self.has_torque && !self.mobility.does_not_turn() {
            self.mean.turning -= self.turning(&(spun * 0.5));
            if !self.led {
                self.driven += (torque * half).dot(&self.mean.turning);
            }
        }
    }

    /// Moves on for `h` `[s]` without a push, and looks ahead to the end of the coming one.
    pub fn drift(&mut self, h: f64) {
        let rigid = &mut self.rigid;
        rigid.position += rigid.velocity * h;
        self.way += rigid.velocity.norm() * h;
        let before = self.twist.turning;
        // Of a drive's torque the end is not looked at: what its change makes of a sub-step is of third order.
        let torque = self.torque + self.turning_drive.first_torque(rigid);
        if !self.mobility.does_not_turn() {
            rigid.orientation = self.mobility.turned(&rigid.orientation, &rigid.spin, h);
            self.turned += self.mobility.angular.max() * rigid.spin.norm() * h;
            self.update_twist();
            let change = self.twist.turning - before;
            if !self.led {
                self.turning_error += 0.5 * self.rigid.spin.dot(&change);
            }
        }
        self.ahead = Twist {
            velocity: self.twist.velocity + self.gained + self.drive.apparent_velocity,
            turning: self.turning(&(self.rigid.spin + torque * (0.5 * h)))
                + self.turning_drive.apparent_turning,
        };
    }

    /// Velocity of its material at `place` as it moves by `twist` `[m/s]`.
    pub fn velocity_at(&self, twist: &Twist, place: &Vector3) -> Vector3 {
        twist.velocity + twist.turning.cross(&(place - self.rigid.position))
    }

    /// Velocity that only the damping of contacts sees, at `place` `[m/s]`.
    pub fn apparent_velocity_at(&self, place: &Vector3) -> Vector3 {
        let turning = &self.turning_drive.apparent_turning;
        self.drive.apparent_velocity + turning.cross(&(place - self.rigid.position))
    }

    /// Adds the force of a contact at `place`.
    pub fn load(&mut self, force: &Vector3, place: &Vector3) {
        self.force += force;
        if self.has_torque && !self.led {
            self.torque += (place - self.rigid.position).cross(force);
        }
    }
}

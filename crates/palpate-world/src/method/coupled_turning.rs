//! How a device of six axes and its avatar turn, in coupled rendering.
//!
//! The avatar is turned against its device by an offset, and has another angular momentum. Torques change momentum by
//! the same in every orientation. So the momentum is what is carried from sample to sample, not the angular velocity:
//! the same momentum in another orientation is another angular velocity.

use crate::commands::Acting;
use crate::moving::Moving;
use crate::part::Part;
use crate::rigid::{Rotation, Vector3};
use crate::turning::TurningDrive;
use crate::turning_observer::{Torque, TurningMotion, TurningObserver, TurningPrior, rotated};

/// What is known of how a device turns, and its avatar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turning {
    pub observer: TurningObserver,
    /// Orientation of the avatar after that of the device: avatar = offset device.
    pub offset: Rotation,
    /// w_L: sigma times the avatar's angular momentum, less L `[N m s]`.
    pub momentum_offset: Vector3,
    /// The device as it is predicted: room.
    pub ahead: TurningMotion,
    /// Where the last sample has found it.
    pub measured: Rotation,
}

/// What an interval has done to a device that turns, in the terms of its book `[J]`.
pub(super) struct TurningWork {
    /// Integral of the device's angular velocity `[rad]`.
    pub path: Vector3,
    /// Kinetic energy that the device has gained, less the work of the torque that was asked for.
    pub by_hand: f64,
    /// Kinetic energy that the avatar has gained,
    pub by_avatar: f64,
    /// and by how much more that is.
    pub gained_more: f64,
}

impl Turning {
    pub fn new(prior: &TurningPrior, measured: Rotation) -> Self {
        let observer = TurningObserver::new(prior, measured);
        Self {
            observer,
            offset: Rotation::identity(),
            momentum_offset: Vector3::zeros(),
            ahead: observer.motion,
            measured,
        }
    }

    /// Turns a tool's avatar in a world as its device is predicted, and by the offset.
    pub fn place(&self, part: &mut Part, prior: &TurningPrior) {
        let device = &self.ahead;
        part.rigid.orientation = unit(self.offset * device.orientation);
        part.rigid.spin = (device.momentum + self.momentum_offset) / device.mobility;
        part.mobility.angular = prior.moments.map(|moment| device.mobility / moment);
        let angular = &part.mobility.angular;
        part.mobility.is_round = angular.x == angular.y && angular.y == angular.z;
        self.drive(part);
    }

    /// The hand's torque on the avatar is that on the device.
    pub fn drive(&self, part: &mut Part) {
        part.turning_drive = TurningDrive {
            torque: self.ahead.external / self.ahead.mobility,
            damping_rate: self.ahead.damping_rate,
            ..TurningDrive::none()
        };
    }

    /// The sample at the end of an interval: `ahead` is the device at its beginning.
    pub fn see(&mut self, prior: &TurningPrior, measured: &Rotation, acted: &Acting, h: f64) {
        let torque = Torque {
            mean: acted.sent,
            lead: acted.lead,
            impulse_deviation: acted.impulse_deviation,
        };
        self.ahead = self.observer.see(prior, measured, &torque, h);
    }

    /// The device as it is predicted moves on under what was asked for. Returns the integral of its angular velocity
    /// `[rad]`.
    pub fn go_on(&mut self, prior: &TurningPrior, acting: &Acting, h: f64) -> Vector3 {
        let torque = Torque {
            mean: acting.intended,
            lead: acting.lead,
            impulse_deviation: Vector3::zeros(),
        };
        let (after, path) = self.ahead.under(&prior.moments, &torque, h);
        self.ahead = after;
        path
    }

    /// The avatar is where an interval has brought it, as `moving` says, and its device where the torque that was
    /// asked for would have. Of a tool that its hand turns there is no work here: the contacts turn neither.
    pub fn conclude(
        &mut self,
        prior: &TurningPrior,
        part: &Part,
        acted: &Acting,
        measured: &Rotation,
        h: f64,
    ) -> TurningWork {
        let start = self.ahead;
        let path = self.go_on(prior, acted, h);
        self.measured = *measured;
        if prior.led {
            // The avatar has turned as its device has; where it was brought by sub-steps differs by what these are.
            return TurningWork {
                path,
                by_hand: 0.0,
                by_avatar: 0.0,
                gained_more: 0.0,
            };
        }
        let end = self.ahead;
        let momentum_offset = part.rigid.spin * end.mobility - end.momentum;
        let energy = |motion: &TurningMotion| motion.kinetic_energy(&prior.moments);
        let of_avatar = |motion: &TurningMotion, offset: Rotation, w: &Vector3| {
            let avatar = TurningMotion {
                orientation: unit(offset * motion.orientation),
                momentum: motion.momentum + w,
                ..*motion
            };
            energy(&avatar)
        };
        let by_device = energy(&end) - energy(&start);
        let offset = unit(part.rigid.orientation * end.orientation.inverse());
        let by_avatar = of_avatar(&end, offset, &momentum_offset)
            - of_avatar(&start, self.offset, &self.momentum_offset);
        self.offset = offset;
        self.momentum_offset = momentum_offset;
        TurningWork {
            path,
            by_hand: by_device - acted.intended.dot(&path),
            by_avatar,
            gained_more: by_avatar - by_device,
        }
    }

    /// The avatar of a tool that touches nothing turns back to its device, by at most `most` `[rad]`; of the offset of
    /// momentum `kept` is left. Returns the rotation vector by which it turns.
    pub fn walk_back(&mut self, most: f64, kept: f64) -> Vector3 {
        self.momentum_offset *= kept;
        self.limit_offset_change(most)
    }

    fn limit_offset_change(&mut self, most: f64) -> Vector3 {
        let vector = self.offset.scaled_axis();
        let angle = vector.norm();
        let back = if angle <= most {
            -vector
        } else {
            vector * (-most / angle)
        };
        self.offset = Rotation::from_scaled_axis(vector + back);
        back
    }

    /// Keeps the offset within an angle `[rad]`; whether it was beyond.
    pub fn limit_offset(&mut self, most: f64) -> bool {
        let angle = self.offset.angle();
        if angle <= most {
            return false;
        }
        self.limit_offset_change(angle - most);
        true
    }

    /// What of the momentum is owed to the device at the beginning of the interval that a torque governs, where `moving`
    /// has begun it `[N m s]`.
    pub fn owed(&self, prior: &TurningPrior, moving: &Moving, tool: usize) -> Vector3 {
        if prior.is_immovable || prior.led {
            return Vector3::zeros();
        }
        moving.parts[tool].turning_drive.spin - self.ahead.momentum / self.ahead.mobility
    }

    /// The device at the last sample.
    pub fn now(&self) -> &TurningMotion {
        &self.observer.motion
    }

    /// Orientation of the avatar at the last sample.
    pub fn avatar(&self) -> Rotation {
        rotated(&self.offset.scaled_axis(), &self.now().orientation)
    }
}

/// The same rotation, of length 1 to rounding.
fn unit(rotation: Rotation) -> Rotation {
    Rotation::new_normalize(rotation.into_inner())
}

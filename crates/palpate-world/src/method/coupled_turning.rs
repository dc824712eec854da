//! Rotation of a six-axis device and its proxy, in coupled rendering.
//!
//! The proxy has a rotational offset and an angular momentum offset relative to its device. A torque changes the
//! momentum equally in every orientation, but not the angular velocity. The momentum is therefore the state that is
//! kept between samples.

use crate::device::commands::Acting;
use crate::device::turning_observer::{
    Torque, TurningMotion, TurningObserver, TurningPrior, rotated,
};
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::{Rotation, Vector3};
use crate::geometry::turning::TurningDrive;
use crate::integration::moving::Moving;

/// Estimated rotation of a device, and its proxy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turning {
    pub observer: TurningObserver,
    /// Orientation of the proxy relative to the device: proxy = offset device.
    pub offset: Rotation,
    /// w_L: sigma times the proxy's angular momentum, minus L `[N m s]`.
    pub momentum_offset: Vector3,
    /// Predicted device (scratch buffer).
    pub ahead: TurningMotion,
    /// Orientation at the last sample.
    pub measured: Rotation,
}

/// Energies of a rotating device over an interval, for the energy ledger `[J]`.
pub(super) struct TurningWork {
    /// Integral of the device's angular velocity `[rad]`.
    pub path: Vector3,
    /// Kinetic energy gained by the device minus the work of the commanded torque.
    pub by_hand: f64,
    /// Kinetic energy gained by the proxy.
    pub by_proxy: f64,
    /// Kinetic energy gained by the proxy minus that gained by the device.
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

    /// Rotates a tool's proxy in a world by the device prediction and the offset.
    pub fn place(&self, part: &mut Part, prior: &TurningPrior) {
        let device = &self.ahead;
        part.rigid.orientation = unit(self.offset * device.orientation);
        part.rigid.spin = (device.momentum + self.momentum_offset) / device.mobility;
        part.mobility.angular = prior.moments.map(|moment| device.mobility / moment);
        let angular = &part.mobility.angular;
        part.mobility.is_round = angular.x == angular.y && angular.y == angular.z;
        self.drive(part);
    }

    /// Applies the hand's torque on the device to the proxy.
    pub fn drive(&self, part: &mut Part) {
        part.turning_drive = TurningDrive {
            torque: self.ahead.external / self.ahead.mobility,
            damping_rate: self.ahead.damping_rate,
            ..TurningDrive::none()
        };
    }

    /// Updates the observer with the sample at the end of an interval, and sets `ahead` to the device at its
    /// beginning.
    pub fn see(&mut self, prior: &TurningPrior, measured: &Rotation, acted: &Acting, h: f64) {
        let torque = Torque {
            mean: acted.sent,
            lead: acted.lead,
            impulse_deviation: acted.impulse_deviation,
        };
        self.ahead = self.observer.see(prior, measured, &torque, h);
    }

    /// Advances the device prediction under the commanded torque. Returns the integral of its angular velocity
    /// `[rad]`.
    pub fn resume(&mut self, prior: &TurningPrior, acting: &Acting, h: f64) -> Vector3 {
        let torque = Torque {
            mean: acting.intended,
            lead: acting.lead,
            impulse_deviation: Vector3::zeros(),
        };
        let (after, path) = self.ahead.under(&prior.moments, &torque, h);
        self.ahead = after;
        path
    }

    /// Updates the offsets from the proxy's state in `moving` and the device under the commanded torque. For a tool
    /// turned by its hand all energies are zero, because the contacts turn neither proxy nor device.
    pub fn conclude(
        &mut self,
        prior: &TurningPrior,
        part: &Part,
        acted: &Acting,
        measured: &Rotation,
        h: f64,
    ) -> TurningWork {
        let start = self.ahead;
        let path = self.resume(prior, acted, h);
        self.measured = *measured;
        if prior.led {
            // The proxy rotates with its device; its integrated orientation differs by the sub-step error.
            return TurningWork {
                path,
                by_hand: 0.0,
                by_proxy: 0.0,
                gained_more: 0.0,
            };
        }
        let end = self.ahead;
        let momentum_offset = part.rigid.spin * end.mobility - end.momentum;
        let energy = |motion: &TurningMotion| motion.kinetic_energy(&prior.moments);
        let of_proxy = |motion: &TurningMotion, offset: Rotation, w: &Vector3| {
            let proxy = TurningMotion {
                orientation: unit(offset * motion.orientation),
                momentum: motion.momentum + w,
                ..*motion
            };
            energy(&proxy)
        };
        let by_device = energy(&end) - energy(&start);
        let offset = unit(part.rigid.orientation * end.orientation.inverse());
        let by_proxy = of_proxy(&end, offset, &momentum_offset)
            - of_proxy(&start, self.offset, &self.momentum_offset);
        self.offset = offset;
        self.momentum_offset = momentum_offset;
        TurningWork {
            path,
            by_hand: by_device - acted.intended.dot(&path),
            by_proxy,
            gained_more: by_proxy - by_device,
        }
    }

    /// Rotates the proxy of a tool without contact towards its device by at most `most` `[rad]`, and scales the
    /// momentum offset by `kept`. Returns the rotation vector of the step.
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

    /// Clamps the offset to an angle `[rad]`. Returns whether it exceeded the angle.
    pub fn limit_offset(&mut self, most: f64) -> bool {
        let angle = self.offset.angle();
        if angle <= most {
            return false;
        }
        self.limit_offset_change(angle - most);
        true
    }

    /// Returns the residual angular impulse at the start of the interval that a torque governs, which `moving` has
    /// begun `[N m s]`.
    pub fn residual(&self, prior: &TurningPrior, moving: &Moving, tool: usize) -> Vector3 {
        if prior.is_immovable || prior.led {
            return Vector3::zeros();
        }
        moving.parts[tool].turning_drive.spin - self.ahead.momentum / self.ahead.mobility
    }

    /// Returns the device at the last sample.
    pub fn now(&self) -> &TurningMotion {
        &self.observer.motion
    }

    /// Returns the orientation of the proxy at the last sample.
    pub fn proxy(&self) -> Rotation {
        rotated(&self.offset.scaled_axis(), &self.now().orientation)
    }
}

/// Normalises a rotation to length 1 up to rounding.
fn unit(rotation: Rotation) -> Rotation {
    Rotation::new_normalize(rotation.into_inner())
}

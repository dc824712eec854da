//! An avatar against its device, and how it goes back to it.

use super::coupled::Coupled;
use crate::rigid::Vector3;

/// An avatar against its device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avatar {
    /// o: its position less the device's `[m]`.
    pub offset: Vector3,
    /// w: its velocity less the device's `[m/s]`.
    pub velocity_offset: Vector3,
}

impl Avatar {
    pub fn none() -> Self {
        Self {
            offset: Vector3::zeros(),
            velocity_offset: Vector3::zeros(),
        }
    }
}

/// Part of the offset's limit that a tool in contact keeps.
const KEPT_IN_CONTACT: f64 = 0.05;
/// Time in which the rest of it goes back in contact `[s]`.
const BACK_IN_CONTACT: f64 = 1.0;

impl Coupled {
    /// The avatar of a tool that touches nothing goes back to its device. Returns the change of its offset.
    pub fn walk_back(&self, avatar: &mut Avatar, elapsed: f64) -> Vector3 {
        let Avatar {
            offset,
            velocity_offset,
        } = avatar;
        let norm = offset.norm();
        let most = self.offset_return * elapsed;
        let back = if norm <= most {
            -*offset
        } else {
            *offset * (-most / norm)
        };
        *offset += back;
        *velocity_offset *= 1.0 - (elapsed / self.velocity_return).min(1.0);
        back
    }

    /// In contact the avatar keeps its offset, since to go back while a force changes costs energy. What is beyond
    /// [`KEPT_IN_CONTACT`] comes from lost samples or a wrong one: else a wall would stand off its place by it for as long as
    /// it is pressed. That goes back within [`BACK_IN_CONTACT`] or so, no faster than in free motion. Returns the change of the offset.
    pub fn walk_back_in_contact(&self, avatar: &mut Avatar, elapsed: f64) -> Vector3 {
        let offset = &mut avatar.offset;
        let norm = offset.norm();
        let beyond = norm - KEPT_IN_CONTACT * self.offset_limit;
        if beyond <= 0.0 {
            return Vector3::zeros();
        }
        let most = (beyond / BACK_IN_CONTACT).min(self.offset_return) * elapsed;
        let back = *offset * (-most / norm);
        *offset += back;
        back
    }

    /// Says whether the offset was beyond its limit, to which it is cut.
    pub fn limit_offset(&self, avatar: &mut Avatar) -> bool {
        let norm = avatar.offset.norm();
        let is_beyond = norm > self.offset_limit;
        if is_beyond {
            avatar.offset *= self.offset_limit / norm;
        }
        is_beyond
    }
}

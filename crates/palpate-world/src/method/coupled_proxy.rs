//! State of a proxy relative to its device, and its decay.

use super::coupled::Coupled;
use crate::geometry::rigid::Vector3;

/// State of a proxy relative to its device. Unlike CHAI3D's proxy it is not constrained to the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProxyState {
    /// o: position of the proxy minus that of the device `[m]`.
    pub offset: Vector3,
    /// w: velocity of the proxy minus that of the device `[m/s]`.
    pub velocity_offset: Vector3,
    /// Whether a force limit acted since the offset was last 0.
    pub was_limited: bool,
    /// Samples since the tool was last in contact.
    pub samples_apart: u32,
    /// Whether tracking began in contact and the device has not yet felt the whole force.
    pub comes_in: bool,
}

impl ProxyState {
    pub fn none() -> Self {
        Self {
            offset: Vector3::zeros(),
            velocity_offset: Vector3::zeros(),
            was_limited: false,
            samples_apart: 0,
            comes_in: false,
        }
    }
}

/// Fraction of the offset limit that a tool in contact keeps.
const KEPT_IN_CONTACT: f64 = 0.05;
/// Decay time of the excess offset in contact `[s]`.
const BACK_IN_CONTACT: f64 = 1.0;
/// Decay time of the offset in a short flight, or after a limited force `[s]`. The work of the hand and of the touched
/// body over the offset is generated energy, and a constant rate generates the more in comparison with the damping,
/// the smaller the bounces are. It averages out over bounces at different phases of the samples. A device in a hand
/// that presses can keep bouncing at one phase, if its flights last a few samples or a force is limited.
pub(crate) const SLOWLY_BACK: f64 = 0.2;
/// Samples without contact up to which a flight is short.
const SHORT_FLIGHT: u32 = 32;

impl Coupled {
    /// Decays the proxy offset of a tool without contact. Returns the change of the offset.
    pub fn walk_back(&self, proxy: &mut ProxyState, elapsed: f64) -> Vector3 {
        let ProxyState {
            offset,
            velocity_offset,
            was_limited,
            samples_apart,
            ..
        } = proxy;
        let norm = offset.norm();
        let mut most = self.offset_return * elapsed;
        *samples_apart = samples_apart.saturating_add(1);
        if *was_limited || *samples_apart <= SHORT_FLIGHT {
            most = most.min(norm * (elapsed / SLOWLY_BACK));
        }
        let back = if norm <= most {
            -*offset
        } else {
            *offset * (-most / norm)
        };
        *offset += back;
        *was_limited &= *offset != Vector3::zeros();
        *velocity_offset *= 1.0 - (elapsed / self.velocity_return).min(1.0);
        back
    }

    /// Decays the excess proxy offset of a tool in contact. Returns the change of the offset.
    ///
    /// A decay during a change of force costs energy, so the proxy keeps an offset of up to [`KEPT_IN_CONTACT`]. A
    /// larger offset results from lost samples or an outlier, and would displace a wall for as long as it is pressed.
    /// The excess decays within about [`BACK_IN_CONTACT`], at most as fast as in free motion. While a soft start or a
    /// delay withholds the first force of a contact, the proxy stays at the device, which the contact has not moved.
    pub fn walk_back_in_contact(&self, proxy: &mut ProxyState, elapsed: f64) -> Vector3 {
        proxy.samples_apart = 0;
        if proxy.comes_in {
            proxy.velocity_offset = Vector3::zeros();
            return -core::mem::replace(&mut proxy.offset, Vector3::zeros());
        }
        let offset = &mut proxy.offset;
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

    /// Returns the largest rotation of a proxy without contact towards its device `[rad]`, and the factor of its momentum
    /// offset. While it comes in, it stays at the device.
    pub fn turns_back(&self, proxy: &ProxyState, elapsed: f64) -> (f64, f64) {
        if proxy.comes_in {
            return (f64::INFINITY, 0.0);
        }
        let kept = 1.0 - (elapsed / self.velocity_return).min(1.0);
        (self.turn_return * elapsed, kept)
    }

    /// Clamps the offset to its limit. Returns whether the offset exceeded it.
    pub fn limit_offset(&self, proxy: &mut ProxyState) -> bool {
        let norm = proxy.offset.norm();
        let is_beyond = norm > self.offset_limit;
        if is_beyond {
            proxy.offset *= self.offset_limit / norm;
        }
        is_beyond
    }
}

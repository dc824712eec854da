//! State vector of a system.
//!
//! It begins with the moving quantities: position and velocity of each device; quaternion and angular momentum of each
//! device if one turns; position, velocity, quaternion and angular momentum of each free body; the bristle of each
//! contact. Integrals over these quantities follow.

/// Indices into the state vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub devices: usize,
    /// Whether a device turns.
    pub turns: bool,
    pub free_bodies: usize,
    pub contacts: usize,
    pub joints: usize,
}

/// Numbers of a device, a free body and a contact in the first part of the state.
const DEVICE: usize = 6;
const TURNING: usize = 7;
const BODY: usize = 13;
const BRISTLE: usize = 3;
/// Of a device: ∫ f dt and ∫ f² dt along each axis, the hand's work, and ∫ f t dt along each axis.
const DEVICE_SUMS: usize = 10;
/// Of a device that turns, additionally the same integrals of its torque.
const TORQUE_SUMS: usize = 6;
/// Of a contact: ∫ N dt, ∫ of the force on its first member dt, and the dissipated energy.
const CONTACT_SUMS: usize = 5;

impl Layout {
    fn device_size(&self) -> usize {
        DEVICE + if self.turns { TURNING } else { 0 }
    }

    pub fn device(&self, device: usize) -> usize {
        self.device_size() * device
    }

    pub fn body(&self, free_body: usize) -> usize {
        self.device_size() * self.devices + BODY * free_body
    }

    pub fn bristle(&self, contact: usize) -> usize {
        self.body(self.free_bodies) + BRISTLE * contact
    }

    /// Returns the number of moving quantities; the rest are integrals over them.
    pub fn moving(&self) -> usize {
        self.bristle(self.contacts)
    }

    pub fn device_sums(&self, device: usize) -> usize {
        let torque = if self.turns { TORQUE_SUMS } else { 0 };
        self.moving() + (DEVICE_SUMS + torque) * device
    }

    /// Returns the index of a device's ∫ f t dt.
    pub fn moment_sums(&self, device: usize) -> usize {
        self.device_sums(device) + DEVICE_SUMS - 3
    }

    pub fn torque_sums(&self, device: usize) -> usize {
        self.device_sums(device) + DEVICE_SUMS
    }

    pub fn contact_sums(&self, contact: usize) -> usize {
        self.device_sums(self.devices) + CONTACT_SUMS * contact
    }

    /// Returns the index of the energy dissipated by a joint's damping.
    pub fn joint_sum(&self, joint: usize) -> usize {
        self.contact_sums(self.contacts) + joint
    }

    pub fn size(&self) -> usize {
        self.joint_sum(self.joints)
    }
}

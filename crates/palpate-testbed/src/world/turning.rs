//! Rotation of a six-axis device in the hand that holds it.

use super::scene::{
    ABOVE_ZERO, InvalidScene, Vector, above_zero, all_finite, not_negative, unit_length,
};
use super::vector::{Rotation, Vec3};
use crate::InvalidParameter;
use crate::hand::Sinusoid;

/// Rotation of a six-axis device.
///
/// L′ = τ + T − k φ − b ω + Σ tremor about the mass centre, along the world's axes: L the angular momentum, τ the
/// contact torque on the tool, φ the rotation vector from the hand's rest to the tool. If the hand alone turns the
/// tool, τ does not act.
#[derive(Debug, Clone, PartialEq)]
pub struct Turning {
    /// Moments of inertia about the mass centre along the tool's axes, finite and above 0 `[kg m²]`.
    pub inertia: Vector,
    /// Unit quaternion `[w, x, y, z]` from the tool's axes to the world's at t = 0.
    pub orientation: [f64; 4],
    /// Angular velocity at t = 0, in world axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// The hand.
    pub hand: TurningHand,
    /// Whether the device gives a torque. If not, the hand alone turns the tool: it takes up the contact torque itself,
    /// feels no motor torque, and no torque is evaluated.
    pub gives_torque: bool,
    /// Quantum of each component of the measured rotation vector from the start, 0 for a perfect sensor `[rad]`.
    pub quantum: f64,
}

/// How a hand turns a device: a torque, a spring and a damper.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningHand {
    /// Constant torque T in world axes `[N m]`.
    pub torque: Vector,
    /// Stiffness k, at least 0 `[N m/rad]`.
    pub stiffness: f64,
    /// Damping b, at least 0 `[N m s/rad]`.
    pub damping: f64,
    /// The orientation in which the spring is relaxed, a unit quaternion `[w, x, y, z]`.
    pub rest: [f64; 4],
    /// Tremor torques about each axis of the world, their amplitudes in `[N m]`; they add up.
    pub tremor: [Vec<Sinusoid>; 3],
}

impl TurningHand {
    /// A hand that lets the device turn.
    #[must_use]
    pub fn none() -> Self {
        Self {
            torque: [0.0; 3],
            stiffness: 0.0,
            damping: 0.0,
            rest: [1.0, 0.0, 0.0, 0.0],
            tremor: [vec![], vec![], vec![]],
        }
    }
}

impl Turning {
    pub(super) fn check(&self, name: &str) -> Result<(), InvalidScene> {
        above_zero(&format!("{name}.inertia"), &self.inertia)?;
        unit_length(&format!("{name}.orientation"), &self.orientation)?;
        all_finite(&format!("{name}.angular_velocity"), &self.angular_velocity)?;
        not_negative(&format!("{name}.quantum"), &[self.quantum])?;
        let hand = &self.hand;
        all_finite(&format!("{name}.hand.torque"), &hand.torque)?;
        not_negative(&format!("{name}.hand.stiffness"), &[hand.stiffness])?;
        not_negative(&format!("{name}.hand.damping"), &[hand.damping])?;
        unit_length(&format!("{name}.hand.rest"), &hand.rest)?;
        for sine in hand.tremor.iter().flatten() {
            let name = format!("{name}.hand.tremor");
            all_finite(&name, &[sine.amplitude, sine.phase])?;
            let holds = sine.frequency_hz > 0.0 && sine.frequency_hz.is_finite();
            InvalidParameter::unless(holds, name, sine.frequency_hz, ABOVE_ZERO)?;
        }
        Ok(())
    }

    /// Torque of the hand `[N m]` on the device as it is turned by `q` and turns with ω.
    pub(super) fn hand_torque(&self, time: f64, q: [f64; 4], omega: Vec3) -> Vec3 {
        let hand = &self.hand;
        let tremor = |axis: usize| -> f64 {
            let sines = hand.tremor[axis].iter();
            sines.map(|sine| sine.value(time)).sum()
        };
        let constant = Vec3(std::array::from_fn(|axis| hand.torque[axis] + tremor(axis)));
        let mut torque = constant - omega * hand.damping;
        if hand.stiffness > 0.0 {
            torque -= rotation_vector(hand.rest, q) * hand.stiffness;
        }
        torque
    }

    /// What of a contact torque `[N m]` acts on the device.
    pub(super) fn of_contacts(&self, torque: Vec3) -> Vec3 {
        if self.gives_torque {
            torque
        } else {
            Vec3::ZERO
        }
    }

    /// Angular momentum that the device has at an angular velocity `[kg m²/s]`.
    pub(super) fn angular_momentum(&self, rotation: &Rotation, omega: Vec3) -> Vec3 {
        let own = rotation.back(omega);
        rotation.out(Vec3(std::array::from_fn(|i| own.0[i] * self.inertia[i])))
    }

    /// R I⁻¹ Rᵀ v: the angular velocity of an angular momentum.
    pub(super) fn angular_velocity(&self, rotation: &Rotation, v: Vec3) -> Vec3 {
        let own = rotation.back(v);
        rotation.out(Vec3(std::array::from_fn(|i| own.0[i] / self.inertia[i])))
    }

    /// What torques about the world's axes are weighted by: the mobility about each at t = 0 `[1/(kg m²)]`.
    #[must_use]
    pub fn mobility(&self) -> Vector {
        let rotation = Rotation::of_quaternion(self.orientation);
        std::array::from_fn(|axis| {
            let mut unit = Vec3::ZERO;
            unit.0[axis] = 1.0;
            self.angular_velocity(&rotation, unit).0[axis]
        })
    }
}

/// The product of two quaternions.
pub(super) fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let (v, w) = (Vec3::new(&a[1..]), Vec3::new(&b[1..]));
    let vector = w * a[0] + v * b[0] + v.cross(w);
    let [x, y, z] = vector.0;
    [a[0] * b[0] - v.dot(w), x, y, z]
}

/// The rotation vector in world axes from one orientation to another, of at most half a turn `[rad]`.
pub(super) fn rotation_vector(from: [f64; 4], to: [f64; 4]) -> Vec3 {
    let [w, x, y, z] = product(to, [from[0], -from[1], -from[2], -from[3]]);
    let side = if w < 0.0 { -1.0 } else { 1.0 };
    let vector = Vec3([x, y, z]) * side;
    let sine = vector.norm();
    let cosine = w * side;
    // Of any length of the two quaternions.
    if sine <= 1e-12 * cosine {
        vector * (2.0 / cosine)
    } else {
        vector * (2.0 * sine.atan2(cosine) / sine)
    }
}

/// An orientation, turned on by a rotation vector in world axes.
pub(super) fn turned_by(vector: Vec3, q: [f64; 4]) -> [f64; 4] {
    let angle = vector.norm();
    let over = if angle > 1e-9 {
        (0.5 * angle).sin() / angle
    } else {
        0.5
    };
    let [x, y, z] = (vector * over).0;
    product([(0.5 * angle).cos(), x, y, z], q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_vector_leads_from_one_orientation_to_the_other() {
        let from = turned_by(Vec3([0.3, -1.0, 0.7]), [1.0, 0.0, 0.0, 0.0]);
        for vector in [[0.2, 0.1, -0.4], [1e-11, 0.0, 2e-11], [-2.0, 1.5, 1.0]] {
            let to = turned_by(Vec3(vector), from);
            let found = rotation_vector(from, to);
            assert!((found - Vec3(vector)).norm() < 1e-13, "{found:?}");
            // The other quaternion of the same rotation.
            let other = rotation_vector(from, to.map(|part| -part));
            assert!((other - Vec3(vector)).norm() < 1e-13, "{other:?}");
        }
    }
}

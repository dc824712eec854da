//! Contact law at one point.

use crate::ContactLaw;
use crate::geometry::rigid::Vector3;

/// Law of one point: the points of a contact share its law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointLaw {
    /// K `[N/m]`.
    pub stiffness: f64,
    /// B `[N s/m]`.
    pub damping: f64,
    /// mu.
    pub friction: f64,
    /// k_t `[N/m]`.
    pub friction_stiffness: f64,
    /// B_t `[N s/m]`.
    pub friction_damping: f64,
}

/// Contact mode of two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Apart.
    #[default]
    Free,
    /// Touching; the bristle sticks, or there is no friction.
    Sticks,
    /// Touching; the bristle is at its limit.
    Slides,
    /// Overlapping without force: the surfaces separate faster than the material follows.
    Parts,
}

/// A bristle within its limit.
pub(crate) struct Cut {
    pub bristle: Vector3,
    pub mode: Mode,
}

impl PointLaw {
    /// Returns the share of one of `points` points.
    pub fn share(law: &ContactLaw, points: f64) -> Self {
        Self {
            stiffness: law.stiffness / points,
            damping: law.damping / points,
            friction: law.friction,
            friction_stiffness: law.friction_stiffness / points,
            friction_damping: law.friction_damping / points,
        }
    }

    /// Returns max(0, K p + B p') for a penetration p above 0 `[N]`.
    #[inline]
    pub fn normal_force(&self, penetration: f64, rate: f64) -> f64 {
        (self.stiffness * penetration + self.damping * rate).max(0.0)
    }

    /// Limits the bristle to the deflection mu N/k_t that a normal force `[N]` can hold.
    #[inline]
    pub fn cut(&self, bristle: Vector3, normal_force: f64) -> Cut {
        if normal_force <= 0.0 || self.friction <= 0.0 {
            return Cut {
                bristle: Vector3::zeros(),
                mode: if normal_force > 0.0 {
                    Mode::Sticks
                } else {
                    Mode::Parts
                },
            };
        }
        let most = self.friction * normal_force / self.friction_stiffness;
        let length = bristle.norm();
        if length <= most {
            return Cut {
                bristle,
                mode: Mode::Sticks,
            };
        }
        Cut {
            bristle: bristle * (most / length),
            mode: Mode::Slides,
        }
    }

    /// Returns the damper's part of the friction force `[N]` at a tangential velocity `[m/s]`. Bristle and damper
    /// force together are limited to mu N. The damper dissipates energy at any velocity, because the bristle force
    /// itself is within the limit.
    #[inline]
    pub fn bristle_damping(
        &self,
        bristle: &Vector3,
        velocity: &Vector3,
        normal_force: f64,
    ) -> Vector3 {
        if self.friction_damping <= 0.0 || self.friction <= 0.0 {
            return Vector3::zeros();
        }
        let spring = bristle * -self.friction_stiffness;
        let wanted = spring - velocity * self.friction_damping;
        let (length, most) = (wanted.norm(), self.friction * normal_force);
        if length > most {
            wanted * (most / length) - spring
        } else {
            velocity * -self.friction_damping
        }
    }

    /// Returns the larger of the damping rates of normal and bristle, for mobilities `along` and `across` the normal
    /// `[1/s]`.
    pub fn damping_rate(&self, along: f64, across: f64) -> f64 {
        let tangential = if self.friction > 0.0 {
            self.friction_damping * across
        } else {
            0.0
        };
        (self.damping * along).max(tangential)
    }

    /// Returns the energy stored by penetration and bristle `[J]`: K p^2/2 + k_t |z|^2/2.
    pub fn stored(&self, penetration: f64, bristle: &Vector3) -> f64 {
        0.5 * (self.stiffness * penetration * penetration
            + self.friction_stiffness * bristle.norm_squared())
    }
}

/// Transport of tangential vectors from one plane to another, by the smallest rotation between their normals.
pub(crate) struct Transport<'a> {
    to: &'a Vector3,
    /// Cosine of the rotation, and its axis with the length of the sine; `None` for equal normals.
    turn: Option<(f64, Vector3)>,
}

impl<'a> Transport<'a> {
    /// Creates the transport from a plane with normal `from` to one with normal `to`.
    #[inline]
    pub fn new(from: &Vector3, to: &'a Vector3) -> Self {
        let cosine = from.dot(to);
        let is_same = from.x == to.x && from.y == to.y && from.z == to.z && cosine == 1.0;
        Self {
            to,
            turn: (!is_same).then(|| (cosine, from.cross(to))),
        }
    }

    /// Transports a vector.
    #[inline]
    pub fn of(&self, vector: Vector3) -> Vector3 {
        let turned = match &self.turn {
            // Rodrigues' formula.
            Some((cosine, axis)) if *cosine > -0.5 => {
                vector * *cosine + axis.cross(&vector) + axis * (axis.dot(&vector) / (1.0 + cosine))
            }
            _ => vector,
        };
        turned - self.to * self.to.dot(&turned)
    }
}

/// Transports a tangential `vector` from a plane with normal `from` to one with normal `to`, by the smallest rotation
/// between the normals.
#[inline]
pub(crate) fn carried(vector: Vector3, from: &Vector3, to: &Vector3) -> Vector3 {
    Transport::new(from, to).of(vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rigid::Rotation;

    /// Parallel transport around a cone in small steps: a loop rotates the bristle by the cone's angle, as for a
    /// rolling wheel.
    #[test]
    fn a_bristle_turns_with_the_normal_and_keeps_its_length() {
        let half_angle: f64 = 0.4;
        let normal = |turn: f64| {
            Vector3::new(
                half_angle.sin() * turn.cos(),
                half_angle.sin() * turn.sin(),
                half_angle.cos(),
            )
        };
        let start = Rotation::from_axis_angle(&Vector3::y_axis(), half_angle) * Vector3::x();
        let mut bristle = start;
        let steps = 20_000;
        for step in 0..steps {
            let turn = |step: u32| std::f64::consts::TAU * f64::from(step) / f64::from(steps);
            bristle = carried(bristle, &normal(turn(step)), &normal(turn(step + 1)));
        }
        let solid_angle = std::f64::consts::TAU * (1.0 - half_angle.cos());
        let turned = bristle.dot(&start).clamp(-1.0, 1.0).acos();
        assert!((bristle.norm() - 1.0).abs() < 1e-9, "{}", bristle.norm());
        assert!(
            (turned - solid_angle).abs() < 1e-4,
            "{turned} {solid_angle}"
        );
    }

    #[test]
    fn a_cut_bristle_holds_what_the_normal_force_does() {
        let law = PointLaw {
            stiffness: 1000.0,
            damping: 1.0,
            friction: 0.5,
            friction_stiffness: 800.0,
            friction_damping: 2.0,
        };
        let cut = law.cut(Vector3::new(0.0, 0.003, 0.004), 2.0);
        assert_eq!(cut.mode, Mode::Slides);
        assert!((cut.bristle.norm() * 800.0 - 1.0).abs() < 1e-12);
        let held = law.cut(Vector3::new(0.0, 0.0003, 0.0004), 2.0);
        assert_eq!((held.mode, held.bristle.norm()), (Mode::Sticks, 0.0005));
        assert_eq!(law.normal_force(0.001, -2.0), 0.0);
    }

    #[test]
    fn a_damped_bristle_keeps_to_the_cone_and_never_gives_energy() {
        let law = PointLaw {
            stiffness: 1000.0,
            damping: 0.0,
            friction: 0.5,
            friction_stiffness: 800.0,
            friction_damping: 2.0,
        };
        let mut limited = 0;
        for step in 0..2000_u32 {
            let turn = 0.37 * f64::from(step);
            let bristle =
                Vector3::new(turn.cos(), turn.sin(), 0.0) * (1.25e-6 * f64::from(step % 1001));
            let velocity =
                Vector3::new((1.7 * turn).sin(), (2.3 * turn).cos(), 0.0) * (turn * 1.3).sin();
            let by_damping = law.bristle_damping(&bristle, &velocity, 2.0);
            let force = by_damping - bristle * law.friction_stiffness;
            assert!(force.norm() <= 1.0 + 1e-12, "{force}");
            assert!(
                by_damping.dot(&velocity) <= 1e-15,
                "{by_damping} {velocity}"
            );
            limited += u32::from(force.norm() > 1.0 - 1e-12);
        }
        assert!((100..1900).contains(&limited), "{limited}");
    }
}

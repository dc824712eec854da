//! What a contact does at one point.

use crate::ContactLaw;
use crate::rigid::Vector3;

/// The law of one point: a contact of several points shares its law among them.
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
}

/// Whether two surfaces touch, and whether they slide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Apart.
    #[default]
    Free,
    /// They touch, and the bristle holds, or there is no friction.
    Sticks,
    /// They touch, and the bristle is at its limit.
    Slides,
    /// They overlap but do not push: they part faster than the material follows.
    Parts,
}

/// A bristle, cut to its limit.
pub(crate) struct Cut {
    pub bristle: Vector3,
    pub mode: Mode,
}

impl PointLaw {
    /// The share of one among `points`.
    pub fn share(law: &ContactLaw, points: f64) -> Self {
        Self {
            stiffness: law.stiffness / points,
            damping: law.damping / points,
            friction: law.friction,
            friction_stiffness: law.friction_stiffness / points,
        }
    }

    /// max(0, K p + B p') of a penetration p above 0 `[N]`.
    pub fn normal_force(&self, penetration: f64, rate: f64) -> f64 {
        (self.stiffness * penetration + self.damping * rate).max(0.0)
    }

    /// The bristle within what a normal force `[N]` holds: mu N/k_t.
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

    /// Energy that penetration and bristle store `[J]`: K p^2/2 + k_t |z|^2/2.
    pub fn stored(&self, penetration: f64, bristle: &Vector3) -> f64 {
        0.5 * (self.stiffness * penetration * penetration
            + self.friction_stiffness * bristle.norm_squared())
    }
}

/// `vector` of a plane with normal `from`, carried with the plane to one with normal `to`: turned about the axis
/// that is perpendicular to both, and by no more.
pub(crate) fn carried(vector: Vector3, from: &Vector3, to: &Vector3) -> Vector3 {
    let axis = from.cross(to);
    let cosine = from.dot(to);
    let turned = if cosine > -0.5 {
        // Rodrigues' formula; the axis has the length of the sine.
        vector * cosine + axis.cross(&vector) + axis * (axis.dot(&vector) / (1.0 + cosine))
    } else {
        vector
    };
    turned - to * to.dot(&turned)
}

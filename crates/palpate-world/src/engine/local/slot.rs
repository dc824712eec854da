//! Slot for a contact of the local model: its strength, and the part of a change that is not yet blended in.

use nalgebra::UnitQuaternion;

use super::model::{LocalContact, Touching};
use crate::contact::law::PointLaw;
use crate::dynamics::moving_body::Part;
use crate::engine::image::Image;
use crate::engine::integration::{Found, found, rate};
use crate::engine::pairs::{Outline, Pair, Shift, Toucher};
use crate::geometry::rigid::{Rotation, Vector3};

/// Slot for a contact of the model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    /// Law at full strength.
    law: PointLaw,
    /// Law of the previous model, and its remaining fraction.
    law_before: PointLaw,
    law_left: f64,
    /// Fraction of the law that acts, 0 to 1.
    pub strength: f64,
    /// Whether the newest model contains the contact.
    is_wanted: bool,
    /// Difference between contact and surface when the newest model arrived.
    shift: Shift,
    /// Remaining fraction of the shift.
    left: f64,
    /// Whether the contact fades at its old position, because the newest model has it far away.
    is_leaving: bool,
    before: Option<Before>,
}

/// Contact geometry just before a model arrived.
#[derive(Clone, Copy, Debug)]
struct Before {
    found: Found,
    rate: f64,
}

const NO_LAW: PointLaw = PointLaw {
    stiffness: 0.0,
    damping: 0.0,
    friction: 0.0,
    friction_stiffness: 0.0,
    friction_damping: 0.0,
};

/// Returns a pair that cannot touch.
pub(super) fn closed(body: usize) -> Pair {
    Pair {
        toucher: Toucher::Tool(0),
        is_open: false,
        body,
        radius: 0.0,
        outline: Outline::Bent(0.0),
        position: Vector3::zeros(),
        orientation: Rotation::identity(),
        law: NO_LAW,
        at_full_strength: NO_LAW,
        shift: None,
    }
}

impl Slot {
    pub fn empty() -> Self {
        let shift = Shift {
            depth: 0.0,
            normal: Vector3::zeros(),
            rate: 0.0,
        };
        Self {
            law: NO_LAW,
            law_before: NO_LAW,
            law_left: 0.0,
            strength: 0.0,
            is_wanted: false,
            shift,
            left: 0.0,
            is_leaving: false,
            before: None,
        }
    }

    /// Stores the contact geometry of the last model before a new model is applied.
    pub fn look_back(&mut self, pair: &Pair, tools: &[Part], images: &[Image]) {
        let now = found(tools, images, pair).filter(|_| self.strength > 0.0);
        self.before = now.map(|found| Before {
            rate: rate(tools, images, pair, &found),
            found,
        });
    }

    /// Applies a model's contact. `hosts` are the poses of the bodies in the model, with the fixed world last.
    pub fn take(
        &mut self,
        pair: &mut Pair,
        contact: Option<&LocalContact>,
        hosts: &[Image],
        radii: &[f64],
    ) {
        let is_felt = self
            .before
            .is_some_and(|before| before.found.penetration > 0.0)
            && pair.toucher.tool().is_some();
        let contact = contact.filter(|contact| {
            // An active contact fades before its slot serves another tool.
            !is_felt
                || contact.touching == Touching::Tool(pair.toucher.tool().unwrap_or(usize::MAX))
        });
        self.is_wanted = contact.is_some();
        let Some(contact) = contact else {
            if !is_felt {
                self.strength = 0.0;
                pair.is_open = false;
            }
            return;
        };
        let fixed = hosts.len() - 1;
        pair.body = contact.on.unwrap_or(fixed);
        pair.outline = Outline::Bent(contact.curvature);
        let host = &hosts[pair.body];
        let back = host.orientation.inverse();
        pair.position = back * (Vector3::from(contact.place) - host.position);
        let normal = back * Vector3::from(contact.normal);
        pair.orientation = turned_to(&normal);
        pair.is_open = true;
        self.law_before = self.law_now();
        self.law_left = 1.0;
        self.law = PointLaw::share(&contact.law, 1.0);
        match contact.touching {
            Touching::Tool(tool) => {
                if !pair.toucher.is_tool(tool) {
                    self.before = None;
                }
                pair.toucher = Toucher::Tool(tool);
                pair.radius = radii[tool];
            }
            Touching::Body {
                body,
                centre,
                radius,
            } => {
                let host = &hosts[body];
                let centre = host.orientation.inverse() * (Vector3::from(centre) - host.position);
                pair.toucher = Toucher::Body { body, centre };
                pair.radius = radius;
            }
        }
    }

    /// Computes the shift that keeps an existing contact at its old geometry, after the copies have been moved.
    pub fn compare(&mut self, pair: &mut Pair, tools: &[Part], images: &[Image]) {
        pair.shift = None;
        self.left = 0.0;
        self.is_leaving = false;
        let before = self.before.take();
        if pair.toucher.tool().is_none() {
            self.law_left = 0.0;
            self.strength = 1.0;
            return;
        }
        let Some(now) = found(tools, images, pair) else {
            return;
        };
        let (to, is_deep) = (now.penetration, now.penetration > 0.0);
        let Some(before) = before else {
            self.law_left = 0.0;
            self.strength = if is_deep { 0.0 } else { 1.0 };
            return;
        };
        let from = before.found.penetration;
        if !is_deep && from <= 0.0 {
            return;
        }
        // A new contact starts at a distance of at most its final depth, so the force starts within half of the
        // settling time.
        self.left = 1.0;
        self.shift = Shift {
            depth: if is_deep { from.max(-to) } else { from } - to,
            normal: before.found.normal - now.normal,
            rate: before.rate - rate(tools, images, pair, &now),
        };
        self.is_leaving = to < -from;
    }

    /// Advances the blending after a tick. `settling` and `fading` are the fractions per tick.
    pub fn go_over(&mut self, pair: &mut Pair, is_stale: bool, settling: f64, fading: f64) {
        let is_of_tool = pair.toucher.tool().is_some();
        if is_of_tool && pair.is_open {
            self.strength = if is_stale {
                (self.strength - fading).max(0.0)
            } else if self.is_wanted && !self.is_leaving {
                (self.strength + settling).min(1.0)
            } else {
                (self.strength - settling).max(0.0)
            };
            if !self.is_wanted && self.strength <= 0.0 {
                pair.is_open = false;
            }
        }
        self.law_left = (self.law_left - settling).max(0.0);
        let law = self.law_now();
        pair.at_full_strength = law;
        pair.law = PointLaw {
            stiffness: law.stiffness * self.strength,
            damping: law.damping * self.strength,
            friction_stiffness: law.friction_stiffness * self.strength,
            friction_damping: law.friction_damping * self.strength,
            ..law
        };
        if self.is_leaving && self.strength > 0.0 {
            pair.shift = Some(self.shift);
            return;
        }
        // A leaving contact has faded at its old position; let it reappear at its new one.
        self.left = if self.is_leaving {
            0.0
        } else {
            (self.left - settling).max(0.0)
        };
        self.is_leaving = false;
        let left = self.left;
        pair.shift = (left > 0.0).then(|| Shift {
            depth: self.shift.depth * left,
            normal: self.shift.normal * left,
            rate: self.shift.rate * left,
        });
    }
}

impl Slot {
    /// Returns the law at full strength, blended with the previous law.
    fn law_now(&self) -> PointLaw {
        let (now, before, left) = (&self.law, &self.law_before, self.law_left);
        let of = |entry: fn(&PointLaw) -> f64| entry(now) + (entry(before) - entry(now)) * left;
        PointLaw {
            stiffness: of(|law| law.stiffness),
            damping: of(|law| law.damping),
            friction: of(|law| law.friction),
            friction_stiffness: of(|law| law.friction_stiffness),
            friction_damping: of(|law| law.friction_damping),
        }
    }
}

/// Returns the rotation from the z axis to a unit vector.
fn turned_to(normal: &Vector3) -> Rotation {
    UnitQuaternion::rotation_between(&Vector3::z(), normal)
        .unwrap_or_else(|| Rotation::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

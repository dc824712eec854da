//! State of a contact point: force, bristle, and sums since the interval began.

use crate::contact::law::{Mode, PointLaw, Transport};
use crate::contact::pairs::Point;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;

/// Cosine of the normal's rotation in a sub-step below which the contact is on another face.
pub(crate) const SAME_FACE: f64 = 0.9;

/// State of a contact point, and its sums since the interval began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub mode: Mode,
    /// Point of application of the force `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// Penetration, 0 if apart `[m]`.
    pub penetration: f64,
    /// Deflection of the bristle `[m]`.
    pub bristle: Vector3,
    /// Normal force `[N]`.
    pub normal_force: f64,
    /// Part of the normal force due to damping `[N]`.
    by_damping: f64,
    /// Part of the friction force from the bristle's damping `[N]`.
    by_rubbing: Vector3,
    /// Approach speed expected at the end of the sub-step `[m/s]`.
    expected: f64,
    /// Actual minus expected approach speed `[m/s]`. The next sub-step of equal length adds it to its expectation.
    pub missed: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    /// Fraction of the elastic force that a force limit leaves.
    elastic_scale: f64,
    /// Velocity of the first relative to the second at the contact point `[m/s]`.
    pub relative: Vector3,
    /// Tangential displacement not yet applied to the bristle `[m]`.
    pub slid: Vector3,
    /// Power dissipated by material damping `[W]`.
    damping_power: f64,
    /// Power of material damping on the apparent motion of a tool that is fixed between samples `[W]`.
    apparent_power: f64,
    /// Clearance of a separated point: displacement since the interval began below which the two cannot touch; 0 if
    /// unknown `[m]`.
    pub clear: f64,
    pub past: Past,
}

/// Sums at a contact point since the interval began.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Past {
    /// Impulse on the first `[N s]`.
    pub impulse: Vector3,
    /// First moment of this impulse about the beginning `[N s^2]`.
    pub moment: Vector3,
    /// Angular impulse on the tool of the two about its mass centre `[N m s]`.
    pub angular_impulse: Vector3,
    /// Work on the first and the second together `[J]`.
    pub work: f64,
    /// Work on the tool of the two `[J]`.
    pub work_on_tool: f64,
    /// Part of this work that the torque does on a rotation by the hand alone `[J]`.
    pub work_on_led_turn: f64,
    /// Energy dissipated by damping and friction, at least 0 `[J]`.
    pub dissipated: f64,
    /// Energy transferred from other points of the same pair `[J]`.
    pub handed: f64,
}

/// A contact whose force is held over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Point of application of the force `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// Normal force `[N]`.
    pub normal_force: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    pub slides: bool,
}

/// Overlap of a point and a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    /// Penetration, not above 0 if apart `[m]`.
    pub penetration: f64,
    /// Unit normal from the second to the first.
    pub normal: Vector3,
    /// Derivative of the penetration against the normal.
    pub slope: f64,
    /// Midpoint between the two surfaces `[m]`.
    pub place: Vector3,
}

impl Met {
    /// Returns the same place without overlap.
    pub fn apart(self) -> Self {
        Self {
            penetration: 0.0,
            ..self
        }
    }
}

impl Touch {
    /// Sets a held force.
    pub fn hold(&mut self, held: Held) {
        *self = Self {
            mode: if held.slides {
                Mode::Slides
            } else {
                Mode::Sticks
            },
            place: held.place,
            normal: held.normal,
            normal_force: held.normal_force,
            force: held.force,
            past: self.past,
            ..Self::apart()
        };
    }

    /// Ends the held force.
    pub fn disable_output(&mut self) {
        *self = Self {
            past: self.past,
            ..Self::apart()
        };
    }

    pub fn apart() -> Self {
        let none = Vector3::zeros();
        Self {
            mode: Mode::Free,
            place: none,
            normal: Vector3::x(),
            penetration: 0.0,
            bristle: none,
            normal_force: 0.0,
            by_damping: 0.0,
            by_rubbing: none,
            expected: 0.0,
            missed: 0.0,
            force: none,
            elastic_scale: 1.0,
            relative: none,
            slid: none,
            damping_power: 0.0,
            apparent_power: 0.0,
            clear: 0.0,
            past: Past::default(),
        }
    }

    /// Moves the contact state to another point, with the sums of that point.
    pub fn at_the_point_of(self, other: &Self) -> Self {
        Self {
            past: other.past,
            ..self
        }
    }

    #[inline]
    pub fn is_apart(&self) -> bool {
        self.mode == Mode::Free
    }

    /// Copies the state of `other`, the same contact at another time of the same interval. A separated contact changes only
    /// in these fields.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        if self.is_apart() && other.is_apart() {
            (self.clear, self.past.handed) = (other.clear, other.past.handed);
        } else {
            *self = *other;
        }
    }

    /// Returns whether the mode differs from that of `other`, or a pressing contact has crossed an edge to another
    /// face.
    #[inline]
    pub fn changed_from(&self, other: &Self) -> bool {
        self.mode != other.mode || !self.is_apart() && self.normal.dot(&other.normal) < SAME_FACE
    }

    /// Adds the impulse of half a sub-step under the force, which acts `at` `[s]`, to the sums. `tool`: the tool, if one
    /// of the two is, with its sign.
    #[inline]
    pub fn entry(&mut self, tool: Option<(&Part, f64)>, [half, at]: [f64; 2]) {
        let impulse = self.force * half;
        self.past.impulse += impulse;
        self.past.moment += impulse * at;
        if let Some((part, sign)) = tool
            && part.has_torque
        {
            let arm = self.place - part.rigid.position;
            self.past.angular_impulse += arm.cross(&(impulse * sign));
        }
    }

    /// Adds the work of half a sub-step under the force to the sums. The relative velocity changes linearly to
    /// `relative`; the tool, if one of the two is, moves with its own mean velocity.
    #[inline]
    pub fn entry_of_work(&mut self, relative: &Vector3, tool: Option<(&Part, f64)>, half: f64) {
        let impulse = self.force * half;
        let apparent = half * self.apparent_power;
        self.past.work += 0.5 * impulse.dot(&(self.relative + relative)) + apparent;
        if let Some((part, sign)) = tool {
            let on_tool = impulse * sign;
            let mut mean = part.mean.velocity;
            if part.has_torque {
                let arm = self.place - part.rigid.position;
                let by_turning = part.mean.turning.cross(&arm);
                mean += by_turning;
                if part.led {
                    self.past.work_on_led_turn += on_tool.dot(&by_turning);
                }
            }
            self.past.work_on_tool += on_tool.dot(&mean) + apparent;
        }
        self.past.dissipated += half * self.damping_power;
    }

    /// Applies a penetration above 0 and an approach speed `[m/s]`. The force is the law's force for penetration and
    /// rate, times the slope: the gradient of the penetration's energy.
    #[inline]
    pub fn press(&mut self, point: &Point, met: &Met, approach: f64) {
        if self.is_apart() {
            self.normal = met.normal;
        }
        let law = &point.law;
        self.expected = approach;
        let push = law.normal_force(met.penetration, met.slope * (approach + self.missed));
        self.penetration = met.penetration;
        self.normal_force = met.slope * push;
        self.by_damping = met.slope * (push - law.stiffness * met.penetration);
    }

    /// Applies a penetration that may be negative, of a contact with a held tool: its spring pulls until the contact
    /// is released. Damping does not pull.
    pub fn press_held(&mut self, point: &Point, met: &Met, approach: f64) {
        if met.penetration > 0.0 {
            self.press(point, met, approach);
            return;
        }
        if self.is_apart() {
            self.normal = met.normal;
        }
        let law = &point.law;
        self.expected = approach;
        let damping = (law.damping * (approach + self.missed) * met.slope).max(0.0);
        self.penetration = met.penetration;
        self.by_damping = met.slope * damping;
        self.normal_force = met.slope * law.stiffness * met.penetration + self.by_damping;
    }

    /// Returns the part of the force on the first due to damping `[N]`.
    pub fn damping_force(&self) -> Vector3 {
        self.normal * self.by_damping + self.by_rubbing
    }

    /// Transports the bristle with the contact plane, adds the earlier slip and the slip `way` `[m]`, and limits it
    /// to the normal force. Its damper uses the velocity of the first relative to the second that is `expected` at
    /// the end of the sub-step `[m/s]`.
    #[inline]
    pub fn rub<const BOOKS: bool>(
        &mut self,
        point: &Point,
        normal: Vector3,
        way: Vector3,
        expected: &Vector3,
    ) {
        let law = &point.law;
        // A limit scales the new force.
        let scale = core::mem::replace(&mut self.elastic_scale, 1.0);
        if law.friction <= 0.0 {
            self.by_rubbing = Vector3::zeros();
            self.mode = law.cut(Vector3::zeros(), self.normal_force).mode;
            self.slid = Vector3::zeros();
            return;
        }
        let transport = Transport::new(&self.normal, &normal);
        let before = transport.of(self.bristle);
        let slid = transport.of(self.slid);
        let follows = before + slid + way - normal * normal.dot(&way);
        let cut = law.cut(follows, self.normal_force);
        if BOOKS && cut.mode != Mode::Sticks {
            let torn = (before + cut.bristle).dot(&(follows - cut.bristle));
            let lost = 0.5 * law.friction_stiffness * torn * scale;
            self.past.dissipated += lost.max(0.0);
        }
        self.bristle = cut.bristle;
        self.mode = cut.mode;
        self.slid = Vector3::zeros();
        let across = expected - normal * normal.dot(expected);
        self.by_rubbing = law.bristle_damping(&cut.bristle, &across, self.normal_force);
    }

    /// Returns the normal and friction force on the first `[N]`.
    #[inline]
    pub fn force_of(&self, point: &Point) -> Vector3 {
        let elastic = self.normal * self.normal_force - self.bristle * point.law.friction_stiffness;
        if point.law.friction_damping > 0.0 {
            elastic + self.by_rubbing
        } else {
            elastic
        }
    }

    /// Returns the energy stored by penetration and bristle `[J]`.
    pub fn stored(&self, law: &PointLaw) -> f64 {
        let scale = self.elastic_scale;
        law.stored(self.penetration, &self.bristle) * (scale * (2.0 - scale))
    }

    /// Scales the elastic force and the total force.
    pub fn scale(&mut self, [elastic, total]: [f64; 2]) {
        self.elastic_scale *= elastic;
        let normal_spring = self.normal_force - self.by_damping;
        let across = self.force - self.normal * self.normal_force;
        self.by_damping = total * self.normal_force - elastic * normal_spring;
        self.by_rubbing = across * total - (across - self.by_rubbing) * elastic;
        self.normal_force *= total;
        self.force *= total;
    }

    /// Keeps the force between two parts that have come to rest.
    pub fn rest(&mut self) {
        self.relative = Vector3::zeros();
        self.expected = 0.0;
        self.missed = 0.0;
        self.damping_power = 0.0;
        self.apparent_power = 0.0;
    }

    /// Separates the surfaces. The energy stored in the bristle is lost.
    pub fn part(&mut self, point: &Point) {
        self.penetration = 0.0;
        self.past.dissipated += self.stored(&point.law);
        *self = Self {
            past: self.past,
            ..Self::apart()
        };
    }

    /// Computes the damping power at a relative velocity: (N - K p) p' of the material, and that of the bristle.
    #[inline]
    pub fn watch_damping<const BOOKS: bool>(
        &mut self,
        point: &Point,
        relative: &Vector3,
        first: &Part,
        second: &Part,
    ) {
        if point.is_held {
            return;
        }
        let mut felt = *relative;
        self.apparent_power = 0.0;
        if first.moves_apparently() || second.moves_apparently() {
            let apparent =
                first.apparent_velocity_at(&self.place) - second.apparent_velocity_at(&self.place);
            felt += apparent;
            self.apparent_power = self.by_damping * self.normal.dot(&apparent);
            if point.law.friction_damping > 0.0 {
                self.apparent_power += self.by_rubbing.dot(&apparent);
            }
        }
        let rate = -self.normal.dot(&felt);
        self.missed = rate - self.expected;
        if !BOOKS {
            return;
        }
        self.damping_power = (self.by_damping * rate).max(0.0);
        if point.law.friction_damping > 0.0 {
            self.damping_power += (-self.by_rubbing.dot(&felt)).max(0.0);
        }
    }
}

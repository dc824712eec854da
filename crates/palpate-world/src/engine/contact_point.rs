//! A contact point between a proxy and an image.

use crate::Mode;
use crate::contact::law::{PointLaw, carried};
use crate::contact::point::SAME_FACE;
use crate::geometry::rigid::Vector3;

/// State of a contact point, and its sums since the period began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub mode: Mode,
    pub place: Vector3,
    /// Unit vector from the body to the tool.
    pub normal: Vector3,
    pub penetration: f64,
    pub bristle: Vector3,
    normal_force: f64,
    /// Part of the friction force from the bristle's damping `[N]`.
    by_rubbing: Vector3,
    /// Approach speed expected at the end of the sub-step `[m/s]`.
    expected: f64,
    /// Actual minus expected approach speed `[m/s]`. The next sub-step of equal length adds it to its expectation.
    pub missed: f64,
    /// Force on the tool `[N]`.
    pub force: Vector3,
    /// Part of the normal force due to damping `[N]`.
    by_damping: f64,
    /// Fraction of the elastic force that a force limit leaves.
    elastic_scale: f64,
    /// Velocity of the tool relative to the body at the contact point `[m/s]`.
    pub relative: Vector3,
    slid: Vector3,
    /// Impulse on the tool since the period began `[N s]`.
    pub impulse: Vector3,
    /// Work on tool and body together since the period began `[J]`.
    pub work: f64,
    /// Work on the proxy since the period began `[J]`.
    pub work_on_proxy: f64,
    /// Energy dissipated by damping and friction since the period began `[J]`.
    pub dissipated: f64,
}

impl Touch {
    pub fn apart() -> Self {
        let none = Vector3::zeros();
        Self {
            mode: Mode::Free,
            place: none,
            normal: Vector3::x(),
            penetration: 0.0,
            bristle: none,
            normal_force: 0.0,
            by_rubbing: none,
            expected: 0.0,
            missed: 0.0,
            force: none,
            by_damping: 0.0,
            elastic_scale: 1.0,
            relative: none,
            slid: none,
            impulse: none,
            work: 0.0,
            work_on_proxy: 0.0,
            dissipated: 0.0,
        }
    }

    pub fn is_apart(&self) -> bool {
        self.mode == Mode::Free
    }

    /// Returns whether the mode differs from that of `other`, or a pressing contact has crossed an edge to another
    /// face.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.mode != other.mode || !self.is_apart() && self.normal.dot(&other.normal) < SAME_FACE
    }

    /// Begins a period.
    pub fn begin(&mut self) {
        self.impulse = Vector3::zeros();
        self.work = 0.0;
        self.work_on_proxy = 0.0;
        self.dissipated = 0.0;
    }

    pub fn stored(&self, law: &PointLaw) -> f64 {
        let scale = self.elastic_scale;
        law.stored(self.penetration, &self.bristle) * (scale * (2.0 - scale))
    }

    /// Returns the part of the force on the tool due to damping `[N]`.
    pub fn damping_force(&self) -> Vector3 {
        self.normal * self.by_damping + self.by_rubbing
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

    /// Updates the force for an overlap of `penetration` `[m]` with an expected `rate` `[m/s]`, an additional slip
    /// `way` `[m]` and a slip velocity `expected` at the end of the sub-step `[m/s]`.
    pub fn press(
        &mut self,
        law: &PointLaw,
        [penetration, rate]: [f64; 2],
        normal: Vector3,
        way: &Vector3,
        expected: &Vector3,
    ) {
        let from = if self.is_apart() { normal } else { self.normal };
        self.penetration = penetration;
        self.expected = rate;
        self.normal_force = law.normal_force(penetration, rate + self.missed);
        self.by_damping = self.normal_force - law.stiffness * penetration;
        // A limit scales the new force.
        let scale = core::mem::replace(&mut self.elastic_scale, 1.0);
        let mut bristle = Vector3::zeros();
        if law.friction > 0.0 {
            let before = carried(self.bristle, &from, &normal);
            let slid = carried(self.slid, &from, &normal);
            let follows = before + slid + way - normal * normal.dot(way);
            let cut = law.cut(follows, self.normal_force);
            let torn = (before + cut.bristle).dot(&(follows - cut.bristle));
            self.dissipated += (0.5 * law.friction_stiffness * torn * scale).max(0.0);
            (bristle, self.mode) = (cut.bristle, cut.mode);
        } else {
            self.mode = law.cut(bristle, self.normal_force).mode;
        }
        self.slid = Vector3::zeros();
        self.bristle = bristle;
        self.normal = normal;
        self.force = normal * self.normal_force - bristle * law.friction_stiffness;
        self.by_rubbing = Vector3::zeros();
        if law.friction_damping > 0.0 {
            let across = expected - normal * normal.dot(expected);
            self.by_rubbing = law.bristle_damping(&bristle, &across, self.normal_force);
            self.force += self.by_rubbing;
        }
    }

    /// Separates the surfaces. The energy stored in the bristle is lost.
    pub fn part(&mut self, law: &PointLaw) {
        self.penetration = 0.0;
        let lost = self.stored(law);
        *self = Self {
            impulse: self.impulse,
            work: self.work,
            work_on_proxy: self.work_on_proxy,
            dissipated: self.dissipated + lost,
            ..Self::apart()
        };
    }

    /// Adds half a sub-step under the force to the sums. `relative` is the tool's velocity relative to the body at
    /// its end; `proxy` is the mean velocity of the proxy.
    pub fn entry(&mut self, relative: &Vector3, proxy: &Vector3, half: f64) {
        let impulse = self.force * half;
        self.impulse += impulse;
        self.work += 0.5 * impulse.dot(&(self.relative + relative));
        self.work_on_proxy += impulse.dot(proxy);
        self.dissipated += (-half * self.by_damping * self.normal.dot(relative)).max(0.0);
        self.dissipated += (-half * self.by_rubbing.dot(relative)).max(0.0);
    }

    /// Stores the error of the expected approach speed, given the actual `rate` at the end of the sub-step `[m/s]`.
    pub fn miss(&mut self, rate: f64) {
        self.missed = rate - self.expected;
    }

    /// Adds the slip of `half` a sub-step.
    pub fn slide(&mut self, relative: &Vector3, half: f64) {
        self.slid += (relative - self.normal * self.normal.dot(relative)) * half;
    }
}

//! A point of contact between an avatar and an image.

use crate::Mode;
use crate::law::{PointLaw, carried};
use crate::rigid::Vector3;
use crate::touch::SAME_FACE;

/// What a point of contact does, and has done since the period began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub mode: Mode,
    pub place: Vector3,
    /// From the body to the tool.
    pub normal: Vector3,
    pub penetration: f64,
    pub bristle: Vector3,
    normal_force: f64,
    /// Part of the friction force that is the bristle's damping `[N]`.
    by_rubbing: Vector3,
    /// How fast the two were expected to approach at the sub-step's end `[m/s]`.
    expected: f64,
    /// By how much faster they did approach `[m/s]`. The next sub-step adds this to what it expects, if it is as long.
    pub missed: f64,
    /// On the tool `[N]`.
    pub force: Vector3,
    /// Velocity of the tool against the body there `[m/s]`.
    pub relative: Vector3,
    slid: Vector3,
    /// Impulse on the tool since the period began `[N s]`.
    pub impulse: Vector3,
    /// Work on tool and body together since the period began `[J]`.
    pub work: f64,
    /// Work on the avatar since the period began `[J]`.
    pub work_on_avatar: f64,
    /// What damping and friction took since the period began `[J]`.
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
            relative: none,
            slid: none,
            impulse: none,
            work: 0.0,
            work_on_avatar: 0.0,
            dissipated: 0.0,
        }
    }

    pub fn is_apart(&self) -> bool {
        self.mode == Mode::Free
    }

    /// Whether its mode is another than in `other`, or it presses across an edge on another face.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.mode != other.mode || !self.is_apart() && self.normal.dot(&other.normal) < SAME_FACE
    }

    /// A period begins.
    pub fn begin(&mut self) {
        self.impulse = Vector3::zeros();
        self.work = 0.0;
        self.work_on_avatar = 0.0;
        self.dissipated = 0.0;
    }

    pub fn stored(&self, law: &PointLaw) -> f64 {
        law.stored(self.penetration, &self.bristle)
    }

    /// The surfaces overlap by `penetration` `[m]` at a `rate` that is expected `[m/s]`, and slide by `way` `[m]` beyond what they
    /// have, with a velocity that is `expected` at the sub-step's end `[m/s]`.
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
        let mut bristle = Vector3::zeros();
        if law.friction > 0.0 {
            let before = carried(self.bristle, &from, &normal);
            let slid = carried(self.slid, &from, &normal);
            let follows = before + slid + way - normal * normal.dot(way);
            let cut = law.cut(follows, self.normal_force);
            let torn = (before + cut.bristle).dot(&(follows - cut.bristle));
            self.dissipated += (0.5 * law.friction_stiffness * torn).max(0.0);
            (bristle, self.mode) = (cut.bristle, cut.mode);
        } else {
            self.mode = law.cut(bristle, self.normal_force).mode;
        }
        self.slid = Vector3::zeros();
        self.bristle = bristle;
        self.normal = normal;
        self.force = normal * self.normal_force - bristle * law.friction_stiffness;
        if law.friction_damping > 0.0 {
            let across = expected - normal * normal.dot(expected);
            self.by_rubbing = law.bristle_damping(&bristle, &across, self.normal_force);
            self.force += self.by_rubbing;
        }
    }

    /// The surfaces are apart: what the bristle stored is lost.
    pub fn part(&mut self, law: &PointLaw) {
        *self = Self {
            impulse: self.impulse,
            work: self.work,
            work_on_avatar: self.work_on_avatar,
            dissipated: self.dissipated + law.stored(0.0, &self.bristle),
            ..Self::apart()
        };
    }

    /// Half a sub-step under the force, at the end of which the tool moves with `relative` against the body; the
    /// avatar's velocity is `avatar` in the mean.
    pub fn book(&mut self, law: &PointLaw, relative: &Vector3, avatar: &Vector3, half: f64) {
        let impulse = self.force * half;
        self.impulse += impulse;
        self.work += 0.5 * impulse.dot(&(self.relative + relative));
        self.work_on_avatar += impulse.dot(avatar);
        let by_damping = self.normal_force - law.stiffness * self.penetration;
        self.dissipated += (-half * by_damping * self.normal.dot(relative)).max(0.0);
        if law.friction_damping > 0.0 {
            self.dissipated += (-half * self.by_rubbing.dot(relative)).max(0.0);
        }
    }

    /// At the end of a sub-step the penetration grew at this `rate` `[m/s]`.
    pub fn miss(&mut self, rate: f64) {
        self.missed = rate - self.expected;
    }

    /// The surfaces slide on for `half` of a sub-step.
    pub fn slide(&mut self, relative: &Vector3, half: f64) {
        self.slid += (relative - self.normal * self.normal.dot(relative)) * half;
    }
}

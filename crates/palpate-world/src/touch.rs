//! What a point of contact does: its force, its bristle, and what has passed there since an interval began.

use crate::law::{Mode, carried};
use crate::pairs::Point;
use crate::part::Part;
use crate::rigid::Vector3;

/// Cosine of the angle by which a normal has to turn in a sub-step to be that of another face.
pub(crate) const SAME_FACE: f64 = 0.9;

/// What a point of contact does, and has done since the interval began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub mode: Mode,
    /// Where the force acts `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// Above 0 where they touch, else 0 `[m]`.
    pub penetration: f64,
    /// Deflection of the bristle `[m]`.
    pub bristle: Vector3,
    /// Normal force `[N]`,
    pub normal_force: f64,
    /// what of it damping adds to the spring `[N]`.
    by_damping: f64,
    /// Part of the friction force that is the bristle's damping `[N]`.
    by_rubbing: Vector3,
    /// How fast the two were expected to approach at the sub-step's end `[m/s]`.
    expected: f64,
    /// By how much faster they did approach `[m/s]`. The next sub-step adds this to what it expects, if it is as long.
    pub missed: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    /// Velocity of the first against the second there `[m/s]`.
    pub relative: Vector3,
    /// Tangential displacement that the bristle has yet to follow `[m]`.
    pub slid: Vector3,
    /// Power that material damping takes `[W]`.
    damping_power: f64,
    /// Power of the material's damping on what only seems to move, a tool that is held between samples `[W]`.
    apparent_power: f64,
    /// Of what is apart: so far the two may move since the interval began before they can touch; 0 if that is not known `[m]`.
    pub clear: f64,
    pub past: Past,
}

/// What has passed at a point of contact since the interval began.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Past {
    /// Impulse on the first `[N s]`.
    pub impulse: Vector3,
    /// Angular impulse on the tool of the two about its mass centre `[N m s]`.
    pub angular_impulse: Vector3,
    /// Work on the first and the second together `[J]`.
    pub work: f64,
    /// Work on the tool of the two `[J]`,
    pub work_on_tool: f64,
    /// and what of it the torque does on a turn that the hand alone makes `[J]`.
    pub work_on_led_turn: f64,
    /// Energy that damping and friction took, not below 0 `[J]`.
    pub dissipated: f64,
    /// Energy that other points of the same pair handed to it `[J]`.
    pub handed: f64,
}

/// A contact whose force is held over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Where the force acts `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// `[N]`
    pub normal_force: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    pub slides: bool,
}

/// How a point and a solid overlap.
pub(crate) struct Met {
    /// Not above 0 where they do not `[m]`.
    pub penetration: f64,
    /// From the second to the first.
    pub normal: Vector3,
    /// By how much the penetration grows per length of a way against the normal.
    pub slope: f64,
    /// Midway between the two surfaces `[m]`.
    pub place: Vector3,
}

impl Touch {
    /// Holds a force from now on.
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

    /// Holds no force any more.
    pub fn let_go(&mut self) {
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
            relative: none,
            slid: none,
            damping_power: 0.0,
            apparent_power: 0.0,
            clear: 0.0,
            past: Past::default(),
        }
    }

    /// The same touch at another point, at which something else has passed.
    pub fn at_the_point_of(self, other: &Self) -> Self {
        Self {
            past: other.past,
            ..self
        }
    }

    pub fn is_apart(&self) -> bool {
        self.mode == Mode::Free
    }

    /// Comes to be as `other`. Of what is apart, nothing but this differs.
    pub fn copy_from(&mut self, other: &Self) {
        if self.is_apart() && other.is_apart() {
            (self.past, self.clear) = (other.past, other.clear);
        } else {
            *self = *other;
        }
    }

    /// Whether its mode is another than in `other`, or it presses across an edge on another face.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.mode != other.mode || !self.is_apart() && self.normal.dot(&other.normal) < SAME_FACE
    }

    /// Half a sub-step under the force, while the relative velocity goes from what it was to `relative`, and that of
    /// the tool, if one of the two is, moves as in its own mean.
    pub fn book(&mut self, relative: &Vector3, tool: Option<(&Part, f64)>, half: f64) {
        let impulse = self.force * half;
        self.past.impulse += impulse;
        let apparent = half * self.apparent_power;
        self.past.work += 0.5 * impulse.dot(&(self.relative + relative)) + apparent;
        if let Some((part, sign)) = tool {
            let on_tool = impulse * sign;
            let arm = self.place - part.rigid.position;
            let mut mean = part.mean.velocity;
            if part.has_torque {
                let by_turning = part.mean.turning.cross(&arm);
                self.past.angular_impulse += arm.cross(&on_tool);
                mean += by_turning;
                if part.led {
                    self.past.work_on_led_turn += on_tool.dot(&by_turning);
                }
            }
            self.past.work_on_tool += on_tool.dot(&mean) + apparent;
        }
        self.past.dissipated += half * self.damping_power;
    }

    /// Takes a penetration above 0, and how fast the two approach `[m/s]`. The force is the law's, of the penetration and its
    /// rate, times the slope: that of the penetration's energy.
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

    /// Carries the bristle with the contact's plane, lets it follow what has slid before and over `way` `[m]`, and
    /// cuts it to what the normal force holds. Its damper sees the velocity of the first against the second that is `expected` at
    /// the sub-step's end `[m/s]`.
    pub fn rub(&mut self, point: &Point, normal: Vector3, way: Vector3, expected: &Vector3) {
        let law = &point.law;
        if law.friction <= 0.0 {
            self.by_rubbing = Vector3::zeros();
            self.mode = law.cut(Vector3::zeros(), self.normal_force).mode;
            self.slid = Vector3::zeros();
            return;
        }
        let before = carried(self.bristle, &self.normal, &normal);
        let slid = carried(self.slid, &self.normal, &normal);
        let follows = before + slid + way - normal * normal.dot(&way);
        let cut = law.cut(follows, self.normal_force);
        let torn = (before + cut.bristle).dot(&(follows - cut.bristle));
        self.past.dissipated += (0.5 * law.friction_stiffness * torn).max(0.0);
        self.bristle = cut.bristle;
        self.mode = cut.mode;
        self.slid = Vector3::zeros();
        let across = expected - normal * normal.dot(expected);
        self.by_rubbing = law.bristle_damping(&cut.bristle, &across, self.normal_force);
    }

    /// Normal and friction force on the first `[N]`.
    pub fn force_of(&self, point: &Point) -> Vector3 {
        let elastic = self.normal * self.normal_force - self.bristle * point.law.friction_stiffness;
        if point.law.friction_damping > 0.0 {
            elastic + self.by_rubbing
        } else {
            elastic
        }
    }

    /// The surfaces are apart: what the bristle stored is lost.
    pub fn part(&mut self, point: &Point) {
        let lost = point.law.stored(0.0, &self.bristle);
        self.past.dissipated += lost;
        *self = Self {
            past: self.past,
            ..Self::apart()
        };
    }

    /// Power of the damping at a relative velocity: (N - K p) p' of the material, and that of the bristle.
    pub fn watch_damping(
        &mut self,
        point: &Point,
        relative: &Vector3,
        first: &Part,
        second: &Part,
    ) {
        if point.is_held {
            return;
        }
        let apparent =
            first.apparent_velocity_at(&self.place) - second.apparent_velocity_at(&self.place);
        let rate = -self.normal.dot(&(relative + apparent));
        self.missed = rate - self.expected;
        self.damping_power = (self.by_damping * rate).max(0.0);
        self.apparent_power = self.by_damping * self.normal.dot(&apparent);
        if point.law.friction_damping > 0.0 {
            self.damping_power += (-self.by_rubbing.dot(&(relative + apparent))).max(0.0);
            self.apparent_power += self.by_rubbing.dot(&apparent);
        }
    }
}

//! Mean load of a contact on its tool along the tool's predicted step.

use crate::contact::law::carried;
use crate::contact::pairs::Point;
use crate::contact::point::Met;
use crate::geometry::rigid::{Rigid, Rotation, Vector3};

/// Displacements below this count as none in divisions of the force `[m]`.
const STANDSTILL: f64 = 1e-9;

/// Force `[N]`, and torque about the centre of the tool `[N m]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    pub force: Vector3,
    pub torque: Vector3,
}

impl Load {
    pub fn none() -> Self {
        Self {
            force: Vector3::zeros(),
            torque: Vector3::zeros(),
        }
    }

    pub fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.torque += other.torque;
    }

    pub fn times(&self, factor: f64) -> Self {
        Self {
            force: self.force * factor,
            torque: self.torque * factor,
        }
    }

    fn add_at(&mut self, force: &Vector3, arm: &Vector3) {
        self.force += force;
        self.torque += arm.cross(force);
    }
}

/// Motion of a tool along its path: displacement of its centre `[m]` and rotation vector along the world's axes
/// `[rad]`, both at constant rates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub way: Vector3,
    pub turn: Vector3,
}

impl Step {
    /// Returns the displacement of the tool's material at `arm` from its centre `[m]`.
    pub fn at(&self, arm: &Vector3) -> Vector3 {
        if self.turn == Vector3::zeros() {
            self.way
        } else {
            self.way + Rotation::from_scaled_axis(self.turn) * arm - arm
        }
    }

    /// Moves a tool by this step.
    pub fn moved(&self, rigid: &Rigid) -> Rigid {
        let mut moved = *rigid;
        moved.position += self.way;
        if self.turn != Vector3::zeros() {
            moved.orientation = Rotation::from_scaled_axis(self.turn) * rigid.orientation;
        }
        moved
    }
}

/// A contact along a step of its tool, with the other part where it is at the end of the interval.
pub(super) struct Passage<'a> {
    pub point: &'a Point,
    /// 1 if the tool is the first of the two, -1 if it is the second.
    pub sign: f64,
    /// Position of the tool's centre at the start of the step `[m]`.
    pub centre: Vector3,
    pub step: Step,
    /// Deflection of the bristle at the start `[m]`.
    pub bristle: Vector3,
    pub start: Met,
    /// Overlap at half of the step; `None` if it is known only at both ends.
    pub middle: Option<Met>,
    pub end: Met,
    /// Whether the contact begins along the step; its bristle is then relaxed at the end.
    pub begins: bool,
    /// Whether a contact that the step ends is released at once, with all its energy along the normal.
    pub snaps: bool,
}

impl Passage<'_> {
    /// Returns the mean load on the tool over the step. Its work along the step is the energy that the contact loses,
    /// without that lost by friction.
    ///
    /// The mean is Simpson's rule, exact for a spring with a constant normal. The difference between its work and the
    /// change of energy is of fifth order in the step; a force and a torque along the step remove it (Gonzalez's
    /// discrete gradient).
    pub fn load(&self) -> Load {
        let law = &self.point.law;
        let (start, end) = (&self.start, &self.end);
        let is_touching = end.penetration > 0.0;
        let arm = start.place - self.centre;
        let slide = self.step.at(&arm) * self.sign;
        let mut load = Load::none();
        if !is_touching && self.snaps {
            let along = start.normal.dot(&slide);
            let stored = law.stored(start.penetration, &Vector3::zeros());
            let is_still = along.abs() < STANDSTILL;
            let spring = law.stiffness * start.penetration;
            let push = if is_still {
                spring.max(0.0)
            } else if spring > 0.0 {
                // A surface without a jump gives at most half of the spring's force.
                (stored / along).max(0.0).min(spring)
            } else {
                stored / along
            };
            load.add_at(&(start.normal * (push * self.sign)), &arm);
            if !is_still && push * along >= stored {
                self.correct(&mut load, stored, arm.norm_squared());
            }
            return load;
        }
        self.push(&mut load, is_touching);
        let mut given = law.stored(start.penetration, &Vector3::zeros());
        if is_touching {
            given -= law.stored(end.penetration, &Vector3::zeros());
        }
        if law.friction > 0.0 && !self.begins {
            given += self.rub(&mut load, &slide, is_touching);
        }
        self.correct(&mut load, given, arm.norm_squared());
        load
    }

    /// Adds the mean of the spring's force.
    fn push(&self, load: &mut Load, is_touching: bool) {
        let ends = if self.middle.is_some() {
            1.0 / 6.0
        } else {
            0.5
        };
        let last = if is_touching { ends } else { 0.0 };
        let middle = self.middle.iter().map(|met| (met, 0.5, 4.0 / 6.0));
        let nodes = [(&self.start, 0.0, ends), (&self.end, 1.0, last)];
        for (met, at, weight) in nodes.into_iter().chain(middle) {
            let push = met.slope * self.point.law.stiffness * met.penetration;
            let force = met.normal * (push * weight * self.sign);
            load.add_at(&force, &(met.place - self.centre - self.step.way * at));
        }
    }

    /// Adds the mean of the bristle's force. Returns the work that it gives to the tool `[J]`: the energy that the
    /// bristle loses, without that dissipated at its limit.
    fn rub(&self, load: &mut Load, slide: &Vector3, is_touching: bool) -> f64 {
        let law = &self.point.law;
        let (from, to) = (&self.start.normal, &self.end.normal);
        let half_stiffness = 0.5 * law.friction_stiffness;
        let arm = (self.start.place + self.end.place - self.step.way) * 0.5 - self.centre;
        if !is_touching {
            let force = self.bristle * (-half_stiffness * self.sign);
            load.add_at(&force, &arm);
            return 0.0;
        }
        let before = carried(self.bristle, from, to);
        let follows = before + carried(slide - from * from.dot(slide), from, to);
        let normal_force = self.end.slope * law.stiffness * self.end.penetration;
        let after = law.cut(follows, normal_force).bristle;
        let torn = (before + after).dot(&(follows - after));
        let force = (self.bristle + after) * (-half_stiffness * self.sign);
        load.add_at(&force, &arm);
        let lost = self.bristle.norm_squared() - after.norm_squared();
        half_stiffness * (lost - torn.max(0.0))
    }

    /// Adds a force and a torque along the step, so that the work becomes `given` `[J]`. The force is at most the sum
    /// of the spring's forces at both ends, which only a jump of the surface under a short step exceeds.
    fn correct(&self, load: &mut Load, given: f64, square_arm: f64) {
        let Step { way, turn } = &self.step;
        let square = way.norm_squared() + square_arm * turn.norm_squared();
        if square < STANDSTILL * STANDSTILL {
            return;
        }
        let missing = given - load.force.dot(way) - load.torque.dot(turn);
        let depths = self.start.penetration.abs() + self.end.penetration.abs();
        let most = self.point.law.stiffness * depths * square.sqrt();
        // An overflow makes the bound NaN, at which `clamp` would panic; the tick's check of finite values reports it.
        let missing = missing.max(-most).min(most);
        load.force += way * (missing / square);
        load.torque += turn * (square_arm * missing / square);
    }
}

//! Mode transitions of contacts.
//!
//! A mode holds slightly beyond its end. A state at an event, known to round-off, therefore stays in one mode instead
//! of alternating between two.

use super::between::order_after;
use super::mesh::{MAX_CONTACTS, OnMesh};
use super::motion::{Condition, Instant, Mode, System, slip_direction};
use super::scene::WorldDevice;
use super::surface::Feature;
use super::vector::{Vec3, turned};

/// Tolerance of a condition on lengths `[m]`.
const SLACK: f64 = 1e-14;
/// Relative tolerance of a condition on friction.
const FRICTION_SLACK: f64 = 1e-9;
/// Tolerance of a condition on speed `[m/s]`.
const SPEED_SLACK: f64 = 1e-13;
/// Rounds in which the contacts settle after an event: one contact's new mode can end another one's.
const ROUNDS: usize = 16;

impl System {
    /// Whether contact `number` is still in its condition, at an instant evaluated for it.
    pub(super) fn holds(&self, number: usize, condition: &Condition, now: &Instant) -> bool {
        let contact = &self.contacts[number];
        let touch = &now.touches[number];
        if !contact.holds(condition.feature, &now.placed, SLACK) {
            return false;
        }
        let p = touch.penetration;
        if condition.mode == Mode::Free {
            return p <= SLACK;
        }
        let push = self.raw_normal_force(number, touch);
        let slack = contact.law.stiffness * SLACK;
        if p <= -SLACK {
            return false;
        }
        if condition.mode == Mode::Clipped {
            return push <= slack;
        }
        if push <= -slack {
            return false;
        }
        match condition.mode {
            Mode::Stick => {
                let largest = self.largest_deflection(number, touch);
                now.bristles[number].norm() <= largest * (1.0 + FRICTION_SLACK) + SLACK
            }
            Mode::Slip => {
                let speed = touch.tangential().norm() + touch.rate.abs();
                now.slips[number] >= -FRICTION_SLACK * speed - SPEED_SLACK
            }
            Mode::Free | Mode::Clipped | Mode::Smooth => true,
        }
    }

    /// Whether all contacts are in their conditions, and devices slide or stick as they did.
    pub(super) fn all_hold(&self, time: f64, conditions: &[Condition], now: &Instant) -> bool {
        let each = || conditions.iter().enumerate();
        let lasts = |(number, device): (usize, &WorldDevice)| {
            let push = || now.push(self, number, time);
            device.drivetrain.coulomb_friction == 0.0
                || now.grasps[number].lasts(device, &now.placed[number], push())
        };
        self.devices.iter().enumerate().all(lasts)
            && each().all(|(number, condition)| self.holds(number, condition, now))
            && self
                .mesh_contacts()
                .all(|first| self.moves_on_mesh(first, conditions, now).is_none())
            && self
                .solid_pairs()
                .all(|first| self.moves_of_solids(first, conditions, now).is_none())
    }

    /// Numbers of the first contact of each pair of boxes or hulls, and of each cylinder with one.
    fn solid_pairs(&self) -> impl Iterator<Item = usize> {
        let contacts = self.contacts.iter().enumerate();
        contacts.filter_map(|(number, contact)| contact.begins_solids().then_some(number))
    }

    /// Returns the required contact state of two solids, if it differs from the present one.
    fn moves_of_solids(
        &self,
        first: usize,
        conditions: &[Condition],
        now: &Instant,
    ) -> Option<Feature> {
        let at = conditions[first].feature;
        let wanted = self.contacts[first].wanted_of_solids(Some(at), &now.placed, SLACK)?;
        (wanted != at).then_some(wanted)
    }

    /// Two solids touch across another plane, or with other places of a rim: bristles go on to the contacts there.
    fn move_solids(
        &self,
        (first, feature): (usize, Feature),
        state: &mut [f64],
        conditions: &mut [Condition],
        now: &mut Instant,
    ) {
        let all = first..first + self.contacts[first].of_pair();
        if feature.is_same(conditions[first].feature) {
            for condition in &mut conditions[all] {
                condition.feature = feature;
            }
            return;
        }
        if !feature.has_points_of(conditions[first].feature) {
            let new: Vec<_> = self.contacts[all.clone()]
                .iter()
                .map(|contact| contact.touch(feature, &now.placed))
                .collect();
            let touched: Vec<_> = conditions[all.clone()]
                .iter()
                .map(|condition| condition.mode != Mode::Free)
                .collect();
            let order = order_after(&now.touches[all.clone()], &touched, &new);
            let old: Vec<_> = all.clone().map(|number| now.bristles[number]).collect();
            for (from, bristle) in old.into_iter().enumerate() {
                let to = first + order[from];
                now.bristles[to] = bristle;
                bristle.write(&mut state[self.layout.bristle(to)..]);
            }
        }
        for number in all {
            // A corner's normal force may have jumped: keep its bristle up to the new largest deflection.
            conditions[number].mode = Mode::Stick;
            self.change_to(feature, number, state, &mut conditions[number], now);
        }
    }

    /// Numbers of the first contact of each sphere with a mesh.
    fn mesh_contacts(&self) -> impl Iterator<Item = usize> {
        // A tool of several spheres has this number of contacts for each.
        let mut count = (None, 0);
        let contacts = self.contacts.iter().enumerate();
        contacts.filter_map(move |(number, contact)| {
            if count.0 != Some(contact.pair) {
                count = (Some(contact.pair), 0);
            }
            let is_first = contact.is_with_mesh() && count.1 % MAX_CONTACTS == 0;
            count.1 += 1;
            is_first.then_some(number)
        })
    }

    /// Returns the required states of the contacts of a sphere with a mesh, if they differ by more than the slack.
    fn moves_on_mesh(
        &self,
        first: usize,
        conditions: &[Condition],
        now: &Instant,
    ) -> Option<[OnMesh; MAX_CONTACTS]> {
        let contact = &self.contacts[first];
        let mut at = [OnMesh::Nothing; MAX_CONTACTS];
        for (at, condition) in at.iter_mut().zip(&conditions[first..]) {
            if let Feature::OnMesh(part) = condition.feature {
                *at = part;
            }
        }
        let wanted = contact.wanted_of_mesh(&at, &now.placed, Vec3::ZERO)?;
        if wanted == at {
            return None;
        }
        let is_first = at == [OnMesh::Nothing; MAX_CONTACTS];
        // Along a direction that is hardly one of a mesh.
        let near = [-SLACK, SLACK].into_iter().any(|slack| {
            let shift = Vec3([0.531, 0.614, -0.584]) * slack;
            contact.wanted_of_mesh(&at, &now.placed, shift) == Some(at)
        });
        (is_first || !near).then_some(wanted)
    }

    /// The conditions at the start: bristles are relaxed.
    pub(super) fn first_conditions(&self, state: &mut [f64], now: &mut Instant) -> Vec<Condition> {
        self.place(state, &mut now.placed);
        let mut conditions: Vec<Condition> = self
            .contacts
            .iter()
            .map(|contact| Condition {
                mode: Mode::Free,
                feature: contact.feature(&now.placed),
            })
            .collect();
        self.settle(0.0, state, &mut conditions, now);
        conditions
    }

    /// Gives every contact the condition of its state, and its bristle what that asks for.
    pub(super) fn settle(
        &self,
        time: f64,
        state: &mut [f64],
        conditions: &mut [Condition],
        now: &mut Instant,
    ) {
        for _ in 0..ROUNDS {
            self.evaluate(time, state, conditions, now);
            let mut settled = true;
            for (number, device) in self.devices.iter().enumerate() {
                if device.drivetrain.coulomb_friction > 0.0 {
                    let (push, placed) = (now.push(self, number, time), &now.placed[number]);
                    let (velocity, changed) = now.grasps[number].settle(device, placed, push);
                    if changed {
                        velocity.write(&mut state[self.layout.device(number) + 3..]);
                        settled = false;
                    }
                }
            }
            let firsts: Vec<usize> = self.mesh_contacts().collect();
            for first in firsts {
                let Some(wanted) = self.moves_on_mesh(first, conditions, now) else {
                    continue;
                };
                for (number, at) in (first..).zip(wanted) {
                    let condition = &mut conditions[number];
                    let feature = Feature::OnMesh(at);
                    if condition.feature != feature {
                        self.change_to(feature, number, state, condition, now);
                        settled = false;
                    }
                }
            }
            let pairs: Vec<usize> = self.solid_pairs().collect();
            for first in pairs {
                if let Some(feature) = self.moves_of_solids(first, conditions, now) {
                    self.move_solids((first, feature), state, conditions, now);
                    settled = false;
                }
            }
            if !settled {
                continue;
            }
            for (number, condition) in conditions.iter_mut().enumerate() {
                if !self.holds(number, condition, now) {
                    self.change(number, state, condition, now);
                    settled = false;
                }
            }
            if settled {
                return;
            }
        }
    }

    /// The condition of a contact that has left its own.
    fn change(&self, number: usize, state: &mut [f64], condition: &mut Condition, now: &Instant) {
        let contact = &self.contacts[number];
        let feature = if contact.is_of_several() {
            condition.feature
        } else {
            contact.feature(&now.placed)
        };
        self.change_to(feature, number, state, condition, now);
    }

    fn change_to(
        &self,
        feature: Feature,
        number: usize,
        state: &mut [f64],
        condition: &mut Condition,
        now: &Instant,
    ) {
        let contact = &self.contacts[number];
        let old_normal = now.touches[number].normal;
        condition.feature = feature;
        let touch = contact.touch(condition.feature, &now.placed);
        let law = &contact.law;
        let push = self.raw_normal_force(number, &touch);
        let largest = self.largest_deflection(number, &touch);
        let before = now.bristles[number];
        let bristle = turned(before, old_normal, touch.normal);
        let deflection = bristle.norm();
        let (mode, bristle) = if touch.penetration <= 0.0 {
            (Mode::Free, Vec3::ZERO)
        } else if push <= 0.0 {
            (Mode::Clipped, Vec3::ZERO)
        } else if law.friction == 0.0 {
            (Mode::Smooth, Vec3::ZERO)
        } else {
            match condition.mode {
                Mode::Stick if deflection > largest => {
                    (Mode::Slip, slip_direction(bristle, &touch) * largest)
                }
                Mode::Slip if now.slips[number] >= 0.0 => {
                    (Mode::Slip, slip_direction(bristle, &touch) * largest)
                }
                Mode::Stick | Mode::Slip => (Mode::Stick, bristle),
                Mode::Free | Mode::Clipped | Mode::Smooth => {
                    // Without damping, the largest deflection grows from 0 at its own rate.
                    let force_rate = touch.slope * law.stiffness * touch.growth;
                    let rate = law.friction * force_rate / law.friction_stiffness;
                    if law.damping == 0.0 && touch.tangential().norm() > rate {
                        let direction = slip_direction(Vec3::ZERO, &touch);
                        (Mode::Slip, direction * largest)
                    } else {
                        (Mode::Stick, Vec3::ZERO)
                    }
                }
            }
        };
        condition.mode = mode;
        // A sudden loss of bristle energy is dissipated.
        let lost = 0.5 * law.friction_stiffness * (before.dot(before) - bristle.dot(bristle));
        state[self.layout.contact_sums(number) + 4] += lost.max(0.0);
        bristle.write(&mut state[self.layout.bristle(number)..]);
    }
}

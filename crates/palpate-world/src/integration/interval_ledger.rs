//! Ledger entries at the end of an interval.

use crate::contact::pairs::Point;
use crate::dynamics::ledger::EnergyLedger;
use crate::integration::moving::Moving;

impl EnergyLedger {
    /// Records the change in the energy stored at the points and in the fields as external: proxies have been displaced from their
    /// expected positions and the contacts re-evaluated.
    pub(crate) fn observe(&mut self, moving: &Moving, points: &[Point]) {
        for &number in moving.nearby.recent() {
            let (entry, point) = (&mut self.contacts[number], &points[number]);
            if moving.is_settled(point) {
                continue;
            }
            let stored = moving.stored(number, point);
            entry.observed += stored - entry.stored;
            entry.stored = stored;
        }
        self.observe_fields(moving);
    }

    /// Records the motion of bodies and contacts over an interval, as in `moving`.
    pub(crate) fn pass(&mut self, moving: &Moving, points: &[Point], tools: usize) {
        for &number in moving.nearby.recent() {
            let (entry, point) = (&mut self.contacts[number], &points[number]);
            if moving.is_settled(point) {
                continue;
            }
            let past = &moving.touches[number].past;
            let stored = moving.stored(number, point);
            if point.is_held {
                // The force is held, so the contact stores no energy.
                entry.observed += past.work;
            } else {
                entry.step_error +=
                    stored - entry.stored + past.dissipated + past.work - past.handed;
                entry.handed += past.handed;
            }
            entry.dissipated += past.dissipated;
            entry.work += past.work;
            if point.tool(tools).is_some() {
                entry.work_on_proxy += past.work_on_tool;
            }
            entry.stored = stored;
        }
        for (number, entry) in self.joints.iter_mut().enumerate() {
            let before = *entry;
            entry.stored = 0.0;
            for link in moving.links.iter().filter(|link| link.joint == number) {
                entry.stored += link.stored;
                entry.work += link.work;
                entry.dissipated += link.dissipated;
            }
            let given = entry.work - before.work + entry.dissipated - before.dissipated;
            entry.step_error += entry.stored - before.stored + given;
        }
        self.pass_fields(moving);
        for (entry, part) in self.bodies.iter_mut().zip(&moving.parts[tools..]) {
            if part.is_settled {
                continue;
            }
            let kinetic = part.mobility.kinetic_energy(&part.rigid);
            // Work of its constant force as integrated by the sub-steps and as given by the displacement.
            let gained = part.work_of_constant_force();
            entry.step_error += part.turning_error + part.driven - gained;
            entry.work += kinetic - entry.kinetic - part.turning_error - part.driven;
            entry.kinetic = kinetic;
            entry.potential -= gained;
        }
    }
}

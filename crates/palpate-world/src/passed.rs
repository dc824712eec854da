//! Ledger entries at the end of an interval.

use crate::books::Books;
use crate::moving::Moving;
use crate::pairs::Point;

impl Books {
    /// Records the change in the energy stored at the points as external: proxies have been displaced from their
    /// expected positions and the contacts re-evaluated.
    pub(crate) fn observe(&mut self, moving: &Moving, points: &[Point]) {
        for (number, (book, point)) in self.contacts.iter_mut().zip(points).enumerate() {
            let stored = moving.stored(number, point);
            book.observed += stored - book.stored;
            book.stored = stored;
        }
    }

    /// Records the motion of bodies and contacts over an interval, as in `moving`.
    pub(crate) fn pass(&mut self, moving: &Moving, points: &[Point], tools: usize) {
        for (number, (book, point)) in self.contacts.iter_mut().zip(points).enumerate() {
            let past = &moving.touches[number].past;
            let stored = moving.stored(number, point);
            if point.is_held {
                // The force is held, so the contact stores no energy.
                book.observed += past.work;
            } else {
                book.step_error += stored - book.stored + past.dissipated + past.work - past.handed;
                book.handed += past.handed;
            }
            book.dissipated += past.dissipated;
            book.work += past.work;
            if point.tool(tools).is_some() {
                book.work_on_avatar += past.work_on_tool;
            }
            book.stored = stored;
        }
        for (number, book) in self.joints.iter_mut().enumerate() {
            let before = *book;
            book.stored = 0.0;
            for link in moving.links.iter().filter(|link| link.joint == number) {
                book.stored += link.stored;
                book.work += link.work;
                book.dissipated += link.dissipated;
            }
            let given = book.work - before.work + book.dissipated - before.dissipated;
            book.step_error += book.stored - before.stored + given;
        }
        for (book, part) in self.bodies.iter_mut().zip(&moving.parts[tools..]) {
            let kinetic = part.mobility.kinetic_energy(&part.rigid);
            // Work of its constant force as integrated by the sub-steps and as given by the displacement.
            let gained = part.work_of_constant_force();
            book.step_error += part.turning_error + part.driven - gained;
            book.work += kinetic - book.kinetic - part.turning_error - part.driven;
            book.kinetic = kinetic;
            book.potential -= gained;
        }
    }
}

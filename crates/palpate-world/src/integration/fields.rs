//! Force fields over an interval.

use crate::dynamics::ledger::EnergyLedger;
use crate::integration::moving::Moving;

impl Moving {
    /// Calls `act` for each field on a tool of the selected islands, with the index of the field.
    #[inline]
    pub(super) fn for_each_near_field(&mut self, mut act: impl FnMut(&mut Self, usize)) {
        for number in 0..self.fields.len() {
            if self.nearby.parts().contains(&self.fields[number].tool) {
                act(self, number);
            }
        }
    }

    /// Evaluates the fields at the current positions, and loads their tools.
    #[inline]
    pub(super) fn meet_fields(&mut self) {
        self.for_each_near_field(|moving, number| {
            let field = &mut moving.fields[number];
            let part = &mut moving.parts[field.tool];
            field.look(part);
            part.force += field.force;
        });
    }

    /// Adds half a sub-step to the sums of the fields.
    #[inline]
    pub(super) fn pull<const BOOKS: bool>(&mut self, half: f64) {
        self.for_each_near_field(|moving, number| {
            let field = &mut moving.fields[number];
            field.entry::<BOOKS>(&moving.parts[field.tool], [half, moving.elapsed]);
        });
    }

    /// Copies the fields on tools of the selected islands.
    #[inline]
    pub(super) fn copy_near_fields_from(&mut self, other: &Self) {
        self.for_each_near_field(|moving, number| moving.fields[number] = other.fields[number]);
    }

    /// Returns whether the tool of a field in the selected islands has passed into another region.
    pub(super) fn has_changed_fields_from(&self, other: &Self) -> bool {
        let mut fields = self.fields.iter().zip(&other.fields);
        fields.any(|(field, other)| {
            field.changed_from(other) && self.nearby.parts().contains(&field.tool)
        })
    }
}

impl EnergyLedger {
    /// Records the change in the energy stored in the fields as external: the tools have been displaced.
    pub(super) fn observe_fields(&mut self, moving: &Moving) {
        for (entry, field) in self.fields.iter_mut().zip(&moving.fields) {
            entry.observed += field.stored - entry.stored;
            entry.stored = field.stored;
        }
    }

    /// Records the motion of the tools in the fields over an interval.
    pub(super) fn pass_fields(&mut self, moving: &Moving) {
        for (entry, field) in self.fields.iter_mut().zip(&moving.fields) {
            let work = field.past.work;
            if field.is_supplied() {
                entry.supplied += work;
            } else {
                entry.step_error += field.stored - entry.stored + work;
            }
            entry.work += work;
            entry.stored = field.stored;
        }
    }
}

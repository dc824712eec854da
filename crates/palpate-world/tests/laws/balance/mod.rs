//! The energy of a world by its books, and what the books are off by.

use palpate_world::{ContactBook, WorldState};

/// Kinetic and potential energy of all bodies `[J]`.
pub fn of_bodies(state: &WorldState) -> f64 {
    let books = state.books().bodies.iter();
    books.map(|book| book.kinetic + book.potential).sum()
}

/// Energy of all bodies, and stored in all contacts and joints, without what a device has done `[J]`.
pub fn energy(state: &WorldState) -> f64 {
    let books = state.books();
    let in_contacts: f64 = books.contacts.iter().map(|book| book.stored).sum();
    let in_joints: f64 = books.joints.iter().map(|book| book.stored).sum();
    of_bodies(state) + in_contacts + in_joints
}

/// What the books of contacts and of the world say, each `[J]`.
pub struct Balance {
    /// What one contact's book is off by at most.
    pub contact: f64,
    /// What the world's is off by: what bodies and contacts have is what the avatars gave.
    pub world: f64,
    /// What the sub-steps made.
    pub steps: f64,
    /// What was turned over.
    pub turned_over: f64,
    /// What points of a pair handed to each other.
    pub handed_on: f64,
    /// The sum of that, which is nothing but round-off.
    handed: f64,
}

impl Balance {
    /// Of a world whose bodies had this much energy at the start `[J]`.
    pub fn since(start: f64, state: &WorldState) -> Self {
        let books = state.books();
        let sum = |of: fn(&ContactBook) -> f64| -> f64 { books.contacts.iter().map(of).sum() };
        let mut contact = 0.0_f64;
        for book in &books.contacts {
            let given = book.observed + book.handed + book.step_error;
            let off = book.stored - given + book.work + book.dissipated;
            contact = contact.max(off.abs());
            assert!(book.dissipated >= 0.0, "{} J", book.dissipated);
        }
        let of_steps: f64 = books.bodies.iter().map(|book| book.step_error).sum();
        let steps = of_steps + sum(|book| book.step_error);
        let has = of_bodies(state) - start + sum(|book| book.stored) + sum(|book| book.dissipated);
        let given = sum(|book| book.observed) - sum(|book| book.work_on_avatar) + steps;
        Self {
            contact,
            world: has - given,
            steps,
            turned_over: sum(|book| book.work.abs()),
            handed_on: sum(|book| book.handed.abs()),
            handed: sum(|book| book.handed),
        }
    }

    /// The books close to round-off, and the sub-steps make little of what is turned over.
    #[track_caller]
    pub fn holds_to(&self, off: f64, steps: f64) {
        let Self { contact, world, .. } = *self;
        assert!(contact < off && world.abs() < off, "{contact} {world} J");
        assert!(self.handed.abs() < off, "{} J handed", self.handed);
        let most = steps * self.turned_over;
        assert!(self.steps.abs() < most, "{} of {most} J", self.steps);
    }
}

impl std::fmt::Display for Balance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.3} J turned over, {:.1e} J handed from point to point, steps {:.1e} J, books off by {:.1e} and {:.1e} J",
            self.turned_over, self.handed_on, self.steps, self.contact, self.world
        )
    }
}

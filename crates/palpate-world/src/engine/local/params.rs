//! The parameters of a local model, and their checks.

use crate::{MOST_POINTS, WorldError, WorldField, WorldPart};

/// Room for a local model, and how the loop goes over from one to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalParams {
    /// How many bodies a model has, at most 16. They are called by their numbers.
    pub bodies: usize,
    /// How many contacts it has at most, 1 to 64, of tools with bodies and of bodies with each other.
    pub contacts: usize,
    /// Age of the newest model beyond which its contacts fade `[s]`: the time since the tick that it is of. At least one period
    /// of the loop, and at most 1000 of them.
    pub stale_after: f64,
    /// Time in which the contacts of a model fade that has become too old, and in which they come back `[s]`, above 0.
    pub fade: f64,
    /// Time in which a change of a contact that touches comes in `[s]`, above 0; less where models come faster.
    pub settle: f64,
    /// Time in which a copy goes back to the host's body `[s]`, above 0. Shorter: the copy is where the host says. Longer: the
    /// force is that of the copy's own motion, which no held wrench has moved.
    pub return_time: f64,
}

impl LocalParams {
    /// Room for so many `bodies` and `contacts`. Models are too old after 0.2 s and fade in 0.1 s; changes come in over
    /// 10 ms, and copies go back in 1 s.
    #[must_use]
    pub fn new(bodies: usize, contacts: usize) -> Self {
        Self {
            bodies,
            contacts,
            stale_after: 0.2,
            fade: 0.1,
            settle: 0.01,
            return_time: 1.0,
        }
    }

    pub(super) fn faults(&self, period: f64) -> Vec<WorldError> {
        let mut faults = Vec::new();
        let mut fault = |field: WorldField, message: String| {
            faults.push(WorldError::new(
                WorldPart::World,
                field,
                "the local model",
                message,
            ));
        };
        if self.bodies > MOST_BODIES {
            let given = self.bodies;
            fault(
                WorldField::Bodies,
                format!("bodies is {given}, and at most {MOST_BODIES} are allowed"),
            );
        }
        if !(1..=MOST_POINTS).contains(&self.contacts) {
            let given = self.contacts;
            fault(
                WorldField::Contacts,
                format!("contacts is {given}, and has to be 1 to {MOST_POINTS}"),
            );
        }
        for (field, value) in [
            (WorldField::Fade, self.fade),
            (WorldField::Settle, self.settle),
            (WorldField::ReturnTime, self.return_time),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                fault(
                    field,
                    format!("{field} is {value} s, and has to be above 0"),
                );
            }
        }
        let periods = self.stale_after / period;
        if period > 0.0 && !(1.0..=MOST_PERIODS).contains(&periods) {
            let (value, most) = (self.stale_after, MOST_PERIODS * period);
            fault(
                WorldField::StaleAfter,
                format!(
                    "stale_after is {value} s, and has to be {period} to {most} s: 1 to {MOST_PERIODS} periods"
                ),
            );
        }
        faults
    }
}

/// Most bodies of a model.
const MOST_BODIES: usize = 16;

/// Most periods that are remembered.
const MOST_PERIODS: f64 = 1000.0;

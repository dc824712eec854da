//! Parameters of a local model, and their checks.

use super::super::pairs::MAX_PAIRS;
use crate::{WorldError, WorldField, WorldPart};

/// Capacity of a local model, and transitions between models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalParams {
    /// Number of bodies of a model, at most 16. They are referred to by index.
    pub bodies: usize,
    /// Maximum number of contacts, 1 to 64, of tools with bodies and between bodies.
    pub contacts: usize,
    /// Age of the newest model, measured from its tick, beyond which its contacts fade `[s]`. At least 1 and at most
    /// 1000 periods of the loop.
    pub stale_after: f64,
    /// Time for contacts of a stale model to fade out, or back in `[s]`, above 0.
    pub fade: f64,
    /// Time over which a change of an active contact is blended in `[s]`, above 0; shorter if models arrive faster.
    pub settle: f64,
    /// Time in which a copy returns to the host's body `[s]`, above 0. A short time keeps the copy close to the
    /// host's position. A long time keeps the force close to that of the copy's own motion, which no mean wrench has
    /// disturbed.
    pub return_time: f64,
}

impl LocalParams {
    /// Creates parameters for this number of `bodies` and `contacts`. Models are stale after 0.2 s and fade in 0.1 s.
    /// Changes are blended in over 10 ms; copies return in 1 s.
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
        if self.bodies > MAX_BODIES {
            let given = self.bodies;
            fault(
                WorldField::Bodies,
                format!("bodies is {given}, and at most {MAX_BODIES} are allowed"),
            );
        }
        if !(1..=MAX_PAIRS).contains(&self.contacts) {
            let given = self.contacts;
            fault(
                WorldField::Contacts,
                format!("contacts is {given}, and has to be 1 to {MAX_PAIRS}"),
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
        if period > 0.0 && !(1.0..=MAX_PERIODS).contains(&periods) {
            let (value, most) = (self.stale_after, MAX_PERIODS * period);
            fault(
                WorldField::StaleAfter,
                format!(
                    "stale_after is {value} s, and has to be {period} to {most} s: 1 to {MAX_PERIODS} periods"
                ),
            );
        }
        faults
    }
}

/// Maximum number of bodies of a model.
const MAX_BODIES: usize = 16;

/// Maximum number of stored periods.
const MAX_PERIODS: f64 = 1000.0;

//! The wrenches of a world between its renderer and whoever holds them: bounded, and softened where they begin.

use palpate_device::Wrench;
use palpate_rt::safety::{Rendered, Safety};
use palpate_world::{Limited, Vector};

/// What a renderer has answered.
pub struct Answered<'a> {
    /// Time since the sample before `[s]`; `None` for the first.
    pub elapsed: Option<f64>,
    /// Where the tools were sampled `[m]`.
    pub positions: &'a [Vector],
    /// Whether the sample was refused.
    pub is_refused: bool,
    /// Limits of the renderer that acted.
    pub limited: Limited,
}

/// Puts each wrench `[N]`, `[N m]` through the safety of its device, and gives the names of the limits that acted.
pub fn bound(
    answered: &Answered<'_>,
    safeties: &mut [Safety],
    wrenches: &mut [Wrench],
) -> Vec<&'static str> {
    let (mut is_limited, mut is_softened) = (answered.limited.force, false);
    for ((safety, wrench), position) in safeties.iter_mut().zip(wrenches).zip(answered.positions) {
        let verdict = safety.judge(&Rendered {
            elapsed: answered.elapsed,
            // A position that the renderer has refused is not looked at.
            position: if answered.is_refused {
                [0.0; 3]
            } else {
                *position
            },
            coordinate: 0.0,
            wrench: *wrench,
            created_energy: 0.0,
            refused: answered.is_refused,
            stalled: false,
        });
        is_limited |= verdict.bounded.force;
        is_softened |= verdict.bounded.soft_start;
        // A force of -0 that comes in softly is none.
        let Wrench { force, torque } = verdict.wrench;
        *wrench = Wrench {
            force: force.map(|component| component + 0.0),
            torque: torque.map(|component| component + 0.0),
        };
    }
    let acted = [
        (is_limited, "force"),
        (answered.limited.torque, "torque"),
        (answered.limited.offset, "offset"),
        (is_softened, "soft-start"),
    ];
    let names = acted.into_iter();
    names
        .filter_map(|(acted, name)| acted.then_some(name))
        .collect()
}

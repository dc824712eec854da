//! Names of active limits of a world for Python.

use palpate_rt::safety::Bounded;
use palpate_world::Limited;

/// Returns the names of the active limits of renderer and safety layer.
pub fn names(limited: Limited, bounded: Bounded) -> Vec<&'static str> {
    let acted = [
        (limited.force || bounded.force, "force"),
        (limited.torque, "torque"),
        (limited.offset, "offset"),
        (limited.guard, "guard"),
        (limited.beyond_guard, "beyond-guard"),
        (bounded.soft_start, "soft-start"),
        (bounded.stopped, "safety-stop"),
    ];
    let names = acted.into_iter();
    names
        .filter_map(|(acted, name)| acted.then_some(name))
        .collect()
}

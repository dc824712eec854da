//! The limits between a renderer of worlds and whoever holds its wrenches, by their names.

use palpate_rt::safety::Bounded;
use palpate_world::Limited;

/// The names of the limits that acted: those of the renderer and those of the safety.
pub fn acted(limited: Limited, bounded: Bounded) -> Vec<&'static str> {
    let acted = [
        (limited.force || bounded.force, "force"),
        (limited.torque, "torque"),
        (limited.offset, "offset"),
        (bounded.soft_start, "soft-start"),
    ];
    let names = acted.into_iter();
    names
        .filter_map(|(acted, name)| acted.then_some(name))
        .collect()
}

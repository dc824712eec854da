//! Worlds in commands: their flags, methods and error messages.

use std::fmt::Display;
use std::path::Path;

use palpate_scene::hand_limit;
use palpate_scene::world::{WorldFile, WorldScene, hand_guard, usual_guard};
use palpate_world::{WorldErrors, WorldField, WorldGuard, WorldHandLimit, WorldPart};

use crate::arguments::{Flags, Given};
use crate::failure::Failure;
use crate::values::AnyMethods;

/// Rejects flags that do not apply to a world.
pub fn only(given: &Given, known: &[&str], path: &Path) -> Result<(), Failure> {
    let known = &[known, &["set"]].concat();
    let Some(flag) = given.other_than(known) else {
        return Ok(());
    };
    Err(Failure::Arguments(format!(
        "{flag}: {} is a world, whose file defines the rendering; allowed flags: {}",
        path.display(),
        known
            .iter()
            .filter(|name| !["file", "scene"].contains(name))
            .map(|name| format!("--{}", name.replace('_', "-")))
            .collect::<Vec<_>>()
            .join(", ")
    )))
}

/// Returns the named methods, or the scene's own. `all` selects the methods for which the scene has every setting and
/// supported shapes.
pub fn methods<'a>(flags: &'a Flags, scene: &'a WorldScene) -> Vec<&'a str> {
    match &flags.method {
        None => vec![&scene.render.method],
        Some(methods) if methods.are_all => able(scene),
        Some(methods) => methods.names.clone(),
    }
}

/// Returns the world with the guard of the flags; without such a flag, that of the file.
pub fn guarded(flags: &Flags, file: &WorldFile) -> WorldFile {
    let mut file = file.clone();
    if let Some(mode) = flags.guard {
        let guard = &mut file.scene.render.guard;
        let mut params = match *guard {
            WorldGuard::Off => usual_guard(),
            WorldGuard::Report(params) | WorldGuard::Limit(params) => params,
        };
        params.largest_speed = flags.guard_speed.unwrap_or(params.largest_speed);
        params.allowance = flags.guard_allowance.unwrap_or(params.allowance);
        params.recovery = flags.guard_recovery.unwrap_or(params.recovery);
        if let Some(limit) = hand_limit(flags.guard_acceleration, flags.guard_hand_force) {
            let given = hand_guard(limit);
            let hand = params.hand.get_or_insert(given);
            hand.limit = match (hand.limit, given.limit) {
                // The file has the angular part.
                (
                    WorldHandLimit::Acceleration { angular, .. },
                    WorldHandLimit::Acceleration { linear, .. },
                ) => WorldHandLimit::Acceleration { linear, angular },
                (WorldHandLimit::Force { torque, .. }, WorldHandLimit::Force { force, .. }) => {
                    WorldHandLimit::Force { force, torque }
                }
                (_, given) => given,
            };
            if let Some(mass) = flags.guard_mass {
                hand.least_mass = [mass; 3];
            }
        }
        *guard = mode.of_world(params);
    }
    file
}

/// Returns the methods of a study on a world: the named ones, or `all`.
pub fn compared(
    named: Option<&AnyMethods>,
    all: impl FnOnce() -> Vec<&'static str>,
) -> Result<Vec<&'static str>, Failure> {
    let Some(named) = named.filter(|methods| !methods.are_all) else {
        return Ok(all());
    };
    let is_unknown = |name: &&&str| !WorldScene::METHODS.contains(name);
    match named.names.iter().find(is_unknown) {
        None => Ok(named.names.clone()),
        Some(other) => Err(Failure::Arguments(format!(
            "--method: {other} does not render worlds; the methods are {}",
            WorldScene::METHODS.join(", ")
        ))),
    }
}

/// Returns the methods for which a world has every setting and supported shapes.
pub fn able(scene: &WorldScene) -> Vec<&'static str> {
    let all = WorldScene::METHODS.into_iter();
    all.filter(|name| scene.method(name).is_ok()).collect()
}

/// Explains an error of a study on the scene of a file.
pub fn failed<E: Display>(path: &Path) -> impl Fn(E) -> Failure {
    move |error| Failure::input(format!("{}: {error}", path.display()))
}

/// Returns the single method.
pub fn one_method<'a>(flags: &'a Flags, scene: &'a WorldScene) -> Result<&'a str, Failure> {
    match methods(flags, scene)[..] {
        [method] => Ok(method),
        _ => Err(Failure::Arguments(
            "--method: this command renders a world with one method; name it".into(),
        )),
    }
}

/// Returns a method's name with a static lifetime.
pub fn known(method: &str) -> &'static str {
    let mut all = WorldScene::METHODS.into_iter();
    all.find(|name| *name == method).unwrap_or("unknown")
}

/// Explains errors of a parsed world: the error is in a flag if one gave the method, else in the file.
pub fn wrong_world(flags: &Flags, file: &WorldFile, faults: &WorldErrors) -> Failure {
    let first = faults.first();
    for (field, flag, value) in [
        (
            WorldField::GuardLargestSpeed,
            "--guard-speed",
            flags.guard_speed,
        ),
        (
            WorldField::GuardAllowance,
            "--guard-allowance",
            flags.guard_allowance,
        ),
        (
            WorldField::GuardAcceleration,
            "--guard-acceleration",
            flags.guard_acceleration,
        ),
        (
            WorldField::GuardHandForce,
            "--guard-hand-force",
            flags.guard_hand_force,
        ),
        (WorldField::GuardMass, "--guard-mass", flags.guard_mass),
        (
            WorldField::GuardRecovery,
            "--guard-recovery",
            flags.guard_recovery,
        ),
    ] {
        if first.field == field && value.is_some() {
            return Failure::Arguments(format!("{flag}: {}", first.message));
        }
    }
    // The file has no such key if it has no such guard.
    let turned = match first.field {
        WorldField::GuardTurning if flags.guard_acceleration.is_some() => Some((
            "--guard-acceleration",
            "turning_acceleration_rad_per_s2 and acceleration_m_per_s2",
        )),
        WorldField::GuardHandTorque if flags.guard_hand_force.is_some() => {
            Some(("--guard-hand-force", "hand_torque_n_m and hand_force_n"))
        }
        _ => None,
    };
    if let Some((flag, keys)) = turned {
        return Failure::Arguments(format!(
            "{flag}: a device turns; set render.guard.{keys} in the file"
        ));
    }
    if flags.method.is_some() && first.part == WorldPart::Method {
        return Failure::Arguments(format!("--method: {}", first.message));
    }
    let error = file.at(first.part, first.field, first.to_string());
    Failure::inputs([error])
}

//! The devices of a world.

use palpate_device::clock::Clock;
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::SpatialHand;

use super::arguments::Choice;
use super::{DeviceArguments, DeviceName, OpenedInWorld, open_as};
use crate::arguments::Given;
use crate::failure::Failure;
use crate::reports::Guarding;

/// Field names of one device's flags. With several named devices they follow the name of their device.
pub const FLAGS_OF_A_DEVICE: [&str; 18] = [
    "port",
    "generation",
    "board",
    "start_pose",
    "reconnect",
    "reconnect_in_start_pose",
    "watchdog",
    "allow_remote",
    "service",
    "events",
    "device_id",
    "service_priority",
    "library",
    "serial",
    "gripper",
    "no_gravity_compensation",
    "origin",
    "world_axes",
];

/// Opens a device for each device of a world, in the order of its file: the one in `arguments`, or several by their
/// names in the file. A device `pointer` is moved by the hand at its index in `hands`; without a hand it stays at its
/// start.
///
/// # Errors
/// A device of the world is not named or is named twice, a name is unknown, a flag belongs after a name, or one device
/// is used twice; otherwise as for one device.
pub fn open_for_world<C: Clock>(
    arguments: &DeviceArguments,
    given: &Given,
    scene: &WorldScene,
    clock: &C,
    guarding: &Guarding,
    hands: &[Option<SpatialHand>],
) -> Result<Vec<OpenedInWorld>, Failure> {
    let mut opened: Vec<OpenedInWorld> = Vec::new();
    let names = names(scene);
    for (of_one, name) in each(arguments, given, scene)?.into_iter().zip(&names) {
        let number = opened.len();
        let hand = hands.get(number).and_then(Option::as_ref);
        let next = open_as((scene, number), of_one, clock, guarding, hand);
        let next = next.map_err(|failure| match &arguments.device[..] {
            [Choice::Kind(_) | Choice::Own(_)] => failure,
            _ => failure.of(&format!("--device {name}=")),
        })?;
        let is_the_same =
            |before: &OpenedInWorld| before.identity.is_some() && before.identity == next.identity;
        if let Some(before) = opened.iter().position(is_the_same) {
            return Err(Failure::Arguments(format!(
                "--device: {} and {} are the same device, {}; give a separate device for each",
                names[before],
                name,
                next.identity.unwrap_or_default()
            )));
        }
        opened.push(next);
    }
    Ok(opened)
}

/// Returns the kind of each device of the world, in the order of its file.
///
/// # Errors
/// As [`open_for_world`], except for errors of a device itself.
pub fn kinds(
    arguments: &DeviceArguments,
    given: &Given,
    scene: &WorldScene,
) -> Result<Vec<DeviceName>, Failure> {
    let each = each(arguments, given, scene)?;
    Ok(each.iter().map(|of_one| of_one.kind()).collect())
}

/// Returns the arguments of each device of the world.
fn each<'a>(
    arguments: &'a DeviceArguments,
    given: &Given,
    scene: &WorldScene,
) -> Result<Vec<&'a DeviceArguments>, Failure> {
    let names = names(scene);
    let refused = |why: String| {
        Failure::Arguments(format!(
            "--device: {why}; the world has {}: give --device \"NAME=DEVICE FLAGS\" once for each, or simulated or \
             pointer for all",
            listed(&names)
        ))
    };
    if let [Choice::Kind(_) | Choice::Own(_)] = arguments.device[..] {
        let kind = arguments.kind();
        let is_for_all = matches!(kind, DeviceName::Simulated | DeviceName::Pointer);
        if names.len() > 1 && !is_for_all {
            return Err(refused("one device is given for all".into()));
        }
        return Ok(vec![arguments; scene.devices.len()]);
    }
    if let Some(flag) = given.one_of(&FLAGS_OF_A_DEVICE) {
        return Err(refused(format!(
            "{flag} must follow the name of its device, within the quotes"
        )));
    }
    let mut found: Vec<Option<&DeviceArguments>> = vec![None; names.len()];
    for choice in &arguments.device {
        let Choice::Of { name, arguments } = choice else {
            return Err(refused("a device without a name".into()));
        };
        let Some(place) = names.iter().position(|own| own == name) else {
            return Err(refused(format!("no device is called {name}")));
        };
        if found[place].replace(arguments).is_some() {
            return Err(refused(format!("{name} is assigned twice")));
        }
    }
    let missing = names.iter().zip(&found).find(|(_, found)| found.is_none());
    if let Some((name, _)) = missing {
        return Err(refused(format!("{name} is not assigned")));
    }
    Ok(found.into_iter().flatten().collect())
}

/// Returns the names of a world's devices in its file, in their order.
pub fn names(scene: &WorldScene) -> Vec<&str> {
    let tools = scene.world.tools.iter();
    tools.map(|tool| tool.name.as_str()).collect()
}

/// Formats names as `left and right` or `a, b and c`.
fn listed(names: &[&str]) -> String {
    match names {
        [] => "none".into(),
        [one] => (*one).into(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

//! What the renderer of a world is told of the device that it runs on.

use palpate_device::Capabilities;
use palpate_scene::world::WorldScene;

/// What there is to tell of a device.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// What it can do.
    pub device: &'a Capabilities,
    /// Along which axes of the world it moves.
    pub has_axes: [bool; 3],
    /// The safety lets no more force through `[N]`.
    pub largest_force: f64,
    /// The safety lets no more torque through `[N m]`.
    pub largest_torque: f64,
}

/// The scene as the renderer of a loop with one device is told it: no force above `largest_force` `[N]` and no torque above
/// `largest_torque` `[N m]`, a sensor as coarse as the device says, and a device that lacks the axes of the world that it has
/// not.
#[must_use]
pub fn told_of(
    scene: &WorldScene,
    device: &Capabilities,
    has_axis: impl Fn(usize) -> bool,
    largest_force: f64,
    largest_torque: f64,
) -> WorldScene {
    told_of_devices(
        scene,
        &[Told {
            device,
            has_axes: [0, 1, 2].map(has_axis),
            largest_force,
            largest_torque,
        }],
    )
}

/// The same of a loop with several devices, in the order of the scene. The limits of the renderer are those of the device that
/// is given the most: the safety of each limits its own.
#[must_use]
pub fn told_of_devices(scene: &WorldScene, devices: &[Told<'_>]) -> WorldScene {
    let mut told = scene.clone();
    for (own, of) in told.devices.iter_mut().zip(devices) {
        if let Some(quantum) = of.device.encoder_quantum {
            own.quantum = own.quantum.map(|of_file| of_file.max(quantum));
        }
    }
    let most = |limit: fn(&Told<'_>) -> f64| devices.iter().map(limit).fold(0.0, f64::max);
    let largest_force = most(|of| of.largest_force);
    let limit = told.render.force_limit.unwrap_or(largest_force);
    told.render.force_limit = Some(limit.min(largest_force));
    let largest_torque = most(|of| of.largest_torque);
    let limit = told.render.torque_limit.unwrap_or(largest_torque);
    told.render.torque_limit = Some(limit.min(largest_torque));
    for (number, of) in devices.iter().enumerate() {
        told = told.with_axes(number, of.has_axes);
    }
    told
}

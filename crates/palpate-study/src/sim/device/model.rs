//! Renderer's model of the device of a world.

use palpate_device::Capabilities;
use palpate_scene::world::WorldScene;

/// Model values of a device.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    /// Capabilities of the device.
    pub device: &'a Capabilities,
    /// Along which axes of the world it moves.
    pub has_axes: [bool; 3],
    /// Force limit of the safety layer `[N]`.
    pub largest_force: f64,
    /// Torque limit of the safety layer `[N m]`.
    pub largest_torque: f64,
}

/// Returns the scene of a renderer for a loop with one device: no force above `largest_force` `[N]`, no torque above
/// `largest_torque` `[N m]`, the device's sensor resolution, and only the world axes that the device has.
#[must_use]
pub fn model_of(
    scene: &WorldScene,
    device: &Capabilities,
    has_axis: impl Fn(usize) -> bool,
    largest_force: f64,
    largest_torque: f64,
) -> WorldScene {
    model_of_devices(
        scene,
        &[Model {
            device,
            has_axes: [0, 1, 2].map(has_axis),
            largest_force,
            largest_torque,
        }],
    )
}

/// Returns the scene of a renderer for a loop with several devices, in the order of the scene. The renderer has the
/// largest of the devices' limits; the safety layer of each device applies its own.
#[must_use]
pub fn model_of_devices(scene: &WorldScene, devices: &[Model<'_>]) -> WorldScene {
    let mut model = scene.clone();
    for (own, of) in model.devices.iter_mut().zip(devices) {
        if let Some(quantum) = of.device.encoder_quantum {
            own.quantum = own.quantum.map(|of_file| of_file.max(quantum));
        }
    }
    let most = |limit: fn(&Model<'_>) -> f64| devices.iter().map(limit).fold(0.0, f64::max);
    let largest_force = most(|of| of.largest_force);
    let limit = model.render.force_limit.unwrap_or(largest_force);
    model.render.force_limit = Some(limit.min(largest_force));
    let largest_torque = most(|of| of.largest_torque);
    let limit = model.render.torque_limit.unwrap_or(largest_torque);
    model.render.torque_limit = Some(limit.min(largest_torque));
    for (number, of) in devices.iter().enumerate() {
        model = model.with_axes(number, of.has_axes);
    }
    model
}

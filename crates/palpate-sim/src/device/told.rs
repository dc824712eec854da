//! What the renderer of a world is told of the device that it runs on.

use palpate_device::Capabilities;
use palpate_scene::world::WorldScene;

/// The scene as the renderer of a loop with one device is told it: no force above `largest_force` `[N]` and no torque above
/// `largest_torque` `[N m]`, a sensor as coarse as the device says, and a device that does not move along the axes of the
/// world that it has not.
#[must_use]
pub fn told_of(
    scene: &WorldScene,
    device: &Capabilities,
    has_axis: impl Fn(usize) -> bool,
    largest_force: f64,
    largest_torque: f64,
) -> WorldScene {
    let mut told = scene.clone();
    if let Some(quantum) = device.encoder_quantum {
        for own in &mut told.devices {
            own.quantum = own.quantum.map(|of_file| of_file.max(quantum));
        }
    }
    let limit = told.render.force_limit.unwrap_or(largest_force);
    told.render.force_limit = Some(limit.min(largest_force));
    let limit = told.render.torque_limit.unwrap_or(largest_torque);
    told.render.torque_limit = Some(limit.min(largest_torque));
    for mass in &mut told.render.device_mass {
        for (axis, mass) in mass.iter_mut().enumerate() {
            if !has_axis(axis) {
                *mass = f64::INFINITY;
            }
        }
    }
    told
}

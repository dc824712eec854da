//! Rendering of a world on its devices.

use crate::sim::device::{Model, model_of_devices};
use palpate_rt::{OnDevice, RenderedWorld, SetupError};
use palpate_scene::world::WorldScene;
use palpate_world::{Tool, WorldErrors};

/// Reason why a loop cannot render a world on its devices.
#[derive(Debug)]
pub enum NotRendered {
    /// Faults of the world, at least one.
    World(WorldErrors),
    /// The devices do not fit the world.
    Devices(SetupError),
}

/// Creates the rendering of `scene` by `method` on the devices of its world, in the order of the scene. The limits of
/// each device bound its forces. The renderer gets the sensor quantum of each device and the axes of the world that
/// it lacks.
///
/// # Errors
/// The method cannot render the world, or the devices do not fit it.
pub fn rendered(
    scene: &WorldScene,
    method: &str,
    on: &[OnDevice],
) -> Result<RenderedWorld, NotRendered> {
    let model = on.iter().map(|on| Model {
        device: &on.capabilities,
        has_axes: has_axes(on),
        largest_force: on.limits.largest_force,
        largest_torque: on.limits.largest_torque,
    });
    let scene = model_of_devices(scene, &model.collect::<Vec<_>>());
    let renderer = scene.renderer(method).map_err(NotRendered::World)?;
    let mut known = WorldScene::METHODS.into_iter();
    let method = known.find(|known| *known == method).unwrap_or("unknown");
    let frames = on.iter().map(|on| on.frame).collect();
    RenderedWorld::of_devices(&scene.world, renderer, method, frames).map_err(NotRendered::Devices)
}

/// Describes the axes of the scene's devices that the loop's devices lack. The loop renders no force along them, but
/// a simulation of the scene has a motor there.
#[must_use]
pub fn lacking_axes(scene: &WorldScene, on: &[OnDevice]) -> Vec<String> {
    let of_one = |(tool, on): (&Tool, &OnDevice)| {
        if tool.own_axes.is_some() {
            return None;
        }
        let has_axes = has_axes(on);
        let left = Tool::new(tool.name.clone(), tool.shape.clone())
            .along([0, 1, 2].map(|axis| tool.axes[axis] && has_axes[axis]));
        if left.axes == tool.axes || left.axes == [false; 3] {
            return None;
        }
        let names = ["x", "y", "z"].into_iter().zip(left.axes);
        let names = names.filter(|(_, has)| *has);
        let names: Vec<_> = names.map(|(name, _)| format!("\"{name}\"")).collect();
        Some(format!(
            "{name}: the file has the axes {says}, but the device has {moves} of the world ({device}): the \
             mechanism holds the tool along the other axes, without a rendered force; set `axes = [{names}]` in \
             [[device]] for `simulate`, `compare` and `tune`, too",
            name = tool.name,
            device = on.capabilities.name,
            moves = left.names_of_axes(),
            says = tool.names_of_axes(),
            names = names.join(", ")
        ))
    };
    scene
        .world
        .tools
        .iter()
        .zip(on)
        .filter_map(of_one)
        .collect()
}

fn has_axes(on: &OnDevice) -> [bool; 3] {
    [0, 1, 2].map(|axis| on.frame.has(axis))
}

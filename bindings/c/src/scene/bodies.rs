//! Functions that add, read, change and remove devices and bodies of a scene.

use core::ffi::c_char;
use std::borrow::ToOwned;
use std::format;

use palpate_world::{Party, Tool, WorldPart};

use super::{BodyParams, DeviceParams, Scene, Shape, at, named, wrong};
use crate::edge::status;
use crate::sized;
use crate::status::Status;

/// Adds a device and the shape of its tool: a sphere, several spheres, a box, a capsule or a cylinder. The order of
/// the calls determines its index in samples and wrenches. The name must not be "", "*", "world" or the name of
/// another device or body, and must not contain a comma, quotation mark or control character.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_device(
    scene: *mut Scene,
    name: *const c_char,
    params: *const DeviceParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: guaranteed by the caller.
        let (params, shape) = unsafe { (sized::read(params)?, Shape::at(shape)?) };
        // The same rule applies to files.
        if name.contains(|letter: char| letter.is_control() || "\",".contains(letter)) {
            return Err(wrong(format!(
                "name is {name:?}, but must have no comma, quotation mark or control character: column names begin with it"
            )));
        }
        scene.free_name(name)?;
        let device = params.device()?;
        let mut tool = Tool::new(name, shape);
        tool.turns = device.turning.is_some();
        tool.gives_torque = device.turning.is_none_or(|turning| turning.gives_torque);
        let number = scene.scene.world.tools.len();
        scene.scene.world.tools.push(tool);
        // The check needs the tool in the scene.
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Tool(number)) {
            scene.scene.world.tools.truncate(number);
            return Err(refusal);
        }
        let scene = scene.edit();
        scene.render.device_mass.push(device.mass);
        let inertia = device.turning.map(|turning| turning.inertia);
        scene.render.device_inertia.push(inertia);
        scene.devices.push(device);
        Ok(())
    })
}

/// Adds a body. The order of the calls determines its index, unless an earlier body is removed.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *const BodyParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: guaranteed by the caller.
        let (params, shape) = unsafe { (sized::read(params)?, Shape::at(shape)?) };
        scene.free_name(name)?;
        let number = scene.scene.world.bodies.len();
        let body = params.body(name, shape)?.balanced();
        scene.scene.world.bodies.push(body);
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Body(number)) {
            scene.scene.world.bodies.truncate(number);
            return Err(refusal);
        }
        scene.edit();
        Ok(())
    })
}

/// Writes the parameters of a body to `*params`. For a moving mesh or hull the position is its centre of mass.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *mut BodyParams,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        let body = &scene.scene.world.bodies[scene.body(name)?];
        // SAFETY: guaranteed by the caller.
        unsafe { sized::write(params, || BodyParams::from(body)) }
    })
}

/// Replaces the parameters of a body. If `shape` is NULL, the shape is kept. On an error nothing changes.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *const BodyParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: guaranteed by the caller.
        let params = unsafe { sized::read(params) }?;
        let number = scene.body(name)?;
        let shape = if shape.is_null() {
            None
        } else {
            // SAFETY: guaranteed by the caller.
            Some(unsafe { Shape::at(shape) }?)
        };
        let before = scene.scene.world.bodies[number].clone();
        let after = match shape {
            // The shape is already relative to the centre of mass.
            None => params.body(name, before.shape.clone())?,
            Some(shape) => params.body(name, shape)?.balanced(),
        };
        scene.scene.world.bodies[number] = after;
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Body(number)) {
            scene.scene.world.bodies[number] = before;
            return Err(refusal);
        }
        scene.edit();
        Ok(())
    })
}

/// Removes a body with its joints and the laws that name it. The indices of later bodies decrease by one.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_body(
    scene: *mut Scene,
    name: *const c_char,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        let number = scene.body(name)?;
        let world = &mut scene.edit().world;
        world.bodies.remove(number);
        let party = Party::Named(name.to_owned());
        world.contacts.retain(|law| !law.between.contains(&party));
        world
            .joints
            .retain(|joint| joint.body != *name && joint.against.as_deref() != Some(name));
        Ok(())
    })
}

/// Returns the number of bodies of the scene; 0 if `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_body_count(scene: *mut Scene) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.bodies.len())
}

/// Returns the number of devices of the scene; 0 if `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_device_count(scene: *mut Scene) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.tools.len())
}

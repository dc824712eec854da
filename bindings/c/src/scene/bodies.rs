//! Devices and bodies of a scene: they are added, read, changed and taken out.

use core::ffi::c_char;
use std::borrow::ToOwned;
use std::format;

use palpate_world::{Party, Tool, WorldPart};

use super::{BodyParams, DeviceParams, Scene, Shape, at, named, wrong};
use crate::edge::status;
use crate::sized;
use crate::status::Status;

/// Adds a device and the shape of its tool: a sphere, several spheres, a box, a capsule or a cylinder. Its place in the scene, which
/// samples and wrenches go by, is that of the call. A name may not be "", "*" or "world", nor that of another device or body, and
/// has no comma, quotation mark or control character.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_device(
    scene: *mut Scene,
    name: *const c_char,
    params: *const DeviceParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: as the caller says.
        let (params, shape) = unsafe { (sized::read(params)?, Shape::at(shape)?) };
        // As in a file.
        if name.contains(|letter: char| letter.is_control() || "\",".contains(letter)) {
            return Err(wrong(format!(
                "name is {name:?}, but must have no comma, quotation mark or control character: it begins names of columns"
            )));
        }
        scene.free_name(name)?;
        let device = params.device()?;
        let mut tool = Tool::new(name, shape);
        tool.turns = device.turning.is_some();
        tool.gives_torque = device.turning.is_none_or(|turning| turning.gives_torque);
        let number = scene.scene.world.tools.len();
        scene.scene.world.tools.push(tool);
        // Only now is it known whether the tool can be.
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

/// Adds a body. Its place is that of the call, as long as none before it is removed.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *const BodyParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: as the caller says.
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

/// Puts what the scene says of a body into `*params`: of a body that moves and is a mesh or hull, its centre of mass.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *mut BodyParams,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        let body = &scene.scene.world.bodies[scene.body(name)?];
        // SAFETY: as the caller says.
        unsafe { sized::write(params, || BodyParams::from(body)) }
    })
}

/// Says another thing of a body. `shape` may be NULL: it keeps its own. On an error it stays as it was.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_body(
    scene: *mut Scene,
    name: *const c_char,
    params: *const BodyParams,
    shape: *const Shape,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (scene, name) = unsafe { (at(scene)?, named(name, "name")?) };
        // SAFETY: as the caller says.
        let params = unsafe { sized::read(params) }?;
        let number = scene.body(name)?;
        let shape = if shape.is_null() {
            None
        } else {
            // SAFETY: as the caller says.
            Some(unsafe { Shape::at(shape) }?)
        };
        let before = scene.scene.world.bodies[number].clone();
        let after = match shape {
            // Its shape is about its centre of mass already.
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

/// Takes a body out, with its joints and with the laws that name it. The bodies behind it go down by one place.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_body(
    scene: *mut Scene,
    name: *const c_char,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
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

/// Number of bodies of the scene; 0 where `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_body_count(scene: *mut Scene) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.bodies.len())
}

/// Number of devices of the scene; 0 where `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_device_count(scene: *mut Scene) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.tools.len())
}

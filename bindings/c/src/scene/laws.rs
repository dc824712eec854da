//! Contact laws and joints.

use core::ffi::c_char;
use std::borrow::ToOwned;
use std::format;

use palpate_world::{Contact, Party, WorldPart};

use super::{JointParams, Law, Scene, at, named, wrong};
use crate::edge::status;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;

/// Reads one side of a law: a name, or "*" for every tool and body.
///
/// # Safety
/// `name` is NULL or points to a text that is terminated by a 0.
unsafe fn party<'a>(name: *const c_char, what: &'static str) -> Result<Party, Refusal<'a>> {
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text::read(name, what) }?;
    Ok(if name == "*" {
        Party::Any
    } else {
        Party::Named(name.to_owned())
    })
}

/// Whether a law is for this unordered pair.
fn is_between(contact: &Contact, [one, other]: &[Party; 2]) -> bool {
    let [a, b] = &contact.between;
    (a == one && b == other) || (a == other && b == one)
}

/// Sets the contact law of a pair and replaces a previous one. `one` and `other` are names of devices or bodies, or
/// "*" for any. The most specific law applies: two names, then a name and "*", then "*" twice. Pairs without a law
/// do not collide.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
    law: *const Law,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { at(scene) }?;
        // SAFETY: guaranteed by the caller.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        // SAFETY: guaranteed by the caller.
        let law = unsafe { sized::read(law) }?.checked()?;
        let contacts = &scene.scene.world.contacts;
        let before = contacts.clone();
        let contacts = &mut scene.scene.world.contacts;
        contacts.retain(|contact| !is_between(contact, &between));
        let number = contacts.len();
        contacts.push(Contact { between, law });
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Contact(number)) {
            scene.scene.world.contacts = before;
            return Err(refusal);
        }
        scene.edit();
        Ok(())
    })
}

/// Writes the law of exactly this pair of names or "*" to `*law`.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
    law: *mut Law,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { at(scene) }?;
        // SAFETY: guaranteed by the caller.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        let contact = scene.law(&between)?;
        // SAFETY: guaranteed by the caller.
        unsafe { sized::write(law, || Law::from(&scene.scene.world.contacts[contact])) }
    })
}

/// Removes the law of exactly this pair of names or "*".
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { at(scene) }?;
        // SAFETY: guaranteed by the caller.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        scene.law(&between)?;
        let contacts = &mut scene.edit().world.contacts;
        contacts.retain(|contact| !is_between(contact, &between));
        Ok(())
    })
}

/// Adds a joint between a body and another one, or the world if `against` is NULL. The order of the calls determines
/// its index, unless an earlier joint is removed.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_joint(
    scene: *mut Scene,
    body: *const c_char,
    against: *const c_char,
    params: *const JointParams,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (scene, body) = unsafe { (at(scene)?, named(body, "body")?) };
        let against = if against.is_null() {
            None
        } else {
            // SAFETY: guaranteed by the caller.
            Some(unsafe { named(against, "against") }?)
        };
        // SAFETY: guaranteed by the caller.
        let joint = unsafe { sized::read(params) }?.joint(body, against)?;
        let number = scene.scene.world.joints.len();
        scene.scene.world.joints.push(joint);
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Joint(number)) {
            scene.scene.world.joints.truncate(number);
            return Err(refusal);
        }
        scene.edit();
        Ok(())
    })
}

/// Replaces the parameters of a joint; its bodies stay the same. On an error nothing changes.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_joint(
    scene: *mut Scene,
    joint: usize,
    params: *const JointParams,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { at(scene) }?;
        // SAFETY: guaranteed by the caller.
        let params = unsafe { sized::read(params) }?;
        let before = scene.joint(joint)?.clone();
        let after = params.joint(&before.body, before.against.as_deref())?;
        scene.scene.world.joints[joint] = after;
        if let Err(refusal) = scene.check(|fault| fault.part == WorldPart::Joint(joint)) {
            scene.scene.world.joints[joint] = before;
            return Err(refusal);
        }
        scene.edit();
        Ok(())
    })
}

/// Removes a joint. The indices of later joints decrease by one.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_joint(scene: *mut Scene, joint: usize) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { at(scene) }?;
        scene.joint(joint)?;
        scene.edit().world.joints.remove(joint);
        Ok(())
    })
}

/// Returns the number of joints of the scene; 0 if `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_joint_count(scene: *mut Scene) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.joints.len())
}

impl Scene {
    /// Returns the index of the law for exactly this pair.
    fn law(&self, between: &[Party; 2]) -> Result<usize, Refusal<'static>> {
        let contacts = &self.scene.world.contacts;
        let place = contacts.iter().rposition(|law| is_between(law, between));
        place.ok_or_else(|| {
            let [one, other] = between.each_ref().map(Party::as_str);
            wrong(format!("there is no law between {one:?} and {other:?}"))
        })
    }

    fn joint(&self, joint: usize) -> Result<&palpate_world::Joint, Refusal<'static>> {
        let joints = &self.scene.world.joints;
        joints.get(joint).ok_or(Refusal::Index {
            name: "joint",
            given: joint,
            count: joints.len(),
        })
    }
}

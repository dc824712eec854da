//! Laws of contacts, and joints.

use core::ffi::c_char;
use std::borrow::ToOwned;
use std::format;

use palpate_world::{Contact, Party, WorldPart};

use super::{JointParams, Law, Scene, at, named, wrong};
use crate::edge::status;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;

/// One side of a law: a name, or "*" for every tool and body.
///
/// # Safety
/// `name` is NULL, or a 0 ends what it points to.
unsafe fn party<'a>(name: *const c_char, what: &'static str) -> Result<Party, Refusal<'a>> {
    // SAFETY: as the caller says.
    let name = unsafe { text::read(name, what) }?;
    Ok(if name == "*" {
        Party::Any
    } else {
        Party::Named(name.to_owned())
    })
}

/// Whether a law is between these two, in any order.
fn is_between(contact: &Contact, [one, other]: &[Party; 2]) -> bool {
    let [a, b] = &contact.between;
    (a == one && b == other) || (a == other && b == one)
}

/// Lets two touch by a law, in place of the one that they had: devices and bodies by their names, or "*" for all. A law between
/// two names goes before one between a name and "*", which goes before one between "*" and "*". A pair without a law does not
/// touch.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
    law: *const Law,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let scene = unsafe { at(scene) }?;
        // SAFETY: as the caller says.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        // SAFETY: as the caller says.
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

/// Puts the law between two into `*law`: the one of just these names, or of "*".
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
    law: *mut Law,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let scene = unsafe { at(scene) }?;
        // SAFETY: as the caller says.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        let contact = scene.law(&between)?;
        // SAFETY: as the caller says.
        unsafe { sized::write(law, || Law::from(&scene.scene.world.contacts[contact])) }
    })
}

/// Takes a law out: the one between just these names, or of "*".
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_law(
    scene: *mut Scene,
    one: *const c_char,
    other: *const c_char,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let scene = unsafe { at(scene) }?;
        // SAFETY: as the caller says.
        let between = unsafe { [party(one, "one")?, party(other, "other")?] };
        scene.law(&between)?;
        let contacts = &mut scene.edit().world.contacts;
        contacts.retain(|contact| !is_between(contact, &between));
        Ok(())
    })
}

/// Adds a joint of a body with another one, or with the world where `against` is NULL. Its place is that of the call, as long
/// as none before it is removed.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_add_joint(
    scene: *mut Scene,
    body: *const c_char,
    against: *const c_char,
    params: *const JointParams,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (scene, body) = unsafe { (at(scene)?, named(body, "body")?) };
        let against = if against.is_null() {
            None
        } else {
            // SAFETY: as the caller says.
            Some(unsafe { named(against, "against") }?)
        };
        // SAFETY: as the caller says.
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

/// Says another thing of a joint between the same two. On an error it stays as it was.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_set_joint(
    scene: *mut Scene,
    joint: usize,
    params: *const JointParams,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let scene = unsafe { at(scene) }?;
        // SAFETY: as the caller says.
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

/// Takes a joint out. The joints behind it go down by one place.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_remove_joint(scene: *mut Scene, joint: usize) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let scene = unsafe { at(scene) }?;
        scene.joint(joint)?;
        scene.edit().world.joints.remove(joint);
        Ok(())
    })
}

/// Number of joints of the scene; 0 where `scene` is NULL.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_joint_count(scene: *mut Scene) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(scene) }.map_or(0, |scene| scene.scene.world.joints.len())
}

impl Scene {
    /// The place of the law between just these.
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

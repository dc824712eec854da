//! Contacts of a world, and tool poses of its devices.

use palpate_world::{Mode, Side};

use super::{Pose, World, at};
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Contact state of two surfaces at a point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// No contact.
    Free = 0,
    /// In contact and sticking, or without friction.
    Sticks = 1,
    /// In contact and sliding.
    Slides = 2,
    /// Overlapping without force: the surfaces separate faster than the material recovers.
    Parts = 3,
}

/// A potential contact point at the last sample. palpate_contact_state_empty() returns an empty one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ContactState {
    /// Size of this struct; palpate_contact_state_empty() sets it.
    pub struct_size: usize,
    /// Index of the first device; PALPATE_NO_DEVICE if the first object is a body.
    pub first_device: u32,
    /// Index of the first body; PALPATE_NO_BODY if the first object is a device.
    pub first_body: u32,
    /// Index of the second device; PALPATE_NO_DEVICE if the second object is a body.
    pub second_device: u32,
    /// Index of the second body; PALPATE_NO_BODY if the second object is a device.
    pub second_body: u32,
    /// Contact state.
    pub touch: Touch,
    /// Unused; 0.
    pub reserved: u32,
    /// Point of application of the force [m].
    pub point: [f64; 3],
    /// Unit normal from the second to the first object.
    pub normal: [f64; 3],
    /// Force on the first object [N].
    pub force: [f64; 3],
    /// Penetration; 0 without overlap [m].
    pub penetration: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for ContactState {
    const NAME: &'static str = "palpate_contact_state";
}

/// Value of `first_body` and `second_body` if the object is a device.
pub const PALPATE_NO_BODY: u32 = u32::MAX;

/// Tool of a device at the last sample. palpate_device_state_empty() returns an empty one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct DeviceState {
    /// Size of this struct; palpate_device_state_empty() sets it.
    pub struct_size: usize,
    /// Device pose as estimated by the method.
    pub pose: Pose,
    /// Proxy pose, with which the world collides. Draw the tool here.
    pub proxy: Pose,
    /// Velocity of the device [m/s].
    pub velocity: [f64; 3],
    /// Velocity of the proxy [m/s].
    pub proxy_velocity: [f64; 3],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for DeviceState {
    const NAME: &'static str = "palpate_device_state";
}

/// Returns the number of potential contact points of the world, active or not; 0 if `world` is NULL.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_contact_count(world: *const World) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { at(world) }.map_or(0, |world| world.bounded.state().contacts().len())
}

/// Writes the state of a contact point to `*state`. `contact` is its 0-based index; a change of the world changes
/// the indices.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_contact_state(
    world: *const World,
    contact: usize,
    state: *mut ContactState,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let contacts = unsafe { at(world) }?.bounded.state().contacts();
        let is = contacts.get(contact).ok_or(Refusal::Index {
            name: "contact",
            given: contact,
            count: contacts.len(),
        })?;
        let place = |place: usize| u32::try_from(place).unwrap_or(u32::MAX);
        let sides = is.between.map(|side| match side {
            Side::Tool(device) => (place(device), PALPATE_NO_BODY),
            Side::Body(body) => (super::PALPATE_NO_DEVICE, place(body)),
        });
        let [(first_device, first_body), (second_device, second_body)] = sides;
        let value = ContactState {
            struct_size: size_of::<ContactState>(),
            first_device,
            first_body,
            second_device,
            second_body,
            touch: match is.mode {
                Mode::Free => Touch::Free,
                Mode::Sticks => Touch::Sticks,
                Mode::Slides => Touch::Slides,
                Mode::Parts => Touch::Parts,
            },
            reserved: 0,
            point: is.point,
            normal: is.normal,
            force: is.force,
            penetration: is.penetration,
        };
        // SAFETY: guaranteed by the caller.
        unsafe { sized::write(state, || value) }
    })
}

/// Writes the tool state of a device to `*state`. `device` is its index in the scene.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_device_state(
    world: *const World,
    device: usize,
    state: *mut DeviceState,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let tools = unsafe { at(world) }?.bounded.state().tools();
        let tool = tools.get(device).ok_or(Refusal::Index {
            name: "device",
            given: device,
            count: tools.len(),
        })?;
        let value = DeviceState {
            struct_size: size_of::<DeviceState>(),
            pose: Pose {
                position: tool.position,
                orientation: tool.orientation,
            },
            proxy: Pose {
                position: tool.proxy_position,
                orientation: tool.proxy_orientation,
            },
            velocity: tool.velocity,
            proxy_velocity: tool.proxy_velocity,
        };
        // SAFETY: guaranteed by the caller.
        unsafe { sized::write(state, || value) }
    })
}

//! What touches in a world, and where the tools of its devices are.

use palpate_world::{Mode, Side};

use super::{Pose, World, at};
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Whether two surfaces touch at a point, and how.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// Apart.
    Free = 0,
    /// They touch, and friction holds, or there is none.
    Sticks = 1,
    /// They touch, and slide.
    Slides = 2,
    /// They overlap but do not push: they part faster than the material follows.
    Parts = 3,
}

/// A point at which two can touch, at the last sample. palpate_contact_state_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ContactState {
    /// Size of this struct; palpate_contact_state_empty() sets it.
    pub struct_size: usize,
    /// Place of the device of the first of the two; PALPATE_NO_DEVICE where it is a body.
    pub first_device: u32,
    /// Place of the body of the first; PALPATE_NO_BODY where it is a device.
    pub first_body: u32,
    /// The same of the second.
    pub second_device: u32,
    /// The same of the second.
    pub second_body: u32,
    /// Whether they touch, and how.
    pub touch: Touch,
    /// 0.
    pub reserved: u32,
    /// Where the force acts [m].
    pub point: [f64; 3],
    /// Unit vector from the second to the first.
    pub normal: [f64; 3],
    /// Force on the first [N].
    pub force: [f64; 3],
    /// How far they overlap, 0 where they do not [m].
    pub penetration: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for ContactState {
    const NAME: &'static str = "palpate_contact_state";
}

/// `first_body` and `second_body` where that is a device.
pub const PALPATE_NO_BODY: u32 = u32::MAX;

/// The tool of a device at the last sample. palpate_device_state_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct DeviceState {
    /// Size of this struct; palpate_device_state_empty() sets it.
    pub struct_size: usize,
    /// Where the device is, by what the method knows.
    pub pose: Pose,
    /// What the world meets in its place: draw the tool here.
    pub avatar: Pose,
    /// Velocity of the device [m/s].
    pub velocity: [f64; 3],
    /// Velocity of its avatar [m/s].
    pub avatar_velocity: [f64; 3],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for DeviceState {
    const NAME: &'static str = "palpate_device_state";
}

/// Number of points at which two of the world can touch, whether they do or not; 0 where `world` is NULL.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_contact_count(world: *const World) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(world) }.map_or(0, |world| world.bounded.state().contacts().len())
}

/// Puts what a point of contact does into `*state`. `contact` is its place, from 0; a world that is changed has other ones.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_contact_state(
    world: *const World,
    contact: usize,
    state: *mut ContactState,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
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
        // SAFETY: as the caller says.
        unsafe { sized::write(state, || value) }
    })
}

/// Puts where the tool of a device is into `*state`. `device` is its place in the scene.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_device_state(
    world: *const World,
    device: usize,
    state: *mut DeviceState,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
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
            avatar: Pose {
                position: tool.avatar_position,
                orientation: tool.avatar_orientation,
            },
            velocity: tool.velocity,
            avatar_velocity: tool.avatar_velocity,
        };
        // SAFETY: as the caller says.
        unsafe { sized::write(state, || value) }
    })
}

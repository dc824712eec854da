//! What can be read of a world between two ticks.

use core::ffi::{CStr, c_char};
use core::ptr;

use super::{Pose, World, at};
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// A body at the last sample. palpate_body_state_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BodyState {
    /// Size of this struct; palpate_body_state_empty() sets it.
    pub struct_size: usize,
    /// Where its centre of mass is, and how it is turned.
    pub pose: Pose,
    /// Velocity of its centre of mass [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity along the world's axes [rad/s].
    pub angular_velocity: [f64; 3],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for BodyState {
    const NAME: &'static str = "palpate_body_state";
}

/// Sums of a world's books up to the last sample. palpate_world_ledger_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldLedger {
    /// Size of this struct; palpate_world_ledger_empty() sets it.
    pub struct_size: usize,
    /// Kinetic energy of the bodies [J].
    pub kinetic: f64,
    /// Potential energy of the bodies' constant forces, 0 at the start [J].
    pub potential: f64,
    /// Elastic energy of contacts and joints [J].
    pub stored: f64,
    /// What damping and friction have taken [J]: never falls.
    pub dissipated: f64,
    /// Work of the devices' forces on the hands [J].
    pub port_work: f64,
    /// Energy that held forces have created [J]: what hands, bodies, contacts and dissipation have gained together, and
    /// nobody has put in.
    pub created: f64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for WorldLedger {
    const NAME: &'static str = "palpate_world_ledger";
}

/// Number of devices; 0 where `world` is NULL.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_device_count(world: *const World) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(world) }.map_or(0, |world| world.devices.len())
}

/// Name of a device by its place in the scene, in UTF-8; NULL where there is none. It lives as long as the world.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_device_name(
    world: *const World,
    device: usize,
) -> *const c_char {
    // SAFETY: as the caller says.
    let world = unsafe { at(world) }.ok();
    let device = world.and_then(|world| world.devices.get(device));
    device.map_or(ptr::null(), |device| device.name.as_ptr())
}

/// 1 for a device of six axes, 2 for one that measures six axes and gives no torque, 0 for one of three axes or of another place
/// than there are.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_device_turns(world: *const World, device: usize) -> u32 {
    // SAFETY: as the caller says.
    let world = unsafe { at(world) }.ok();
    let device = world.and_then(|world| world.devices.get(device));
    device.map_or(0, |device| match (device.turns, device.gives_torque) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => 2,
    })
}

/// Number of bodies, fixed ones too; 0 where `world` is NULL.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_body_count(world: *const World) -> usize {
    // SAFETY: as the caller says.
    unsafe { at(world) }.map_or(0, |world| world.bodies.len())
}

/// Name of a body by its place in the scene, in UTF-8; NULL where there is none. It lives until the world is changed or freed.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_body_name(
    world: *const World,
    body: usize,
) -> *const c_char {
    // SAFETY: as the caller says.
    let world = unsafe { at(world) }.ok();
    let name = world.and_then(|world| world.bodies.get(body));
    name.map_or(ptr::null(), |name| CStr::as_ptr(name))
}

/// Nominal time from sample to sample [s]; 0 where `world` is NULL.
///
/// # Safety
/// `world` is NULL or a world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_period(world: *const World) -> f64 {
    // SAFETY: as the caller says.
    unsafe { at(world) }.map_or(0.0, |world| world.bounded.renderer().in_loop().period)
}

/// Puts where a body is and how it moves into `*state`. `body` is its place in the scene.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_body_state(
    world: *const World,
    body: usize,
    state: *mut BodyState,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let bodies = unsafe { at(world) }?.bounded.state().bodies();
        let body = bodies.get(body).ok_or(Refusal::Index {
            name: "body",
            given: body,
            count: bodies.len(),
        })?;
        let value = BodyState {
            struct_size: size_of::<BodyState>(),
            pose: Pose {
                position: body.position,
                orientation: body.orientation,
            },
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
        };
        // SAFETY: as the caller says.
        unsafe { sized::write(state, || value) }
    })
}

/// Puts the sums of the books up to the last sample into `*ledger`.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_ledger_of(
    world: *const World,
    ledger: *mut WorldLedger,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let books = unsafe { at(world) }?.bounded.state().books();
        let (mut sums, contacts) = (WorldLedger::none(), &books.contacts);
        for body in books.bodies.iter().chain([&books.gone.bodies]) {
            sums.kinetic += body.kinetic;
            sums.potential += body.potential;
        }
        for contact in contacts.iter().chain([&books.gone.contacts]) {
            sums.stored += contact.stored;
            sums.dissipated += contact.dissipated;
        }
        for joint in books.joints.iter().chain([&books.gone.joints]) {
            sums.stored += joint.stored;
            sums.dissipated += joint.dissipated;
        }
        sums.port_work = books.devices.iter().map(|device| device.port_work).sum();
        sums.created = books.created();
        // SAFETY: as the caller says.
        unsafe { sized::write(ledger, || sums) }
    })
}

impl WorldLedger {
    fn none() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            kinetic: 0.0,
            potential: 0.0,
            stored: 0.0,
            dissipated: 0.0,
            port_work: 0.0,
            created: 0.0,
        }
    }
}

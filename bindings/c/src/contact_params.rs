//! Parameters of a contact and of its rendering method in the C API.

use core::ffi::c_char;
use core::ptr;

use palpate_core::{
    Basis, Contact, Mass, MethodName, ObjectState, Rendering, Scalar, Side as CoreSide,
};

use crate::choice;
use crate::edge::status;
use crate::loop_params::LoopParams;
use crate::methods;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// Side of the device on which the object lies.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In the direction of increasing device position: penetration = device - object.
    Positive = 0,
    /// In the direction of decreasing device position: penetration = object - device.
    Negative = 1,
}

/// A method setting, by its key in files: {"damping_n_s_per_m", 0.5, NULL}, or {"placement", 0, "false"}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Key, such as "damping_n_s_per_m"; palpate_setting_text lists the keys of each method.
    pub key: *const c_char,
    /// Value in the unit of the key; used if `word` is NULL.
    pub number: f64,
    /// Value as a word: a word of this setting, "auto", or "true" and "false" for a switch. NULL: `number` is used.
    pub word: *const c_char,
}

/// One contact between the device's end-point and a virtual object along one axis, and the method that
/// renders it. palpate_contact_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ContactParams {
    /// Size of this struct; palpate_contact_params_default() sets it.
    pub struct_size: usize,
    /// Contact stiffness K [N/m], greater than 0. It has no default.
    pub stiffness: f64,
    /// Mass M of the object [kg], greater than 0. INFINITY, the default: a wall.
    pub object_mass: f64,
    /// Initial position of the object's surface, or the fixed position of a wall [m]. Default: 0.
    pub object_position: f64,
    /// Initial velocity of the object [m/s]; 0 for a wall. Default: 0.
    pub object_velocity: f64,
    /// Virtual force f_V on the object, for instance its weight, positive along the axis [N]. The virtual force
    /// of a sample is added. Default: 0.
    pub virtual_force: f64,
    /// Name of the method; palpate_method_text lists all names. NULL, the default: coupled rendering.
    pub method: *const c_char,
    /// Settings of the method; a missing setting has its default. NULL if there are none.
    pub settings: *const Setting,
    /// Number of settings.
    pub setting_count: usize,
    /// A palpate_side. Default: PALPATE_SIDE_POSITIVE.
    pub side: u32,
    /// 1: the contact may only push. Default: 0, as in the paper, whose methods may pull for a part of an
    /// interval.
    pub unilateral: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for ContactParams {
    const NAME: &'static str = "palpate_contact_params";
}

impl Default for ContactParams {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            stiffness: 0.0,
            object_mass: f64::INFINITY,
            object_position: 0.0,
            object_velocity: 0.0,
            virtual_force: 0.0,
            method: ptr::null(),
            settings: ptr::null(),
            setting_count: 0,
            side: Side::Positive as u32,
            unilateral: 0,
        }
    }
}

impl ContactParams {
    /// Returns the rendering for a loop. The core checks the numbers when it creates a renderer.
    ///
    /// # Safety
    /// The texts and the settings satisfy their documentation.
    unsafe fn rendering<'a, S: Scalar>(
        &self,
        of_loop: &LoopParams,
    ) -> Result<Rendering<S>, Refusal<'a>> {
        let period = of_loop.period;
        let of_loop = of_loop.checked::<S>()?;
        let method = if self.method.is_null() {
            MethodName::default()
        } else {
            // SAFETY: guaranteed by the caller.
            let name = unsafe { text::read(self.method, "method") }?;
            MethodName::named(name).ok_or(Refusal::UnknownMethod(name))?
        };
        // SAFETY: guaranteed by the caller.
        let settings = unsafe { methods::settings(method, self.settings, self.setting_count) }?;
        let side = match self.side {
            0 => CoreSide::Positive,
            1 => CoreSide::Negative,
            given => {
                return Err(Refusal::Choice {
                    name: "side",
                    given,
                    allowed: "PALPATE_SIDE_POSITIVE or PALPATE_SIDE_NEGATIVE",
                });
            }
        };
        let unilateral = choice::switch("unilateral", self.unilateral)?;
        let virtual_force = S::from_f64(self.virtual_force);
        if !virtual_force.is_finite() {
            return Err(methods::not_finite_virtual_force(self.virtual_force));
        }
        let contact = Contact {
            stiffness: S::from_f64(self.stiffness),
            // A finite mass that overflows to infinity when rounded to `S` does not become a wall.
            object_mass: if self.object_mass == f64::INFINITY {
                Mass::Infinite
            } else {
                Mass::Finite(S::from_f64(self.object_mass))
            },
            side,
            unilateral,
        };
        let moving = if self.object_mass.is_finite() {
            0.5 * self.object_mass * self.object_velocity * self.object_velocity
        } else {
            0.0
        };
        let basis = Basis {
            stiffness: self.stiffness,
            period,
            device_mass: of_loop.device_mass,
            encoder_quantum: of_loop.encoder_quantum,
            recorded: of_loop.recorded,
            // Until the first sample the object is assumed to be out of contact.
            stored_energy: moving,
        };
        // Report faults of the inputs first: an error in a derived setting would hide the wrong input.
        contact
            .faults()
            .chain(of_loop.params.faults())
            .next()
            .map_or(Ok(()), Err)?;
        Ok(Rendering {
            contact,
            loop_params: of_loop.params,
            params: method.params(&settings, &basis)?,
            virtual_force,
            object: ObjectState {
                position: S::from_f64(self.object_position),
                velocity: S::from_f64(self.object_velocity),
            },
        })
    }
}

/// Converts the two C structs to a rendering, rounded to the number type of a tick.
///
/// # Safety
/// Each pointer is NULL or points to a struct that satisfies its documentation; its first field is its size.
pub(crate) unsafe fn rendering<'a, S: Scalar>(
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Result<Rendering<S>, Refusal<'a>> {
    // SAFETY: guaranteed by the caller.
    let (contact, of_loop) = unsafe { (sized::read(params)?, sized::read(loop_params)?) };
    // SAFETY: guaranteed by the caller.
    unsafe { contact.rendering(&of_loop) }
}

/// Fills contact parameters with the defaults. `struct_size` is sizeof(palpate_contact_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_params_init(
    params: *mut ContactParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, ContactParams::default()) })
}

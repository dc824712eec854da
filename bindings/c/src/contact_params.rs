//! The contact and its method, as C says them.

use core::ffi::c_char;
use core::ptr;

use palpate::{Basis, Contact, Mass, MethodName, ObjectState, Rendering, Scalar, Side as CoreSide};

use crate::choice;
use crate::edge::status;
use crate::loop_params::LoopParams;
use crate::methods;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// On which side of the device the object lies.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In the direction of increasing device position: penetration = device - object.
    Positive = 0,
    /// In the direction of decreasing device position: penetration = object - device.
    Negative = 1,
}

/// A setting of a method, by its key in files: {"damping_n_s_per_m", 0.5, NULL}, or {"placement", 0,
/// "false"}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its key, such as "damping_n_s_per_m"; palpate_setting_text has those of each method.
    pub key: *const c_char,
    /// Its number, in the unit of the key, where `word` is NULL.
    pub number: f64,
    /// Its word: one of its own words, "auto", or "true" and "false" of a switch. NULL: the number.
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
    /// Where the object's surface is at the start, and a wall always [m]. Default: 0.
    pub object_position: f64,
    /// Its velocity at the start [m/s]; a wall has none. Default: 0.
    pub object_velocity: f64,
    /// Virtual force f_V on the object, for instance its weight, positive along the axis [N]; that of a
    /// sample adds to it. Default: 0.
    pub virtual_force: f64,
    /// Name of the method; palpate_method_text has them all. NULL, the default: coupled rendering.
    pub method: *const c_char,
    /// Settings of the method; what is not given has its default. NULL where there are none.
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
    /// What is to be rendered in a loop; the core checks the numbers when it makes a renderer.
    ///
    /// # Safety
    /// The texts and the settings are what their documentation says.
    unsafe fn rendering<'a, S: Scalar>(
        &self,
        of_loop: &LoopParams,
    ) -> Result<Rendering<S>, Refusal<'a>> {
        let period = of_loop.period;
        let of_loop = of_loop.checked::<S>()?;
        let method = if self.method.is_null() {
            MethodName::default()
        } else {
            // SAFETY: as the caller says.
            let name = unsafe { text::read(self.method, "method") }?;
            MethodName::named(name).ok_or(Refusal::UnknownMethod(name))?
        };
        // SAFETY: as the caller says.
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
            // A mass that is infinite only when it is rounded is no wall.
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
            // Until the first sample the object is taken as untouched.
            stored_energy: moving,
        };
        // What is derived from them has to say what is wrong with them, not with itself.
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

/// What is to be rendered, as two structs of C say it, rounded to the numbers of a tick.
///
/// # Safety
/// Both are NULL or what their documentation says, with the sizes that they begin with.
pub(crate) unsafe fn rendering<'a, S: Scalar>(
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Result<Rendering<S>, Refusal<'a>> {
    // SAFETY: as the caller says.
    let (contact, of_loop) = unsafe { (sized::read(params)?, sized::read(loop_params)?) };
    // SAFETY: as the caller says.
    unsafe { contact.rendering(&of_loop) }
}

/// Fills parameters of a contact with the defaults. `struct_size` is sizeof(palpate_contact_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_params_init(
    params: *mut ContactParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, ContactParams::default()) })
}

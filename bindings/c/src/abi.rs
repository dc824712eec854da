//! Sizes, alignments and field offsets of the structs on 64-bit machines. tests/c/abi.c asserts the same
//! values for the header.
#![cfg(target_pointer_width = "64")]

use core::mem::offset_of;

use crate::{ContactParams, Fault, Ledger, LoopParams, Output, Phase, Sample, Setting, Status};

const _: () = assert!(crate::PALPATE_ABI_VERSION == 1);
const _: () = assert!(size_of::<Status>() == 4);
const _: () = assert!(size_of::<Phase>() == 4);
const _: () = assert!(size_of::<Fault>() == 4);
const _: () = assert!(size_of::<Setting>() == 24);

macro_rules! has {
    ($Type:ty, $size:literal, $align:literal $(, $field:ident at $place:literal)*) => {
        const _: () = assert!(size_of::<$Type>() == $size);
        const _: () = assert!(align_of::<$Type>() == $align);
        const _: () = assert!(offset_of!($Type, struct_size) == 0);
        $(const _: () = assert!(offset_of!($Type, $field) == $place);)*
    };
}

has!(ContactParams, 80, 8, virtual_force at 40, setting_count at 64, unilateral at 76);
has!(LoopParams, 176, 8, force_limit at 32, delay at 48, device_mass at 96, guard at 160, hold at 164);
has!(Sample<f64>, 40, 8, has_elapsed at 32);
has!(Output<f64>, 88, 8, slope_on_device at 24, proxy_shift at 64, phase at 72, limited at 80);
has!(Ledger<f64>, 88, 8, held_leak at 40);
has!(Sample<f32>, 32, 8, has_elapsed at 20);
has!(Output<f32>, 56, 8, slope_on_device at 16, proxy_shift at 36, phase at 40, limited at 48);
has!(Ledger<f32>, 48, 8, held_leak at 24);

#[cfg(feature = "worlds")]
mod worlds {
    use core::mem::offset_of;

    use crate::{
        BodyParams, BodyProgress, BodyState, ContactState, DeviceParams, DeviceState, GuardParams,
        HostBody, HostContact, JointParams, Law, LocalOutput, LocalParams, ModelRefusal, Pose,
        Progress, SceneParams, Shape, Touch, WorldLedger, WorldOutput, WorldParams, WorldSample,
        Wrench,
    };

    const _: () = assert!(size_of::<Pose>() == 56);
    const _: () = assert!(size_of::<Wrench>() == 72);
    has!(WorldParams, 40, 8, force_limit at 16, soft_start at 32);
    has!(WorldSample, 40, 8, pose_count at 16, has_elapsed at 32);
    has!(WorldOutput, 40, 8, limited at 16, left_out at 36);
    has!(BodyState, 112, 8, velocity at 64, angular_velocity at 88);
    has!(WorldLedger, 56, 8, created at 48);
    has!(SceneParams, 96, 8, gain at 32, coupling_inertia at 80, hold at 88);
    has!(GuardParams, 96, 8, acceleration at 40, late_samples at 88, mode at 92);
    has!(DeviceParams, 96, 8, inertia at 56, turns at 88);
    has!(BodyParams, 168, 8, mass at 64, velocity at 96, force at 144);
    has!(Shape, 120, 8, radius at 16, normal at 56, points at 88, face_count at 112);
    has!(Law, 48, 8, friction_stiffness at 32, friction_damping at 40);
    has!(JointParams, 128, 8, kind at 8, point at 16, stiffness at 64, limits at 112);
    has!(ContactState, 112, 8, touch at 24, point at 32, penetration at 104);
    has!(DeviceState, 168, 8, proxy at 64, velocity at 120);
    has!(LocalParams, 136, 8, device_mass at 16, stale_after at 48, quantum at 80, force_limit at 112, bodies at 128);
    has!(LocalOutput, 48, 8, fault at 16, refusal at 28, too_fast at 44);
    has!(Progress, 96, 8, position at 24, model_tick at 72, refusal at 88);
    const _: () = assert!(size_of::<HostBody>() == 440 && offset_of!(HostBody, mobility) == 152);
    const _: () = assert!(size_of::<HostContact>() == 136 && offset_of!(HostContact, on) == 128);
    const _: () = assert!(size_of::<BodyProgress>() == 72 && offset_of!(BodyProgress, copy) == 48);
    const _: () = assert!(size_of::<ModelRefusal>() == 4);
    const _: () = assert!(size_of::<Touch>() == 4);
}

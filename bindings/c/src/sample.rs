//! What goes into a tick.

use palpate_core::Sample as Core;

use crate::sized::SizedStruct;

/// One sample of the device. palpate_sample_at() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Size of this struct; palpate_sample_at() sets it.
    pub struct_size: usize,
    /// Measured position of the device's end-point along the contact's axis [m].
    pub device_position: f64,
    /// Time since the sample before [s], where `has_elapsed` is not 0.
    pub elapsed: f64,
    /// Virtual force on the object over the coming interval [N], beside that of the contact.
    pub virtual_force: f64,
    /// 1: `elapsed` was measured. 0: one period.
    pub has_elapsed: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for Sample {
    const NAME: &'static str = "palpate_sample";
}

impl From<Sample> for Core<f64> {
    #[inline]
    fn from(sample: Sample) -> Self {
        Self {
            device_position: sample.device_position,
            elapsed: (sample.has_elapsed != 0).then_some(sample.elapsed),
            virtual_force: sample.virtual_force,
        }
    }
}

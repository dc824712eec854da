//! Input of a tick.

use palpate_core::Sample as Core;

use crate::choice;
use crate::number::Number;
use crate::sized::{self, SizedStruct};
use crate::status::Refusal;

/// One sample of the device. palpate_sample_at() fills it, palpate_sample_f32_at() one in float.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Sample<S> {
    /// Size of this struct.
    pub struct_size: usize,
    /// Measured position of the device's end-point along the contact's axis [m].
    pub device_position: S,
    /// Time since the previous sample [s]; used if `has_elapsed` is 1.
    pub elapsed: S,
    /// Virtual force on the object over the coming interval, in addition to that of the contact [N].
    pub virtual_force: S,
    /// 1: `elapsed` is the measured time. 0: one period has elapsed.
    pub has_elapsed: u32,
    /// Must be 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl<S: Number> SizedStruct for Sample<S> {
    const NAME: &'static str = S::SAMPLE;
}

impl<S: Number> Sample<S> {
    /// Reads the sample at `given`. The tick checks its numbers.
    ///
    /// # Safety
    /// `given` is NULL or points to a sample whose first field is its size.
    #[inline]
    pub(crate) unsafe fn at<'a>(given: *const Self) -> Result<Self, Refusal<'a>> {
        // SAFETY: guaranteed by the caller.
        let sample = unsafe { sized::read(given) }?;
        choice::switch("has_elapsed", sample.has_elapsed)?;
        choice::unused(sample.reserved)?;
        Ok(sample)
    }
}

impl<S: Number> From<Sample<S>> for Core<S> {
    #[inline]
    fn from(sample: Sample<S>) -> Self {
        Self {
            device_position: sample.device_position,
            elapsed: (sample.has_elapsed != 0).then_some(sample.elapsed),
            virtual_force: sample.virtual_force,
        }
    }
}

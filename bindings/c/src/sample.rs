//! What goes into a tick.

use palpate::Sample as Core;

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
    /// Time since the sample before [s], where `has_elapsed` is not 0.
    pub elapsed: S,
    /// Virtual force on the object over the coming interval [N], beside that of the contact.
    pub virtual_force: S,
    /// 1: `elapsed` was measured. 0: one period.
    pub has_elapsed: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl<S: Number> SizedStruct for Sample<S> {
    const NAME: &'static str = S::SAMPLE;
}

impl<S: Number> Sample<S> {
    /// The sample at `given`. What is wrong with its numbers says the tick.
    ///
    /// # Safety
    /// `given` is NULL or to a sample of the size that it begins with.
    #[inline]
    pub(crate) unsafe fn at<'a>(given: *const Self) -> Result<Self, Refusal<'a>> {
        // SAFETY: as the caller says.
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

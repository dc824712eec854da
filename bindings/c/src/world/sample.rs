//! What goes into a tick of a world.

use crate::array::array;
use crate::choice;
use crate::sized::{self, SizedStruct};
use crate::status::Refusal;

/// Where a device is. It stands in arrays, so it has no struct_size and stays as it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Measured position of its tool along the world's axes [m].
    pub position: [f64; 3],
    /// Measured orientation, for a device of six axes: a unit quaternion w, x, y, z that turns the tool's axes into those
    /// of the world. Not looked at for a device of three axes.
    pub orientation: [f64; 4],
}

/// What a device is to give to the hand, and to hold until the next sample. It stands in arrays, so it has no struct_size
/// and stays as it is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Wrench {
    /// Force along the world's axes [N].
    pub force: [f64; 3],
    /// Torque about the tool's centre of mass along the world's axes [N m]; 0 for a device of three axes.
    pub torque: [f64; 3],
}

/// One sample of all devices of a world. palpate_world_sample_at() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldSample {
    /// Size of this struct; palpate_world_sample_at() sets it.
    pub struct_size: usize,
    /// The devices, in the order of the scene.
    pub poses: *const Pose,
    /// Number of poses: palpate_world_device_count().
    pub pose_count: usize,
    /// Time since the sample before [s], where `has_elapsed` is not 0.
    pub elapsed: f64,
    /// 1: `elapsed` was measured. 0: one period.
    pub has_elapsed: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for WorldSample {
    const NAME: &'static str = "palpate_world_sample";
}

impl WorldSample {
    /// The sample at `given`, and its poses: one for each of so many devices. What is wrong with their numbers says the tick.
    ///
    /// # Safety
    /// `given` is NULL or to a sample of the size that it begins with, with as many poses as it says.
    pub(crate) unsafe fn at<'a>(
        given: *const Self,
        devices: usize,
    ) -> Result<(Self, &'a [Pose]), Refusal<'static>> {
        // SAFETY: as the caller says.
        let sample = unsafe { sized::read(given) }?;
        choice::switch("has_elapsed", sample.has_elapsed)?;
        choice::unused(sample.reserved)?;
        if sample.pose_count != devices {
            return Err(Refusal::Count {
                name: "pose_count",
                given: sample.pose_count,
                needed: devices,
                of: ("the world", "devices"),
            });
        }
        // SAFETY: as the caller says.
        let poses = unsafe { array(sample.poses, devices, "poses") }?;
        Ok((sample, poses))
    }
}

impl Wrench {
    /// Refuses what is no number.
    pub(crate) fn reported(&self) -> Result<(), Refusal<'static>> {
        let of = |name, numbers: [f64; 3], allowed| {
            let wrong = numbers.into_iter().find(|number| !number.is_finite());
            wrong.map_or(Ok(()), |given| {
                Err(Refusal::Number {
                    name,
                    given,
                    allowed,
                })
            })
        };
        of("force", self.force, "finite [N]")?;
        of("torque", self.torque, "finite [N m]")
    }
}

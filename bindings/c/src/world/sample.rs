//! Input of a world tick.

use crate::array::array;
use crate::choice;
use crate::sized::{self, SizedStruct};
use crate::status::Refusal;

/// Pose of a device. The struct is an array element, so it has no struct_size and its layout is fixed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Measured position of the tool in world axes [m].
    pub position: [f64; 3],
    /// Measured orientation of a device of six axes: the unit quaternion w, x, y, z that rotates the tool's axes to the
    /// world's. Ignored for a device of three axes.
    pub orientation: [f64; 4],
}

/// Wrench of a device on the hand, to be held until the next sample. The struct is an array element, so it has no
/// struct_size and its layout is fixed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Wrench {
    /// Force in world axes [N].
    pub force: [f64; 3],
    /// Torque about the tool's centre of mass in world axes [N m]; 0 for a device of three axes.
    pub torque: [f64; 3],
    /// Slope of the force [N/s]: with PALPATE_HOLD_LINE the force is `force + slope (t - T/2)` for t from 0 to the
    /// period T, then its last value. Otherwise 0.
    pub slope: [f64; 3],
}

/// One sample of all devices of a world. palpate_world_sample_at() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorldSample {
    /// Size of this struct; palpate_world_sample_at() sets it.
    pub struct_size: usize,
    /// Poses of the devices in the order of the scene.
    pub poses: *const Pose,
    /// Number of poses: palpate_world_device_count().
    pub pose_count: usize,
    /// Time since the previous sample [s]; used if `has_elapsed` is 1.
    pub elapsed: f64,
    /// 1: `elapsed` is the measured time. 0: one period has elapsed.
    pub has_elapsed: u32,
    /// Must be 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for WorldSample {
    const NAME: &'static str = "palpate_world_sample";
}

impl WorldSample {
    /// Reads the sample at `given` and its poses, one for each of `devices`. The tick checks their numbers.
    ///
    /// # Safety
    /// `given` is NULL or points to a sample whose first field is its size, with the stated number of poses.
    pub(crate) unsafe fn at<'a>(
        given: *const Self,
        devices: usize,
    ) -> Result<(Self, &'a [Pose]), Refusal<'static>> {
        // SAFETY: guaranteed by the caller.
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
        // SAFETY: guaranteed by the caller.
        let poses = unsafe { array(sample.poses, devices, "poses") }?;
        Ok((sample, poses))
    }
}

impl Wrench {
    /// Rejects a non-finite wrench.
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
        of("torque", self.torque, "finite [N m]")?;
        of("slope", self.slope, "finite [N/s]")
    }
}

//! Along which axes a device moves its tool.

use crate::rigid::Vector3;
use crate::{Tool, Vector};

/// Along which of the world's axes a device moves its tool and can push it. Along the others its mechanism holds the tool: it
/// carries every force there, and the tool is where the device is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axes([bool; 3]);

impl Axes {
    pub fn of(tool: &Tool) -> Self {
        Self(tool.axes)
    }

    /// Whether the device has all three.
    pub fn are_all(self) -> bool {
        self.0 == [true; 3]
    }

    /// The part of a vector along the axes that the device has.
    pub fn along(self, vector: &Vector3) -> Vector3 {
        Vector3::from_fn(|axis, _| if self.0[axis] { vector[axis] } else { 0.0 })
    }

    /// The part along those that it lacks.
    pub fn across(self, vector: &Vector3) -> Vector3 {
        Vector3::from_fn(|axis, _| if self.0[axis] { 0.0 } else { vector[axis] })
    }

    /// `own` along the axes that the device has, `other` along those that it lacks.
    pub fn mixed(self, own: &Vector3, other: &Vector3) -> Vector3 {
        Vector3::from_fn(|axis, _| if self.0[axis] { own[axis] } else { other[axis] })
    }

    /// Leaves of a force what the device can give.
    pub fn keep(self, force: &mut Vector) {
        for (force, has) in force.iter_mut().zip(self.0) {
            if !has {
                *force = 0.0;
            }
        }
    }
}

//! Along which axes a device moves its tool.

use crate::rigid::{Matrix3, Vector3};
use crate::{Tool, Vector};

/// The axes of a device, and along which of them it moves its tool and can push it. Along the others its mechanism holds the tool: it
/// carries every force there, and the tool is where the device is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    has: [bool; 3],
    /// Its columns are the device's axes; `None` for those of the world.
    own: OwnAxes,
}

/// Axes that are not those of the world: the columns of a rotation. `None`: those of the world.
pub(crate) type OwnAxes = Option<Matrix3>;

/// A vector of the world along such axes.
pub(crate) fn own(axes: &OwnAxes, vector: &Vector3) -> Vector3 {
    axes.as_ref().map_or(*vector, |axes| axes.tr_mul(vector))
}

/// A vector along such axes in the world.
pub(crate) fn out(axes: &OwnAxes, own: &Vector3) -> Vector3 {
    axes.as_ref().map_or(*own, |axes| axes * own)
}

/// A vector of the world whose parts along such axes are multiplied by one factor each.
pub(crate) fn scaled(axes: &OwnAxes, factors: &Vector3, vector: &Vector3) -> Vector3 {
    match axes {
        None => factors.component_mul(vector),
        Some(axes) => axes * factors.component_mul(&axes.tr_mul(vector)),
    }
}

impl Axes {
    pub fn of(tool: &Tool) -> Self {
        let own = tool.own_axes.map(|axes| {
            let columns = axes.map(Vector3::from);
            Matrix3::from_columns(&columns)
        });
        Self {
            has: tool.axes,
            own,
        }
    }

    /// The device's axes, of which it may lack some.
    pub fn own_axes(&self) -> OwnAxes {
        self.own
    }

    /// Whether the device has all three.
    pub fn are_all(&self) -> bool {
        self.has == [true; 3]
    }

    /// A vector of the world along the device's axes.
    pub fn own(&self, vector: &Vector3) -> Vector3 {
        own(&self.own, vector)
    }

    /// A vector along the device's axes in the world.
    pub fn out(&self, own: &Vector3) -> Vector3 {
        out(&self.own, own)
    }

    /// Standard deviations along the device's axes of what has these along the world's, each for itself.
    pub fn own_deviations(&self, deviations: &Vector3) -> Vector3 {
        self.own.map_or(*deviations, |axes| {
            let squares = axes
                .component_mul(&axes)
                .tr_mul(&deviations.component_mul(deviations));
            squares.map(|square| square.max(0.0).sqrt())
        })
    }

    /// This number along the axes that the device has, 0 along the others: a vector along the device's axes.
    pub fn where_there(&self, number: f64) -> Vector3 {
        Vector3::from(self.has.map(|has| if has { number } else { 0.0 }))
    }

    /// The part of a vector along the axes that the device has.
    pub fn along(&self, vector: &Vector3) -> Vector3 {
        self.mixed(vector, &Vector3::zeros())
    }

    /// The part along those that it lacks.
    pub fn across(&self, vector: &Vector3) -> Vector3 {
        self.mixed(&Vector3::zeros(), vector)
    }

    /// `own` along the axes that the device has, `other` along those that it lacks.
    pub fn mixed(&self, own: &Vector3, other: &Vector3) -> Vector3 {
        if self.are_all() {
            return *own;
        }
        let (one, other) = (self.own(own), self.own(other));
        let mixed = Vector3::from_fn(|axis, _| {
            if self.has[axis] {
                one[axis]
            } else {
                other[axis]
            }
        });
        self.out(&mixed)
    }

    /// Leaves of a force what the device can give.
    pub fn keep(&self, force: &mut Vector) {
        *force = self.along(&Vector3::from(*force)).into();
    }
}

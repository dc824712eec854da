//! Axes along which a device moves its tool.

use crate::Vector;
use crate::geometry::rigid::{Matrix3, Vector3};

/// The axes of a device, and those along which it can move and push its tool. Along the other axes its mechanism
/// constrains the tool to the measured position and carries every force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    has: [bool; 3],
    /// The device's axes as columns; `None` for those of the world.
    own: OwnAxes,
}

/// Axes other than those of the world, as the columns of a rotation matrix; `None` for those of the world.
pub(crate) type OwnAxes = Option<Matrix3>;

/// Transforms a vector from the world's axes to these axes.
#[inline]
pub(crate) fn own(axes: &OwnAxes, vector: &Vector3) -> Vector3 {
    axes.as_ref().map_or(*vector, |axes| axes.tr_mul(vector))
}

/// Transforms a vector from these axes to the world's axes.
#[inline]
pub(crate) fn out(axes: &OwnAxes, own: &Vector3) -> Vector3 {
    axes.as_ref().map_or(*own, |axes| axes * own)
}

/// Scales a vector of the world along each of these axes by its own factor.
#[inline]
pub(crate) fn scaled(axes: &OwnAxes, factors: &Vector3, vector: &Vector3) -> Vector3 {
    match axes {
        None => factors.component_mul(vector),
        Some(axes) => axes * factors.component_mul(&axes.tr_mul(vector)),
    }
}

impl Axes {
    /// `has`: whether the device can move along each axis. `own`: the device's axes, as unit vectors of the world;
    /// `None` for those of the world.
    pub fn new(has: [bool; 3], own: Option<[Vector; 3]>) -> Self {
        let own = own.map(|axes| {
            let columns = axes.map(Vector3::from);
            Matrix3::from_columns(&columns)
        });
        Self { has, own }
    }

    /// Returns the device's axes, including constrained ones.
    pub fn own_axes(&self) -> OwnAxes {
        self.own
    }

    /// Returns whether the device has all three axes.
    pub fn are_all(&self) -> bool {
        self.has == [true; 3]
    }

    /// Transforms a vector from the world's axes to the device's axes.
    pub fn own(&self, vector: &Vector3) -> Vector3 {
        own(&self.own, vector)
    }

    /// Transforms a vector from the device's axes to the world's axes.
    pub fn out(&self, own: &Vector3) -> Vector3 {
        out(&self.own, own)
    }

    /// Returns the standard deviations along the device's axes from independent ones along the world's axes.
    pub fn own_deviations(&self, deviations: &Vector3) -> Vector3 {
        self.own.map_or(*deviations, |axes| {
            let squares = axes
                .component_mul(&axes)
                .tr_mul(&deviations.component_mul(deviations));
            squares.map(|square| square.max(0.0).sqrt())
        })
    }

    /// Returns a vector along the device's axes with `number` on the available axes and 0 on the others.
    pub fn where_there(&self, number: f64) -> Vector3 {
        Vector3::from(self.has.map(|has| if has { number } else { 0.0 }))
    }

    /// Returns the part of a vector along the available axes.
    pub fn along(&self, vector: &Vector3) -> Vector3 {
        self.mixed(vector, &Vector3::zeros())
    }

    /// Returns the part of a vector along the constrained axes.
    pub fn across(&self, vector: &Vector3) -> Vector3 {
        self.mixed(&Vector3::zeros(), vector)
    }

    /// Returns `own` along the available axes and `other` along the constrained axes.
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

    /// Removes the part of a force that the device cannot exert.
    pub fn keep(&self, force: &mut Vector) {
        *force = self.along(&Vector3::from(*force)).into();
    }
}

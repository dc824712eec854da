//! A one-dimensional contact, placed in the plane or in space.

use crate::Scalar;
use crate::parameter::{ParameterError, check, finite};

/// Where the axis of a contact lies in a device of `N` dimensions: an origin and a unit normal.
///
/// The contact's coordinate is the distance from the origin along the normal. A force along the
/// contact becomes a vector along the normal. The device's own Jacobian stays with the device.
///
/// ```
/// use palpate::Placement;
///
/// let floor = Placement::new([0.0, 0.0, 0.1], [0.0, 0.0, 1.0])?;
/// assert_eq!(floor.coordinate([0.3, -0.2, 0.25]), 0.15);
/// assert_eq!(floor.vector(-2.0), [0.0, 0.0, -2.0]);
/// # Ok::<(), palpate::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement<S, const N: usize> {
    origin: [S; N],
    normal: [S; N],
}

impl<S: Scalar, const N: usize> Placement<S, N> {
    /// An axis through `origin` `[m]` along the unit vector `normal` `[1]`, in which device
    /// positions increase.
    ///
    /// # Errors
    /// A coordinate that is not finite; a normal whose length is not 1 within 1e-3 (it is then
    /// scaled to length 1 exactly, so a normal written with few digits does no harm).
    pub fn new(origin: [S; N], normal: [S; N]) -> Result<Self, ParameterError> {
        for coordinate in origin {
            finite("origin", "m", coordinate)?;
        }
        let mut square = S::ZERO;
        for component in normal {
            square += finite("normal", "", component)? * component;
        }
        let length = square.sqrt();
        check(
            (length - S::ONE).abs() <= S::from_f64(1e-3),
            "length of normal",
            "",
            length,
            "1",
        )?;
        Ok(Self {
            origin,
            normal: normal.map(|component| component / length),
        })
    }

    /// Coordinate of `point` `[m]` along the axis `[m]`.
    #[inline]
    pub fn coordinate(&self, point: [S; N]) -> S {
        let mut sum = S::ZERO;
        for ((x, o), n) in point.iter().zip(&self.origin).zip(&self.normal) {
            sum += (*x - *o) * *n;
        }
        sum
    }

    /// The vector of signed length `along` on the axis, for instance a force `[N]`.
    #[inline]
    pub fn vector(&self, along: S) -> [S; N] {
        self.normal.map(|component| component * along)
    }
}

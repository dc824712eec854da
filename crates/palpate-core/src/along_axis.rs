//! One-dimensional contact along an axis in the plane or in space.

use crate::Scalar;
use crate::parameter::{Allowed, Parameter, ParameterError};

/// Axis of a contact in a device of `N` dimensions: an origin and a unit normal.
///
/// The contact's coordinate is the distance from the origin along the normal. A force along the contact becomes a
/// vector along the normal. The device's own Jacobian is not included.
///
/// **Solid side**: with [`Side::Positive`](crate::Side::Positive), the default, the object occupies coordinates greater
/// than the object's position. The normal therefore points *into* the solid, and the force on the device points against
/// it.
///
/// ```text
///        z ▲      device at z = 0.25 m: coordinate −0.25 m, no force
///          │
///          │      device at z = −0.002 m: coordinate 0.002 m, +4 N along z
///  z = 0 ──┼───────────────────  surface: origin (0, 0, 0)
///          │ ░░░░░░░░░│░░░░░░░░
///            ░ solid  ▼  normal (0, 0, −1)
/// ```
///
/// A floor of 2000 N/m at z = 0:
///
/// ```
/// use palpate_core::{BasicParams, Contact, LoopParams, ObjectState, AlongAxis, Renderer, Sample};
///
/// let floor = AlongAxis::new([0.0, 0.0, 0.0], [0.0, 0.0, -1.0])?;
/// let wall = Contact::object(2000.0, f64::INFINITY);
/// let renderer = Renderer::new(wall, LoopParams::new(0.001), BasicParams)?;
/// let start = renderer.start(ObjectState::at_rest(0.0))?; // the surface is at the origin
///
/// let force_at = |point: [f64; 3]| {
///     let mut state = start; // a new state for each point; a loop keeps one state
///     let output = renderer.step(&mut state, Sample::at(floor.coordinate(point)));
///     floor.vector(output.force_on_device)
/// };
/// assert_eq!(force_at([0.3, -0.2, 0.25])[2], 0.0); // above the floor
/// assert_eq!(force_at([0.3, -0.2, -0.002])[2], 4.0); // 2 mm in it: pushed up
/// # Ok::<(), palpate_core::ParameterError>(())
/// ```
///
/// The forces of several contacts on one device, each with its own renderer and placement, are added. `docs/signs.md`
/// shows a block on this floor, and the limitations of several independent contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlongAxis<S, const N: usize> {
    origin: [S; N],
    normal: [S; N],
}

impl<S: Scalar, const N: usize> AlongAxis<S, N> {
    /// Creates an axis through `origin` `[m]` along the unit vector `normal` `[1]`, in which device positions increase:
    /// into the object of a contact on [`Side::Positive`](crate::Side::Positive).
    ///
    /// # Errors
    /// A coordinate is not finite, or the length of the normal is not 1 within 1e-3. An accepted normal is scaled to
    /// length 1 exactly, so few digits suffice.
    pub fn new(origin: [S; N], normal: [S; N]) -> Result<Self, ParameterError> {
        for coordinate in origin {
            Parameter::AxisOrigin.finite(coordinate)?;
        }
        let mut square = S::ZERO;
        for component in normal {
            square += Parameter::AxisNormal.finite(component)? * component;
        }
        let length = square.sqrt();
        let is_one = (length - S::ONE).abs() <= S::from_f64(1e-3);
        Parameter::AxisNormalLength.unless(is_one, length, Allowed::Words("1"))?;
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

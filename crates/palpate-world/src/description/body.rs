//! Contents of a world: the tools of the devices, and bodies.

use std::sync::Arc;

use crate::geometry::axes::Axes;
use crate::geometry::rigid::{Vector3, orientation, quaternion};
use crate::{IDENTITY, MassTable, MassTableError, Quaternion, Shape, Vector};

/// The object that a device moves through the world. The device measures its position and orientation.
///
/// The origin of the tool's axes is the mass centre of the moving part of the device: the position of a sample and
/// the torques refer to this point.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name of the tool, used by contacts.
    pub name: String,
    /// Shape in the tool's axes.
    pub shape: Shape,
    /// Whether the device rotates the tool: a six-axis device, which measures an orientation. Otherwise the tool's
    /// axes are those of the world.
    pub turns: bool,
    /// Whether a device that rotates the tool also exerts a torque. If not, the hand alone sets the orientation
    /// regardless of contacts, and feels no torque. Most stylus devices measure six axes and push along three. Used
    /// only if `turns` is set.
    pub gives_torque: bool,
    /// Axes along which the device can move and push the tool; at least one. Along the others its mechanism
    /// constrains the tool to the measured position: the force on the device is 0 there, regardless of contacts.
    pub axes: [bool; 3],
    /// The device's axes, along which its mobility is diagonal and its model mass is given: orthogonal unit vectors,
    /// to 1e-9, along the world's axes. `None`: the world's axes. Positions and forces are always along the world's
    /// axes.
    pub own_axes: Option<[Vector; 3]>,
    /// Position-dependent mass of the device; `None` if it is constant. The device's axes are then those of the
    /// mobility at the table's reference. They are also the axes of the model masses of a method.
    pub mass_table: Option<Arc<MassTable>>,
}

impl Tool {
    /// Creates a tool with this name and shape, whose device moves it along all three axes and does not rotate it.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: Shape) -> Self {
        Self {
            name: name.into(),
            shape,
            turns: false,
            gives_torque: true,
            axes: [true; 3],
            own_axes: None,
            mass_table: None,
        }
    }

    /// Sets the device's axes ([`own_axes`](Self::own_axes)): those of its mobility 1/m, which is a matrix in the
    /// world's axes.
    #[must_use]
    pub fn with_own_axes(self, own_axes: [Vector; 3]) -> Self {
        Self {
            own_axes: Some(own_axes),
            ..self
        }
    }

    /// Sets a position-dependent mass matrix of the device, such as that of a linkage.
    ///
    /// `places`: increasing coordinates from the world's origin along each available axis ([`axes`](Self::axes),
    /// [`own_axes`](Self::own_axes)) `[m]`; a single value if nothing changes along an axis. `masses`: the matrix
    /// along these axes at each grid point, last axis fastest, as `[xx, yy, zz, xy, xz, yz]`, `[xx, yy, xy]` or
    /// `[xx]` `[kg]`.
    ///
    /// The device's axes become those in which the matrix at `reference` `[m]` is diagonal. The model masses of a
    /// method are along these axes ([`MassTable::masses_at_reference`]). The table defines only the relative change
    /// from there: a constant factor has no effect. Only [`CoupledParams`](crate::CoupledParams) uses the table; the
    /// other methods use no mass.
    ///
    /// # Errors
    /// Lists that do not fit the axes or each other, coordinates that do not increase, a matrix that is not positive
    /// definite, or grid points too far apart for the change between them.
    pub fn with_mass_table<P: AsRef<[f64]>, M: AsRef<[f64]>>(
        self,
        places: &[P],
        masses: &[M],
        reference: Vector,
    ) -> Result<Self, MassTableError> {
        let frame = (self.axes, Axes::new(self.axes, self.own_axes).own_axes());
        let table = MassTable::new(frame, places, masses, reference)?;
        let (own, _) = table.principal();
        Ok(Self {
            own_axes: own.map(|own| [0, 1, 2].map(|axis| own.column(axis).into_owned().into())),
            mass_table: Some(Arc::new(table)),
            ..self
        })
    }

    /// Restricts the device to these of its axes; a planar pantograph has two.
    #[must_use]
    pub fn along(self, axes: [bool; 3]) -> Self {
        Self { axes, ..self }
    }

    /// Returns the available axes in words: `x and z`, or `the first and the third of its own axes`.
    #[must_use]
    pub fn names_of_axes(&self) -> String {
        if self.own_axes.is_some() {
            let named = self.named(["the first", "the second", "the third"]);
            return format!("{named} of its own axes");
        }
        self.named(["x", "y", "z"])
    }

    fn named(&self, names: [&'static str; 3]) -> String {
        let names = names.into_iter().zip(self.axes);
        let names: Vec<_> = names
            .filter_map(|(name, has)| has.then_some(name))
            .collect();
        match names[..] {
            [] => "no axis".into(),
            [one] => one.into(),
            [one, other] => format!("{one} and {other}"),
            [one, other, ..] => format!("{one}, {other} and {}", names[2]),
        }
    }

    /// Sets a six-axis device, which exerts a torque.
    #[must_use]
    pub fn turning(self) -> Self {
        Self {
            turns: true,
            gives_torque: true,
            ..self
        }
    }

    /// Sets a device that measures six axes and pushes along three: its hand turns the tool and feels no torque.
    #[must_use]
    pub fn turned_by_hand(self) -> Self {
        Self {
            turns: true,
            gives_torque: false,
            ..self
        }
    }

    /// Returns whether contact torques turn the tool and its device exerts them on the hand.
    #[must_use]
    pub fn feels_torque(&self) -> bool {
        self.turns && self.gives_torque
    }

    /// Returns whether the hand alone sets the orientation.
    pub(crate) fn is_led(&self) -> bool {
        self.turns && !self.gives_torque
    }
}

/// A body of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name of the body, used by contacts.
    pub name: String,
    /// Shape in the body's axes, whose origin is its centre of mass.
    pub shape: Shape,
    /// Initial position of its centre of mass `[m]`.
    pub position: Vector,
    /// Initial orientation.
    pub orientation: Quaternion,
    /// Whether the body moves, and its initial motion.
    pub motion: Motion,
}

impl Body {
    /// Creates a body at the origin with identity orientation.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: Shape, motion: Motion) -> Self {
        Self {
            name: name.into(),
            shape,
            position: [0.0; 3],
            orientation: IDENTITY,
            motion,
        }
    }

    /// Sets the initial position of its centre of mass `[m]`.
    #[must_use]
    pub fn at(self, position: Vector) -> Self {
        Self { position, ..self }
    }

    /// Sets the initial orientation.
    #[must_use]
    pub fn turned(self, orientation: Quaternion) -> Self {
        Self {
            orientation,
            ..self
        }
    }

    /// Moves the body's axes to its centre of mass and its principal axes, so that its moments of inertia are known.
    /// The shape keeps its pose in the world, and its original origin and axes no longer matter.
    ///
    /// This applies to a moving body that fills a closed mesh or a hull homogeneously. Other bodies are unchanged. If
    /// moments of inertia are given, the shape's origin must be the centre of mass and its axes must be principal.
    #[must_use]
    pub fn balanced(self) -> Self {
        let Motion::Free(free @ Free { inertia: None, .. }) = &self.motion else {
            return self;
        };
        let of = match &self.shape {
            Shape::Mesh(mesh) => mesh.mass_properties(free.mass),
            Shape::Hull(hull) => hull.mass_properties(free.mass),
            _ => None,
        };
        let Some(of) = of else {
            return self;
        };
        if of.centre == [0.0; 3] && of.orientation == IDENTITY {
            return self;
        }
        let (centre, axes) = (Vector3::from(of.centre), orientation(of.orientation));
        let turned = orientation(self.orientation);
        let orientation = turned * axes;
        let shape = match self.shape {
            Shape::Mesh(mesh) => Shape::Mesh(mesh.seen_from(&centre, &axes)),
            Shape::Hull(hull) => Shape::Hull(Arc::new(hull.seen_from(&of))),
            other => other,
        };
        Self {
            shape,
            position: (Vector3::from(self.position) + turned * centre).into(),
            orientation: quaternion(&orientation),
            ..self
        }
    }
}

/// Motion of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// The body is fixed.
    Fixed,
    /// The body moves under forces.
    Free(Free),
}

/// A moving body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Mass, above 0 `[kg]`.
    pub mass: f64,
    /// Moments of inertia about the centre of mass along the body's axes, each above 0 `[kg m^2]`. `None`: those of
    /// the homogeneous shape.
    pub inertia: Option<Vector>,
    /// Initial velocity of the centre of mass `[m/s]`.
    pub velocity: Vector,
    /// Initial angular velocity, along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// A constant force at the centre of mass, for example the weight `[N]`.
    pub force: Vector,
}

impl Free {
    /// Creates a body with this mass `[kg]` at rest, without a constant force.
    #[must_use]
    pub fn of_mass(mass: f64) -> Self {
        Self {
            mass,
            inertia: None,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            force: [0.0; 3],
        }
    }

    /// Sets the constant force at the centre of mass `[N]`.
    #[must_use]
    pub fn pulled_by(self, force: Vector) -> Self {
        Self { force, ..self }
    }

    /// Sets the initial velocity `[m/s]`.
    #[must_use]
    pub fn moving(self, velocity: Vector) -> Self {
        Self { velocity, ..self }
    }
}

//! What there is in a world: the tools of the devices, and bodies.

use std::sync::Arc;

use nalgebra::UnitQuaternion;

use crate::axes::Axes;
use crate::rigid::{Rotation, Vector3};
use crate::state::quaternion;
use crate::{MassTable, MassTableError, NOT_TURNED, Quaternion, Shape, Vector};

/// What a device moves through the world. Where it is, and how it is turned, the device measures.
///
/// The tool's own axes begin at the mass centre of what the device moves: the position of a sample is that point's, and
/// a torque is about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Its name, by which contacts call it.
    pub name: String,
    /// Its shape, in its own axes.
    pub shape: Shape,
    /// Whether the device turns it: a device of six axes, which measures an orientation. If not, the tool's axes are those of
    /// the world.
    pub turns: bool,
    /// Whether a device that turns it gives a torque, too. If not, its hand alone turns it, whatever the contacts push, and
    /// feels no torque: most devices with a stylus measure six axes and push along three. Read only if the tool turns.
    pub gives_torque: bool,
    /// Along which of its axes the device moves it and can push it; at least one. Along the others its mechanism holds the
    /// tool where the device is measured: the force on the device is 0 there, whatever the contacts push.
    pub axes: [bool; 3],
    /// The device's axes, along which its mass is told and its mobility diagonal: unit vectors at right angles, to 1e-9, along the
    /// world's axes. `None`: the world's own. Positions and forces are in the world's axes in any case.
    pub own_axes: Option<[Vector; 3]>,
    /// How the device's mass changes with the place of the tool; `None` if it is the same everywhere. The device's axes are then
    /// those of the mobility at the table's reference, and so are the masses that a method is told.
    pub mass_table: Option<Arc<MassTable>>,
}

impl Tool {
    /// A tool of that name and shape, which its device moves along all three axes and does not turn.
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

    /// The same tool, moved by a device with axes of its own ([`own_axes`](Self::own_axes)): those of its mobility 1/m, which is a
    /// matrix in the world's axes.
    #[must_use]
    pub fn with_own_axes(self, own_axes: [Vector; 3]) -> Self {
        Self {
            own_axes: Some(own_axes),
            ..self
        }
    }

    /// The same tool, moved by a device whose mass matrix changes with the place of the tool, as that of a linkage does.
    ///
    /// `places`: increasing coordinates along each of the axes that the device has ([`axes`](Self::axes), [`own_axes`](Self::own_axes)),
    /// from the world's origin; one alone where nothing changes along an axis `[m]`. `masses`: the matrix along these axes at each
    /// place of that grid, those of the last axis side by side, as `[xx, yy, zz, xy, xz, yz]`, `[xx, yy, xy]` or `[xx]` `[kg]`.
    ///
    /// The device's axes become those along which the matrix at `reference` `[m]` is diagonal; a method is told the masses along these,
    /// [`MassTable::masses_at_reference`]. The table says how the mass changes from there: one that is wrong by a factor tells the same.
    /// [`CoupledParams`](crate::CoupledParams) follows it; no other method knows masses.
    ///
    /// # Errors
    /// Lists that do not fit the axes or each other, places that do not increase, a matrix that is not positive definite, or places
    /// too far apart for what changes between them.
    pub fn with_mass_table<P: AsRef<[f64]>, M: AsRef<[f64]>>(
        self,
        places: &[P],
        masses: &[M],
        reference: Vector,
    ) -> Result<Self, MassTableError> {
        let frame = (self.axes, Axes::of(&self).own_axes());
        let table = MassTable::new(frame, places, masses, reference)?;
        let (own, _) = table.principal();
        Ok(Self {
            own_axes: own.map(|own| [0, 1, 2].map(|axis| own.column(axis).into_owned().into())),
            mass_table: Some(Arc::new(table)),
            ..self
        })
    }

    /// The same tool, moved by a device that has these of its axes only: a pantograph in a plane has two.
    #[must_use]
    pub fn along(self, axes: [bool; 3]) -> Self {
        Self { axes, ..self }
    }

    /// The axes along which its device moves it, in words: `x and z`, or `the first and the third of its own axes`.
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

    /// The same tool, moved by a device of six axes, which gives a torque.
    #[must_use]
    pub fn turning(self) -> Self {
        Self {
            turns: true,
            gives_torque: true,
            ..self
        }
    }

    /// The same tool, moved by a device that measures six axes and pushes along three: its hand turns it, and feels no
    /// torque.
    #[must_use]
    pub fn turned_by_hand(self) -> Self {
        Self {
            turns: true,
            gives_torque: false,
            ..self
        }
    }

    /// Whether the torques of its contacts turn it, and its device gives them to the hand.
    #[must_use]
    pub fn feels_torque(&self) -> bool {
        self.turns && self.gives_torque
    }

    /// Whether its hand alone turns it.
    pub(crate) fn is_led(&self) -> bool {
        self.turns && !self.gives_torque
    }
}

/// A body of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name, by which contacts call it.
    pub name: String,
    /// Its shape, in its own axes, about its centre of mass.
    pub shape: Shape,
    /// Where its centre of mass is at the start `[m]`.
    pub position: Vector,
    /// How it is turned at the start.
    pub orientation: Quaternion,
    /// Whether it moves, and how at the start.
    pub motion: Motion,
}

impl Body {
    /// A body at the origin that is not turned.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: Shape, motion: Motion) -> Self {
        Self {
            name: name.into(),
            shape,
            position: [0.0; 3],
            orientation: NOT_TURNED,
            motion,
        }
    }

    /// The same body with its centre of mass at `position` `[m]`.
    #[must_use]
    pub fn at(self, position: Vector) -> Self {
        Self { position, ..self }
    }

    /// The same body, turned.
    #[must_use]
    pub fn turned(self, orientation: Quaternion) -> Self {
        Self {
            orientation,
            ..self
        }
    }

    /// The same body in the same place, for which the origin and the axes of its shape are of no account: its own axes
    /// begin at its centre of mass and are its principal ones, so that its moments of inertia are known.
    ///
    /// This is for a body that moves and fills a closed mesh or a hull evenly. All others stay as they are; where moments of inertia
    /// are given, the shape's origin is the centre of mass and its axes are principal.
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
        if of.centre == [0.0; 3] && of.orientation == NOT_TURNED {
            return self;
        }
        let (centre, axes) = (Vector3::from(of.centre), rotation(of.orientation));
        let turned = rotation(self.orientation);
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

pub(crate) fn rotation([w, x, y, z]: Quaternion) -> Rotation {
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
}

/// Whether a body moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// It stays where it is.
    Fixed,
    /// It moves as forces tell it.
    Free(Free),
}

/// A body that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Mass, above 0 `[kg]`.
    pub mass: f64,
    /// Moments of inertia about the centre of mass along the body's own axes, each above 0 `[kg m^2]`.
    /// `None`: of the shape, filled evenly.
    pub inertia: Option<Vector>,
    /// Velocity of the centre of mass at the start `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity at the start, along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// A constant force at the centre of mass, its weight for instance `[N]`.
    pub force: Vector,
}

impl Free {
    /// A body of that mass `[kg]` at rest, which no force but those of contacts pulls at.
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

    /// The same body with a constant force at its centre of mass `[N]`.
    #[must_use]
    pub fn pulled_by(self, force: Vector) -> Self {
        Self { force, ..self }
    }

    /// The same body with that velocity at the start `[m/s]`.
    #[must_use]
    pub fn moving(self, velocity: Vector) -> Self {
        Self { velocity, ..self }
    }
}

//! Model published by a host, and its checks.

use nalgebra::UnitVector3;
use palpate_core::Range;

use super::params::LocalParams;
use crate::engine::body::BodyNow;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::{ContactLaw, Tool, Vector, WorldError, WorldErrors, WorldField, WorldPart};

/// Input of the fast loop: bodies and contacts of a host at a tick. Created and checked by
/// [`LocalRenderer::model`](super::LocalRenderer::model).
#[derive(Clone, Debug, PartialEq)]
pub struct LocalModel {
    pub(super) tick: u64,
    pub(super) tools: usize,
    pub(super) bodies: Vec<BodyNow>,
    pub(super) contacts: Vec<Option<LocalContact>>,
}

/// A possible contact of a sphere with a surface, with the bodies at the positions in the model.
///
/// The surface is a plane or, with a curvature, a sphere. It is unbounded and fixed to its body.
///
/// ```text
///           o  sphere: a tool, or a part of a body
///           ^
///           | normal
///    -------+-------  surface of `on`, at `place`
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalContact {
    /// The sphere that touches the surface.
    pub touching: Touching,
    /// Index of the body with the surface; `None` for a fixed surface.
    pub on: Option<usize>,
    /// A point of the surface, along the world's axes, usually the point nearest to the sphere `[m]`.
    pub place: Vector,
    /// Outward unit normal of the surface there, along the world's axes.
    pub normal: Vector,
    /// Curvature of the surface `[1/m]`: 1/r of a ball of radius r, -1/r of the inside of one, 0 of a plane.
    pub curvature: f64,
    /// Contact law.
    pub law: ContactLaw,
}

/// The sphere that touches a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touching {
    /// The tool of this index. Its force is rendered.
    Tool(usize),
    /// A sphere of a body: a contact between the host's own bodies, such as a ball on a floor. The host computes its
    /// force. The loop computes its effect on the body's copy between two models.
    Body {
        /// Index of the body.
        body: usize,
        /// Centre of the sphere, along the world's axes, with the body at the position in the model `[m]`.
        centre: Vector,
        /// Radius of the sphere `[m]`; 0 for a corner.
        radius: f64,
    },
}

impl LocalContact {
    /// Creates a flat surface of `on` through `place` `[m]` with this normal, for a tool.
    #[must_use]
    pub fn of_tool(
        tool: usize,
        on: Option<usize>,
        place: Vector,
        normal: Vector,
        law: ContactLaw,
    ) -> Self {
        Self {
            touching: Touching::Tool(tool),
            on,
            place,
            normal,
            curvature: 0.0,
            law,
        }
    }

    /// Creates a flat surface at a signed `gap` `[m]` from a spherical tool of `radius` `[m]` with its centre at
    /// `centre` `[m]`: the usual result of an engine's distance query. A negative gap is an overlap.
    #[must_use]
    pub fn at_gap(
        (tool, centre, radius): (usize, Vector, f64),
        on: Option<usize>,
        gap: f64,
        normal: Vector,
        law: ContactLaw,
    ) -> Self {
        let place = Vector3::from(centre) - Vector3::from(normal) * (gap + radius);
        Self::of_tool(tool, on, place.into(), normal, law)
    }

    /// Creates a flat surface that a sphere of a body touches ([`Touching::Body`]).
    #[must_use]
    pub fn of_body(
        (body, centre, radius): (usize, Vector, f64),
        on: Option<usize>,
        place: Vector,
        normal: Vector,
        law: ContactLaw,
    ) -> Self {
        Self {
            touching: Touching::Body {
                body,
                centre,
                radius,
            },
            ..Self::of_tool(0, on, place, normal, law)
        }
    }

    /// Sets the curvature of the surface `[1/m]`.
    #[must_use]
    pub fn curved(self, curvature: f64) -> Self {
        Self { curvature, ..self }
    }
}

impl LocalModel {
    /// Returns the loop tick up to which the model includes the tools' impulses.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Returns all faults of bodies and contacts, or otherwise the model. Contacts that are not given become empty
    /// slots.
    pub(super) fn checked(
        tick: u64,
        bodies: &[BodyNow],
        contacts: &[Option<LocalContact>],
        tools: &[Tool],
        params: &LocalParams,
    ) -> Result<Self, WorldErrors> {
        let mut faults = Vec::new();
        if bodies.len() != params.bodies {
            let message = format!(
                "there are {} bodies, and the loop needs exactly {}: give every body, including bodies without \
                 contacts",
                bodies.len(),
                params.bodies
            );
            faults.push(WorldError::new(
                WorldPart::World,
                WorldField::Bodies,
                "the local model",
                message,
            ));
        }
        for (number, body) in bodies.iter().enumerate() {
            if !body.is_finite() {
                let message = "position, orientation, motion, acceleration and mobility have to be numbers, and the \
                               orientation a unit quaternion";
                faults.push(WorldError::new(
                    WorldPart::Body(number),
                    WorldField::Whole,
                    format!("body {number}"),
                    message,
                ));
            }
        }
        if contacts.len() > params.contacts {
            let message = format!(
                "there are {} contacts, and at most {} are allowed: give those that are nearest to touching",
                contacts.len(),
                params.contacts
            );
            faults.push(WorldError::new(
                WorldPart::World,
                WorldField::Contacts,
                "the local model",
                message,
            ));
        }
        for (number, contact) in contacts.iter().enumerate() {
            let Some(contact) = contact else { continue };
            for (field, message) in contact.faults(tools.len(), bodies.len()) {
                let subject = format!("contact {number}");
                faults.push(WorldError::new(
                    WorldPart::Contact(number),
                    field,
                    subject,
                    message,
                ));
            }
        }
        WorldErrors::check(faults)?;
        let mut slots = contacts.to_vec();
        slots.resize(params.contacts, None);
        for contact in slots.iter_mut().flatten() {
            contact.normal = UnitVector3::new_normalize(Vector3::from(contact.normal))
                .into_inner()
                .into();
        }
        Ok(Self {
            tick,
            tools: tools.len(),
            bodies: bodies.to_vec(),
            contacts: slots,
        })
    }
}

/// Allowed deviation of a normal's length from 1.
const LENGTH_TOLERANCE: f64 = 1e-3;

impl LocalContact {
    fn faults(&self, tools: usize, bodies: usize) -> Vec<(WorldField, String)> {
        let mut faults = Vec::new();
        self.check_touching(tools, bodies, &mut faults);
        self.check_surface(bodies, &mut faults);
        self.check_law(&mut faults);
        faults
    }

    /// Reports a missing tool or body, a body that touches itself, or a wrong radius.
    fn check_touching(&self, tools: usize, bodies: usize, faults: &mut Vec<(WorldField, String)>) {
        match self.touching {
            Touching::Tool(tool) if tool >= tools => {
                faults.push((
                    WorldField::Touching,
                    format!("its tool is {tool}, and there are {tools} tools, from 0"),
                ));
            }
            Touching::Tool(_) => {}
            Touching::Body { body, radius, .. } => {
                if body >= bodies {
                    faults.push((
                        WorldField::Touching,
                        format!("its body is {body}, and there are {bodies} bodies, from 0"),
                    ));
                }
                if self.on == Some(body) {
                    faults.push((WorldField::On, format!("body {body} cannot touch itself")));
                }
                if !(radius >= 0.0 && radius.is_finite()) {
                    faults.push((
                        WorldField::Radius,
                        format!("radius is {radius} m, and has to be at least 0"),
                    ));
                }
            }
        }
    }

    /// Reports a surface of a missing body, or one with a wrong place, normal or curvature.
    fn check_surface(&self, bodies: usize, faults: &mut Vec<(WorldField, String)>) {
        if let Some(on) = self.on
            && on >= bodies
        {
            faults.push((
                WorldField::On,
                format!("it is on body {on}, and there are {bodies} bodies, from 0"),
            ));
        }
        let mut vectors = vec![(WorldField::Place, self.place)];
        if let Touching::Body { centre, .. } = self.touching {
            vectors.push((WorldField::Centre, centre));
        }
        for (field, vector) in vectors {
            if !vector.iter().all(|x| x.is_finite()) {
                faults.push((
                    field,
                    format!("{field} is {vector:?} m, and has to be three finite numbers"),
                ));
            }
        }
        let length = Vector3::from(self.normal).norm();
        let is_unit = (length - 1.0).abs() <= LENGTH_TOLERANCE;
        if !is_unit {
            faults.push((
                WorldField::Normal,
                format!("normal has length {length}, and has to have length 1"),
            ));
        }
        if !self.curvature.is_finite() {
            let curvature = self.curvature;
            faults.push((
                WorldField::Curvature,
                format!("curvature is {curvature} 1/m, and has to be a number"),
            ));
        }
    }

    /// Reports the values of the contact law that are out of range.
    fn check_law(&self, faults: &mut Vec<(WorldField, String)>) {
        let ContactLaw {
            stiffness,
            damping,
            friction,
            friction_stiffness,
            friction_damping,
        } = self.law;
        for (field, value, range) in [
            (WorldField::Stiffness, stiffness, Range::Positive),
            (WorldField::Damping, damping, Range::NotNegative),
            (WorldField::Friction, friction, Range::NotNegative),
            (
                WorldField::FrictionStiffness,
                friction_stiffness,
                Range::Positive,
            ),
            (
                WorldField::FrictionDamping,
                friction_damping,
                Range::NotNegative,
            ),
        ] {
            let fault = out_of_range(field, value, range);
            faults.extend(fault.map(|message| (field, message)));
        }
    }
}

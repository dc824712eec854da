//! Bodies of another physics engine: their description, and their state at each step.

use nalgebra::Vector6;

use crate::{
    Body, Contact, ContactLaw, Motion, Party, Quaternion, Shape, Tool, Vector, World, WorldError,
    WorldField, WorldPart,
};

/// A body of another physics engine that tools may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineBody {
    /// Name of the body in messages.
    pub name: String,
    /// Shapes that tools can touch.
    pub shapes: Vec<PlacedShape>,
    /// Law of its contacts with every tool.
    pub law: ContactLaw,
}

/// A shape that is fixed to a body.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// The shape, in its own axes.
    pub shape: Shape,
    /// Position of the shape relative to the body's reference point, in the body's axes `[m]`.
    pub position: Vector,
    /// Orientation of the shape's axes relative to the body's axes.
    pub orientation: Quaternion,
}

/// The engine's position integrator for a constant force. It determines the position of a body after a step, compared
/// with the motion under the continuous force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stepping {
    /// x += h (v + v')/2: exact for a constant force, like Runge-Kutta and the midpoint rule.
    #[default]
    MeanVelocity,
    /// x += h v', with the velocity v' after the step: semi-implicit Euler, used by most engines.
    EndVelocity,
    /// [`EndVelocity`](Self::EndVelocity) in this number of equal parts of the step (at least 1), for engines that
    /// sub-divide a step internally, such as Rapier and Box2D.
    Parts(u32),
}

impl Stepping {
    /// Returns the distance that a step moves a body beyond the exact motion, per step and per velocity change.
    pub(super) fn ahead(self) -> f64 {
        match self {
            Self::MeanVelocity => 0.0,
            Self::EndVelocity => 0.5,
            // Part k of n ends with k/n of the velocity change.
            Self::Parts(parts) => 0.5 / f64::from(parts.max(1)),
        }
    }
}

/// State of an engine's body at the beginning of a step, along the world's axes. The engine takes torques about the
/// body's reference point, usually the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyNow {
    /// Position of the reference point `[m]`.
    pub position: Vector,
    /// Orientation of the body.
    pub orientation: Quaternion,
    /// Velocity of the reference point `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity `[rad/s]`.
    pub angular_velocity: Vector,
    /// Acceleration of the reference point over the step, without the tools `[m/s^2]`.
    pub acceleration: Vector,
    /// Angular acceleration without the tools `[rad/s^2]`.
    pub angular_acceleration: Vector,
    /// Mobility: maps force `[N]` and torque about the reference point `[N m]` (columns) to the six accelerations
    /// (rows). It has rank 1 for a body on a hinge and is zero for a fixed body.
    pub mobility: [[f64; 6]; 6],
}

impl BodyNow {
    /// Returns a fixed body at `position` `[m]`, at rest and not rotated.
    #[must_use]
    pub fn fixed(position: Vector) -> Self {
        Self {
            position,
            orientation: crate::IDENTITY,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            acceleration: [0.0; 3],
            angular_acceleration: [0.0; 3],
            mobility: [[0.0; 6]; 6],
        }
    }

    /// Returns velocity `[m/s]` and angular velocity `[rad/s]`.
    pub(super) fn twist(&self) -> Vector6<f64> {
        let [v, w] = [&self.velocity, &self.angular_velocity];
        Vector6::new(v[0], v[1], v[2], w[0], w[1], w[2])
    }

    pub(super) fn is_finite(&self) -> bool {
        let vectors = [
            &self.position,
            &self.velocity,
            &self.angular_velocity,
            &self.acceleration,
            &self.angular_acceleration,
        ];
        let sum: f64 = vectors.into_iter().flatten().sum();
        let turned: f64 = self.orientation.iter().map(|q| q * q).sum();
        let answers: f64 = self.mobility.iter().flatten().sum();
        sum.is_finite() && answers.is_finite() && turned > 0.25 && turned < 4.0
    }
}

/// A constant wrench on a body for one step, along the world's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyWrench {
    /// Force `[N]`.
    pub force: Vector,
    /// Torque about the body's reference point `[N m]`.
    pub torque: Vector,
}

impl EngineBody {
    /// Returns all faults of the body with this index, by the rules of a [`World`].
    pub(super) fn faults(&self, number: usize, tools: &[Tool]) -> Vec<WorldError> {
        let place = WorldPart::Body(number);
        let subject = format!("body {:?}", self.name);
        if self.shapes.is_empty() {
            let message = "it has no shape; give at least one";
            return vec![WorldError::new(place, WorldField::Shape, subject, message)];
        }
        let mut faults = Vec::new();
        for placed in &self.shapes {
            let body = Body::new(&self.name, placed.shape.clone(), Motion::Fixed)
                .at(placed.position)
                .turned(placed.orientation);
            let alone = World {
                joints: Vec::new(),
                fields: Vec::new(),
                tools: tools.to_vec(),
                bodies: vec![body],
                contacts: vec![Contact {
                    between: [Party::Any, Party::Any],
                    law: self.law,
                }],
            };
            for fault in alone.check().err().into_iter().flatten() {
                let is_of_body = matches!(fault.part, WorldPart::Body(_) | WorldPart::Contact(_));
                let of_this = WorldError {
                    part: place,
                    subject: subject.clone(),
                    ..fault
                };
                if is_of_body && !faults.contains(&of_this) {
                    faults.push(of_this);
                }
            }
        }
        faults
    }
}

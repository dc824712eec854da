//! What is told of an engine's bodies: once, and at each of its steps.

use nalgebra::Vector6;

use crate::{
    Body, Contact, ContactLaw, Motion, Party, Quaternion, Shape, Tool, Vector, World, WorldError,
    WorldField, WorldPart,
};

/// A body of another engine that tools may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineBody {
    /// Its name, in messages.
    pub name: String,
    /// What tools touch of it.
    pub shapes: Vec<PlacedShape>,
    /// The law of its contacts with every tool.
    pub law: ContactLaw,
}

/// A shape that is fixed to a body.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// The shape, in its own axes.
    pub shape: Shape,
    /// Where the shape is, in the axes of the body, from the body's reference point `[m]`.
    pub position: Vector,
    /// How the shape's axes are turned against the body's.
    pub orientation: Quaternion,
}

/// How an engine steps under a constant force. It decides where a body is after a step, against where the force would
/// have brought it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stepping {
    /// x += h (v + v')/2: exact for a constant force, as Runge-Kutta's and the midpoint rule are.
    #[default]
    MeanVelocity,
    /// x += h v', v' the velocity after the step: semi-implicit Euler, as most engines do.
    EndVelocity,
    /// The same in so many equal parts of the step, at least 1: engines that divide a step by themselves, as Rapier and
    /// Box2D do.
    Parts(u32),
}

/// A body of an engine at the beginning of a step. Everything is along the world's axes; its reference point is where
/// the engine takes torques about, as a rule the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyNow {
    /// Position of the reference point `[m]`.
    pub position: Vector,
    /// How the body is turned.
    pub orientation: Quaternion,
    /// Velocity of the reference point `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity `[rad/s]`.
    pub angular_velocity: Vector,
    /// Acceleration of the reference point by everything but the tools, over the step `[m/s^2]`.
    pub acceleration: Vector,
    /// Angular acceleration by everything but the tools `[rad/s^2]`.
    pub angular_acceleration: Vector,
    /// What a wrench does to these six: rows are accelerations, columns force `[N]` and torque about the reference
    /// point `[N m]`. Of a body on a hinge it has rank 1; of a body that does not move it is zero.
    pub mobility: [[f64; 6]; 6],
}

impl BodyNow {
    /// A body that is at rest at `position` `[m]`, not turned, and that nothing moves.
    #[must_use]
    pub fn fixed(position: Vector) -> Self {
        Self {
            position,
            orientation: crate::NOT_TURNED,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            acceleration: [0.0; 3],
            angular_acceleration: [0.0; 3],
            mobility: [[0.0; 6]; 6],
        }
    }

    /// Velocity `[m/s]` and angular velocity `[rad/s]`.
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

/// A wrench on a body, along the world's axes, to be held over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyWrench {
    /// Force `[N]`.
    pub force: Vector,
    /// Torque about the body's reference point `[N m]`.
    pub torque: Vector,
}

impl EngineBody {
    /// Everything that is wrong with the body of this number, by the rules of a [`World`].
    pub(super) fn faults(&self, number: usize, tools: &[Tool]) -> Vec<WorldError> {
        let place = WorldPart::Body(number);
        let subject = format!("body {:?}", self.name);
        if self.shapes.is_empty() {
            let message = "it has no shape that a tool could touch";
            return vec![WorldError::new(place, WorldField::Shape, subject, message)];
        }
        let mut faults = Vec::new();
        for placed in &self.shapes {
            let body = Body::new(&self.name, placed.shape.clone(), Motion::Fixed)
                .at(placed.position)
                .turned(placed.orientation);
            let alone = World {
                joints: Vec::new(),
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

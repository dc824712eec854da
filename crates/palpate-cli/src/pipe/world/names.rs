//! Names of the tools and bodies of a world in messages.

use palpate_study::text::digits;
use palpate_world::{ContactState, Side, World};

/// The names of a world's tools and bodies.
#[derive(Clone, Debug)]
pub struct Names {
    tools: Vec<String>,
    bodies: Vec<String>,
}

impl Names {
    /// Returns the names of `world`.
    #[must_use]
    pub fn new(world: &World) -> Self {
        Self {
            tools: world.tools.iter().map(|tool| tool.name.clone()).collect(),
            bodies: world.bodies.iter().map(|body| body.name.clone()).collect(),
        }
    }

    fn side(&self, side: Side) -> &str {
        match side {
            Side::Tool(number) => &self.tools[number],
            Side::Body(number) => &self.bodies[number],
        }
    }

    /// Describes a tool or body inside a mesh.
    #[must_use]
    pub fn inside(&self, between: [Side; 2]) -> String {
        let [one, mesh] = between.map(|side| self.side(side));
        format!(
            "\"{one}\" starts inside \"{mesh}\"; no contact force acts on it until it is outside"
        )
    }

    /// Describes a tool or body that has come out of the far side of a solid.
    #[must_use]
    pub fn through(&self, between: [Side; 2]) -> String {
        let [one, solid] = between.map(|side| self.side(side));
        format!("\"{one}\" went through \"{solid}\" and is pushed out of its far side")
    }

    /// Describes an overlap.
    #[must_use]
    pub fn overlap(&self, contact: &ContactState) -> String {
        let [one, other] = contact.between.map(|side| self.side(side));
        format!(
            "\"{one}\" and \"{other}\" overlap by {} m",
            digits(contact.penetration)
        )
    }
}

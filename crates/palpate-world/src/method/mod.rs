//! The methods by which a world can be rendered.
//!
//! A method brings the world to a sample, says which forces follow, and keeps its books. A method is a file of this
//! folder.

mod basic;

pub use basic::BasicParams;

use crate::state::WorldState;
use crate::{Effort, Limited, Place, Vector, WorldError, WorldRenderer};
use basic::{Basic, BasicMemory};

/// A method, with its parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum WorldMethod {
    /// The spring force at the sample, for comparison.
    Basic(BasicParams),
}

impl WorldMethod {
    /// Short name, as scene files spell it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Basic(_) => "basic",
        }
    }

    pub(crate) fn check(self, tools: usize) -> Result<Checked, Vec<WorldError>> {
        match self {
            Self::Basic(params) => params.check(tools).map(Checked::Basic),
        }
    }
}

impl From<BasicParams> for WorldMethod {
    fn from(params: BasicParams) -> Self {
        Self::Basic(params)
    }
}

/// A method with checked parameters.
#[derive(Clone, Debug)]
pub(crate) enum Checked {
    Basic(Basic),
}

/// What a method remembers.
#[derive(Clone, Debug)]
pub(crate) enum Memory {
    Basic(BasicMemory),
}

impl Checked {
    pub fn memory(&self, renderer: &WorldRenderer) -> Memory {
        match self {
            Self::Basic(_) => Memory::Basic(BasicMemory::new(renderer.tools)),
        }
    }

    /// A first sample, or the first that can be used again: the devices are at `positions` `[m]`, at rest.
    pub fn begin(&self, renderer: &WorldRenderer, state: &mut WorldState, positions: &[Vector]) {
        match self {
            Self::Basic(_) => Basic::begin(renderer, state, positions),
        }
    }

    /// Brings the world through an interval of `elapsed` `[s]` that ends with the devices at `positions` `[m]`.
    pub fn conclude(
        &self,
        renderer: &WorldRenderer,
        state: &mut WorldState,
        positions: &[Vector],
        elapsed: f64,
        limited: &mut Limited,
    ) -> Effort {
        let _ = limited;
        match self {
            Self::Basic(_) => Basic::conclude(renderer, state, positions, elapsed),
        }
    }

    /// Says which force follows on each tool.
    pub fn plan(&self, renderer: &WorldRenderer, state: &mut WorldState) -> Effort {
        match self {
            Self::Basic(basic) => basic.plan(renderer, state),
        }
    }

    /// The forces of a sample are sent.
    pub fn sent(&self, state: &mut WorldState) {
        let Memory::Basic(memory) = &mut state.memory;
        memory.sent(&state.forces);
    }

    /// A sample could not be used: the devices are lost.
    pub fn lose(&self, state: &mut WorldState) {
        let _ = state;
    }

    /// Writes what it knows of the tools.
    pub fn publish(&self, state: &mut WorldState) {
        for (tool, part) in state.tools.iter_mut().zip(&state.now.parts) {
            let position: Vector = part.rigid.position.into();
            let velocity: Vector = part.drive.apparent_velocity.into();
            tool.position = position;
            tool.avatar_position = position;
            tool.velocity = velocity;
            tool.avatar_velocity = velocity;
        }
    }
}

/// One number for each tool, or none.
pub(crate) fn one_per_tool(
    field: &'static str,
    given: usize,
    tools: usize,
) -> Result<(), WorldError> {
    if given == 0 || given == tools {
        return Ok(());
    }
    Err(WorldError::new(
        Place::Method,
        field,
        "the method",
        format!("{field} has {given} entries for {tools} tools; give one for each, or none"),
    ))
}

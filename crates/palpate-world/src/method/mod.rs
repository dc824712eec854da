//! Rendering methods for worlds.
//!
//! A method advances the world to a sample, computes the next forces and keeps the energy ledger. Each method has a
//! file in this folder.

mod basic;
pub(crate) mod change;
pub(crate) mod coupled;
mod coupled_impulse;
mod coupled_ledger;
mod coupled_motions;
mod coupled_params;
pub(crate) mod coupled_proxy;
mod coupled_turning;
pub(crate) mod far_side;
mod god_object;
mod god_object_proxy;
mod hfcr;
mod initial;
mod lines;
pub(crate) mod renderer;
mod sampled;
pub(crate) mod state;
mod virtual_coupling;

pub use basic::BasicParams;
pub use coupled_params::CoupledParams;
pub use god_object::GodObjectParams;
pub use hfcr::HfcrParams;
pub use sampled::{PopcParams, SehParams};
pub use virtual_coupling::VirtualCouplingParams;

use crate::geometry::rigid::Vector3;
use crate::integration::held_tools::HeldTools;
use crate::method::state::Progress;
use crate::{
    Effort, Field, Limited, Tool, Vector, WorldError, WorldErrors, WorldField, WorldPart,
    WorldRenderer,
};
use basic::Basic;
use coupled::{Coupled, CoupledMemory};
use god_object::{GodObject, GodObjectMemory};
use hfcr::{Hfcr, HfcrMemory};
use sampled::{Sampled, SampledMemory};
use virtual_coupling::{VirtualCoupling, VirtualCouplingMemory};

/// A rendering method with its parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum WorldMethod {
    /// Spring force at the sample, for comparison.
    Basic(BasicParams),
    /// Spring and damper between each device and a proxy with mass, for comparison.
    VirtualCoupling(VirtualCouplingParams),
    /// Spring and damper between each device and a proxy that stays on the surface, for comparison.
    GodObject(GodObjectParams),
    /// Estimate of the mean of the spring force over the coming interval, for comparison.
    Seh(SehParams),
    /// Spring force with a passivity observer and controller at each port, for comparison.
    Popc(PopcParams),
    /// Force whose work along the predicted step of each device is the change of the contacts' energy.
    Hfcr(HfcrParams),
    /// Prediction of devices and world together; the mean force is held.
    Coupled(CoupledParams),
}

impl WorldMethod {
    /// Returns the short name used in scene files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Basic(params) => params.name(),
            Self::VirtualCoupling(_) => "virtual-coupling",
            Self::GodObject(_) => "god-object",
            Self::Seh(_) => "seh",
            Self::Popc(params) => params.name(),
            Self::Hfcr(params) => params.name(),
            Self::Coupled(_) => "coupled",
        }
    }

    /// Checks whether the method renders a world with these force fields.
    ///
    /// # Errors
    /// There are fields, and the method renders none.
    pub fn can_render(&self, fields: &[Field]) -> Result<(), WorldError> {
        if fields.is_empty() || matches!(self, Self::Basic(_) | Self::Coupled(_)) {
            return Ok(());
        }
        let message = format!(
            "{} renders no force fields, and the world has {}; use coupled, basic or virtual-damper, or remove the \
             fields",
            self.name(),
            fields.len()
        );
        Err(WorldError::new(
            WorldPart::Method,
            WorldField::Method,
            "the method",
            message,
        ))
    }

    pub(crate) fn check(self, tools: &[Tool], fields: &[Field]) -> Result<Checked, WorldErrors> {
        self.can_render(fields)?;
        match self {
            Self::Basic(params) => params.check(tools.len()).map(Checked::Basic),
            Self::VirtualCoupling(params) => params.check(tools).map(Checked::VirtualCoupling),
            Self::GodObject(params) => params.check(tools).map(Checked::GodObject),
            Self::Seh(_) => Ok(Checked::Sampled(Sampled::Estimated)),
            Self::Popc(params) => params.check(tools).map(Checked::Sampled),
            Self::Hfcr(params) => params.check(tools.len()).map(Checked::Hfcr),
            Self::Coupled(params) => params.check(tools).map(Checked::Coupled),
        }
    }
}

impl From<BasicParams> for WorldMethod {
    fn from(params: BasicParams) -> Self {
        Self::Basic(params)
    }
}

impl From<VirtualCouplingParams> for WorldMethod {
    fn from(params: VirtualCouplingParams) -> Self {
        Self::VirtualCoupling(params)
    }
}

impl From<GodObjectParams> for WorldMethod {
    fn from(params: GodObjectParams) -> Self {
        Self::GodObject(params)
    }
}

impl From<SehParams> for WorldMethod {
    fn from(params: SehParams) -> Self {
        Self::Seh(params)
    }
}

impl From<PopcParams> for WorldMethod {
    fn from(params: PopcParams) -> Self {
        Self::Popc(params)
    }
}

impl From<HfcrParams> for WorldMethod {
    fn from(params: HfcrParams) -> Self {
        Self::Hfcr(params)
    }
}

impl From<CoupledParams> for WorldMethod {
    fn from(params: CoupledParams) -> Self {
        Self::Coupled(params)
    }
}

/// A method with checked parameters.
#[derive(Clone, Debug)]
pub(crate) enum Checked {
    Basic(Basic),
    VirtualCoupling(VirtualCoupling),
    GodObject(GodObject),
    Sampled(Sampled),
    Hfcr(Hfcr),
    Coupled(Coupled),
}

/// State of a method. It is valid only for the renderer that created it.
#[derive(Clone, Debug)]
pub(crate) enum Memory {
    Basic,
    VirtualCoupling(VirtualCouplingMemory),
    GodObject(GodObjectMemory),
    Sampled(SampledMemory),
    Hfcr(HfcrMemory),
    Coupled(CoupledMemory),
}

impl Checked {
    /// Returns the initial inverse moments of inertia of a tool that contacts turn `[1/(kg m^2)]`.
    pub fn angular_mobility(&self, tool: usize) -> Vector3 {
        match self {
            Self::Basic(_) | Self::GodObject(_) | Self::Sampled(_) | Self::Hfcr(_) => {
                Vector3::zeros()
            }
            Self::VirtualCoupling(coupling) => coupling.angular_mobility(tool),
            Self::Coupled(coupled) => coupled.turning_priors[tool]
                .filter(|prior| !prior.led)
                .map_or(Vector3::zeros(), |prior| prior.moments.map(f64::recip)),
        }
    }

    /// Returns whether the method itself sets the force that a tool's contact holds over an interval.
    pub fn holds_contacts(&self) -> bool {
        matches!(self, Self::GodObject(_))
    }

    /// Returns whether the contacts yield to a force limit.
    pub fn yields_to_limits(&self) -> bool {
        matches!(self, Self::Coupled(_))
    }

    /// Returns the state of tools that each contact holds at its own place, empty for other methods.
    pub fn held_tools(&self, renderer: &WorldRenderer) -> HeldTools {
        match self {
            Self::Hfcr(hfcr) => hfcr.held_tools(renderer),
            _ => HeldTools::default(),
        }
    }

    pub fn memory(&self, renderer: &WorldRenderer) -> Memory {
        match self {
            Self::Basic(_) => Memory::Basic,
            Self::VirtualCoupling(_) => {
                Memory::VirtualCoupling(VirtualCouplingMemory::new(renderer.tools))
            }
            Self::GodObject(_) => {
                let points = renderer.tool_points;
                Memory::GodObject(GodObjectMemory::new(renderer.tools, points))
            }
            Self::Sampled(_) => Memory::Sampled(SampledMemory::new(renderer.tools)),
            Self::Hfcr(_) => Memory::Hfcr(HfcrMemory::new(renderer.tool_points)),
            Self::Coupled(coupled) => {
                Memory::Coupled(CoupledMemory::new(coupled, renderer.loop_params().period))
            }
        }
    }

    /// Processes a first sample, or the first usable one after a fault: the devices are at `positions` `[m]`, at
    /// rest.
    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut Memory,
        positions: &[Vector],
    ) {
        match (self, memory) {
            (Self::Coupled(coupled), Memory::Coupled(memory)) => {
                coupled.begin(renderer, state, memory, positions);
            }
            (Self::VirtualCoupling(coupling), Memory::VirtualCoupling(memory)) => {
                coupling.begin(renderer, state, memory, positions);
            }
            (Self::GodObject(god_object), Memory::GodObject(memory)) => {
                god_object.begin(renderer, state, memory, positions);
            }
            (_, memory) => {
                if let Memory::Sampled(memory) = memory {
                    memory.begin();
                }
                Basic::begin(renderer, state, positions);
            }
        }
    }

    /// Advances the world through an interval of `elapsed` `[s]` that ends with the devices at `positions` `[m]`.
    pub fn conclude(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut Memory,
        positions: &[Vector],
        elapsed: f64,
        limited: &mut Limited,
    ) -> Effort {
        match (self, memory) {
            (Self::Coupled(coupled), Memory::Coupled(memory)) => {
                coupled.conclude(renderer, state, memory, positions, elapsed, limited)
            }
            (Self::VirtualCoupling(coupling), Memory::VirtualCoupling(memory)) => {
                coupling.conclude(renderer, state, memory, positions, elapsed)
            }
            (Self::GodObject(god_object), Memory::GodObject(memory)) => {
                god_object.conclude(renderer, state, memory, positions, elapsed)
            }
            (Self::Hfcr(_), Memory::Hfcr(memory)) => {
                Hfcr::conclude(renderer, state, memory, positions, elapsed)
            }
            _ => Basic::conclude(renderer, state, positions, elapsed),
        }
    }

    /// Computes the next force on each tool.
    pub fn plan(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut Memory,
    ) -> Effort {
        match (self, memory) {
            (Self::Coupled(coupled), Memory::Coupled(memory)) => {
                coupled.plan(renderer, state, memory)
            }
            (Self::VirtualCoupling(coupling), Memory::VirtualCoupling(memory)) => {
                coupling.plan(renderer, state, memory)
            }
            (Self::GodObject(god_object), Memory::GodObject(memory)) => {
                god_object.plan(state, memory)
            }
            (Self::Sampled(sampled), Memory::Sampled(memory)) => {
                sampled.plan(renderer, state, memory)
            }
            (Self::Hfcr(hfcr), Memory::Hfcr(memory)) => hfcr.plan(renderer, state, memory),
            (Self::Basic(basic), _) => basic.plan(renderer, state),
            // The state belongs to another renderer.
            _ => Effort::default(),
        }
    }
}

impl Memory {
    /// Continues from the state of the same method in another world. `points` maps this world's contact points to the
    /// previous indices. It does not allocate.
    pub fn goes_on_from(&mut self, before: &Self, points: &[Option<usize>]) {
        match (self, before) {
            (Self::VirtualCoupling(memory), Self::VirtualCoupling(before)) => {
                memory.copy_from(before);
            }
            (Self::GodObject(memory), Self::GodObject(before)) => {
                memory.goes_on_from(before, points);
            }
            (Self::Sampled(memory), Self::Sampled(before)) => memory.copy_from(before),
            (Self::Hfcr(memory), Self::Hfcr(before)) => memory.goes_on_from(before, points),
            (Self::Coupled(memory), Self::Coupled(before)) => memory.copy_from(before),
            _ => {}
        }
    }

    /// Writes the method's estimate of the tools.
    pub fn publish(&self, state: &mut Progress) {
        match self {
            Self::Basic | Self::Sampled(_) | Self::Hfcr(_) => Basic::publish(state),
            Self::VirtualCoupling(memory) => memory.publish(state),
            Self::GodObject(memory) => memory.publish(state),
            Self::Coupled(memory) => memory.publish(state),
        }
    }
}

/// Checks that a list has one number per tool or is empty.
pub(crate) fn one_per_tool(
    field: WorldField,
    given: usize,
    tools: usize,
) -> Result<(), WorldError> {
    if given == 0 || given == tools {
        return Ok(());
    }
    Err(WorldError::new(
        WorldPart::Method,
        field,
        "the method",
        format!("{field} has {given} entries for {tools} tools; give one for each, or none"),
    ))
}

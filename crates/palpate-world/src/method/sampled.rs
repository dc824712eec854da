//! Methods that correct the force of basic rendering: sample-estimate-hold, and passivity observers and controllers.

use palpate_core::Range;

use crate::contact::pairs::Point;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::integration::moving::Moving;
use crate::method::basic::Basic;
use crate::method::state::Progress;
use crate::{Effort, Tool, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer};

/// Parameters of sample-estimate-hold (Ellis, Sarkar, Jenkins 1997).
///
/// The held force estimates the mean of the coming interval from the forces f of basic rendering at the last two
/// samples: (3 f_i - f_(i-1))/2, and zero while nothing touches the tool. The same formula gives the torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SehParams;

/// Parameters of a passivity observer and controller (Hannaford and Ryu 2002) at the port of each device.
///
/// While the tool touches something, a damper along its velocity v removes the excess energy d within one period: the
/// force is that of basic rendering minus alpha v, with alpha = d/(T v^2). The controller does not act on torques.
#[derive(Clone, Debug, PartialEq)]
pub struct PopcParams {
    /// Maximum alpha of each tool, above 0 `[N s/m]`.
    pub damping_cap: Vec<f64>,
    /// Speed up to which no damping is injected, at least 0 `[m/s]`.
    pub speed_threshold: f64,
    /// Energy that each device may give out before the controller acts, at least 0 `[J]`. Not used with a reference.
    pub initial_energy: f64,
    /// Whether the excess is that over the energy that the contacts have given the tool (`popc-ref`), in place of all
    /// energy given out (`popc`).
    pub follows_reference: bool,
}

impl PopcParams {
    /// Creates a controller with these caps `[N s/m]`, which acts above 0.1 mm/s.
    #[must_use]
    pub fn new(damping_cap: Vec<f64>) -> Self {
        Self {
            damping_cap,
            speed_threshold: 1e-4,
            initial_energy: 0.0,
            follows_reference: false,
        }
    }

    /// Returns the controller that follows the reference energy.
    #[must_use]
    pub fn following_reference(self) -> Self {
        Self {
            follows_reference: true,
            ..self
        }
    }

    pub(super) fn name(&self) -> &'static str {
        if self.follows_reference {
            "popc-ref"
        } else {
            "popc"
        }
    }

    pub(super) fn check(self, tools: &[Tool]) -> Result<Sampled, WorldErrors> {
        let mut faults = Vec::new();
        let cap = WorldField::DampingCap;
        let (given, wanted) = (self.damping_cap.len(), tools.len());
        if given != wanted {
            let message =
                format!("{cap} has {given} entries for {wanted} tools; give one for each");
            faults.push(WorldError::new(
                WorldPart::Method,
                cap,
                "the method",
                message,
            ));
        }
        let caps = self.damping_cap.iter();
        let caps = caps.map(|value| (cap, *value, Range::Positive));
        let others = [
            (WorldField::SpeedThreshold, self.speed_threshold),
            (WorldField::InitialEnergy, self.initial_energy),
        ];
        let others = others.map(|(field, value)| (field, value, Range::NotNegative));
        for (field, value, range) in caps.chain(others) {
            if let Some(message) = out_of_range(field, value, range) {
                let part = WorldPart::Method;
                faults.push(WorldError::new(part, field, "the method", message));
            }
        }
        WorldErrors::check(faults)?;
        Ok(Sampled::Observed(self))
    }
}

/// A correction of basic rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) enum Sampled {
    Estimated,
    Observed(PopcParams),
}

/// Force and torque of basic rendering on each tool at the last sample.
#[derive(Clone, Debug)]
pub(crate) struct SampledMemory {
    before: Vec<[Vector3; 2]>,
}

impl SampledMemory {
    pub fn new(tools: usize) -> Self {
        Self {
            before: vec![[Vector3::zeros(); 2]; tools],
        }
    }

    /// Copies the state of `other`, which has the same number of tools.
    pub fn copy_from(&mut self, other: &Self) {
        self.before.copy_from_slice(&other.before);
    }

    /// Forgets the last sample.
    pub fn begin(&mut self) {
        self.before.fill([Vector3::zeros(); 2]);
    }
}

impl Sampled {
    pub fn plan(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut SampledMemory,
    ) -> Effort {
        let effort = Basic::undamped().plan(renderer, state);
        for (tool, before) in memory.before.iter_mut().enumerate() {
            let [last_force, last_torque] = *before;
            let (force, torque) = (state.intended[tool], state.intended_torques[tool]);
            *before = [force, torque];
            if !is_touched(&state.now, &renderer.points, tool) {
                continue;
            }
            match self {
                Self::Estimated => {
                    state.intended[tool] = force * 1.5 - last_force * 0.5;
                    state.intended_torques[tool] = torque * 1.5 - last_torque * 0.5;
                }
                Self::Observed(params) => {
                    let velocity = state.now.parts[tool].drive.apparent_velocity;
                    let excess = params.excess(renderer, state, tool);
                    let period = renderer.loop_params.period;
                    let damping = params.damping(tool, excess, &velocity, period);
                    state.intended[tool] -= state.commands.for_force(&(velocity * damping));
                }
            }
        }
        effort
    }
}

impl PopcParams {
    /// Returns the excess energy that a device has been given `[J]`.
    fn excess(&self, renderer: &WorldRenderer, state: &Progress, tool: usize) -> f64 {
        let device = &state.ledger.devices[tool];
        let given = device.port_work + device.carried;
        if !self.follows_reference {
            return given - self.initial_energy;
        }
        let points = &renderer.points[..renderer.tool_points];
        let contacts = state.ledger.contacts.iter().zip(points);
        let contacts = contacts.filter(|(_, point)| point.sign_on(tool).is_some());
        given + contacts.map(|(entry, _)| entry.created()).sum::<f64>()
    }

    /// Returns the injected damping of a tool `[N s/m]`.
    fn damping(&self, tool: usize, excess: f64, velocity: &Vector3, period: f64) -> f64 {
        let square = velocity.norm_squared();
        let is_still = square <= self.speed_threshold * self.speed_threshold;
        match self.damping_cap.get(tool) {
            Some(cap) if excess > 0.0 && !is_still => cap.min(excess / (period * square)),
            _ => 0.0,
        }
    }
}

/// Returns whether a contact touches a tool.
fn is_touched(moving: &Moving, points: &[Point], tool: usize) -> bool {
    let mut numbers = moving.nearby.recent().iter();
    numbers
        .any(|&number| points[number].sign_on(tool).is_some() && !moving.touches[number].is_apart())
}

//! Local model of a low-rate simulator for a caller-owned loop: it renders the model and limits the forces by the
//! safety of each device.
//!
//! The caller-owned loop reads positions and sends wrenches itself, as with [`BoundedWorld`](crate::BoundedWorld).

use palpate_device::Wrench;
use palpate_world::engine::local::{LocalRenderer, LocalState, ModelRefusal};
use palpate_world::{Effort, Limited, Sample, WorldFault};

use crate::bounded_world::{Answered, WorldSafety};
use crate::rendering::{FromHost, LowRateSimulator, sides};
use crate::safety::{Bounded, SafetyError, SafetyParams, SafetyStop};

/// Renderer of the models published by a low-rate simulator, for any number of tools, with the safety limits of each
/// device.
#[derive(Debug)]
pub struct BoundedLocalWorld {
    renderer: LocalRenderer,
    state: LocalState,
    host: FromHost,
    safety: WorldSafety,
    /// Wrench to hold, for each tool.
    wrenches: Vec<Wrench>,
}

/// Result of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldLocal<'a> {
    /// Wrench on the hand that each device holds until the next sample, always finite. The torque is 0.
    pub wrenches: &'a [Wrench],
    /// Active limits of the renderer.
    pub limited: Limited,
    /// Active limits of the safety.
    pub bounded: Bounded,
    /// Computing effort of the tick and work left undone.
    pub effort: Effort,
    /// Reason for rejecting the sample, if any. All wrenches are then zero.
    pub fault: Option<WorldFault>,
    /// Age of the newest model `[s]`; `None` without a model.
    pub age: Option<f64>,
    /// Whether contact forces are fading or faded, because the model is missing or too old.
    pub is_stale: bool,
    /// Reason for rejecting the model that arrived with this sample, if any. The previous model stays in use.
    pub refusal: Option<ModelRefusal>,
}

/// Creates both ends of a local model: that of the simulator and that of a caller-owned loop, with the same limits
/// for each device. Each end may be used on its own thread.
///
/// # Errors
/// The name and the allowed range of the first limit outside its range.
pub fn bounded_local_world(
    renderer: LocalRenderer,
    limits: SafetyParams,
) -> Result<(LowRateSimulator, BoundedLocalWorld), SafetyError> {
    let state = renderer.start();
    let tools = state.tools().len();
    let loop_params = renderer.loop_params();
    let safety =
        WorldSafety::new(tools, limits, loop_params.period)?.rendering(&loop_params.actuation);
    let (host, from_host) = sides(&renderer);
    let world = BoundedLocalWorld {
        host: from_host,
        safety,
        wrenches: vec![Wrench::NONE; tools],
        state,
        renderer,
    };
    Ok((host, world))
}

impl BoundedLocalWorld {
    /// Performs one tick: takes a sample of all tools and returns the wrench that each device must hold, by the
    /// newest model. It does not allocate, lock or block. The renderer's energy ledger contains the wrenches after
    /// all limits.
    pub fn step(&mut self, sample: &Sample<'_>) -> HeldLocal<'_> {
        let output = self
            .renderer
            .step(&mut self.state, sample, self.host.newest());
        let (limited, effort, fault) = (output.limited, output.effort, output.fault);
        let (age, is_stale, refusal) = (output.age, output.is_stale, output.refusal);
        for (wrench, &force) in self.wrenches.iter_mut().zip(output.forces) {
            *wrench = Wrench {
                force,
                torque: [0.0; 3],
            };
        }
        let answered = Answered {
            elapsed: sample.elapsed,
            positions: sample.positions,
            refused: fault.is_some(),
            created_energy: self.state.created_at_ports(),
        };
        let bounded = self.safety.bound(&answered, &mut self.wrenches);
        self.host.tell(self.state.progress());
        for (tool, wrench) in self.wrenches.iter().enumerate() {
            let state = &mut self.state;
            self.renderer.report_sent(state, tool, wrench.force);
        }
        HeldLocal {
            wrenches: &self.wrenches,
            limited,
            bounded,
            effort,
            fault,
            age,
            is_stale,
            refusal,
        }
    }

    /// Returns the safety stop that holds all forces at 0, if any.
    #[must_use]
    pub fn safety_stop(&self) -> Option<SafetyStop> {
        self.safety.safety_stop()
    }

    /// Replaces the wrench of the last sample by the one actually sent to a device, for example after saturation.
    pub fn report_sent(&mut self, tool: usize, sent: Wrench) {
        self.renderer.report_sent(&mut self.state, tool, sent.force);
    }

    /// Returns the local model at the last sample.
    #[must_use]
    pub fn state(&self) -> &LocalState {
        &self.state
    }

    /// Returns the renderer.
    #[must_use]
    pub fn renderer(&self) -> &LocalRenderer {
        &self.renderer
    }

    /// Returns the limits of each device.
    #[must_use]
    pub fn limits(&self) -> &SafetyParams {
        self.safety.params()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_world::engine::local::{LocalContact, LocalParams};
    use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, WorldLoop};

    const PERIOD: f64 = 1e-3;

    /// A sphere of 5 mm that touches the published bodies, and a floor whose surface is at 0.
    fn ends(limits: SafetyParams) -> (LowRateSimulator, BoundedLocalWorld, LocalContact) {
        let tool = Tool::new("tool", Shape::Sphere { radius: 5e-3 });
        let renderer = LocalRenderer::new(
            &[tool],
            LocalParams::new(0, 1),
            WorldLoop::new(PERIOD),
            CoupledParams::new(vec![[0.1; 3]]),
        );
        let (host, world) =
            bounded_local_world(renderer.expect("right"), limits).expect("limits in their range");
        let law = ContactLaw::spring(1000.0);
        let floor = LocalContact::of_tool(0, None, [0.0; 3], [0.0, 0.0, 1.0], law);
        (host, world, floor)
    }

    fn held(world: &mut BoundedLocalWorld, depth: f64) -> HeldLocal<'_> {
        world.step(&Sample::at(&[[0.0, 0.0, 5e-3 - depth]]))
    }

    #[test]
    fn a_floor_of_the_host_holds_within_the_limits_and_fades_when_the_host_is_gone() {
        let (mut host, mut world, floor) = ends(SafetyParams {
            largest_force: 2.0,
            soft_start: 0.0,
            ..SafetyParams::default()
        });
        let first = held(&mut world, 1e-3);
        assert!(first.is_stale && first.age.is_none());
        assert_eq!(first.wrenches, [Wrench::NONE]);
        // Longer than the maximum age of a model.
        for _ in 0..400 {
            let tick = host.progress().tick;
            host.publish(tick, &[], &[Some(floor)]).expect("right");
            held(&mut world, 1e-3);
        }
        let answer = held(&mut world, 1e-3);
        assert!(!answer.is_stale && answer.refusal.is_none() && answer.fault.is_none());
        assert_eq!(answer.age, Some(2.0 * PERIOD));
        let force = answer.wrenches[0].force[2];
        assert!((force - 1.0).abs() < 0.05, "{force}");
        let answer = held(&mut world, 5e-3);
        assert_eq!(answer.wrenches[0].force[2], 2.0);
        assert!(answer.bounded.force || answer.limited.force);
        for _ in 0..400 {
            held(&mut world, 1e-3);
        }
        let answer = held(&mut world, 1e-3);
        assert!(answer.is_stale);
        assert_eq!(answer.wrenches[0].force, [0.0; 3]);
        assert!(host.progress().is_stale);
    }

    #[test]
    fn a_force_comes_in_softly_and_a_sample_that_is_refused_gets_none() {
        let (mut host, mut world, floor) = ends(SafetyParams {
            soft_start: 20.0 * PERIOD,
            ..SafetyParams::default()
        });
        let tick = host.progress().tick;
        host.publish(tick, &[], &[Some(floor)]).expect("right");
        let answer = held(&mut world, 1e-3);
        assert!(answer.bounded.soft_start && answer.wrenches[0].force[2] < 0.2);
        for _ in 0..150 {
            held(&mut world, 1e-3);
        }
        assert!(held(&mut world, 1e-3).wrenches[0].force[2] > 0.9);
        let refused = held(&mut world, f64::NAN);
        assert!(refused.fault.is_some());
        assert_eq!(refused.wrenches, [Wrench::NONE]);
        assert!(held(&mut world, 1e-3).wrenches[0].force[2] < 0.2);
    }
}

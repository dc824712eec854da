//! One contact with its state and its safety, for `Renderer` and `Renderers`.

use palpate_core::{
    AnyMemory, AnyRenderer, Leak, LoopParams, ObjectState, Output, Rendering, Sample, State,
};
use palpate_device::Wrench;
use palpate_rt::safety::{self, Safety, SafetyParams};
use palpate_study::sim::replay::ReplaySetup;
use pyo3::prelude::*;

use crate::names::{refused, wrong_argument};

/// A contact, its state and its safety.
#[derive(Clone)]
pub struct Contact {
    pub renderer: AnyRenderer<f64>,
    pub now: Now,
    start: Now,
    virtual_force: f64,
}

/// State of a contact: renderer, safety and the result of the last sample.
#[derive(Clone)]
pub struct Now {
    state: State<f64, AnyMemory<f64>>,
    safety: Safety,
    pub last: Option<Answer>,
}

/// Result of a sample.
#[derive(Clone, Copy)]
pub struct Answer {
    pub output: Output<f64>,
    /// Force to command, after the soft start `[N]`.
    pub force_on_device: f64,
    /// Its slope `[N/s]`.
    pub slope_on_device: f64,
    pub softened: bool,
    /// Whether generated energy has caused a safety stop.
    pub stopped: bool,
}

impl Contact {
    /// Creates a contact in its initial state.
    pub fn new(setup: &ReplaySetup, rendering: &Rendering<f64>, soft_start: f64) -> PyResult<Self> {
        let renderer = rendering
            .renderer()
            .map_err(|error| wrong_argument(&error))?;
        let state = renderer
            .start(setup.object)
            .map_err(|error| wrong_argument(&error))?;
        let start = Now {
            state,
            safety: safety_of(setup, soft_start)?,
            last: None,
        };
        Ok(Self {
            renderer,
            now: start.clone(),
            start,
            virtual_force: setup.virtual_force,
        })
    }

    /// Resets the state: the object at its start, no sample, an empty energy ledger.
    pub fn reset(&mut self) {
        self.now = self.start.clone();
    }

    /// Executes one tick: returns the force on the device for a position. `force` replaces the virtual force.
    pub fn step(&mut self, position: f64, elapsed: Option<f64>, force: Option<f64>) -> f64 {
        let sample = Sample {
            elapsed,
            ..Sample::at(position).with_virtual_force(force.unwrap_or(self.virtual_force))
        };
        let Now {
            state,
            safety,
            last,
        } = &mut self.now;
        let mut output = self.renderer.step(state, sample);
        let is_used = output.fault.is_none();
        // The renderer has rejected the position, so the safety layer must not use it.
        let coordinate = if is_used { position } else { 0.0 };
        let verdict = safety.evaluate(&safety::Rendered {
            elapsed,
            position: [coordinate, 0.0, 0.0],
            coordinate,
            wrench: Wrench::of_force([output.force_on_device, 0.0, 0.0]),
            slope: [output.slope_on_device, 0.0, 0.0],
            created_energy: state.ledger().created(),
            refused: !is_used,
            stalled: false,
        });
        output.limited.force |= verdict.bounded.force;
        output.limited.slew |= verdict.bounded.slew;
        let [force_on_device, ..] = verdict.wrench.force;
        // Adding 0.0 normalises -0.0, which the soft start produces.
        let force_on_device = force_on_device + 0.0;
        let slope_on_device = verdict.slope[0] + 0.0;
        *last = Some(Answer {
            output,
            force_on_device,
            slope_on_device,
            softened: verdict.bounded.soft_start,
            stopped: verdict.bounded.stopped,
        });
        self.report_sent(force_on_device, slope_on_device);
        force_on_device
    }

    /// Reports the force `[N]` and the slope `[N/s]` that were sent to the device for the last sample.
    pub fn report_sent(&mut self, force_on_device: f64, slope_on_device: f64) {
        self.renderer
            .report_sent_line(&mut self.now.state, -force_on_device, -slope_on_device);
    }

    /// Moves the object at the next sample and records the energy in the ledger.
    pub fn teleport(&mut self, object: ObjectState<f64>) -> PyResult<()> {
        self.renderer
            .teleport(&mut self.now.state, object)
            .map_err(|error| wrong_argument(&error))
    }

    /// Returns the energy ledger: stored energy, works and leaks.
    pub fn ledger(&self) -> ([f64; 4], [Leak<f64>; 2]) {
        let ledger = self.now.state.ledger();
        let energies = [
            ledger.stored,
            ledger.port_work,
            ledger.virtual_force_work,
            ledger.outside_work,
        ];
        (energies, [ledger.original_leak, ledger.held_leak])
    }
}

/// Returns the limits of `palpate pipe`: largest force, soft-start time and generated energy.
fn safety_of(setup: &ReplaySetup, soft_start: f64) -> PyResult<Safety> {
    let LoopParams {
        force_limit,
        period,
        ..
    } = setup.loop_params;
    let limits = safety_params(force_limit, None, soft_start)?;
    let known = setup.known_loop();
    let slew_limit = known.slew_limit.unwrap_or(f64::INFINITY);
    let safety = Safety::new(limits, period).map_err(refused)?;
    Ok(safety.rendering(&known.actuation, slew_limit))
}

/// Returns these limits with a torque limit.
pub fn safety_params(
    force_limit: Option<f64>,
    torque_limit: Option<f64>,
    soft_start: f64,
) -> PyResult<SafetyParams> {
    if !(0.0..=60.0).contains(&soft_start) {
        return Err(refused(format!(
            "soft_start is {soft_start} s, but must be 0 to 60"
        )));
    }
    Ok(SafetyParams::bounding(
        force_limit,
        torque_limit,
        soft_start,
    ))
}

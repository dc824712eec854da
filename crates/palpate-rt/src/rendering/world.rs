//! A world in the loop.

use palpate_core::{Actuation, Hold};
use palpate_device::{Line, Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{
    Limited, Sample, Succession, Tool, World, WorldErrors, WorldRenderer, WorldState,
};

use super::frame::WorldFrame;
use super::renders::{Answer, DeviceSamples, Renders};
use super::world_rows::WorldRows;
use crate::created_energy::CreatedEnergy;
use crate::setup::SetupError;

/// Rotation of a tool, and the resulting requirements on its device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turns {
    /// No rotation: any device with three axes is suitable.
    No,
    /// Rotation with torque: the device measures an orientation and gives a torque.
    WithTorque,
    /// Rotation by the hand alone: the device measures an orientation and needs no torque.
    ByHand,
}

impl Turns {
    fn new(tool: &Tool) -> Self {
        match (tool.turns, tool.gives_torque) {
            (false, _) => Self::No,
            (true, true) => Self::WithTorque,
            (true, false) => Self::ByHand,
        }
    }
}

/// A world in the loop: renderer, state, and frame of each device.
#[derive(Clone, Debug)]
pub struct RenderedWorld {
    renderer: WorldRenderer,
    state: WorldState,
    method: &'static str,
    /// Frame of each tool's device, in the order of the tools.
    frames: Vec<WorldFrame>,
    /// Names of the tools.
    names: Vec<String>,
    /// Rotation of each tool.
    turns: Vec<Turns>,
    /// Sampled positions of the tools along the world's axes; scratch buffer of a tick.
    positions: Vec<Vector>,
    orientations: Vec<[f64; 4]>,
    /// Whether the held force acts without delay: the model of the actuator has neither delay nor lag.
    acts_at_once: bool,
    /// Whether the devices hold lines.
    holds_lines: bool,
    /// Whether each device has a line that its driver has not reported.
    is_new: Vec<bool>,
    /// Whether the last reported line of each device ends with a force.
    has_force: Vec<bool>,
    limited: Limited,
    created: CreatedEnergy,
    rows: WorldRows,
}

impl RenderedWorld {
    /// Creates a loop's `world`, which `renderer` renders by the method of that name, with a device at `frame`.
    ///
    /// # Errors
    /// A number of tools other than one; a rotating tool whose frame axes are not those of the world.
    pub fn new(
        world: &World,
        renderer: WorldRenderer,
        method: &'static str,
        frame: WorldFrame,
    ) -> Result<Self, SetupError> {
        Self::of_devices(world, renderer, method, vec![frame])
    }

    /// Creates a loop's `world` with a device for each of its tools, at `frames` in the order of the tools.
    ///
    /// # Errors
    /// No tools, or a number of tools that differs from the number of frames; a rotating tool whose frame axes are
    /// not those of the world.
    pub fn of_devices(
        world: &World,
        renderer: WorldRenderer,
        method: &'static str,
        frames: Vec<WorldFrame>,
    ) -> Result<Self, SetupError> {
        let state = renderer.start();
        let tools = state.tools().len();
        if tools != frames.len() || tools == 0 {
            return Err(SetupError::Devices {
                world: tools,
                given: frames.len(),
            });
        }
        let turns: Vec<_> = world.tools.iter().map(Turns::new).collect();
        let mut placed = turns.iter().zip(&frames);
        if placed.any(|(turns, frame)| *turns != Turns::No && !frame.is_aligned()) {
            return Err(SetupError::TurnedFrame);
        }
        let actuation = renderer.loop_params().actuation;
        Ok(Self {
            acts_at_once: actuation.delay == 0.0 && actuation.lag == 0.0,
            holds_lines: actuation.hold == Hold::Line,
            is_new: vec![false; tools],
            has_force: vec![false; tools],
            method,
            names: world.tools.iter().map(|tool| tool.name.clone()).collect(),
            positions: vec![[0.0; 3]; tools],
            orientations: vec![[f64::NAN; 4]; tools],
            frames,
            turns,
            limited: Limited::default(),
            created: CreatedEnergy::default(),
            rows: WorldRows::new(world, &state),
            state,
            renderer,
        })
    }

    /// Returns the frame of each device in the world.
    #[must_use]
    pub fn frames(&self) -> &[WorldFrame] {
        &self.frames
    }

    /// Returns the rotation of each tool. A rotating tool needs a device that measures six axes.
    #[must_use]
    pub fn turns(&self) -> &[Turns] {
        &self.turns
    }

    /// Prepares to continue from `before` with the kept bodies ([`WorldRenderer::migrate`]).
    pub(super) fn migrate(
        &mut self,
        before: &Self,
        is_kept: &[bool],
    ) -> Result<Succession, WorldErrors> {
        let succession = self.renderer.migrate(&before.renderer, is_kept)?;
        self.state = self.renderer.start();
        Ok(succession)
    }

    /// Continues from `before` between two samples ([`WorldRenderer::resume`]).
    pub(super) fn resume(&mut self, before: &Self, succession: &Succession) {
        let past = (&before.renderer, &before.state);
        self.renderer.resume(&mut self.state, past, succession);
        let recorded = self.state.created_at_ports();
        self.created.resume(&before.created, recorded);
    }

    /// Limits wrenches that replace those of the last step so that the limits of the world's loop and its guard hold
    /// for them.
    pub(super) fn keep_within(&mut self, held: &mut [Wrench]) {
        let limited = self.renderer.keep_within(&self.state, held, |wrench| {
            [&mut wrench.force, &mut wrench.torque]
        });
        self.limited = self.limited.and(limited);
    }

    /// Bounds the slope `[N/s]` of a line whose `mean` `[N]` was kept within the limits of the world's loop.
    pub(super) fn keep_slope_within(&mut self, device: usize, mean: &Vector, slope: &mut Vector) {
        self.limited.force |= self.renderer.keep_slope_within(device, mean, slope);
    }

    /// Reports the line sent to a device or held by it, in the axes of the device, to the renderer.
    fn report(&mut self, device: usize, line: Line) {
        let Some(frame) = self.frames.get(device) else {
            return;
        };
        if let Some(has_force) = self.has_force.get_mut(device) {
            *has_force = line.end().force != [0.0; 3];
        }
        let (mean, slope) = (
            frame.of_device(line.wrench.force),
            frame.of_device(line.slope),
        );
        self.renderer
            .report_sent_line(&mut self.state, device, mean, slope);
        // A device with six axes has those of the world.
        self.renderer
            .report_sent_torque(&mut self.state, device, line.wrench.torque);
    }

    /// Returns the world at the last sample.
    #[must_use]
    pub fn state(&self) -> &WorldState {
        &self.state
    }
}

impl Renders for RenderedWorld {
    fn devices(&self) -> usize {
        self.frames.len()
    }

    fn device_name(&self, device: usize) -> Option<&str> {
        self.names.get(device).map(String::as_str)
    }

    fn period(&self) -> f64 {
        self.renderer.loop_params().period
    }

    fn method(&self) -> &'static str {
        self.method
    }

    fn step(&mut self, sample: &DeviceSamples<'_>, asked: &mut [Line]) -> Answer {
        for (number, device) in sample.devices.iter().enumerate() {
            if let Some(held) = device.held
                && self.acts_at_once
                && !self.holds_lines
            {
                self.report(number, held.into());
            }
        }
        let placed = self.positions.iter_mut().zip(&mut self.orientations);
        let devices = self.frames.iter().zip(sample.devices);
        for ((position, orientation), (frame, device)) in placed.zip(devices) {
            *position = frame.in_world(device.position);
            // NaN makes the renderer reject a sample without orientation.
            *orientation = device.orientation.unwrap_or([f64::NAN; 4]);
        }
        let output = self.renderer.step(
            &mut self.state,
            &Sample {
                elapsed: sample.elapsed,
                ..Sample::at(&self.positions).turned(&self.orientations)
            },
        );
        let forces = output.forces.iter().zip(output.slopes);
        let answers = forces.zip(output.torques).zip(&self.frames);
        for (asked, (((&force, &slope), &torque), frame)) in asked.iter_mut().zip(answers) {
            let wrench = Wrench {
                force: frame.on_device(force),
                torque,
            };
            *asked = Line {
                slope: frame.on_device(slope),
                ..wrench.into()
            };
        }
        self.is_new.fill(true);
        let fault = output.fault.map(|fault| fault.fault);
        let is_crowded = output.effort.left_out > 0;
        self.limited = output.limited;
        let recorded = self.state.created_at_ports();
        self.created
            .close(recorded, fault.is_some(), sample.was_off);
        Answer {
            coordinate: 0.0,
            fault,
            is_crowded,
        }
    }

    fn report_written(&mut self, device: usize, held: Line, sent: Option<Line>) {
        let is_new = self.is_new.get_mut(device).is_some_and(std::mem::take);
        // Without a new sample the force stays at the end of its line, which is part of the model, or is cut.
        if self.holds_lines && !is_new {
            let had_force = self.has_force.get(device) == Some(&true);
            if had_force && held.wrench.force == [0.0; 3] {
                self.report(device, Line::NONE);
            }
            return;
        }
        let sent = if self.acts_at_once {
            held
        } else {
            sent.unwrap_or(held)
        };
        self.report(device, sent);
    }

    fn account(&mut self, sequence: u64, _: Vector) {
        self.rows.fill(sequence, &self.state);
    }

    fn contacts(&self) -> &[ContactTick] {
        self.rows.contacts()
    }

    fn bodies(&self) -> &[BodyTick] {
        self.rows.bodies()
    }

    fn flags(&self) -> Flags {
        Flags::default()
            .with(Flags::CONTACT, !self.rows.contacts().is_empty())
            .with(
                Flags::LIMITED_FORCE,
                self.limited.force || self.limited.torque,
            )
            .with(Flags::LIMITED_GUARD, self.limited.guard)
            .with(Flags::BEYOND_GUARD, self.limited.beyond_guard)
    }

    fn actuation(&self) -> Actuation<f64> {
        self.renderer.loop_params().actuation
    }

    fn created_energy(&self) -> f64 {
        self.created.counted()
    }
}

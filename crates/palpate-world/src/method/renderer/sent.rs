//! Reports of forces that a driver changed.

use crate::geometry::rigid::Vector3;
use crate::method::state::WorldState;
use crate::{Tool, Vector, WorldRenderer};

impl WorldRenderer {
    /// Replaces the last output on a tool by the force that was actually sent `[N]`, for example after saturation.
    /// Its delay is that of the output, and a line becomes this constant. Non-finite values are ignored, and so are
    /// components along axes that the device lacks.
    pub fn report_sent(&self, state: &mut WorldState, tool: usize, force: Vector) {
        self.report_sent_line(state, tool, force, [0.0; 3]);
    }

    /// Replaces the last output on a tool by the line that was actually sent: its mean `[N]` and its slope `[N/s]`, like
    /// [`report_sent`](Self::report_sent) for a constant.
    pub fn report_sent_line(
        &self,
        state: &mut WorldState,
        tool: usize,
        mut mean: Vector,
        mut slope: Vector,
    ) {
        if let Some(axes) = self.axes.get(tool) {
            axes.keep(&mut mean);
            axes.keep(&mut slope);
        }
        if mean.iter().chain(&slope).all(|x| x.is_finite()) {
            let commands = &mut state.progress.commands;
            commands.correct(tool, mean.into(), slope.into());
        }
    }

    /// Replaces the last output on a tool by the torque that was actually sent `[N m]`, like
    /// [`report_sent`](Self::report_sent) for the force. Ignored for a tool that feels no torque.
    pub fn report_sent_torque(&self, state: &mut WorldState, tool: usize, torque: Vector) {
        let feels_torque = self.world.tools.get(tool).is_some_and(Tool::feels_torque);
        if torque.iter().all(|x| x.is_finite()) && feels_torque {
            state
                .progress
                .torque_commands
                .correct(tool, torque.into(), Vector3::zeros());
        }
    }
}

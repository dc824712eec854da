//! The contact as it is rendered, tick by tick.

use std::mem::discriminant;

use palpate::{
    AnyMemory, AnyRenderer, Ledger, ObjectState, Output, ParameterError, Sample, Side, State,
};

use super::blend::Blend;
use super::{Change, Rendering};

/// A contact in the loop: renderer, state, and the changes that come in.
#[derive(Debug)]
pub struct Rendered {
    changes: triple_buffer::Output<Change>,
    rendering: Rendering,
    renderer: AnyRenderer<f64>,
    state: State<f64, AnyMemory<f64>>,
    virtual_force: f64,
    blend: Option<Blend>,
    generation: u32,
    /// What the renderer that runs was made with.
    running: Rendering,
    /// Where a wall is.
    wall: ObjectState<f64>,
}

impl Rendered {
    pub(crate) fn new(
        first: Change,
        changes: triple_buffer::Output<Change>,
    ) -> Result<Self, ParameterError> {
        let Change {
            rendering,
            renderer,
            generation,
        } = first;
        Ok(Self {
            changes,
            state: renderer.start(rendering.object)?,
            virtual_force: rendering.virtual_force,
            rendering,
            renderer,
            blend: None,
            generation,
            running: rendering,
            wall: rendering.object,
        })
    }

    /// Number of the parameters in force.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// What is rendered once a change that has come in is through.
    pub fn rendering(&self) -> &Rendering {
        &self.rendering
    }

    /// Books up to the last sample.
    pub fn ledger(&self) -> &Ledger<f64> {
        self.state.ledger()
    }

    /// Takes a change, if one has come in. Its number.
    pub fn take_change(&mut self) -> Option<u32> {
        if !self.changes.update() {
            return None;
        }
        let change = *self.changes.output_buffer();
        let from = self.blend.map_or(self.rendering, |blend| blend.now());
        // What was still to fade goes on fading.
        let remainder = self.blend.map_or(0.0, |blend| blend.remainder());
        self.blend = Some(Blend::new(from, change, remainder));
        self.rendering = change.rendering;
        self.generation = change.generation;
        Some(self.generation)
    }

    /// Tells the renderer the force on the object that was sent for its last output `[N]`.
    pub fn report_sent(&mut self, force_on_object: f64) {
        self.renderer.report_sent(&mut self.state, force_on_object);
    }

    /// Tells the renderer the force on the object that was held since the last sample, or its mean
    /// `[N]`.
    pub fn report_held(&mut self, force_on_object: f64) {
        self.renderer.report_held(&mut self.state, force_on_object);
    }

    /// One tick, at `position` `[m]`, `elapsed` `[s]` after the last; the force on the device `[N]`
    /// passes over from what was rendered before.
    pub fn step(&mut self, position: f64, elapsed: Option<f64>) -> Output<f64> {
        let sample = |virtual_force| Sample {
            elapsed,
            ..Sample::at(position).with_virtual_force(virtual_force)
        };
        let mut remainder = 0.0;
        if let Some(mut blend) = self.blend {
            let (old, new) = (self.running, self.rendering);
            let other_method = discriminant(&old.params) != discriminant(&new.params)
                || old.is_wall() != new.is_wall();
            // What the parameters before make of this sample, on a copy.
            let before = (other_method || old.params != new.params).then(|| {
                let mut state = self.state;
                self.renderer.step(&mut state, sample(self.virtual_force))
            });
            self.running = self.rendering;
            let carried = blend.remainder();
            let between = blend.advance();
            if other_method && let Some(before) = &before {
                self.state.forget_past();
                if !old.is_wall() && before.fault.is_none() {
                    self.wall = touching(&self.rendering, position);
                }
                if self.rendering.is_wall() && before.object_position != self.wall.position {
                    // Another method has placed it. Where none has, what is known of the device
                    // would be lost, and with it a damper's velocity.
                    let _ = self.renderer.teleport(&mut self.state, self.wall);
                }
            }
            self.renderer = between.renderer;
            self.virtual_force = between.virtual_force;
            self.renderer.adopt(&mut self.state);
            remainder = between.remainder;
            self.blend = (!between.is_over).then_some(blend);
            if let Some(before) = before {
                let mut output = self
                    .renderer
                    .step(&mut self.state, sample(self.virtual_force));
                let step = before.force_on_device + carried - output.force_on_device;
                if let Some(blend) = &mut self.blend {
                    blend.step = step;
                    add(&mut output, step);
                }
                return output;
            }
        }
        let mut output = self
            .renderer
            .step(&mut self.state, sample(self.virtual_force));
        // Nothing is left on a device that has come free, or whose sample was refused.
        if output.force_on_device != 0.0 {
            add(&mut output, remainder);
        }
        output
    }
}

/// Where something that becomes a wall is: at its place, or where it touches a device that is beyond
/// that at `position` `[m]`. There it would strike, and no spring that fades in would soften the blow.
fn touching(rendering: &Rendering, position: f64) -> ObjectState<f64> {
    let object = rendering.object;
    ObjectState {
        position: match rendering.contact.side {
            Side::Positive => object.position.max(position),
            Side::Negative => object.position.min(position),
        },
        ..object
    }
}

fn add(output: &mut Output<f64>, force: f64) {
    output.force_on_device += force;
    output.force_on_object -= force;
}

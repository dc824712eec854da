//! Transition between two contacts without a step in the force.

use super::{Change, Rendering};
use crate::Scalar;
use crate::contact::Mass;
use crate::render::AnyRenderer;

/// Duration of a change of stiffness, mass, virtual force or method `[s]`: short for a hand, long for a motor.
pub const CHANGE_DURATION: f64 = 0.1;

/// A change in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend<S> {
    from: Rendering<S>,
    to: Change<S>,
    /// Progress, 0 to 1.
    part: S,
    /// Command of the previous method minus that of the new one at the change `[N]`.
    pub step: S,
    /// Function that raises its first argument to the power of the second.
    power: fn(S, S) -> S,
}

/// Rendering during a transition.
pub(super) struct Between<S> {
    pub renderer: AnyRenderer<S>,
    pub virtual_force: S,
    /// Remainder of the force step `[N]`.
    pub remainder: S,
    pub is_over: bool,
}

impl<S: Scalar> Blend<S> {
    pub fn new(from: Rendering<S>, to: Change<S>, step: S, power: fn(S, S) -> S) -> Self {
        Self {
            from,
            to,
            part: S::ZERO,
            step,
            power,
        }
    }

    /// Returns the current remainder of the force step `[N]`.
    pub fn remainder(&self) -> S {
        self.step * (S::ONE - self.part)
    }

    /// Returns the rendering of the next tick.
    pub fn advance(&mut self) -> Between<S> {
        let period = self.to.rendering.loop_params.period;
        self.part = S::ONE.min(self.part + period / S::from_f64(CHANGE_DURATION));
        let over = Between {
            renderer: self.to.renderer,
            virtual_force: self.to.rendering.virtual_force,
            remainder: S::ZERO,
            is_over: true,
        };
        if self.part >= S::ONE {
            return over;
        }
        let now = self.now();
        match now.renderer() {
            Ok(renderer) => Between {
                renderer,
                virtual_force: now.virtual_force,
                remainder: self.remainder(),
                is_over: false,
            },
            // Both ends are valid, but an intermediate value is not.
            Err(_) => over,
        }
    }

    /// Returns the current rendering: stiffness and mass change geometrically (from 100 to 10000 N/m, 1000 is
    /// half-way), the virtual force linearly; other parameters have their final values.
    pub fn now(&self) -> Rendering<S> {
        let (old, new) = (&self.from, &self.to.rendering);
        let between = |old: S, new: S| old * (self.power)(new / old, self.part);
        let mut now = *new;
        now.contact.stiffness = between(old.contact.stiffness, new.contact.stiffness);
        if let (Mass::Finite(old), Mass::Finite(new)) =
            (old.contact.object_mass, new.contact.object_mass)
        {
            now.contact.object_mass = Mass::Finite(between(old, new));
        }
        now.virtual_force = old.virtual_force + self.part * (new.virtual_force - old.virtual_force);
        now
    }
}

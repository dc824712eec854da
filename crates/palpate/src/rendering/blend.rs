//! From one contact to another without a step in the force.

use super::{Change, Rendering};
use crate::Scalar;
use crate::contact::Mass;
use crate::render::AnyRenderer;

/// Time a change of stiffness, mass, virtual force or method takes `[s]`: short for a hand, long for
/// a motor.
pub const CHANGE_DURATION: f64 = 0.1;

/// A change in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend<S> {
    from: Rendering<S>,
    to: Change<S>,
    /// How far it has come, 0 to 1.
    part: S,
    /// Force that the method before would have commanded beyond that of the new one at the change
    /// `[N]`.
    pub step: S,
    /// The first argument to the power of the second.
    power: fn(S, S) -> S,
}

/// What is rendered on the way.
pub(super) struct Between<S> {
    pub renderer: AnyRenderer<S>,
    pub virtual_force: S,
    /// What is left of the step `[N]`.
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

    /// What is left of the step now `[N]`.
    pub fn remainder(&self) -> S {
        self.step * (S::ONE - self.part)
    }

    /// What is rendered in the next tick.
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
            // Both ends are allowed, but something between them is not.
            Err(_) => over,
        }
    }

    /// What is rendered now: stiffness and mass by equal ratios (from 100 to 10000 N/m, 1000 is half
    /// of the way), the virtual force by equal steps, the rest as it is to be.
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

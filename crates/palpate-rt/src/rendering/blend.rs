//! From one contact to another without a step in the force.

use palpate::{AnyRenderer, Mass};

use super::{Change, Rendering};

/// Time a change of stiffness, mass, virtual force or method takes `[s]`: short for a hand, long for
/// a motor.
pub const CHANGE_DURATION: f64 = 0.1;

/// A change in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blend {
    from: Rendering,
    to: Change,
    /// How far it has come, 0 to 1.
    part: f64,
    /// Force that the method before would have commanded beyond that of the new one at the change
    /// `[N]`.
    pub step: f64,
}

/// What is rendered on the way.
pub(super) struct Between {
    pub renderer: AnyRenderer<f64>,
    pub virtual_force: f64,
    /// What is left of the step `[N]`.
    pub remainder: f64,
    pub is_over: bool,
}

impl Blend {
    pub fn new(from: Rendering, to: Change, step: f64) -> Self {
        Self {
            from,
            to,
            part: 0.0,
            step,
        }
    }

    /// What is left of the step now `[N]`.
    pub fn remainder(&self) -> f64 {
        self.step * (1.0 - self.part)
    }

    /// What is rendered in the next tick.
    pub fn advance(&mut self) -> Between {
        let period = self.to.rendering.loop_params.period;
        self.part = (self.part + period / CHANGE_DURATION).min(1.0);
        let over = Between {
            renderer: self.to.renderer,
            virtual_force: self.to.rendering.virtual_force,
            remainder: 0.0,
            is_over: true,
        };
        if self.part >= 1.0 {
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
    pub fn now(&self) -> Rendering {
        let (old, new) = (&self.from, &self.to.rendering);
        let between = |old: f64, new: f64| old * (new / old).powf(self.part);
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

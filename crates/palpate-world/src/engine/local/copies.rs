//! Update of the copies of the host's bodies by a new model.

use super::model::LocalModel;
use super::past::Then;
use super::state::LocalState;
use crate::engine::body::BodyNow;
use crate::engine::contact_point::Touch;
use crate::engine::image::{Image, ImageOffset};
use crate::engine::integration::Meeting;
use crate::{Effort, SubSteps};

/// Sub-step limits for recomputing a host step, by the phase of its fastest contact: at most 640 sub-steps. Ticks
/// that the loop has missed use the same limits.
pub(super) const HOST_STEPS: SubSteps = SubSteps {
    least: 16,
    most: 512,
    phase: 0.1,
    finer: 16,
    refined: 8,
};

/// Returns the duration of this number of periods `[s]`.
#[expect(clippy::cast_precision_loss, reason = "a number of ticks")]
pub(super) fn duration(ticks: u64, period: f64) -> f64 {
    ticks as f64 * period
}

impl LocalState {
    /// Moves the copies by the difference between the model and the prediction. The contacts are still those of the
    /// last model.
    pub(super) fn take_bodies(&mut self, model: &LocalModel, period: f64, return_time: f64) {
        let now = self.progress.tick;
        let before = self.model_tick.unwrap_or(model.tick);
        let step = duration(model.tick.saturating_sub(before), period);
        self.record_slow_ports(model, step);
        let is_expected = self.is_known && self.foresee(model.tick, step, period);
        let share = (step / return_time).min(1.0);
        for (body, described) in model.bodies.iter().enumerate() {
            let host = Image::new(described, &ImageOffset::none());
            let expected = self.host.images[body];
            let Some(then) = self.past.at(model.tick, body).copied() else {
                continue;
            };
            let way = host.apart_from(&expected) - then.apart_from(&expected) * share;
            let twist = host.twist - expected.twist + (expected.twist - then.twist) * share;
            for tick in model.tick..=now {
                let since = duration(tick - model.tick, period);
                if let Some(copy) = self.past.at(tick, body) {
                    if is_expected {
                        copy.correct(&(way + twist * since), &twist);
                    } else {
                        copy.goes_on_from(&host, since);
                    }
                }
            }
            let image = &mut self.engine.meeting.images[body];
            if let Some(copy) = self.past.at(now, body) {
                copy.put(image);
            }
            image.acceleration = host.acceleration;
            image.mobility = host.mobility;
            self.host.images[body] = host;
            self.at_model[body] = then;
        }
        self.model_tick = Some(model.tick);
        self.is_known = true;
    }

    /// Records the work of the tools on the copies and on the host's bodies up to the model's tick.
    fn record_slow_ports(&mut self, model: &LocalModel, step: f64) {
        for (body, described) in model.bodies.iter().enumerate() {
            let host = Image::new(described, &ImageOffset::none());
            let Some(then) = self.past.at(model.tick, body) else {
                continue;
            };
            let (entry, before) = (&mut self.slow_ports[body], &self.at_model[body]);
            entry.work += then.work - before.work;
            if step > 0.0 {
                let mean = (then.impulse - before.impulse) / step;
                let work = mean.dot(&host.apart_from(&self.host.images[body]));
                entry.host_work += if work.is_finite() { work } else { 0.0 };
            }
        }
    }

    /// Predicts the bodies after the host's step of `step` `[s]` up to `tick`, under the mean wrenches of the tools.
    /// Returns `false` if the result is not finite or if a contact between the host's own bodies makes the
    /// integration unstable.
    fn foresee(&mut self, tick: u64, step: f64, period: f64) -> bool {
        if step <= 0.0 {
            return true;
        }
        for body in 0..self.at_model.len() {
            let Some(then) = self.past.at(tick, body) else {
                continue;
            };
            let mean = (then.impulse - self.at_model[body].impulse) / step;
            let image = &mut self.host.images[body];
            image.acceleration += image.mobility * mean;
        }
        self.host.look(&self.pairs);
        let steps = &HOST_STEPS;
        let effort = self.host.advance(
            &mut self.host_before,
            &self.pairs,
            steps,
            1,
            step,
            step.max(period),
        );
        let sum: f64 = self.host.images.iter().map(Image::sum).sum();
        let is_known = sum.is_finite() && !effort.unstable;
        if !is_known {
            self.host.touches.fill(Touch::apart());
            put_fixed_world(&mut self.host);
        }
        // An unstable prediction does not invalidate the sample.
        let effort = Effort {
            unstable: false,
            ..effort
        };
        self.engine.effort = self.engine.effort.and(effort);
        is_known
    }
}

/// Sets the image of the fixed world, which is stored after the last body's.
pub(super) fn put_fixed_world(meeting: &mut Meeting) {
    if let Some(last) = meeting.images.last_mut() {
        *last = Image::new(&BodyNow::fixed([0.0; 3]), &ImageOffset::none());
    }
}

/// Returns an undefined copy.
pub(super) fn nowhere() -> Then {
    Then::new(&Image::nowhere(), nalgebra::Vector6::zeros(), 0.0)
}

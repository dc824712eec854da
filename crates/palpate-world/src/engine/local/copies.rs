//! How the copies of the host's bodies go on when a model comes.

use super::model::LocalModel;
use super::past::Then;
use super::state::LocalState;
use crate::engine::body::BodyNow;
use crate::engine::image::{Image, ImageOffset};
use crate::engine::meeting::Meeting;
use crate::engine::touch::Touch;
use crate::{Effort, SubSteps};

/// How finely a step of the host is computed once more, by the phase of its fastest contact: in at most 640 sub-steps. The time of
/// ticks that the loop has missed is computed as finely.
pub(super) const HOST_STEPS: SubSteps = SubSteps {
    least: 16,
    most: 512,
    phase: 0.1,
    finer: 16,
    refined: 8,
};

/// Length of so many periods `[s]`.
#[expect(clippy::cast_precision_loss, reason = "a number of ticks")]
pub(super) fn duration(ticks: u64, period: f64) -> f64 {
    ticks as f64 * period
}

impl LocalState {
    /// Moves the copies by what the model says beyond what was expected. The contacts are still those of the last model.
    pub(super) fn take_bodies(&mut self, model: &LocalModel, period: f64, return_time: f64) {
        let now = self.progress.tick;
        let before = self.model_tick.unwrap_or(model.tick);
        let step = duration(model.tick.saturating_sub(before), period);
        self.book_slow_ports(model, step);
        let is_expected = self.is_known && self.foresee(model.tick, step, period);
        let share = (step / return_time).min(1.0);
        for (body, described) in model.bodies.iter().enumerate() {
            let host = Image::of(described, &ImageOffset::none());
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

    /// What the tools did to copies and host's bodies up to the model's tick.
    fn book_slow_ports(&mut self, model: &LocalModel, step: f64) {
        for (body, described) in model.bodies.iter().enumerate() {
            let host = Image::of(described, &ImageOffset::none());
            let Some(then) = self.past.at(model.tick, body) else {
                continue;
            };
            let (book, before) = (&mut self.slow_ports[body], &self.at_model[body]);
            book.work += then.work - before.work;
            if step > 0.0 {
                let mean = (then.impulse - before.impulse) / step;
                let work = mean.dot(&host.apart_from(&self.host.images[body]));
                book.host_work += if work.is_finite() { work } else { 0.0 };
            }
        }
    }

    /// Computes where the host's step up to `tick`, which is `step` `[s]` long, should have brought its bodies under the mean
    /// wrenches of the tools. `false` where that is no number, or a contact of the host's own is so fast that it would grow.
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
        // The sample is not refused for it.
        let effort = Effort {
            unstable: false,
            ..effort
        };
        self.engine.effort = self.engine.effort.and(effort);
        is_known
    }
}

/// What never moves has the image after the last body's.
pub(super) fn put_fixed_world(meeting: &mut Meeting) {
    if let Some(last) = meeting.images.last_mut() {
        *last = Image::of(&BodyNow::fixed([0.0; 3]), &ImageOffset::none());
    }
}

/// A copy of which nothing is known.
pub(super) fn nowhere() -> Then {
    Then::of(&Image::nowhere(), nalgebra::Vector6::zeros(), 0.0)
}

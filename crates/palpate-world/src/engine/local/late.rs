//! Compensation for late ticks.

use super::copies::{HOST_STEPS, duration};
use super::state::LocalState;
use crate::Effort;
use crate::engine::contact_point::Touch;
use crate::engine::image::Image;
use crate::integration::interval::whole;

/// Tolerance for rounding, as a fraction of a period.
const ROUNDING: f64 = 1e-6;

impl LocalState {
    /// Processes a sample that arrives `elapsed` `[s]` after the previous one. Each whole period of accumulated delay
    /// counts as a tick. Over these ticks the copies move under the tools' mean wrench of the last period, because
    /// the devices were held for the same time.
    pub(super) fn catch_up(&mut self, elapsed: f64, period: f64) {
        self.behind += elapsed / period - 1.0;
        let missed = whole((self.behind + ROUNDING).floor());
        if missed == 0 {
            return;
        }
        self.behind -= f64::from(missed);
        if self.is_known {
            self.resume(f64::from(missed) * period, period);
        }
        let (before, missed) = (self.progress.tick, u64::from(missed));
        let room = u64::try_from(self.past.ticks()).unwrap_or(u64::MAX);
        let images = &self.engine.meeting.images;
        for (body, image) in images.iter().take(self.at_model.len()).enumerate() {
            let Some(start) = self.past.at(before, body).copied() else {
                continue;
            };
            for tick in missed.saturating_sub(room) + 1..=missed {
                if let Some(then) = self.past.at(before + tick, body) {
                    *then = start.towards(image, duration(tick, 1.0) / duration(missed, 1.0));
                    then.impulse += image.impulse * duration(tick, 1.0);
                }
            }
        }
        self.progress.tick = before + missed;
    }

    /// Advances the copies by `h` `[s]`. The copies keep their state if the result is not finite.
    fn resume(&mut self, h: f64, period: f64) {
        let bodies = self.at_model.len();
        let (meeting, late) = (&mut self.engine.meeting, &mut self.late);
        late.images.copy_from_slice(&meeting.images);
        for image in late.images.iter_mut().take(bodies) {
            image.acceleration += image.mobility * (image.impulse / period);
        }
        let touches = meeting.touches.iter().zip(&self.pairs);
        for (late, (touch, pair)) in late.touches.iter_mut().zip(touches) {
            let is_of_tool = pair.toucher.tool().is_some();
            *late = if is_of_tool { Touch::apart() } else { *touch };
        }
        late.look(&self.pairs);
        let before = &mut self.host_before;
        let effort = late.advance(before, &self.pairs, &HOST_STEPS, 1, h, h.max(period));
        let sum: f64 = late.images.iter().map(Image::sum).sum();
        let is_known = sum.is_finite() && !effort.unstable;
        // An unstable prediction does not invalidate the sample.
        let effort = Effort {
            unstable: false,
            ..effort
        };
        self.engine.effort = self.engine.effort.and(effort);
        if !is_known {
            return;
        }
        for (image, late) in meeting.images.iter_mut().zip(&late.images).take(bodies) {
            image.position = late.position;
            image.orientation = late.orientation;
            image.twist = late.twist;
        }
        let touches = meeting.touches.iter_mut().zip(&late.touches);
        for ((touch, late), pair) in touches.zip(&self.pairs) {
            if pair.toucher.tool().is_none() {
                *touch = *late;
                touch.begin();
            }
        }
    }
}

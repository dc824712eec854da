//! Contacts of a tool whose device has a force limit: springs up to the limit, and that force beyond it.
//!
//! A device that is pressed in against a limited force has stored less energy than its springs, and receives less
//! energy back. The motion must therefore include the limit: all contacts of the tool are scaled alike, on both sides.
//! For springs of one direction this is the potential `(2 s - s^2) V` of springs with the energy V, whose force is
//! scaled by s.

use palpate_core::Actuation;

use crate::contact::pairs::Point;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::Vector3;
use crate::integration::moving::Moving;

/// Square of the largest component of a normal along the axes that a device lacks. A contact that the mechanism carries
/// in part has no such potential: its command is limited, and its motion is not.
const ALONG: f64 = 1e-12;

/// Force limit of a tool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceLimit {
    /// Largest force on the tool `[N]`.
    pub force: f64,
    /// Axes along which the device acts on it.
    pub axes: Axes,
    /// Whether it acted since the interval began.
    pub has_acted: bool,
}

impl ForceLimit {
    /// Returns the limits of tools with these axes, from the limits of their commands `[N]`.
    pub fn each(limits: &[f64], actuation: &Actuation<f64>, axes: &[Axes]) -> Vec<Self> {
        let of_tool = limits.iter().zip(axes).map(|(&limit, &axes)| Self {
            // Both the command and the delivered force are limited.
            force: actuation.gain * limit / actuation.limit_gain(),
            axes,
            has_acted: false,
        });
        of_tool.collect()
    }

    /// Returns whether the device acts along the whole of a contact's normal.
    pub fn is_along(&self, normal: &Vector3) -> bool {
        self.axes.across(normal).norm_squared() < ALONG
    }

    /// Returns the fractions of the elastic and of the total contact force on the tool that are left, if the limit
    /// acts.
    pub fn scales(&mut self, elastic: &Vector3, total: &Vector3) -> Option<[f64; 2]> {
        let scales = [elastic, total].map(|force| self.scale(force));
        let acts = scales.iter().any(|scale| *scale < 1.0);
        self.has_acted |= acts;
        acts.then_some(scales)
    }

    /// Returns the fraction of a force that is within the limit.
    fn scale(&self, force: &Vector3) -> f64 {
        let norm = self.axes.along(force).norm();
        if norm > self.force {
            self.force / norm
        } else {
            1.0
        }
    }
}

impl Moving {
    /// Returns whether the force limit of a tool acted since the interval began.
    pub fn has_yielded(&self, tool: usize) -> bool {
        self.limits.get(tool).is_some_and(|limit| limit.has_acted)
    }

    /// Scales the contacts of each tool whose elastic force or total force exceeds its limit.
    #[inline]
    pub(super) fn yield_to_limits(&mut self, points: &[Point]) {
        if self.limits.is_empty() {
            return;
        }
        let (limits, parts) = (self.limits.len(), self.nearby.parts().len());
        for place in 0..parts {
            let tool = self.nearby.parts()[place];
            if tool >= limits {
                continue;
            }
            let limit = &self.limits[tool];
            let mut elastic = Vector3::zeros();
            let mut is_along = true;
            for &number in self.nearby.numbers() {
                let touch = &self.touches[number];
                if let Some(sign) = points[number].sign_on(tool)
                    && !touch.is_apart()
                {
                    elastic += (touch.force - touch.damping_force()) * sign;
                    is_along &= limit.is_along(&touch.normal);
                }
            }
            if !is_along {
                continue;
            }
            if let Some(scales) = self.limits[tool].scales(&elastic, &self.parts[tool].force) {
                self.scale_contacts(points, tool, scales);
            }
        }
    }

    #[cold]
    fn scale_contacts(&mut self, points: &[Point], tool: usize, scales: [f64; 2]) {
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if point.sign_on(tool).is_none() || touch.is_apart() {
                continue;
            }
            let before = touch.force;
            touch.scale(scales);
            let change = touch.force - before;
            self.parts[point.first].load(&change, &touch.place);
            self.parts[point.second].load(&-change, &touch.place);
        }
    }
}

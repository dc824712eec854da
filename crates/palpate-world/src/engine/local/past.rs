//! History of the copies over the last ticks.

use nalgebra::Vector6;

use crate::engine::image::{Image, angular, linear};
use crate::geometry::rigid::{Rotation, Vector3};

/// State of a body's copy at the beginning of a tick's period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Then {
    pub position: Vector3,
    pub orientation: Rotation,
    pub twist: Vector6<f64>,
    /// Impulse of the tools on the copy since the start `[N s]`, `[N m s]`.
    pub impulse: Vector6<f64>,
    /// Work of the tools on the copy since the start `[J]`.
    pub work: f64,
}

impl Then {
    pub fn new(image: &Image, impulse: Vector6<f64>, work: f64) -> Self {
        Self {
            position: image.position,
            orientation: image.orientation,
            twist: image.twist,
            impulse,
            work,
        }
    }
}

impl Then {
    /// Sets the state to that of the image `since` `[s]` later, under the image's acceleration only.
    pub fn goes_on_from(&mut self, image: &Image, since: f64) {
        let mut later = *image;
        later.shift(&(image.twist * since + image.acceleration * (0.5 * since * since)));
        self.position = later.position;
        self.orientation = later.orientation;
        self.twist = image.twist + image.acceleration * since;
    }

    /// Displaces the copy by a translation `[m]` and a rotation vector `[rad]`, and adds `twist` to its velocity.
    pub fn correct(&mut self, way: &Vector6<f64>, twist: &Vector6<f64>) {
        self.position += linear(way);
        self.orientation = Rotation::from_scaled_axis(angular(way)) * self.orientation;
        self.twist += twist;
    }

    /// Returns the pose relative to an image: translation `[m]` and rotation vector `[rad]`.
    pub fn apart_from(&self, image: &Image) -> Vector6<f64> {
        let mut then = *image;
        self.put(&mut then);
        then.apart_from(image)
    }

    /// Interpolates between this state and a later image at a fraction `share` of the time.
    pub fn towards(&self, later: &Image, share: f64) -> Self {
        let mut between = *later;
        self.put(&mut between);
        let way = later.apart_from(&between) * share;
        between.shift(&way);
        Self {
            position: between.position,
            orientation: between.orientation,
            twist: self.twist + (later.twist - self.twist) * share,
            ..*self
        }
    }

    /// Sets the pose and velocity of an image to this state.
    pub fn put(&self, image: &mut Image) {
        image.position = self.position;
        image.orientation = self.orientation;
        image.twist = self.twist;
        image.ahead = self.twist;
    }
}

/// Ring buffer of the copies' states over the last ticks.
#[derive(Clone, Debug)]
pub(super) struct Past {
    bodies: usize,
    rows: Vec<Then>,
}

impl Past {
    /// Creates a buffer for `ticks` ticks (at least 1), filled with `start`.
    pub fn new(bodies: usize, ticks: usize, start: Then) -> Self {
        Self {
            bodies,
            rows: vec![start; bodies * ticks],
        }
    }

    /// Returns the capacity in ticks; 0 without bodies.
    pub fn ticks(&self) -> usize {
        self.rows.len().checked_div(self.bodies).unwrap_or(0)
    }

    /// Returns the state of a body at a tick, which must be one of the last [`ticks`](Self::ticks).
    pub fn at(&mut self, tick: u64, body: usize) -> Option<&mut Then> {
        let ticks = u64::try_from(self.ticks())
            .ok()
            .filter(|ticks| *ticks > 0)?;
        let row = usize::try_from(tick % ticks).ok()?;
        self.rows.get_mut(row * self.bodies + body)
    }
}

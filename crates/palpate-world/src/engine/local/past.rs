//! What the copies did in the last ticks.

use nalgebra::Vector6;

use crate::engine::image::{Image, angular, linear};
use crate::rigid::{Rotation, Vector3};

/// A body's copy at the beginning of a tick's period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Then {
    pub position: Vector3,
    pub orientation: Rotation,
    pub twist: Vector6<f64>,
    /// Impulse of the tools on it since the start `[N s]`, `[N m s]`.
    pub impulse: Vector6<f64>,
    /// Their work on the copy since the start `[J]`.
    pub work: f64,
}

impl Then {
    pub fn of(image: &Image, impulse: Vector6<f64>, work: f64) -> Self {
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
    /// As the image of a body is, `since` `[s]` later, moved by nothing but what accelerates it.
    pub fn goes_on_from(&mut self, image: &Image, since: f64) {
        let mut later = *image;
        later.shift(&(image.twist * since + image.acceleration * (0.5 * since * since)));
        self.position = later.position;
        self.orientation = later.orientation;
        self.twist = image.twist + image.acceleration * since;
    }

    /// Is put elsewhere, by a translation `[m]` and a rotation vector `[rad]`, and moves otherwise by `twist`.
    pub fn correct(&mut self, way: &Vector6<f64>, twist: &Vector6<f64>) {
        self.position += linear(way);
        self.orientation = Rotation::from_scaled_axis(angular(way)) * self.orientation;
        self.twist += twist;
    }

    /// Where it is less where an image is: translation `[m]` and rotation vector `[rad]`.
    pub fn apart_from(&self, image: &Image) -> Vector6<f64> {
        let mut then = *image;
        self.put(&mut then);
        then.apart_from(image)
    }

    /// Between this and an image at a later time, after this share of the time.
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

    /// Puts an image there, as it moves then.
    pub fn put(&self, image: &mut Image) {
        image.position = self.position;
        image.orientation = self.orientation;
        image.twist = self.twist;
        image.ahead = self.twist;
    }
}

/// The last ticks, each in the place of the one that is as many ticks ago as there are places.
#[derive(Clone, Debug)]
pub(super) struct Past {
    bodies: usize,
    rows: Vec<Then>,
}

impl Past {
    /// Room for so many `ticks`, at least 1. Before the first everything was as `start` says.
    pub fn new(bodies: usize, ticks: usize, start: Then) -> Self {
        Self {
            bodies,
            rows: vec![start; bodies * ticks],
        }
    }

    /// How many ticks there is room for; 0 where there is no body.
    pub fn ticks(&self) -> usize {
        self.rows.len().checked_div(self.bodies).unwrap_or(0)
    }

    /// The body at a tick, which has to be one of the last.
    pub fn at(&mut self, tick: u64, body: usize) -> Option<&mut Then> {
        let ticks = u64::try_from(self.ticks())
            .ok()
            .filter(|ticks| *ticks > 0)?;
        let row = usize::try_from(tick % ticks).ok()?;
        self.rows.get_mut(row * self.bodies + body)
    }
}

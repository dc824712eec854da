//! What a sphere need not look at again until its centre has gone some way.

use super::gather::MOST_TRIANGLES;
use crate::rigid::Vector3;

/// When to look again at each triangle about a sphere. A triangle that cannot have what is looked for until the centre has gone
/// some way is left alone until then. This holds whatever path the centre takes: its distance from where it was when the triangle
/// was looked at is at most the way that it has gone since.
#[derive(Clone, Debug)]
pub(super) struct Spared {
    /// Where the centre was last.
    place: Vector3,
    /// The way that it has gone since the triangles were gathered `[m]`.
    gone: f64,
    /// By number, what `gone` is when the triangle may have what is looked for `[m]`.
    until: Box<[f64]>,
    /// So much earlier it is looked at, for what is rounded `[m]`.
    slack: f64,
    /// Those that are looked at before `gone` is `soon` `[m]`, in the order of their numbers.
    next: Box<[u16]>,
    count: usize,
    soon: f64,
}

/// Share of a reach that covers what is rounded where a sphere is held against triangles within it.
const ROUNDED: f64 = 1e-4;
/// A way after which all triangles are gone through for those that are looked at soon `[m]`: that of a few sub-steps of a tool
/// that a hand moves.
const STRIDE: f64 = 8e-5;

impl Spared {
    pub fn none() -> Self {
        Self {
            place: Vector3::zeros(),
            gone: 0.0,
            until: vec![0.0; MOST_TRIANGLES].into(),
            slack: 0.0,
            next: vec![0; MOST_TRIANGLES].into(),
            count: 0,
            soon: 0.0,
        }
    }

    /// Triangles were gathered about a place: of each how far the centre has to go at least until it may have what is looked for
    /// `[m]`. All are within `reach` `[m]`.
    pub fn begin(&mut self, place: &Vector3, reach: f64, ways: impl Iterator<Item = f64>) {
        self.place = *place;
        self.gone = 0.0;
        self.slack = ROUNDED * reach;
        self.soon = 0.0;
        for (until, way) in self.until.iter_mut().zip(ways) {
            *until = way - self.slack;
        }
    }

    /// The centre of the sphere, about which there are so many triangles, is here now.
    pub fn go_to(&mut self, place: &Vector3, triangles: usize) {
        self.gone += (place - self.place).norm();
        self.place = *place;
        if self.gone < self.soon {
            return;
        }
        self.soon = self.gone + STRIDE;
        self.count = 0;
        for (number, &until) in (0..).zip(&self.until[..triangles]) {
            self.next[self.count] = number;
            self.count += usize::from(until < self.soon);
        }
    }

    /// The number of the next triangle that may have what is looked for, after the `seen` ones.
    pub fn next(&self, seen: &mut usize) -> Option<usize> {
        while *seen < self.count {
            let number = usize::from(self.next[*seen]);
            *seen += 1;
            if self.gone >= self.until[number] {
                return Some(number);
            }
        }
        None
    }

    /// The triangle of this number cannot have it until the centre has gone this way from here `[m]`.
    pub fn spare(&mut self, number: usize, way: f64) {
        self.until[number] = self.gone + way - self.slack;
    }
}

//! Schedule of the triangles that a moving sphere must re-evaluate.

use super::gather::MAX_TRIANGLES;
use crate::geometry::rigid::Vector3;

/// Re-evaluation schedule of the triangles near a sphere. A triangle is skipped until the centre has travelled the
/// distance before which it cannot satisfy the criterion. This holds for any path: the displacement since the last
/// evaluation is at most the path length.
#[derive(Clone, Debug)]
pub(super) struct Spared {
    /// Last position of the centre.
    place: Vector3,
    /// Path length since the triangles were gathered `[m]`.
    gone: f64,
    /// Value of `gone` at which each triangle may satisfy the criterion `[m]`.
    until: Box<[f64]>,
    /// Safety margin for rounding `[m]`.
    slack: f64,
    /// Triangles due within a long stride, and the subset due within a short one.
    listed: [Listed; STRIDES.len()],
}

/// Triangles due within a stride, in index order.
#[derive(Clone, Debug)]
struct Listed {
    numbers: Box<[u16]>,
    count: usize,
    /// Value of `gone` at the end of the stride `[m]`.
    soon: f64,
}

/// Rounding margin of a distance to triangles within a reach, relative to the reach.
const ROUNDED: f64 = 1e-4;
/// Path lengths after which the two lists are rebuilt `[m]`: the first from all triangles, the second from the first
/// list. A hand-held tool travels the second length in about ten sub-steps.
const STRIDES: [f64; 2] = [4e-4, 5e-5];

impl Spared {
    pub fn none() -> Self {
        Self {
            place: Vector3::zeros(),
            gone: 0.0,
            until: vec![0.0; MAX_TRIANGLES].into(),
            slack: 0.0,
            listed: STRIDES.map(|_| Listed {
                numbers: vec![0; MAX_TRIANGLES].into(),
                count: 0,
                soon: 0.0,
            }),
        }
    }

    /// Starts a schedule for triangles gathered around `place`. `ways` are the minimum travels before each may
    /// satisfy the criterion `[m]`. All triangles are within `reach` `[m]`.
    pub fn begin(&mut self, place: &Vector3, reach: f64, ways: impl Iterator<Item = f64>) {
        self.place = *place;
        self.gone = 0.0;
        self.slack = ROUNDED * reach;
        for listed in &mut self.listed {
            listed.soon = 0.0;
        }
        for (until, way) in self.until.iter_mut().zip(ways) {
            *until = way - self.slack;
        }
    }

    /// Updates the position of the sphere's centre. `triangles` is the number of gathered triangles.
    pub fn go_to(&mut self, place: &Vector3, triangles: usize) {
        self.gone += (place - self.place).norm();
        self.place = *place;
        let gone = self.gone;
        let [wide, narrow] = &mut self.listed;
        if gone < narrow.soon {
            return;
        }
        let until = &self.until[..triangles];
        if gone >= wide.soon {
            wide.list((0..).zip(until), gone + STRIDES[0]);
        }
        let of_wide = wide.numbers[..wide.count].iter();
        let waiting = of_wide.map(|&number| (number, &until[usize::from(number)]));
        narrow.list(waiting, wide.soon.min(gone + STRIDES[1]));
    }

    /// Returns the index of the next triangle due, after the `seen` ones.
    pub fn next(&self, seen: &mut usize) -> Option<usize> {
        let [_, narrow] = &self.listed;
        while *seen < narrow.count {
            let number = usize::from(narrow.numbers[*seen]);
            *seen += 1;
            if self.gone >= self.until[number] {
                return Some(number);
            }
        }
        None
    }

    /// Skips this triangle until the centre has travelled `way` from here `[m]`.
    pub fn spare(&mut self, number: usize, way: f64) {
        self.until[number] = self.gone + way - self.slack;
    }
}

impl Listed {
    /// Selects the triangles due before the path length `soon` `[m]`.
    fn list<'a>(&mut self, waiting: impl Iterator<Item = (u16, &'a f64)>, soon: f64) {
        self.soon = soon;
        self.count = 0;
        for (number, &until) in waiting {
            self.numbers[self.count] = number;
            self.count += usize::from(until < soon);
        }
    }
}

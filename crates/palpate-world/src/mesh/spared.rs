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
    /// Those that are looked at within a stride, and of these those within a shorter one.
    listed: [Listed; STRIDES.len()],
}

/// The triangles that are looked at before the centre has `gone` a stride further, in the order of their numbers.
#[derive(Clone, Debug)]
struct Listed {
    numbers: Box<[u16]>,
    count: usize,
    /// What `gone` is then `[m]`.
    soon: f64,
}

/// Share of a reach that covers what is rounded where a sphere is held against triangles within it.
const ROUNDED: f64 = 1e-4;
/// Ways of the centre after which each of the two lists is made anew `[m]`. The first list is made of all triangles, the second of those
/// in the first. Under a hand a tool goes the second way in some ten sub-steps.
const STRIDES: [f64; 2] = [4e-4, 5e-5];

impl Spared {
    pub fn none() -> Self {
        Self {
            place: Vector3::zeros(),
            gone: 0.0,
            until: vec![0.0; MOST_TRIANGLES].into(),
            slack: 0.0,
            listed: STRIDES.map(|_| Listed {
                numbers: vec![0; MOST_TRIANGLES].into(),
                count: 0,
                soon: 0.0,
            }),
        }
    }

    /// Triangles were gathered about a place: of each how far the centre has to go at least until it may have what is looked for
    /// `[m]`. All are within `reach` `[m]`.
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

    /// The centre of the sphere, about which there are so many triangles, is here now.
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

    /// The number of the next triangle that may have what is looked for, after the `seen` ones.
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

    /// The triangle of this number cannot have it until the centre has gone this way from here `[m]`.
    pub fn spare(&mut self, number: usize, way: f64) {
        self.until[number] = self.gone + way - self.slack;
    }
}

impl Listed {
    /// Takes those that are looked at before the centre has gone so far `[m]`.
    fn list<'a>(&mut self, waiting: impl Iterator<Item = (u16, &'a f64)>, soon: f64) {
        self.soon = soon;
        self.count = 0;
        for (number, &until) in waiting {
            self.numbers[self.count] = number;
            self.count += usize::from(until < soon);
        }
    }
}

//! What a device is held by after its world was changed: no step, and the difference fades.

use palpate::CHANGE_DURATION;
use palpate_device::Wrench;

/// What is left of what was held before a change.
#[derive(Clone, Debug)]
pub(crate) struct Fade {
    /// By how much more was held before, for each device.
    more: Vec<Wrench>,
    /// Whether it has yet to be seen.
    is_new: bool,
    /// For how long yet `[s]`; 0: nothing is left.
    left: f64,
}

impl Fade {
    pub fn none(devices: usize) -> Self {
        Self {
            more: vec![Wrench::NONE; devices],
            is_new: false,
            left: 0.0,
        }
    }

    /// The world was changed: the next answer is what was held before, and goes over to what is asked for.
    pub fn begin(&mut self) {
        self.is_new = true;
        self.left = CHANGE_DURATION;
    }

    /// Nothing is left.
    pub fn end(&mut self) {
        self.is_new = false;
        self.left = 0.0;
    }

    /// Puts what is asked for and what is left into `held`, which has what was held before. `elapsed` is the time since
    /// then `[s]`.
    pub fn answer(
        &mut self,
        asked: impl Iterator<Item = Wrench>,
        elapsed: f64,
        held: &mut [Wrench],
    ) {
        if self.left <= 0.0 {
            for (held, asked) in held.iter_mut().zip(asked) {
                *held = asked;
            }
            return;
        }
        let is_new = std::mem::take(&mut self.is_new);
        if !is_new {
            // A time that is refused is at least one of which nothing is known.
            self.left -= if elapsed > 0.0 { elapsed } else { 0.0 };
        }
        let share = (self.left / CHANGE_DURATION).clamp(0.0, 1.0);
        for ((held, more), asked) in held.iter_mut().zip(&mut self.more).zip(asked) {
            if is_new {
                *more = sum(held, &asked, -1.0);
            }
            *held = sum(&asked, more, share);
        }
    }
}

/// One wrench, and `share` of another.
fn sum(one: &Wrench, other: &Wrench, share: f64) -> Wrench {
    let add = |one: [f64; 3], other: [f64; 3]| {
        let [x, y, z] = one;
        let [a, b, c] = other;
        [x + a * share, y + b * share, z + c * share]
    };
    Wrench {
        force: add(one.force, other.force),
        torque: add(one.torque, other.torque),
    }
}

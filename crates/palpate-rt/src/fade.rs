//! What a device is held by after its world was changed: no step, and the difference fades.

use palpate::CHANGE_DURATION;
use palpate_device::Wrench;

/// How many samples after a change devices are held as before it: what a method asks for in the first of them may be what it
/// owes for an interval that began in one world and ended in another.
const SETTLING: u32 = 3;

/// What is left of what was held before a change.
#[derive(Clone, Debug)]
pub(crate) struct Fade {
    /// By how much more is to be held than is asked for, for each device, before it fades.
    more: Vec<Wrench>,
    /// The same of a change before that had not faded when this one came.
    carried: Vec<Wrench>,
    /// For how many samples yet the devices are held as before.
    settling: u32,
    /// For how long yet `[s]`; 0: nothing is left.
    left: f64,
}

impl Fade {
    pub fn none(devices: usize) -> Self {
        Self {
            more: vec![Wrench::NONE; devices],
            carried: vec![Wrench::NONE; devices],
            settling: 0,
            left: 0.0,
        }
    }

    /// The world was changed: the next answers are those of before, and then go over to what is asked for.
    pub fn begin(&mut self) {
        let share = self.share();
        for (carried, more) in self.carried.iter_mut().zip(&self.more) {
            *carried = sum(&Wrench::NONE, more, share);
        }
        self.settling = SETTLING;
        self.left = CHANGE_DURATION;
    }

    /// Nothing is left.
    pub fn end(&mut self) {
        self.settling = 0;
        self.left = 0.0;
    }

    /// Whether the devices are held as before.
    pub fn is_settling(&self) -> bool {
        self.settling > 0
    }

    fn share(&self) -> f64 {
        (self.left / CHANGE_DURATION).clamp(0.0, 1.0)
    }

    /// Puts what is asked for and what is left into `held`, which has what was held before. `before` is what the world of
    /// before the change asks for, where somebody knows it. `elapsed` is the time since the sample before `[s]`. Whether
    /// anything was left: then no limit of the world has seen what is to be held.
    pub fn answer(
        &mut self,
        asked: impl Iterator<Item = Wrench>,
        before: Option<&[Wrench]>,
        elapsed: f64,
        held: &mut [Wrench],
    ) -> bool {
        if self.left <= 0.0 {
            for (held, asked) in held.iter_mut().zip(asked) {
                *held = asked;
            }
            return false;
        }
        let is_settling = self.is_settling();
        if is_settling {
            self.settling -= 1;
        } else {
            // Of a time that is refused nothing is known.
            self.left -= if elapsed > 0.0 { elapsed } else { 0.0 };
        }
        let share = self.share();
        let devices = self.more.iter_mut().zip(&self.carried).enumerate();
        for ((held, (device, (more, carried))), asked) in held.iter_mut().zip(devices).zip(asked) {
            if is_settling {
                let as_before = before.and_then(|before| before.get(device));
                let reference = as_before.map_or(*held, |before| sum(before, carried, 1.0));
                *more = sum(&reference, &asked, -1.0);
            }
            *held = sum(&asked, more, share);
        }
        true
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

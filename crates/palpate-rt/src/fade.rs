//! Forces after a change of the world: the difference to the previous force fades, without a step.

use palpate_core::CHANGE_DURATION;
use palpate_device::Wrench;

/// Number of samples after a change during which devices hold the forces of the previous world. The first of them may
/// request an impulse correction for an interval that began in one world and ended in another.
const SETTLING: u32 = 3;

/// Fading difference to the force before a change.
#[derive(Clone, Debug)]
pub(crate) struct Fade {
    /// Difference between held and requested wrench of each device, before fading.
    more: Vec<Wrench>,
    /// Remaining difference of an earlier change that had not faded at this change.
    carried: Vec<Wrench>,
    /// Remaining number of samples during which devices hold the previous forces.
    settling: u32,
    /// Remaining time of the fade `[s]`; 0: inactive.
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

    /// Starts a fade after a change: the next forces are those of the previous world and then change over to the
    /// requested ones.
    pub fn begin(&mut self) {
        let share = self.share();
        for (carried, more) in self.carried.iter_mut().zip(&self.more) {
            *carried = sum(&Wrench::NONE, more, share);
        }
        self.settling = SETTLING;
        self.left = CHANGE_DURATION;
    }

    /// Ends the fade.
    pub fn end(&mut self) {
        self.settling = 0;
        self.left = 0.0;
    }

    /// Returns whether the devices hold the previous forces.
    pub fn is_settling(&self) -> bool {
        self.settling > 0
    }

    fn share(&self) -> f64 {
        (self.left / CHANGE_DURATION).clamp(0.0, 1.0)
    }

    /// Adds the fading difference to the requested wrenches and writes the sum to `held`, which contains the
    /// previously held wrenches. `before`: wrench of a device requested by the world before the change, if known.
    /// `elapsed`: time since the previous sample `[s]`. Returns whether a fade was active: then the limits of the world
    /// have not been applied to the sum.
    pub fn answer(
        &mut self,
        asked: impl Iterator<Item = Wrench>,
        before: impl Fn(usize) -> Option<Wrench>,
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
            // An invalid time does not advance the fade.
            self.left -= if elapsed > 0.0 { elapsed } else { 0.0 };
        }
        let share = self.share();
        let devices = self.more.iter_mut().zip(&self.carried).enumerate();
        for ((held, (device, (more, carried))), asked) in held.iter_mut().zip(devices).zip(asked) {
            if is_settling {
                let reference = before(device).map_or(*held, |before| sum(&before, carried, 1.0));
                *more = sum(&reference, &asked, -1.0);
            }
            *held = sum(&asked, more, share);
        }
        true
    }
}

/// Returns `one + share * other`.
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

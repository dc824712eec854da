//! Check that each motor turns its own joint in the right direction.

use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{DeviceError, DeviceErrorKind};
use palpate_rt::StopFlag;

use super::driver::TwoDiy;

/// Torque of a pulse `[N m]`: a quarter of the maximum, about 0.4 N at the end-point.
const TORQUE: f32 = 0.03;
/// A pulse ends after this time, or when the arm has moved by `FARTHEST` `[degrees]`.
const LONGEST_PULSE: Duration = Duration::from_millis(80);
const FARTHEST: f32 = 4.0;
/// Maximum number of attempts for a pulse, and for two equal verdicts in a row.
const TRIES: u32 = 5;
/// Minimum time without torque between pulses.
const REST: Duration = Duration::from_millis(250);
/// The arm is at rest if no joint has turned by more than this many quanta for `AT_REST_FOR`.
const AT_REST: f64 = 1.5;
const AT_REST_FOR: Duration = Duration::from_millis(100);
/// Time limit for the arm to come to rest.
const LONGEST_REST: Duration = Duration::from_secs(5);

/// Result of the check of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The motor turns its joint in the right direction.
    Fine,
    /// The motor turns its joint in the wrong direction: exchange its two wires, or change its direction setting.
    Reversed,
    /// The motor turns the other joint: exchange the two motors' cables, or their ports.
    Swapped,
    /// Nothing moves: no power, a loose cable, or a hand that holds the arm.
    Dead,
}

impl Verdict {
    /// Returns the name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Reversed => "reversed",
            Self::Swapped => "swapped",
            Self::Dead => "dead",
        }
    }

    /// Returns a description with the remedy.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Fine => "turns its joint the right way",
            Self::Reversed => "turns its joint the WRONG WAY: exchange its two wires",
            Self::Swapped => "turns the OTHER joint: exchange the cables of the two motors",
            Self::Dead => {
                "moves NOTHING: is the power supply on, is its cable in, does a hand hold the arm?"
            }
        }
    }
}

/// Verdict and measured motion of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    /// Verdict.
    pub verdict: Verdict,
    /// Rotation of joints 1 and 2 in a forward pulse minus that in a backward pulse `[degrees]`.
    pub turned: [f32; 2],
}

/// Reason why the motors were not checked. The commanded torque is zero.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unchecked {
    /// The stop flag was raised.
    #[error("ended before the motors were checked")]
    Stopped,
    /// The board does not answer, or this machine is too busy for short pulses.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl<C: Clock> TwoDiy<C> {
    /// Gives each motor a short weak forward pulse and a backward one, and measures which joint turns. **The arm
    /// moves** by a few degrees: warn the user, and keep hands off the arm. The torque is zero on return. The check
    /// ends within milliseconds after `stop` is raised. Connect the signals that end the program to `stop`, or they
    /// leave a torque on.
    ///
    /// # Errors
    /// `stop` was raised, or the board does not answer.
    pub fn check_motors(&mut self, stop: &StopFlag) -> Result<[Checked; 2], Unchecked> {
        let checked = self
            .check(0, stop)
            .and_then(|first| Ok([first, self.check(1, stop)?]));
        self.command([0.0; 2])?;
        checked
    }

    /// Requires two equal verdicts in a row: a single pair of pulses can be wrong because the program stalled or a hand
    /// touched the arm.
    fn check(&mut self, joint: usize, stop: &StopFlag) -> Result<Checked, Unchecked> {
        let mut before = self.check_once(joint, stop)?;
        for _ in 0..TRIES {
            let checked = self.check_once(joint, stop)?;
            if checked.verdict == before.verdict {
                return Ok(checked);
            }
            before = checked;
        }
        Err(refused(
            "successive pulses disagree: release the arm, close other programs and try again",
        ))
    }

    fn check_once(&mut self, joint: usize, stop: &StopFlag) -> Result<Checked, Unchecked> {
        let forwards = self.pulse(joint, TORQUE, stop)?;
        let backwards = self.pulse(joint, -TORQUE, stop)?;
        let turned = [0, 1].map(|k| forwards[k] - backwards[k]);
        let (own, other) = (turned[joint], turned[1 - joint]);
        let [first, second] = [0, 1].map(|k| 4.0 * self.board().quantum(self.layout(), k));
        let least = f64::max(first, second);
        let verdict = if f64::from(own.abs().max(other.abs())) < least {
            Verdict::Dead
        } else if other.abs() > 1.5 * own.abs() {
            Verdict::Swapped
        } else if own < 0.0 {
            Verdict::Reversed
        } else {
            Verdict::Fine
        };
        Ok(Checked { verdict, turned })
    }

    /// Returns the rotation of the joints in a pulse `[degrees]`. Repeats a pulse during which this program stalled,
    /// because the torque then lasted too long.
    fn pulse(&mut self, joint: usize, torque: f32, stop: &StopFlag) -> Result<[f32; 2], Unchecked> {
        for _ in 0..TRIES {
            let (moved, took) = self.pulse_once(joint, torque, stop)?;
            let is_too_far = moved.iter().any(|by| by.abs() > 3.0 * FARTHEST);
            if took < 2 * LONGEST_PULSE && !is_too_far {
                return Ok(moved);
            }
        }
        Err(refused(
            "this machine is too busy for short pulses: close other programs and try again",
        ))
    }

    fn pulse_once(
        &mut self,
        joint: usize,
        torque: f32,
        stop: &StopFlag,
    ) -> Result<([f32; 2], Duration), Unchecked> {
        let start = self.at_rest(stop)?;
        let mut torques = [0.0; 2];
        torques[joint] = torque;
        self.command(torques)?;
        let begun = Instant::now();
        let mut moved = [0.0_f32; 2];
        while begun.elapsed() < LONGEST_PULSE && moved.iter().all(|by| by.abs() < FARTHEST) {
            std::thread::sleep(Duration::from_millis(1));
            resume(stop)?;
            match self.ask_angles() {
                Ok(angles) => moved = [0, 1].map(|k| angles[k] - start[k]),
                Err(error) if error.kind == DeviceErrorKind::NothingNew => {}
                Err(error) => return Err(error.into()),
            }
        }
        self.command([0.0; 2])?;
        Ok((moved, begun.elapsed()))
    }

    /// Commands zero torque and returns the angles once the arm is at rest.
    fn at_rest(&mut self, stop: &StopFlag) -> Result<[f32; 2], Unchecked> {
        self.command([0.0; 2])?;
        let begun = Instant::now();
        let farthest = AT_REST * self.board().coarsest_quantum(self.layout());
        // The angles that the arm has kept, and the time since when.
        let mut kept: Option<([f32; 2], Instant)> = None;
        while begun.elapsed() < LONGEST_REST {
            std::thread::sleep(Duration::from_millis(2));
            resume(stop)?;
            let angles = match self.ask_angles() {
                Err(error) if error.kind == DeviceErrorKind::NothingNew => continue,
                answered => answered?,
            };
            let has_turned =
                |from: [f32; 2]| (0..2).any(|k| f64::from((angles[k] - from[k]).abs()) > farthest);
            match kept {
                Some((from, since)) if !has_turned(from) => {
                    if since.elapsed() >= AT_REST_FOR && begun.elapsed() >= REST {
                        return Ok(angles);
                    }
                }
                _ => kept = Some((angles, Instant::now())),
            }
        }
        Err(refused(if kept.is_some() {
            "the arm does not come to rest: release it"
        } else {
            "the board did not answer"
        }))
    }
}

fn refused(what: &'static str) -> Unchecked {
    Unchecked::Device(DeviceError::new(DeviceErrorKind::Refused, what))
}

fn resume(stop: &StopFlag) -> Result<(), Unchecked> {
    if stop.is_raised() {
        Err(Unchecked::Stopped)
    } else {
        Ok(())
    }
}

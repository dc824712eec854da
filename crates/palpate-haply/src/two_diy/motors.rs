//! Whether each motor turns its own joint, the right way.

use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{DeviceError, DeviceErrorKind};
use palpate_rt::StopFlag;

use super::driver::TwoDiy;

/// Torque of a pulse `[N m]`: a quarter of the largest, about 0.4 N at the end-point.
const TORQUE: f32 = 0.03;
/// A pulse ends after this, or when the arm has moved by that much `[degrees]`.
const LONGEST_PULSE: Duration = Duration::from_millis(80);
const FARTHEST: f32 = 4.0;
/// How often a pulse is tried, and a motor is tried until two verdicts in a row agree.
const TRIES: u32 = 5;
/// How long the arm is left alone between pulses, at least.
const REST: Duration = Duration::from_millis(250);
/// The arm is at rest when no joint has turned by more than this many quanta for that long.
const AT_REST: f64 = 1.5;
const AT_REST_FOR: Duration = Duration::from_millis(100);
/// How long the arm may take to come to rest.
const LONGEST_REST: Duration = Duration::from_secs(5);

/// What a motor does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It turns its joint the right way.
    Fine,
    /// It turns its joint the wrong way: exchange its two wires, or its direction.
    Reversed,
    /// It turns the other joint: exchange the two motors' cables, or their ports.
    Swapped,
    /// Nothing moves: no power, a loose cable, or a hand that holds on.
    Dead,
}

impl Verdict {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Reversed => "reversed",
            Self::Swapped => "swapped",
            Self::Dead => "dead",
        }
    }

    /// What to do about it.
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

/// A motor and what it moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    /// What it does.
    pub verdict: Verdict,
    /// By how much a pulse forwards turned joints 1 and 2 farther than one backwards `[degrees]`.
    pub turned: [f32; 2],
}

/// Why motors were not checked. No torque is commanded any more.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unchecked {
    /// The flag was raised.
    #[error("ended before the motors were checked")]
    Stopped,
    /// The board does not answer, or this machine is too busy for short pulses.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl<C: Clock> TwoDiy<C> {
    /// Gives each motor a short weak pulse forwards and one backwards, and looks at what turns.
    /// **The arm moves**, by a few degrees: nobody should hold it, and whoever calls this has been
    /// asked. It always ends without a torque, and within milliseconds once `stop` is raised: let
    /// the signals that end the program raise it, or they leave a torque on.
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

    /// One pair of pulses can mislead: a program that stood still meanwhile, a hand that touched the
    /// arm. Two in a row that agree do so only if the cause stays.
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
            "one pulse says another thing than the next: let go of the arm, close other programs \
             and try again",
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

    /// How far the joints turn in a pulse `[degrees]`. One during which this program stood still says
    /// nothing: the arm went on until it came back.
    fn pulse(&mut self, joint: usize, torque: f32, stop: &StopFlag) -> Result<[f32; 2], Unchecked> {
        for _ in 0..TRIES {
            let (moved, took) = self.pulse_once(joint, torque, stop)?;
            let is_too_far = moved.iter().any(|by| by.abs() > 3.0 * FARTHEST);
            if took < 2 * LONGEST_PULSE && !is_too_far {
                return Ok(moved);
            }
        }
        Err(refused(
            "this machine is too busy to give short pulses: close other programs and try again",
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
            go_on(stop)?;
            match self.ask_angles() {
                Ok(angles) => moved = [0, 1].map(|k| angles[k] - start[k]),
                Err(error) if error.kind == DeviceErrorKind::NothingNew => {}
                Err(error) => return Err(error.into()),
            }
        }
        self.command([0.0; 2])?;
        Ok((moved, begun.elapsed()))
    }

    /// The angles after the arm was left alone and has come to rest.
    fn at_rest(&mut self, stop: &StopFlag) -> Result<[f32; 2], Unchecked> {
        self.command([0.0; 2])?;
        let begun = Instant::now();
        let farthest = AT_REST * self.board().coarsest_quantum(self.layout());
        // The angles that the arm has kept, and since when.
        let mut kept: Option<([f32; 2], Instant)> = None;
        while begun.elapsed() < LONGEST_REST {
            std::thread::sleep(Duration::from_millis(2));
            go_on(stop)?;
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
            "the arm does not come to rest: let go of it"
        } else {
            "the board did not answer"
        }))
    }
}

fn refused(what: &'static str) -> Unchecked {
    Unchecked::Device(DeviceError::new(DeviceErrorKind::Refused, what))
}

fn go_on(stop: &StopFlag) -> Result<(), Unchecked> {
    if stop.is_raised() {
        Err(Unchecked::Stopped)
    } else {
        Ok(())
    }
}

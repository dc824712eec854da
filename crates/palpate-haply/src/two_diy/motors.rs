//! Whether each motor turns its own joint, the right way.

use std::time::{Duration, Instant};

use palpate_rt::StopFlag;
use palpate_rt::clock::Clock;
use palpate_rt::device::{DeviceError, DeviceErrorKind};

use super::driver::TwoDiy;

/// Torque of a pulse `[N m]`: a quarter of the largest, about 0.4 N at the end-point.
const TORQUE: f32 = 0.03;
/// A pulse ends after this, or when the arm has moved by that much `[degrees]`.
const LONGEST_PULSE: Duration = Duration::from_millis(80);
const FARTHEST: f32 = 4.0;
/// How often a pulse is tried.
const PULSES: u32 = 5;
/// How long the arm is left alone between pulses.
const REST: Duration = Duration::from_millis(250);

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

    fn check(&mut self, joint: usize, stop: &StopFlag) -> Result<Checked, Unchecked> {
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
        for _ in 0..PULSES {
            let (moved, took) = self.pulse_once(joint, torque, stop)?;
            let is_too_far = moved.iter().any(|by| by.abs() > 3.0 * FARTHEST);
            if took < 2 * LONGEST_PULSE && !is_too_far {
                return Ok(moved);
            }
        }
        Err(Unchecked::Device(DeviceError::new(
            DeviceErrorKind::Refused,
            "this machine is too busy to give short pulses: close other programs and try again",
        )))
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
            match self.ask() {
                Ok(angles) => moved = [0, 1].map(|k| angles[k] - start[k]),
                Err(error) if error.kind == DeviceErrorKind::NothingNew => {}
                Err(error) => return Err(error.into()),
            }
        }
        self.command([0.0; 2])?;
        Ok((moved, begun.elapsed()))
    }

    /// The angles after the arm was left alone.
    fn at_rest(&mut self, stop: &StopFlag) -> Result<[f32; 2], Unchecked> {
        self.command([0.0; 2])?;
        let begun = Instant::now();
        let mut last = Err(DeviceError::new(
            DeviceErrorKind::NothingNew,
            "the board did not answer",
        ));
        while begun.elapsed() < REST {
            std::thread::sleep(Duration::from_millis(2));
            go_on(stop)?;
            match self.ask() {
                Err(error) if error.kind == DeviceErrorKind::NothingNew => {}
                answered => last = Ok(answered?),
            }
        }
        Ok(last?)
    }
}

fn go_on(stop: &StopFlag) -> Result<(), Unchecked> {
    if stop.is_raised() {
        Err(Unchecked::Stopped)
    } else {
        Ok(())
    }
}

//! Arguments that say what a recording is: a motion, or a hand.

use clap::{Args, ValueEnum};
use palpate_study::recording::StatedHand;

use crate::failure::Failure;
use crate::values::number;

/// How a recording is replayed.
#[derive(Args, Debug)]
#[command(next_help_heading = "Replay")]
pub struct ReplayFlags {
    /// What is replayed: the recorded motion, or the hand that made it
    #[arg(long, value_name = "KIND", value_enum, default_value_t = ReplayKind::Motion)]
    pub replay: ReplayKind,
    /// Bandwidth of the hand's force [Hz] [default: the one under which the recording is most likely]
    #[arg(long, value_name = "Hz", value_parser = number, allow_hyphen_values = true)]
    pub hand_bandwidth: Option<f64>,
    /// Stiffness with which the hand holds on to its recorded motion [N/m]; 0 and no damping: its force
    /// stays the recorded one wherever the device goes [default: 60]
    #[arg(long, value_name = "N/m", value_parser = number, allow_hyphen_values = true)]
    pub hand_stiffness: Option<f64>,
    /// Damping with which it does [N s/m] [default: 2]
    #[arg(long, value_name = "N s/m", value_parser = number, allow_hyphen_values = true)]
    pub hand_damping: Option<f64>,
}

/// What is replayed of a recording.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayKind {
    /// The motion: the device goes where it went, whatever the force
    Motion,
    /// The hand: its force is estimated from the motion, and the device moves under the new force
    Hand,
}

impl ReplayFlags {
    /// What they state of a hand.
    pub fn stated_hand(&self) -> StatedHand {
        StatedHand {
            bandwidth: self.hand_bandwidth,
            stiffness: self.hand_stiffness,
            damping: self.hand_damping,
        }
    }

    /// Refuses a flag that is for a hand only where a motion is replayed.
    pub fn check(&self) -> Result<(), Failure> {
        if self.replay == ReplayKind::Hand {
            return Ok(());
        }
        let of_a_hand = [
            ("--hand-bandwidth", self.hand_bandwidth),
            ("--hand-stiffness", self.hand_stiffness),
            ("--hand-damping", self.hand_damping),
        ]
        .into_iter()
        .find_map(|(flag, value)| value.map(|_| flag));
        of_a_hand.map_or(Ok(()), |flag| {
            Err(Failure::Arguments(format!(
                "{flag} is for --replay hand; a motion is replayed as it was"
            )))
        })
    }
}

//! Arguments that interpret a recording as a motion or as a hand.

use clap::{Args, ValueEnum};
use palpate_study::recording::StatedHand;

use crate::failure::Failure;
use crate::values::number;

/// Replay of a recording.
#[derive(Args, Debug)]
#[command(next_help_heading = "Replay")]
pub struct ReplayFlags {
    /// Replay source: the recorded motion, or the hand that produced it
    #[arg(long, value_name = "KIND", value_enum, default_value_t = ReplayKind::Motion)]
    pub replay: ReplayKind,
    /// Bandwidth of the hand's force [Hz] [default: the most likely one for the recording]
    #[arg(long, value_name = "Hz", value_parser = number, allow_hyphen_values = true)]
    pub hand_bandwidth: Option<f64>,
    /// Stiffness of the spring from the hand to its recorded motion [N/m]; with 0 and no damping its force is the
    /// recorded one regardless of the device's motion [default: 60]
    #[arg(long, value_name = "N/m", value_parser = number, allow_hyphen_values = true)]
    pub hand_stiffness: Option<f64>,
    /// Damping of that spring [N s/m] [default: 2]
    #[arg(long, value_name = "N s/m", value_parser = number, allow_hyphen_values = true)]
    pub hand_damping: Option<f64>,
}

/// Source of a replay.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayKind {
    /// The motion: the device follows its recorded motion regardless of the force
    Motion,
    /// The hand: its force is estimated from the motion, and the device moves under the new force
    Hand,
}

impl ReplayFlags {
    /// Returns the parameters of a hand from the flags.
    pub fn stated_hand(&self) -> StatedHand {
        StatedHand {
            bandwidth: self.hand_bandwidth,
            stiffness: self.hand_stiffness,
            damping: self.hand_damping,
        }
    }

    /// Rejects a flag of the hand if a motion is replayed.
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
                "{flag} is for --replay hand; motion replay has no hand model"
            )))
        })
    }
}

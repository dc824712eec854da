//! What happens in a run.

use palpate::{AnyParams, HfcrParams};
use palpate_firmware_knob::{KnobParams, WhenSilent};

use crate::example;
use crate::handle::Handle;

/// A run, by the number that the emulator is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A constant force of 1 N, from 0.06 s on, lets the rim bounce on the wall, rendered by coupled rendering.
    Wall,
    /// The same, by HFCR.
    WallByHfcr,
    /// The same, by the plain spring force.
    WallByBasic,
    /// A hand goes in and out of the wall; the host falls silent from 0.4 to 0.8 s, and the loop goes on.
    SilentHost,
    /// The same, and the loop lets go.
    SilentHostLetsGo,
    /// The loop stalls in the wall.
    Stall,
    /// The loop stalls in the wall, and holds up the supervisor too.
    StallOfAll,
    /// The sensor jumps by 3000 counts for one tick, in the wall.
    Glitch,
    /// The board starts while the hand holds the rim inside the wall.
    StartInside,
}

/// How a loop stalls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stall {
    /// It does not.
    Not = 0,
    /// It does not come back.
    Loop = 1,
    /// It does not come back, and masks the interrupt of the supervisor.
    Masked = 2,
}

impl Scene {
    /// The scene of a number, as `palpate-firmware-check` counts them.
    pub fn of(number: u32) -> Self {
        match number {
            0 => Self::Wall,
            1 => Self::WallByHfcr,
            2 => Self::WallByBasic,
            3 => Self::SilentHost,
            4 => Self::SilentHostLetsGo,
            5 => Self::Stall,
            6 => Self::StallOfAll,
            7 => Self::Glitch,
            8 => Self::StartInside,
            other => panic!("no scene {other}"),
        }
    }

    /// Where the handle is at first.
    pub fn start(self) -> Handle {
        match self {
            Self::StartInside => Handle {
                position: 0.002,
                ..Handle::default()
            },
            _ => Handle::default(),
        }
    }

    /// What the wall is rendered by.
    pub fn method(self) -> AnyParams<f32> {
        match self {
            Self::WallByBasic => AnyParams::Basic,
            Self::WallByHfcr => AnyParams::Hfcr(HfcrParams::default()),
            _ => AnyParams::Coupled(example::coupled()),
        }
    }

    /// The knob.
    pub fn params(self) -> KnobParams {
        match self {
            Self::SilentHostLetsGo => KnobParams {
                // 20 ms: the host speaks every 4 ms.
                when_silent: WhenSilent::LetGo { after: 80 },
                ..example::PARAMS
            },
            _ => example::PARAMS,
        }
    }

    /// Force of the hand on the rim `[N]` at `time` `[s]`: constant, or by a spring to where the hand is.
    pub fn hand(self, time: f32, handle: &Handle) -> f32 {
        if matches!(self, Self::Wall | Self::WallByHfcr | Self::WallByBasic) {
            // Once the soft start is over, so that the wall alone is judged.
            return if time < 0.06 { 0.0 } else { 1.0 };
        }
        // In and out four times a second, from 5 mm inside the wall to 8 mm in front of it, and at first
        // outside, or inside where the scene begins there.
        let begins_inside = self == Self::StartInside;
        let turns = 4.0 * time + if begins_inside { 0.5 } else { 0.0 };
        #[allow(clippy::cast_possible_truncation)] // a few turns
        let part = turns - (turns as i32) as f32;
        let inside = if part < 0.5 {
            2.0 * part
        } else {
            2.0 - 2.0 * part
        };
        let hand_at = -0.008 + 0.013 * inside;
        1000.0 * (hand_at - handle.position) - 4.0 * handle.velocity
    }

    /// Whether the host speaks at `time` `[s]`.
    pub fn host_speaks(self, time: f32) -> bool {
        !(0.4..0.8).contains(&time)
    }

    /// How the loop stalls at the event.
    pub fn stall(self) -> Stall {
        match self {
            Self::Stall => Stall::Loop,
            Self::StallOfAll => Stall::Masked,
            _ => Stall::Not,
        }
    }

    /// Whether the event is a jump of the sensor.
    pub fn has_glitch(self) -> bool {
        self == Self::Glitch
    }
}

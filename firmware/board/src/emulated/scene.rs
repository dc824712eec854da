//! Scenes of the emulated runs.

use palpate::{AnyParams, HfcrParams};
use palpate_firmware_knob::{KnobParams, WhenSilent};

use crate::example;
use crate::handle::Handle;

/// A scene, by the number passed to the emulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// With a constant force of 1 N, from 0.06 s on, the rim bounces on the wall, rendered by coupled rendering.
    Wall,
    /// The bouncing rim, by HFCR.
    WallByHfcr,
    /// The bouncing rim, by the plain spring force.
    WallByBasic,
    /// A hand moves in and out of the wall; the host is silent from 0.4 to 0.8 s, and the loop continues.
    SilentHost,
    /// With the silent host, the loop disables its output.
    SilentHostLetsGo,
    /// The loop stalls in the wall.
    Stall,
    /// The loop stalls in the wall and blocks the supervisor too.
    StallOfAll,
    /// The sensor jumps by 3000 counts for one tick, in the wall.
    Glitch,
    /// The board starts while the hand holds the rim inside the wall.
    StartInside,
    /// The bouncing rim, on a wall of the host, whose constant forces the board holds.
    HostConstants,
    /// The same with the host's lines.
    HostLines,
    /// A line of the host comes one and a half of its periods late.
    HostLineLate,
    /// The host is silent from 0.4 to 0.8 s.
    HostLinesSilent,
}

/// Stall of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stall {
    /// No stall.
    Not = 0,
    /// The loop does not return.
    Loop = 1,
    /// The loop does not return, and masks the supervisor's interrupt.
    Masked = 2,
}

impl Scene {
    /// Returns the scene of a number, as in `palpate-firmware-check`.
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
            9 => Self::HostConstants,
            10 => Self::HostLines,
            11 => Self::HostLineLate,
            12 => Self::HostLinesSilent,
            other => panic!("no scene {other}"),
        }
    }

    /// Returns the initial state of the handle.
    pub fn start(self) -> Handle {
        match self {
            Self::StartInside => Handle {
                position: 0.002,
                ..Handle::default()
            },
            _ => Handle::default(),
        }
    }

    /// Returns the method that renders the wall.
    pub fn method(self) -> AnyParams<f32> {
        match self {
            Self::WallByBasic => AnyParams::Basic,
            Self::WallByHfcr => AnyParams::Hfcr(HfcrParams::default()),
            _ => AnyParams::Coupled(example::coupled()),
        }
    }

    /// Returns the parameters of the knob.
    pub fn params(self) -> KnobParams {
        match self {
            Self::SilentHostLetsGo => KnobParams {
                // 20 ms: the host sends a message every 4 ms.
                when_silent: WhenSilent::DisableOutput { after: 80 },
                ..example::PARAMS
            },
            _ => example::PARAMS,
        }
    }

    /// Returns the force of the hand on the rim `[N]` at `time` `[s]`: constant, or a spring to the hand's position.
    pub fn hand(self, time: f32, handle: &Handle) -> f32 {
        let bounces = matches!(self, Self::Wall | Self::WallByHfcr | Self::WallByBasic);
        if bounces || self.is_of_the_host() {
            // After the soft start, so that only the wall is evaluated.
            return if time < 0.06 { 0.0 } else { 1.0 };
        }
        // In and out four times a second, from 5 mm inside the wall to 8 mm in front of it. The motion begins outside,
        // or inside if the scene begins there.
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

    /// Whether the host sends messages at `time` `[s]`.
    pub fn host_speaks(self, time: f32) -> bool {
        !(0.4..0.8).contains(&time)
    }

    /// Returns the stall of the loop at the event.
    pub fn stall(self) -> Stall {
        match self {
            Self::Stall => Stall::Loop,
            Self::StallOfAll => Stall::Masked,
            _ => Stall::Not,
        }
    }

    /// Whether the host renders the wall.
    pub fn is_of_the_host(self) -> bool {
        matches!(
            self,
            Self::HostConstants | Self::HostLines | Self::HostLineLate | Self::HostLinesSilent
        )
    }

    /// Whether the event is a late message of the host.
    pub fn has_late_line(self) -> bool {
        self == Self::HostLineLate
    }

    /// Whether the event is a jump of the sensor.
    pub fn has_glitch(self) -> bool {
        self == Self::Glitch
    }
}

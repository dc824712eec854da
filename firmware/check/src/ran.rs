//! Runs of the knob.

use std::error::Error;

use crate::qemu::{Core, Time};

/// Address of the pins of the emulated board.
const PINS: u32 = 0x2030_0000;

/// The scenes of the program `knob`, by their numbers there (`board/src/emulated/scene.rs`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // said there
pub enum Scene {
    Wall,
    WallByHfcr,
    WallByBasic,
    SilentHost,
    SilentHostLetsGo,
    Stall,
    StallOfAll,
    Glitch,
    StartInside,
    HostConstants,
    HostLines,
    HostLineLate,
    HostLinesSilent,
}

/// Status numbers of the loop: `palpate_firmware_knob::Status`.
pub mod status {
    #![allow(missing_docs)] // said there
    pub const WAITING: u32 = 0;
    pub const COMING_IN: u32 = 1;
    pub const RENDERING: u32 = 2;
    pub const SAMPLE_REFUSED: u32 = 3;
    pub const HOST_SILENT: u32 = 4;
}

/// State of the world, once per period of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Time since the start of the world `[s]`.
    pub time: f64,
    /// Position of the rim `[m]`; the wall is at 0.
    pub position: f64,
    /// Velocity of the rim `[m/s]`.
    pub velocity: f64,
    /// Force of the motor on the rim `[N]`.
    pub motor: f64,
    /// Work of the hand on the rim `[J]`.
    pub hand_work: f64,
    /// Work of the motor on the rim `[J]`.
    pub motor_work: f64,
    /// Status of the loop: see [`status`].
    pub status: u32,
    /// Number of starts of the controller.
    pub starts: u32,
}

/// A run of 1.2 s.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Entries in order of time.
    pub entries: Vec<Entry>,
    /// Time of the scene's event `[s]`.
    pub event: Option<f64>,
    /// Longest tick, including its interruptions `[s]`.
    pub longest: f64,
    /// Ticks longer than a period.
    pub overruns: u32,
    /// Started ticks.
    pub ticks: u32,
}

/// Start delays of the board's interrupts, after one period each, in counts of its 25 MHz timer. In firmware, the
/// compiler changes them with the length of the preceding code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Phases {
    /// Delay of the first tick of the loop.
    pub of_loop: u32,
    /// Delay of the first check of the supervisor.
    pub of_supervisor: u32,
}

/// Period of the host in ticks of the loop, if it renders: 100 to 1000 Hz are 40 to 4 ticks.
pub const HOST_TICKS: u32 = 16;

/// Runs `scene` on `core`.
///
/// # Errors
/// The program does not run, or its output is invalid.
pub fn ran(core: Core, scene: Scene, phases: Phases) -> Result<Ran, Box<dyn Error>> {
    ran_by_host(core, scene, phases, HOST_TICKS)
}

/// Runs `scene` on `core` with a host of a period of `host_ticks`.
///
/// # Errors
/// Those of [`ran`].
pub fn ran_by_host(
    core: Core,
    scene: Scene,
    phases: Phases,
    host_ticks: u32,
) -> Result<Ran, Box<dyn Error>> {
    // Words of `emulated::Pins` of the board.
    let words = [
        (PINS, scene as u32),
        (PINS + 44, phases.of_loop),
        (PINS + 48, phases.of_supervisor),
        (PINS + 52, host_ticks),
    ];
    let said = core.run("knob", Time::Real, &words)?;
    let mut ran = Ran {
        entries: Vec::new(),
        event: None,
        longest: 0.0,
        overruns: 0,
        ticks: 0,
    };
    for line in said.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            [
                "entry",
                time,
                position,
                velocity,
                motor,
                hand,
                motor_work,
                status,
                starts,
            ] => {
                ran.entries.push(Entry {
                    time: time.parse()?,
                    position: position.parse()?,
                    velocity: velocity.parse()?,
                    motor: motor.parse()?,
                    hand_work: hand.parse()?,
                    motor_work: motor_work.parse()?,
                    status: status.parse()?,
                    starts: starts.parse()?,
                });
            }
            ["event", time] => ran.event = Some(time.parse()?),
            ["loop", longest, overruns, ticks] => {
                // Counts of 25 MHz.
                ran.longest = longest.parse::<f64>()? / 25e6;
                ran.overruns = overruns.parse()?;
                ran.ticks = ticks.parse()?;
            }
            _ => return Err(format!("the knob says `{line}`").into()),
        }
    }
    Ok(ran)
}

impl Ran {
    /// Returns the speeds at which the rim leaves the wall `[m/s]`.
    pub fn rebounds(&self) -> Vec<f64> {
        self.entries
            .windows(2)
            .filter(|pair| pair[0].position > 0.0 && pair[1].position <= 0.0)
            .map(|pair| pair[1].velocity.abs())
            .collect()
    }

    /// Returns the entries from `from` to `to` `[s]`.
    pub fn between(&self, from: f64, to: f64) -> impl Iterator<Item = &Entry> {
        self.entries
            .iter()
            .filter(move |entry| (from..to).contains(&entry.time))
    }

    /// Returns the first time after `from` `[s]` at which the motor's force is 0.
    pub fn off_after(&self, from: f64) -> Option<f64> {
        self.between(from, f64::INFINITY)
            .find(|entry| entry.motor == 0.0)
            .map(|entry| entry.time)
    }
}

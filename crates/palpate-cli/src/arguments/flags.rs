//! Flags shared by several commands, in SI units.

use clap::{ArgAction, Args};
use palpate_core::Side;
use palpate_scene::GuardMode;

use super::actuation::ActuationFlags;
use super::edits::EditFlags;
use super::setting_flags::{SettingFlags, method_help};
use crate::values::{AnyMethods, any_methods, guard, limit, number, period, side, whole};

/// Timing imperfections of a scene's loop.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Loop")]
pub struct TimingFlags {
    /// Fraction of a period, below 1, on top of --delay-periods [default: 0, or the scene's]
    #[arg(long, value_name = "FRACTION", value_parser = number, allow_hyphen_values = true)]
    pub delay_fraction: Option<f64>,
    /// Samples are uniformly distributed within this much of their instant, below half a period [s] [default: 0, or the
    /// scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub jitter: Option<f64>,
    /// Probability, below 1, that a sample is lost; the force stays held [default: 0, or the scene's]
    #[arg(long, value_name = "PROBABILITY", value_parser = number, allow_hyphen_values = true)]
    pub drop: Option<f64>,
    /// Seed of the random numbers of --jitter and --drop [default: 0, or the scene's]
    #[arg(long, value_name = "NUMBER", value_parser = whole::<u64>)]
    pub seed: Option<u64>,
}

/// Flags of every command that renders, in SI units.
#[derive(Args, Debug, Default)]
pub struct Flags {
    /// Edits of the scene.
    #[command(flatten)]
    pub edits: EditFlags,
    /// Contact stiffness K [N/m]
    #[arg(
        long,
        value_name = "N/m",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub stiffness: Option<f64>,
    /// Mass M of the object [kg]; inf is a wall
    #[arg(
        long,
        value_name = "kg|inf",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub mass: Option<f64>,
    /// Virtual force f_V on the object [N], such as its weight [default: 0, or the scene's]
    #[arg(
        long,
        value_name = "N",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub force: Option<f64>,
    /// Position of the object at the start [m] [default: 0, or the scene's]
    #[arg(
        long,
        value_name = "m",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub object_position: Option<f64>,
    /// Velocity of the object at the start [m/s] [default: 0, or the scene's]
    #[arg(
        long,
        value_name = "m/s",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub object_velocity: Option<f64>,
    /// Side of the device on which the object lies: positive or negative [default:
    /// positive, or the scene's]
    #[arg(long, value_name = "SIDE", value_parser = side, help_heading = "Contact")]
    pub side: Option<Side>,
    /// Never pull: clamp attractive forces to 0
    #[arg(long, action = ArgAction::SetTrue, help_heading = "Contact")]
    pub unilateral: bool,

    /// Nominal period T of the loop [s]
    #[arg(
        long,
        value_name = "s",
        value_parser = period,
        allow_hyphen_values = true,
        help_heading = "Loop"
    )]
    pub period: Option<f64>,
    /// Largest force [N], of a command and of the command times --gain; inf: no limit [default: no limit,
    /// or the scene's; in pipe 20]
    #[arg(
        long,
        value_name = "N",
        value_parser = limit,
        allow_hyphen_values = true,
        help_heading = "Loop"
    )]
    pub force_limit: Option<f64>,
    /// Fastest change of the same force [N/s], also in a soft start; a safety stop sets it to 0 at once [default: no
    /// limit]
    #[arg(
        long,
        value_name = "N/s",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Loop"
    )]
    pub slew_limit: Option<f64>,
    /// Device speed above which a sample is rejected [m/s] [default: 100; no limit in simulate]
    #[arg(
        long,
        value_name = "m/s",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Loop"
    )]
    pub speed_limit: Option<f64>,
    /// Longest time between samples that is bridged [s] [default: 20 periods]
    #[arg(
        long,
        value_name = "s",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Loop"
    )]
    pub largest_gap: Option<f64>,
    /// Passivity guard, against energy that held forces output beyond the available energy: off, report, or limit,
    /// which limits the force so that no device speed up to --guard-speed exceeds it [default: off, or the scene's]
    #[arg(long, value_name = "MODE", value_parser = guard, help_heading = "Loop")]
    pub guard: Option<GuardMode>,
    /// Largest device speed for which the guard is designed [m/s] [default: 1]
    #[arg(
        long,
        value_name = "m/s",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard",
        help_heading = "Loop"
    )]
    pub guard_speed: Option<f64>,
    /// Largest acceleration of the device by everything except the rendered force, for example hand force over device
    /// mass: the guard then also permits each force that cannot give out too much before the next sample, and charges
    /// the sensor's quantum and forces that change between samples [m/s^2] [default: no bound]
    #[arg(
        long,
        value_name = "m/s^2",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard",
        group = "guard_hand",
        help_heading = "Loop"
    )]
    pub guard_acceleration: Option<f64>,
    /// Largest force on the device by everything except the rendered force, instead of --guard-acceleration: its
    /// acceleration is at most this force over the least device mass [N] [default: no bound]
    #[arg(
        long,
        value_name = "N",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard",
        group = "guard_hand",
        help_heading = "Loop"
    )]
    pub guard_hand_force: Option<f64>,
    /// Least device mass for which the guard is designed [kg] [default: half the model mass of the device]
    #[arg(
        long,
        value_name = "kg",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard_hand",
        help_heading = "Loop"
    )]
    pub guard_mass: Option<f64>,
    /// Raise the least mass to the mass that the motion shows; it must be the same in every pose
    #[arg(long, requires = "guard_hand", help_heading = "Loop")]
    pub guard_learn_mass: bool,
    /// Power by which the guard forgives energy that may have been given out unnoticed; 0: none [W] [default: 0.02]
    #[arg(
        long,
        value_name = "W",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard",
        help_heading = "Loop"
    )]
    pub guard_recovery: Option<f64>,
    /// Additional energy allowance of the guard [J] [default: 0.001; 0.02 with --guard-acceleration or --guard-hand-force; 0.05 in a
    /// world]
    #[arg(
        long,
        value_name = "J",
        value_parser = number,
        allow_hyphen_values = true,
        requires = "guard",
        help_heading = "Loop"
    )]
    pub guard_allowance: Option<f64>,

    /// Delay, lag and gain.
    #[command(flatten)]
    pub actuation: ActuationFlags,

    /// The methods to run.
    #[arg(
        long,
        value_name = "NAMES",
        value_parser = any_methods,
        help = method_help(),
        help_heading = "Method"
    )]
    pub method: Option<AnyMethods>,
    #[command(flatten)]
    pub settings: SettingFlags,

    /// Effective mass of the device [kg]
    #[arg(
        long,
        value_name = "kg",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Device"
    )]
    pub device_mass: Option<f64>,
    /// Model value of the device mass [kg]; simulate and tune only, whose device has its own mass [default: the
    /// effective mass, or the scene's]
    #[arg(
        long,
        value_name = "kg",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Device"
    )]
    pub model_device_mass: Option<f64>,
    /// Quantum of the device's position sensor [m]; simulate applies it, a recording or a pipe contains it already
    #[arg(
        long,
        value_name = "m",
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = "Device"
    )]
    pub encoder_quantum: Option<f64>,
}

//! Parameters of the loop and of its device in the C API.

use palpate_core::{
    Actuation, Allowed, Guard, GuardParams, HandBound, HandLimit, Hold, LoopParams as Core,
    Parameter, ParameterError, Scalar,
};

use crate::choice;
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Default force limit [N], equal to that of the program.
const FORCE_LIMIT: f64 = 20.0;

/// Mode of the guard, which bounds the energy that held forces generate.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuardKind {
    /// The guard is off.
    Off = 0,
    /// A force beyond the bound is held and reported.
    Report = 1,
    /// Forces are limited to the bound.
    Limit = 2,
}

impl GuardKind {
    /// Returns the error of an unknown mode.
    pub(crate) const fn unknown<'a>(name: &'static str, given: u32) -> Refusal<'a> {
        Refusal::Choice {
            name,
            given,
            allowed: "PALPATE_GUARD_OFF, PALPATE_GUARD_REPORT or PALPATE_GUARD_LIMIT",
        }
    }
}

/// Force that the actuator holds for each command, over one period.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldKind {
    /// A constant: zero-order hold.
    Constant = 0,
    /// A line: `force_on_device + slope_on_device (t - T/2)` for t from 0 to the period T, then its last value. It
    /// requires coupled rendering and an output at each tick, and excludes a lag, a slew limit and a guard.
    Line = 1,
}

impl HoldKind {
    /// Returns the hold of a field.
    pub(crate) fn read<'a>(given: u32) -> Result<Hold, Refusal<'a>> {
        match given {
            0 => Ok(Hold::Constant),
            1 => Ok(Hold::Line),
            given => Err(Refusal::Choice {
                name: "hold",
                given,
                allowed: "PALPATE_HOLD_CONSTANT or PALPATE_HOLD_LINE",
            }),
        }
    }
}

/// Parameters of the loop and its device, and the limits. palpate_loop_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LoopParams {
    /// Size of this struct; palpate_loop_params_default() sets it.
    pub struct_size: usize,
    /// Nominal time T between samples [s], greater than 0: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Largest allowed time between two samples [s]; a longer gap is a fault. 0: 20 periods.
    pub largest_gap: f64,
    /// Largest accepted device speed [m/s]; a faster jump is a fault. INFINITY: no limit.
    /// Default: 100.
    pub speed_limit: f64,
    /// Largest held force [N]. INFINITY: no limit. Default: 20.
    pub force_limit: f64,
    /// Largest rate of change of the held force [N/s]. INFINITY, the default: no limit.
    pub slew_limit: f64,
    /// Delay from a sample to the start of its force [s], at most 8 periods. Default: 0.
    pub delay: f64,
    /// Standard deviation of the delay, including its variation between commands [s], at most 8 periods.
    pub delay_deviation: f64,
    /// Time constant of the actuator [s]. Default: 0.
    pub lag: f64,
    /// Standard deviation of the lag [s], at most 8 periods.
    pub lag_deviation: f64,
    /// Ratio of delivered to commanded force, greater than 0. Default: 1.
    pub gain: f64,
    /// Standard deviation of the gain, at most the gain.
    pub gain_deviation: f64,
    /// Effective mass of the device at its end-point [kg], within a factor of 2; coupled rendering needs
    /// it. 0, the default: unknown. INFINITY: the device is position-driven by a recording.
    pub device_mass: f64,
    /// Quantum of the position sensor [m]. 0, the default: unknown or none.
    pub encoder_quantum: f64,
    /// Largest device speed for which the guard's bound holds [m/s].
    pub guard_speed: f64,
    /// Energy that the guard allows beyond the energy balance [J].
    pub guard_allowance: f64,
    /// Largest acceleration of the device by everything except the rendered force [m/s^2]: see HandBound. 0, the
    /// default: none. Else guard_mass is needed. Without it and guard_hand_force the guard bounds by speed only.
    pub guard_acceleration: f64,
    /// Largest force on the device by everything except the rendered force [N], instead of guard_acceleration, which is
    /// then this force over guard_mass. 0, the default: none.
    pub guard_hand_force: f64,
    /// Least mass of the device for the bound by acceleration [kg], greater than 0.
    pub guard_mass: f64,
    /// Power by which the guard forgives energy that may have been given out unnoticed [W]. Default: 0.
    pub guard_recovery: f64,
    /// A palpate_guard. Default: PALPATE_GUARD_OFF.
    pub guard: u32,
    /// A palpate_hold: what the actuator holds. Default: PALPATE_HOLD_CONSTANT.
    pub hold: u32,
    /// 1: the motion may raise guard_mass; the mass must be the same in every pose. Default: 0.
    pub guard_learns_mass: u32,
    /// Must be 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for LoopParams {
    const NAME: &'static str = "palpate_loop_params";
}

/// Loop parameters of the core, and the values from which method settings are derived.
pub(crate) struct Loop<S> {
    pub params: Core<S>,
    pub device_mass: Option<f64>,
    pub encoder_quantum: f64,
    pub recorded: bool,
}

impl Default for LoopParams {
    fn default() -> Self {
        let core = Core::new(0.0).with_force_limit(FORCE_LIMIT);
        let Actuation {
            delay,
            lag,
            gain,
            delay_deviation,
            lag_deviation,
            gain_deviation,
            transmission: _,
            hold: _,
        } = core.actuation;
        let limit = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
        Self {
            struct_size: size_of::<Self>(),
            period: core.period,
            largest_gap: 0.0,
            speed_limit: limit(core.speed_limit),
            force_limit: limit(core.force_limit),
            slew_limit: limit(core.slew_limit),
            delay,
            delay_deviation,
            lag,
            lag_deviation,
            gain,
            gain_deviation,
            device_mass: 0.0,
            encoder_quantum: 0.0,
            guard_speed: 0.0,
            guard_allowance: 0.0,
            guard_acceleration: 0.0,
            guard_hand_force: 0.0,
            guard_mass: 0.0,
            guard_recovery: 0.0,
            guard: GuardKind::Off as u32,
            hold: HoldKind::Constant as u32,
            guard_learns_mass: 0,
            reserved: 0,
        }
    }
}

impl LoopParams {
    /// Returns the loop parameters of the core, rounded to `S`. The core checks their ranges.
    pub(crate) fn checked<S: Scalar>(&self) -> Result<Loop<S>, Refusal<'static>> {
        let number = S::from_f64;
        let limit = |limit: f64| (limit != f64::INFINITY).then_some(number(limit));
        let refused = |parameter, value, words| {
            Refusal::Parameter(ParameterError {
                parameter,
                value,
                allowed: Allowed::Words(words),
            })
        };
        choice::unused(self.reserved)?;
        let learns_mass = choice::switch("guard_learns_mass", self.guard_learns_mass)?;
        let hand = match (self.guard_acceleration, self.guard_hand_force) {
            (0.0, 0.0) => None,
            (acceleration, 0.0) => Some(HandLimit::Acceleration(number(acceleration))),
            (0.0, force) => Some(HandLimit::Force(number(force))),
            (_, force) => {
                return Err(refused(
                    Parameter::GuardHandForce,
                    force,
                    "0 if guard_acceleration is given",
                ));
            }
        };
        let guard_params = GuardParams {
            largest_speed: number(self.guard_speed),
            allowance: number(self.guard_allowance),
            quantum: number(self.encoder_quantum),
            recovery: number(self.guard_recovery),
            hand: hand.map(|limit| HandBound {
                limit,
                least_mass: number(self.guard_mass),
                learns_mass,
            }),
        };
        let guard = match self.guard {
            0 => Guard::Off,
            1 => Guard::Report(guard_params),
            2 => Guard::Limit(guard_params),
            given => return Err(GuardKind::unknown("guard", given)),
        };
        let hold = HoldKind::read(self.hold)?;
        let recorded = self.device_mass == f64::INFINITY;
        if self.device_mass.is_nan() || self.device_mass < 0.0 {
            let words = "greater than 0, or 0 if unknown";
            return Err(refused(Parameter::DeviceMass, self.device_mass, words));
        }
        if !(self.encoder_quantum.is_finite() && self.encoder_quantum >= 0.0) {
            let words = "finite and not below 0";
            return Err(refused(
                Parameter::EncoderQuantum,
                self.encoder_quantum,
                words,
            ));
        }
        Ok(Loop {
            params: Core {
                period: number(self.period),
                largest_gap: (self.largest_gap != 0.0).then_some(number(self.largest_gap)),
                speed_limit: limit(self.speed_limit),
                force_limit: limit(self.force_limit),
                slew_limit: limit(self.slew_limit),
                actuation: Actuation {
                    delay: number(self.delay),
                    lag: number(self.lag),
                    gain: number(self.gain),
                    delay_deviation: number(self.delay_deviation),
                    lag_deviation: number(self.lag_deviation),
                    gain_deviation: number(self.gain_deviation),
                    transmission: None,
                    hold,
                },
                guard,
            },
            device_mass: (self.device_mass > 0.0 && !recorded).then_some(self.device_mass),
            encoder_quantum: self.encoder_quantum,
            recorded,
        })
    }
}

/// Fills loop parameters with the defaults. `struct_size` is sizeof(palpate_loop_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_loop_params_init(
    params: *mut LoopParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, LoopParams::default()) })
}

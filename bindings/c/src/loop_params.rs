//! The loop and the device in it, as C says them.

use palpate::{
    Actuation, Allowed, Guard, GuardParams, LoopParams as Core, Parameter, ParameterError, Scalar,
};

use crate::choice;
use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};

/// Largest force that is held unless another one is set [N], as in the program.
const FORCE_LIMIT: f64 = 20.0;

/// Whether the energy that held forces give out is bounded.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuardKind {
    /// It is not.
    Off = 0,
    /// A force beyond the bound is held and reported.
    Report = 1,
    /// No force exceeds the bound.
    Limit = 2,
}

/// The loop, the device in it, and what must never be exceeded. palpate_loop_params_default() fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LoopParams {
    /// Size of this struct; palpate_loop_params_default() sets it.
    pub struct_size: usize,
    /// Nominal time T between samples [s], greater than 0: 0.001 is 1 ms. It has no default.
    pub period: f64,
    /// Longest time between two samples that is bridged [s]; a longer one is a fault. 0: 20 periods.
    pub largest_gap: f64,
    /// Fastest device motion that is believed [m/s]; a faster jump is a fault. INFINITY believes any.
    /// Default: 100.
    pub speed_limit: f64,
    /// Largest force that is held [N]. INFINITY: no limit. Default: 20.
    pub force_limit: f64,
    /// Fastest change of the held force [N/s]. INFINITY, the default: no limit.
    pub slew_limit: f64,
    /// Time from a sample to the beginning of its force [s], at most 8 periods. Default: 0.
    pub delay: f64,
    /// Standard deviation of the delay, its changes from command to command included [s].
    pub delay_deviation: f64,
    /// Time constant of the actuator [s]. Default: 0.
    pub lag: f64,
    /// Standard deviation of the lag [s].
    pub lag_deviation: f64,
    /// Delivered over commanded force, greater than 0. Default: 1.
    pub gain: f64,
    /// Standard deviation of the gain.
    pub gain_deviation: f64,
    /// Effective mass of the device at its end-point [kg], within a factor of 2; coupled rendering needs
    /// it. 0, the default: not known. INFINITY: a recording moves the device, and no force can.
    pub device_mass: f64,
    /// Quantum of the position sensor [m]; 0, the default: not known to have one.
    pub encoder_quantum: f64,
    /// Fastest device motion against which the guard's bound holds [m/s].
    pub guard_speed: f64,
    /// Energy that the guard lets be given out beyond the balance [J].
    pub guard_allowance: f64,
    /// A palpate_guard. Default: PALPATE_GUARD_OFF.
    pub guard: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for LoopParams {
    const NAME: &'static str = "palpate_loop_params";
}

/// The loop as the core has it, with what methods are derived from.
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
            guard: GuardKind::Off as u32,
            reserved: 0,
        }
    }
}

impl LoopParams {
    /// As the core has it, rounded to its numbers; the core checks what it has.
    pub(crate) fn checked<S: Scalar>(&self) -> Result<Loop<S>, Refusal<'static>> {
        let number = S::from_f64;
        let limit = |limit: f64| (limit != f64::INFINITY).then_some(number(limit));
        let guard_params = GuardParams {
            largest_speed: number(self.guard_speed),
            allowance: number(self.guard_allowance),
        };
        let guard = match self.guard {
            0 => Guard::Off,
            1 => Guard::Report(guard_params),
            2 => Guard::Limit(guard_params),
            given => {
                return Err(Refusal::Choice {
                    name: "guard",
                    given,
                    allowed: "PALPATE_GUARD_OFF, PALPATE_GUARD_REPORT or PALPATE_GUARD_LIMIT",
                });
            }
        };
        choice::unused(self.reserved)?;
        let refused = |parameter, value, words| {
            Refusal::Parameter(ParameterError {
                parameter,
                value,
                allowed: Allowed::Words(words),
            })
        };
        let recorded = self.device_mass == f64::INFINITY;
        if self.device_mass.is_nan() || self.device_mass < 0.0 {
            let words = "greater than 0, or 0 where it is not known";
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
                },
                guard,
            },
            device_mass: (self.device_mass > 0.0 && !recorded).then_some(self.device_mass),
            encoder_quantum: self.encoder_quantum,
            recorded,
        })
    }
}

/// Fills parameters of a loop with the defaults. `struct_size` is sizeof(palpate_loop_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_loop_params_init(
    params: *mut LoopParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, LoopParams::default()) })
}

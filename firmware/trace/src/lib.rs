#![no_std]
#![forbid(unsafe_code)]
//! The committed trace (`trace.csv`), the contacts and methods that render it in `f32`, and one line of text per tick.
//! Board and desktop run this crate; equal lines mean equal bits.

use core::fmt::{self, Write};

use palpate::{
    Contact, CoupledParams, Fault, Guard, GuardParams, HfcrParams, LoopParams, Mass, MethodParams,
    ObjectState, Output, ParameterError, Phase, Renderer, Sample,
};

/// Columns `position_m`, `elapsed_s` (empty: the nominal period) and `virtual_force_n`.
const TRACE: &str = include_str!("../trace.csv");

/// Period of the loop `[s]`.
pub const PERIOD: f32 = 0.001;
/// Start position of the block `[m]`.
pub const BLOCK_AT: f32 = 0.01;
/// Position of the wall `[m]`.
pub const WALL_AT: f32 = -0.002;

/// Returns a block of 0.1 kg that is pushed only.
pub fn block() -> Contact<f32> {
    Contact::object(1000.0, 0.1).pushing_only()
}

/// Returns a wall.
pub fn wall() -> Contact<f32> {
    Contact::wall(3000.0)
}

/// Returns the initial state of the object of `contact`.
pub fn start(contact: &Contact<f32>) -> ObjectState<f32> {
    ObjectState::at_rest(match contact.object_mass {
        Mass::Infinite => WALL_AT,
        Mass::Finite(_) => BLOCK_AT,
    })
}

/// Returns the loop parameters with every limit set; each limit acts on some tick of the trace.
pub fn loop_params() -> LoopParams<f32> {
    LoopParams {
        speed_limit: Some(3.0),
        slew_limit: Some(3000.0),
        guard: Guard::Limit(GuardParams::by_speed(1.0, 1e-3)),
        ..LoopParams::new(PERIOD).with_force_limit(5.0)
    }
}

/// Returns HFCR with damping 0.02 N s/m.
pub fn hfcr() -> HfcrParams<f32> {
    HfcrParams::with_damping(0.02)
}

/// Returns coupled rendering of a device of 0.1 kg.
pub fn coupled() -> CoupledParams<f32> {
    CoupledParams::new(0.1)
}

/// Returns the samples of the trace, in order.
///
/// # Panics
/// Panics if a cell is not a number, which is a build error because the file is committed.
pub fn samples() -> impl Iterator<Item = Sample<f32>> + Clone {
    TRACE.lines().skip(1).map(|line| {
        let mut cells = line.split(',').map(str::trim);
        let mut cell = || cells.next().expect("a trace has three columns");
        let number = |text: &str| -> f32 { text.parse().expect("a cell of a trace is a number") };
        let device_position = number(cell());
        let elapsed = match cell() {
            "" => None,
            text => Some(number(text)),
        };
        Sample {
            device_position,
            elapsed,
            virtual_force: number(cell()),
        }
    })
}

/// Coverage of a run, for checking that a comparison is complete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Numbers of ticks that were free, in contact, entering and leaving.
    pub phases: [u32; 4],
    /// Numbers of rejected samples, in the order of [`FAULTS`].
    pub faults: [u32; 6],
    /// Numbers of limited forces: no pull, force, slew, guard.
    pub limits: [u32; 4],
}

/// The faults counted by [`Seen`].
pub const FAULTS: [Fault; 6] = [
    Fault::PositionNotFinite,
    Fault::VirtualForceNotFinite,
    Fault::ElapsedNotPositive,
    Fault::GapTooLong,
    Fault::JumpTooFast,
    Fault::Overflow,
];

impl Seen {
    /// Counts one tick.
    pub fn count(&mut self, output: &Output<f32>) {
        match output.phase {
            Phase::Free => self.phases[0] += 1,
            Phase::Contact => self.phases[1] += 1,
            Phase::Enters => self.phases[2] += 1,
            Phase::Leaves => self.phases[3] += 1,
            Phase::Waiting => {}
        }
        for (count, fault) in self.faults.iter_mut().zip(FAULTS) {
            *count += u32::from(output.fault == Some(fault));
        }
        let limited = output.limited;
        let acted = [limited.pull, limited.force, limited.slew, limited.guard];
        for (count, acted) in self.limits.iter_mut().zip(acted) {
            *count += u32::from(acted);
        }
    }
}

/// A failure of [`replay`].
#[derive(Clone, Copy, Debug)]
pub enum ReplayError {
    /// A parameter of this crate is outside its range.
    Parameter(ParameterError),
    /// A line could not be written.
    Write(fmt::Error),
}

impl From<ParameterError> for ReplayError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl From<fmt::Error> for ReplayError {
    fn from(error: fmt::Error) -> Self {
        Self::Write(error)
    }
}

/// Renders the trace and writes a line for each tick: its number; force on the device, object position, object
/// velocity, penetration and transition time as the hexadecimal bits of an `f32`; phase, limits and fault. A last line
/// has the bits of the ledger.
///
/// # Errors
/// Errors of `out`.
pub fn replay<P: MethodParams<f32>>(
    name: &str,
    contact: Contact<f32>,
    params: P,
    out: &mut impl Write,
) -> Result<Seen, ReplayError> {
    let renderer = Renderer::new(contact, loop_params(), params)?;
    let mut state = renderer.start(start(&contact))?;
    let mut seen = Seen::default();
    for (tick, sample) in samples().enumerate() {
        let output = renderer.step(&mut state, sample);
        seen.count(&output);
        line(name, tick, &output, out)?;
    }
    let ledger = state.ledger();
    writeln!(
        out,
        "{name} ledger {:08x} {:08x} {:08x} {:08x} {:08x} {:08x}",
        ledger.stored.to_bits(),
        ledger.port_work.to_bits(),
        ledger.virtual_force_work.to_bits(),
        ledger.outside_work.to_bits(),
        ledger.original_leak.accumulated.to_bits(),
        ledger.held_leak.accumulated.to_bits(),
    )?;
    Ok(seen)
}

fn line(name: &str, tick: usize, output: &Output<f32>, out: &mut impl Write) -> fmt::Result {
    let limited = output.limited;
    writeln!(
        out,
        "{name} {tick} {:08x} {:08x} {:08x} {:08x} {:08x} {} {}{}{}{} {}",
        output.force_on_device.to_bits(),
        output.object_position.to_bits(),
        output.object_velocity.to_bits(),
        output.penetration.to_bits(),
        output.transition_after.to_bits(),
        output.phase.name(),
        if limited.pull { 'p' } else { '-' },
        if limited.force { 'f' } else { '-' },
        if limited.slew { 's' } else { '-' },
        if limited.guard { 'g' } else { '-' },
        output.fault.map_or("-", Fault::name),
    )
}

/// Renders both contacts by both methods: writes the lines of every run, and returns the coverage per run.
///
/// # Errors
/// Errors of `out`.
pub fn replay_all(out: &mut impl Write) -> Result<[Seen; 4], ReplayError> {
    Ok([
        replay("hfcr-block", block(), hfcr(), out)?,
        replay("hfcr-wall", wall(), hfcr(), out)?,
        replay("coupled-block", block(), coupled(), out)?,
        replay("coupled-wall", wall(), coupled(), out)?,
    ])
}

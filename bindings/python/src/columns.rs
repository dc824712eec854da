//! Ticks of runs as arrays: one record per tick.

use numpy::{PyArray1, PyArrayMethods as _};
use palpate_core::{Fault, Limited, Output, Phase};
use palpate_study::sim::run::{IdealPoint, Reference, Run, Tick};
use pyo3::prelude::*;

/// Defines the list of the numbers of a record, by their names in files, and the function that takes them from
/// a `$record`.
macro_rules! numbers {
    ($names:ident, $take:ident, $of:ty, $record:ident: $($name:literal = $number:expr,)+) => {
        const $names: &[&str] = &[$($name),+];

        #[inline]
        fn $take($record: &$of) -> [f64; $names.len()] {
            [$($number),+]
        }
    };
}

numbers! { NUMBERS, numbers, Tick, tick:
    "t_s" = tick.time,
    "device_position_m" = tick.device_position,
    "object_position_m" = tick.output.object_position,
    "object_velocity_m_per_s" = tick.output.object_velocity,
    "force_on_object_n" = tick.output.force_on_object,
    "leak_original_j" = tick.ledger.original_leak.accumulated,
    "leak_held_j" = tick.ledger.held_leak.accumulated,
    "force_on_device_n" = tick.output.force_on_device,
    "held_force_on_object_n" = tick.held_force_on_object,
    "command_from_s" = tick.command_from.unwrap_or(f64::NAN),
    "penetration_m" = tick.output.penetration,
    "true_device_position_m" = tick.true_device_position,
    "stored_energy_j" = tick.ledger.stored,
    "port_work_j" = tick.ledger.port_work,
    "virtual_force_work_j" = tick.ledger.virtual_force_work,
    "outside_work_j" = tick.ledger.outside_work,
    "transition_after_s" = tick.output.transition_after,
    "proxy_shift_m" = tick.output.proxy_shift,
}

numbers! { IDEAL, ideal_numbers, IdealPoint, point:
    "t_s" = point.time,
    "device_position_m" = point.device_position,
    "object_position_m" = point.object_position,
    "force_on_object_n" = point.force_on_object,
}

/// Codes that follow the numbers of a tick, one byte each.
const CODES: [&str; 3] = ["phase", "limited", "fault"];

/// Phases in the order of their codes.
const PHASES: [Phase; 5] = [
    Phase::Free,
    Phase::Contact,
    Phase::Enters,
    Phase::Leaves,
    Phase::Waiting,
];

/// Faults in the order of their codes, which start at 1.
const FAULTS: [Fault; 6] = [
    Fault::PositionNotFinite,
    Fault::VirtualForceNotFinite,
    Fault::ElapsedNotPositive,
    Fault::GapTooLong,
    Fault::JumpTooFast,
    Fault::Overflow,
];

/// Limits, starting at the lowest bit of the code.
const LIMITS: [&str; 5] = ["pull", "force", "slew", "guard", "beyond-guard"];

/// Returns which limits acted.
fn acted(limited: Limited) -> [bool; LIMITS.len()] {
    let Limited {
        pull,
        force,
        slew,
        guard,
        beyond_guard,
    } = limited;
    [pull, force, slew, guard, beyond_guard]
}

/// Returns the names of the limits that acted.
pub fn limits(limited: Limited) -> impl Iterator<Item = &'static str> {
    let named = LIMITS.into_iter().zip(acted(limited));
    named.filter_map(|(name, acted)| acted.then_some(name))
}

/// Returns the names of the numbers and codes of a tick, and the meaning of the codes: phases, limits by bit, and
/// faults. Fault code 0 means no fault.
#[pyfunction]
pub fn columns() -> (Vec<&'static str>, [&'static str; 3], [Vec<&'static str>; 3]) {
    let phases = PHASES.into_iter().map(Phase::name).collect();
    let faults = FAULTS.into_iter().map(Fault::name);
    let faults = std::iter::once("").chain(faults).collect();
    (NUMBERS.to_vec(), CODES, [phases, LIMITS.to_vec(), faults])
}

/// Returns the names of the numbers of a point of the reference solution.
#[pyfunction]
pub fn ideal_columns() -> Vec<&'static str> {
    IDEAL.to_vec()
}

/// Records as 64-bit words.
pub type Words = Vec<u64>;

/// Returns the ticks of a run in a NumPy array. NumPy allocates large arrays directly from the system, ten times
/// faster than Rust does for this many records. Releases the GIL.
pub fn of_run(py: Python<'_>, run: Run) -> PyResult<Bound<'_, PyArray1<u64>>> {
    const WIDTH: usize = NUMBERS.len() + 1;
    let array = PyArray1::zeros(py, run.ticks.len() * WIDTH, false);
    let mut words = array.readwrite();
    let words = words.as_slice_mut()?;
    py.detach(move || {
        for (record, tick) in words.chunks_exact_mut(WIDTH).zip(&run.ticks) {
            let (of_numbers, of_codes) = record.split_at_mut(NUMBERS.len());
            of_numbers.copy_from_slice(&numbers(tick).map(f64::to_bits));
            of_codes[0] = codes(tick);
        }
        drop(run);
    });
    Ok(array)
}

/// Returns the motion of the reference solution.
pub fn of_ideal(reference: &Reference) -> Words {
    let mut words = Vec::with_capacity(reference.curve.len() * IDEAL.len());
    for point in &reference.curve {
        words.extend(ideal_numbers(point).map(f64::to_bits));
    }
    words
}

fn codes(tick: &Tick) -> u64 {
    let [phase, limited, fault] = output_codes(&tick.output);
    u64::from_ne_bytes([phase, limited, fault, 0, 0, 0, 0, 0])
}

/// Returns the codes of an output: phase, limits and fault.
pub fn output_codes(output: &Output<f64>) -> [u8; 3] {
    let place = |index: Option<usize>| index.and_then(|index| u8::try_from(index).ok());
    let phase = place(PHASES.iter().position(|phase| *phase == output.phase));
    let bits = acted(output.limited).into_iter().enumerate();
    let limited = bits.fold(0, |code, (bit, acted)| code | (u8::from(acted) << bit));
    let fault = output.fault.map_or(Some(0), |fault| {
        place(FAULTS.iter().position(|known| *known == fault)).map(|index| index + 1)
    });
    let unknown = u8::MAX;
    [phase.unwrap_or(unknown), limited, fault.unwrap_or(unknown)]
}

/// Moves the words into a NumPy array without a copy.
pub fn array(py: Python<'_>, words: Words) -> Bound<'_, PyArray1<u64>> {
    PyArray1::from_vec(py, words)
}

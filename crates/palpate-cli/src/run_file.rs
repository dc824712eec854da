//! Run files: every tick of one or more runs as CSV.

use std::io::Write;

use palpate_record::run::{RunWriteError, RunWriter};
use palpate_sim::run::Run;

/// Columns of a run file. Leaks and works are accumulated over the intervals before the sample.
pub const COLUMNS: [&str; 22] = [
    "t_s",
    "device_position_m",
    "object_position_m",
    "object_velocity_m_per_s",
    "force_on_object_n",
    "leak_original_j",
    "leak_held_j",
    "force_on_device_n",
    "held_force_on_object_n",
    "command_from_s",
    "penetration_m",
    "true_device_position_m",
    "stored_energy_j",
    "port_work_j",
    "virtual_force_work_j",
    "outside_work_j",
    "phase",
    "transition_after_s",
    "placement_shift_m",
    "limited",
    "fault",
    "method",
];

/// The column that follows where an object has a radius: its centre.
const CENTRE: &str = "object_centre_m";

/// Writes `runs`, one after the other, with a receipt of what made them.
pub fn write(
    writer: &mut dyn Write,
    receipt: &[(String, String)],
    runs: &[Run],
) -> Result<(), RunWriteError> {
    let centre = runs.iter().any(|run| run.centre_offset != 0.0);
    let mut columns = COLUMNS.to_vec();
    columns.extend(centre.then_some(CENTRE));
    let mut file = RunWriter::new(writer, receipt, &columns)?;
    for run in runs {
        for tick in &run.ticks {
            let (output, ledger) = (&tick.output, &tick.ledger);
            let limited = [
                (output.limited.pull, "pull"),
                (output.limited.force, "force"),
                (output.limited.slew, "slew"),
                (output.limited.guard, "guard"),
            ]
            .into_iter()
            .filter_map(|(acted, name)| acted.then_some(name))
            .collect::<Vec<_>>()
            .join(" ");
            let mut row = vec![
                tick.time.into(),
                tick.device_position.into(),
                output.object_position.into(),
                output.object_velocity.into(),
                output.force_on_object.into(),
                ledger.original_leak.accumulated.into(),
                ledger.held_leak.accumulated.into(),
                output.force_on_device.into(),
                tick.held_force_on_object.into(),
                // Empty for a command that never reaches the motor.
                tick.command_from.unwrap_or(f64::NAN).into(),
                output.penetration.into(),
                tick.true_device_position.into(),
                ledger.stored.into(),
                ledger.port_work.into(),
                ledger.virtual_force_work.into(),
                ledger.outside_work.into(),
                output.phase.name().into(),
                output.transition_after.into(),
                output.placement_shift.into(),
                limited.as_str().into(),
                output.fault.map_or("", |fault| fault.name()).into(),
                run.method.name().into(),
            ];
            let place = output.object_position + run.centre_offset;
            if centre {
                row.push(place.into());
            }
            file.row(&row)?;
        }
    }
    file.finish()?;
    Ok(())
}

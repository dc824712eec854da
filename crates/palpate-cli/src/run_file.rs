//! Run files: every tick of one or more runs as CSV.

use std::io::Write;

use palpate_record::recording::{Column, ContactTick, Row, Tick, Value};
use palpate_record::run::{RunWriteError, RunWriter};
use palpate_rt::answered;
use palpate_study::sim::run::Run;

/// Columns of a run file: those of a tick, by their names, and the run's own. Leaks and works are accumulated over the
/// intervals before the sample.
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
    "proxy_shift_m",
    "limited",
    "fault",
    "method",
];

/// Additional column for an object with a radius: its centre.
const CENTRE: &str = "object_centre_m";

/// Writes `runs`, one after the other, with metadata of their origin.
pub fn write(
    writer: &mut dyn Write,
    metadata: &[(String, String)],
    runs: &[Run],
) -> Result<(), RunWriteError> {
    let centre = runs.iter().any(|run| run.centre_offset != 0.0);
    let mut columns = COLUMNS.to_vec();
    columns.extend(centre.then_some(CENTRE));
    let mut file = RunWriter::new(writer, metadata, &columns)?;
    let of_tick: Vec<_> = columns.iter().map(|name| Column::named(name)).collect();
    for run in runs {
        for tick in &run.ticks {
            let (output, ledger) = (&tick.output, &tick.ledger);
            let listed = Row {
                tick: Tick {
                    time: tick.time,
                    ..Tick::UNKNOWN
                },
                contact: ContactTick {
                    device_position: tick.device_position,
                    ..answered(output, ledger)
                },
                ..Row::UNKNOWN
            };
            let limits: Vec<_> = listed.contact.flags.limits().collect();
            let limits = limits.join(" ");
            let cells = columns
                .iter()
                .zip(&of_tick)
                .map(|(name, column)| match *name {
                    "held_force_on_object_n" => tick.held_force_on_object.into(),
                    // Empty for a command that never reaches the motor.
                    "command_from_s" => tick.command_from.unwrap_or(f64::NAN).into(),
                    "true_device_position_m" => tick.true_device_position.into(),
                    "transition_after_s" => output.transition_after.into(),
                    "limited" => limits.as_str().into(),
                    "fault" => output.fault.map_or("", |fault| fault.name()).into(),
                    "method" => run.method.name().into(),
                    CENTRE => (output.object_position + run.centre_offset).into(),
                    _ => match column.map(|column| column.value(&listed)) {
                        Some(Value::Phase(phase)) => phase.name().into(),
                        value => value.map_or(f64::NAN, Value::number).into(),
                    },
                });
            file.row(&cells.collect::<Vec<_>>())?;
        }
    }
    file.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_one_of_a_tick_or_the_run_s_own() {
        let mut others = COLUMNS.iter().filter(|name| Column::named(name).is_none());
        let own = [
            "held_force_on_object_n",
            "command_from_s",
            "true_device_position_m",
            "transition_after_s",
            "limited",
            "fault",
            "method",
        ];
        assert!(others.all(|name| own.contains(name)));
    }
}

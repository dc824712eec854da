//! The types of the messages, as ROS 2 writes them: what tells Foxglove and PlotJuggler which bytes are
//! what.

use std::fmt::Write;

use super::column::Column;
use super::state::{Flags, Phase};
use super::{COLUMNS, event};

/// Name of the type of a tick.
pub(super) const TICK: &str = "palpate_msgs/msg/Tick";
/// Name of the type of an event.
pub(super) const EVENT: &str = "palpate_msgs/msg/Event";

/// What the first version of the format says of the columns that it began with. These bytes stay; a
/// column that came later is described by its meaning.
const FIRST_COMMENTS: [(&str, &str); 25] = [
    (
        "sequence",
        "0, 1, 2, ...; a number that is missing is a tick that was lost",
    ),
    (
        "t_s",
        "when the device was sampled, since the loop's start [s]",
    ),
    ("lateness_s", "past the planned instant [s]"),
    ("period_s", "measured time since the sample before [s]"),
    ("device_axis_1_m", "end-point in the device's own frame [m]"),
    ("device_axis_2_m", ""),
    ("device_axis_3_m", ""),
    (
        "device_position_m",
        "along the contact's normal, as the renderer saw it [m]",
    ),
    ("object_position_m", "[m]"),
    ("object_velocity_m_per_s", "[m/s]"),
    ("penetration_m", "positive in contact [m]"),
    (
        "placement_shift_m",
        "shift of the object over the last interval [m]",
    ),
    ("force_on_object_n", "as the renderer answered [N]"),
    ("force_on_device_n", "as really sent [N]"),
    ("stored_energy_j", "in object and contact [J]"),
    ("port_work_j", "since the start, into the object [J]"),
    ("virtual_force_work_j", "since the start [J]"),
    ("outside_work_j", "since the start [J]"),
    (
        "leak_original_j",
        "of the spring force on the same motion [J]",
    ),
    (
        "leak_held_j",
        "of the force that was held; positive: created [J]",
    ),
    ("tick_duration_s", "from the sample to the command [s]"),
    ("device_round_trip_s", "[s]"),
    ("generation", "of the parameters; 0: those of the receipt"),
    ("flags", "bits, see the constants"),
    (
        "phase",
        "predicted of the coming interval, see the constants",
    ),
];

/// The type of a tick.
pub(super) fn tick() -> String {
    let mut text = String::from(
        "# One tick of a haptic loop, palpate recording format 1. SI units, each in the name of its field.\n\
         # Positions, velocities and forces are along the contact's axis; NaN where there is no value.\n",
    );
    let fields = COLUMNS
        .iter()
        .map(|column| (field(column), comment(column)));
    push(&mut text, fields.collect());
    for (flag, name) in Flags::NAMED {
        line(
            &mut text,
            &format!("uint32 FLAG_{}={}", constant(name), flag.0),
        );
    }
    for phase in Phase::ALL {
        let name = constant(phase.name());
        line(&mut text, &format!("uint8 PHASE_{name}={}", phase.number()));
    }
    text
}

/// The type of an event.
pub(super) fn event() -> String {
    let mut text = String::from(
        "# Something that happened at a tick of a haptic loop, palpate recording format 1.\n",
    );
    let fields = event::COLUMNS.iter().map(|column| {
        let field = format!("{} {}", column.message_type, column.name);
        (field, column.meaning.to_owned())
    });
    push(&mut text, fields.collect());
    text
}

fn field(column: &Column) -> String {
    format!("{} {}", column.kind.message_type(), column.name)
}

fn comment(column: &Column) -> String {
    let first = FIRST_COMMENTS.iter().find(|(name, _)| *name == column.name);
    match first {
        Some((_, comment)) => (*comment).to_owned(),
        None if column.unit == "1" => column.meaning.to_owned(),
        None => format!("{} [{}]", column.meaning, column.unit),
    }
}

fn constant(name: &str) -> String {
    name.to_uppercase().replace('-', "_")
}

/// Adds fields, with their comments below each other.
fn push(text: &mut String, fields: Vec<(String, String)>) {
    let width = fields.iter().map(|(field, _)| field.len()).max();
    let width = width.unwrap_or(0);
    for (field, comment) in fields {
        match comment.as_str() {
            "" => line(text, &field),
            comment => line(text, &format!("{field:width$}  # {comment}")),
        }
    }
}

fn line(text: &mut String, line: &str) {
    // A string takes whatever is written into it.
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The types that the first version of the format wrote, as they stand in a recording of it.
    fn first(begins: &str) -> String {
        let file = include_bytes!("../../tests/recording/golden-v1.mcap");
        let text = String::from_utf8_lossy(file);
        let from = text.find(begins).unwrap();
        // Up to the length of the next record.
        text[from..].split('\0').next().unwrap().to_owned()
    }

    /// What a line says, however its comment is set.
    fn words(line: &str) -> Vec<&str> {
        line.split_whitespace().collect()
    }

    #[test]
    fn a_recording_without_newer_columns_has_the_bytes_of_the_first_version() {
        for (own, first) in [
            (tick(), first("# One tick of a haptic loop")),
            (event(), first("# Something that happened")),
        ] {
            let end = first.rfind('\n').unwrap() + 1;
            let first = &first[..end];
            assert!(first.lines().count() > 4, "{first}");
            if COLUMNS.len() == FIRST_COMMENTS.len() {
                assert_eq!(own, first);
            }
            // A newer column stands between, and changes none.
            let mut lines = own.lines();
            for line in first.lines() {
                assert!(lines.any(|own| words(own) == words(line)), "{line}");
            }
        }
    }
}

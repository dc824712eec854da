//! Types of the messages in ROS 2 syntax, which describe their bytes to Foxglove and PlotJuggler.

use std::fmt::Write;

use super::column::{Column, Kind};
use super::state::{Flags, Phase};
use super::{BodyTick, ContactTick, DeviceTick, Tick, event};

/// Type name of a tick.
pub(super) const TICK: &str = "palpate_msgs/msg/Tick";
/// Type name of a contact.
pub(super) const CONTACT: &str = "palpate_msgs/msg/Contact";
/// Type name of a body.
pub(super) const BODY: &str = "palpate_msgs/msg/Body";
/// Type name of a device.
pub(super) const DEVICE: &str = "palpate_msgs/msg/Device";
/// Type name of an event.
pub(super) const EVENT: &str = "palpate_msgs/msg/Event";

/// Returns the type of a tick.
pub(super) fn tick() -> String {
    let mut text = String::from(
        "# One tick of a haptic loop, palpate recording format 2. SI units, each in the name of its field.\n\
         # Vectors are in the device's own frame; NaN where there is no value.\n",
    );
    push_columns(&mut text, Tick::COLUMNS, Flags::ALL);
    text
}

/// Returns the type of a contact.
pub(super) fn contact() -> String {
    let mut text = String::from(
        "# One contact of a tick of a haptic loop, palpate recording format 2. SI units, each in the name of \
         its field.\n\
         # Positions, velocities and forces are along the contact's normal; those of a contact of a world are along \
         the world's axes. NaN where there is no value.\n",
    );
    push_columns(&mut text, ContactTick::COLUMNS, Flags::OF_CONTACT);
    text
}

/// Returns the type of a body.
pub(super) fn body() -> String {
    let mut text = String::from(
        "# One body of a world at a tick of a haptic loop, palpate recording format 2. SI units, each in the name \
         of its field.\n\
         # Vectors are along the axes of the world; NaN where there is no value.\n",
    );
    push_columns(&mut text, BodyTick::COLUMNS, Flags::default());
    text
}

/// Returns the type of a device.
pub(super) fn device() -> String {
    let mut text = String::from(
        "# One device at a tick of a haptic loop with several devices, palpate recording format 2. SI units, each in \
         the name of its field.\n\
         # Vectors are in the frame of the device itself; NaN where there is no value.\n",
    );
    push_columns(&mut text, DeviceTick::COLUMNS, Flags::OF_DEVICE);
    text
}

/// Returns the type of an event.
pub(super) fn event() -> String {
    let mut text =
        String::from("# Event at a tick of a haptic loop, palpate recording format 2.\n");
    let fields = event::COLUMNS.iter().map(|column| {
        let field = format!("{} {}", column.message_type, column.name);
        (field, column.meaning.to_owned())
    });
    push(&mut text, fields.collect());
    text
}

/// Appends a field for each column, and the constants of its possible values.
fn push_columns(text: &mut String, columns: &[Column], flags: Flags) {
    let fields = columns
        .iter()
        .map(|column| (field(column), comment(column)));
    push(text, fields.collect());
    let has = |kind| columns.iter().any(|column| column.kind == kind);
    if has(Kind::Flags) {
        let named = Flags::NAMED.iter().filter(|(flag, _)| flags.has(*flag));
        for (flag, name) in named {
            line(text, &format!("uint32 FLAG_{}={}", constant(name), flag.0));
        }
    }
    if has(Kind::Phase) {
        for phase in Phase::ALL {
            let name = constant(phase.name());
            line(text, &format!("uint8 PHASE_{name}={}", phase.number()));
        }
    }
}

fn field(column: &Column) -> String {
    format!("{} {}", column.kind.message_type(), column.name)
}

fn comment(column: &Column) -> String {
    if column.unit == "1" {
        column.meaning.to_owned()
    } else {
        format!("{} [{}]", column.meaning, column.unit)
    }
}

fn constant(name: &str) -> String {
    name.to_uppercase().replace('-', "_")
}

/// Appends fields with aligned comments.
fn push(text: &mut String, fields: Vec<(String, String)>) {
    let width = fields.iter().map(|(field, _)| field.len()).max();
    let width = width.unwrap_or(0);
    for (field, comment) in fields {
        line(text, &format!("{field:width$}  # {comment}"));
    }
}

fn line(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::super::Row;
    use super::super::samples::{body as body_of, device as device_of, row};
    use super::super::stream::{encode_body, encode_contact, encode_device, encode_tick};
    use super::*;

    /// Decodes a message by its type alone: returns the names and values of its fields.
    fn by_schema(schema: &str, message: &[u8]) -> Vec<(String, f64)> {
        assert_eq!(message[..4], [0, 1, 0, 0], "little-endian CDR");
        let body = &message[4..];
        let mut at = 0;
        let mut fields = Vec::new();
        for line in schema.lines() {
            let code = line.split('#').next().unwrap();
            let [kind, name] = code.split_whitespace().collect::<Vec<_>>()[..] else {
                assert!(code.trim().is_empty() || code.contains('='), "{line}");
                continue;
            };
            if name.contains('=') {
                continue;
            }
            let size = match kind {
                "uint64" | "float64" => 8,
                "uint32" => 4,
                "uint8" => 1,
                other => panic!("{other}"),
            };
            at = usize::div_ceil(at, size) * size;
            let bytes = &body[at..at + size];
            at += size;
            let value = match kind {
                "float64" => f64::from_le_bytes(bytes.try_into().unwrap()),
                _ => bytes
                    .iter()
                    .rev()
                    .fold(0.0, |sum, b| sum * 256.0 + f64::from(*b)),
            };
            fields.push((name.to_owned(), value));
        }
        assert_eq!(at, body.len(), "the message ends with its last field");
        fields
    }

    fn assert_fields(fields: &[(String, f64)], expected: &[(&str, f64)]) {
        for (name, expected) in expected {
            let (_, value) = fields.iter().find(|(field, _)| field == name).unwrap();
            assert!(
                value.to_bits() == expected.to_bits(),
                "{name}: {value} for {expected}"
            );
        }
        let names: Vec<_> = fields.iter().map(|(name, _)| name).collect();
        assert_eq!(fields.len(), expected.len(), "{names:?}");
    }

    #[test]
    fn a_program_that_knows_the_message_types_reads_every_quantity_by_its_name() {
        let Row {
            tick: t,
            contact: c,
            ..
        } = row(7, 1);
        let mut message = Vec::new();
        encode_tick(&t, &mut message);
        assert_fields(
            &by_schema(&tick(), &message),
            &[
                ("sequence", 7.0),
                ("t_s", t.time),
                ("lateness_s", t.lateness),
                ("period_s", t.period),
                ("device_axis_1_m", t.device_axes[0]),
                ("device_axis_2_m", t.device_axes[1]),
                ("device_axis_3_m", t.device_axes[2]),
                ("device_orientation_w", t.device_orientation[0]),
                ("device_orientation_x", t.device_orientation[1]),
                ("device_orientation_y", t.device_orientation[2]),
                ("device_orientation_z", t.device_orientation[3]),
                ("commanded_force_1_n", t.commanded_force[0]),
                ("commanded_force_2_n", t.commanded_force[1]),
                ("commanded_force_3_n", t.commanded_force[2]),
                ("commanded_torque_1_n_m", t.commanded_torque[0]),
                ("commanded_torque_2_n_m", t.commanded_torque[1]),
                ("commanded_torque_3_n_m", t.commanded_torque[2]),
                ("delivered_force_1_n", t.delivered_force[0]),
                ("delivered_force_2_n", t.delivered_force[1]),
                ("delivered_force_3_n", t.delivered_force[2]),
                ("delivered_slope_1_n_per_s", t.delivered_slope[0]),
                ("delivered_slope_2_n_per_s", t.delivered_slope[1]),
                ("delivered_slope_3_n_per_s", t.delivered_slope[2]),
                ("delivered_torque_1_n_m", t.delivered_torque[0]),
                ("delivered_torque_2_n_m", t.delivered_torque[1]),
                ("delivered_torque_3_n_m", t.delivered_torque[2]),
                ("tick_duration_s", t.tick_duration),
                ("device_round_trip_s", t.device_round_trip),
                ("generation", 3.0),
                ("contacts", 2.0),
                ("bodies", 0.0),
                ("created_energy_j", t.created_energy),
                ("flags", 259.0),
            ],
        );
        message.clear();
        encode_contact(&c, &mut message);
        assert_fields(
            &by_schema(&contact(), &message),
            &[
                ("sequence", 7.0),
                ("contact", 1.0),
                ("contact_flags", 3.0),
                ("device_position_m", c.device_position),
                ("object_position_m", c.object_position),
                ("object_velocity_m_per_s", c.object_velocity),
                ("penetration_m", c.penetration),
                ("proxy_shift_m", c.proxy_shift),
                ("force_on_object_n", c.force_on_object),
                ("force_on_device_n", c.force_on_device),
                ("stored_energy_j", c.stored_energy),
                ("port_work_j", c.port_work),
                ("virtual_force_work_j", c.virtual_force_work),
                ("outside_work_j", c.outside_work),
                ("leak_original_j", c.original_leak),
                ("leak_held_j", c.held_leak),
                ("contact_point_1_m", c.point[0]),
                ("contact_point_2_m", c.point[1]),
                ("contact_point_3_m", c.point[2]),
                ("contact_normal_1", c.normal[0]),
                ("contact_normal_2", c.normal[1]),
                ("contact_normal_3", c.normal[2]),
                ("contact_force_1_n", c.force[0]),
                ("contact_force_2_n", c.force[1]),
                ("contact_force_3_n", c.force[2]),
                ("pair", 5.0),
                ("phase", 3.0),
            ],
        );
        let b = body_of(7, 2);
        message.clear();
        encode_body(&b, &mut message);
        assert_fields(
            &by_schema(&body(), &message),
            &[
                ("sequence", 7.0),
                ("body", 2.0),
                ("body_position_1_m", b.position[0]),
                ("body_position_2_m", b.position[1]),
                ("body_position_3_m", b.position[2]),
                ("body_orientation_w", b.orientation[0]),
                ("body_orientation_x", b.orientation[1]),
                ("body_orientation_y", b.orientation[2]),
                ("body_orientation_z", b.orientation[3]),
                ("body_velocity_1_m_per_s", b.velocity[0]),
                ("body_velocity_2_m_per_s", b.velocity[1]),
                ("body_velocity_3_m_per_s", b.velocity[2]),
                ("body_angular_velocity_1_rad_per_s", b.angular_velocity[0]),
                ("body_angular_velocity_2_rad_per_s", b.angular_velocity[1]),
                ("body_angular_velocity_3_rad_per_s", b.angular_velocity[2]),
            ],
        );
        let d = device_of(7, 1);
        message.clear();
        encode_device(&d, &mut message);
        assert_fields(
            &by_schema(&device(), &message),
            &[
                ("sequence", 7.0),
                ("device", 1.0),
                ("devices", 2.0),
                ("flags", 512.0),
                ("t_s", d.time),
                ("device_round_trip_s", d.round_trip),
                ("device_axis_1_m", d.axes[0]),
                ("device_axis_2_m", d.axes[1]),
                ("device_axis_3_m", d.axes[2]),
                ("device_orientation_w", d.orientation[0]),
                ("device_orientation_x", d.orientation[1]),
                ("device_orientation_y", d.orientation[2]),
                ("device_orientation_z", d.orientation[3]),
                ("commanded_force_1_n", d.commanded_force[0]),
                ("commanded_force_2_n", d.commanded_force[1]),
                ("commanded_force_3_n", d.commanded_force[2]),
                ("commanded_torque_1_n_m", d.commanded_torque[0]),
                ("commanded_torque_2_n_m", d.commanded_torque[1]),
                ("commanded_torque_3_n_m", d.commanded_torque[2]),
                ("delivered_force_1_n", d.delivered_force[0]),
                ("delivered_force_2_n", d.delivered_force[1]),
                ("delivered_force_3_n", d.delivered_force[2]),
                ("delivered_slope_1_n_per_s", d.delivered_slope[0]),
                ("delivered_slope_2_n_per_s", d.delivered_slope[1]),
                ("delivered_slope_3_n_per_s", d.delivered_slope[2]),
                ("delivered_torque_1_n_m", d.delivered_torque[0]),
                ("delivered_torque_2_n_m", d.delivered_torque[1]),
                ("delivered_torque_3_n_m", d.delivered_torque[2]),
            ],
        );
    }

    #[test]
    fn the_types_name_every_flag_and_phase_with_its_number() {
        for (flag, name) in Flags::NAMED {
            let line = format!("uint32 FLAG_{}={}\n", constant(name), flag.0);
            assert!(tick().contains(&line), "{line}");
            let is_of_contact = Flags::OF_CONTACT.has(flag);
            assert_eq!(contact().contains(&line), is_of_contact, "{line}");
        }
        for phase in Phase::ALL {
            let line = format!(
                "uint8 PHASE_{}={}\n",
                constant(phase.name()),
                phase.number()
            );
            assert!(
                contact().contains(&line) && !tick().contains(&line),
                "{line}"
            );
            assert_eq!(Phase::ALL[usize::from(phase.number())], phase);
        }
    }
}

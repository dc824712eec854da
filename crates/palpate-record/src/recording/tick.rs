//! One tick of a loop: its quantities, each said once.

use super::cdr::Writer;
use super::column::{Cells, Column};
use super::state::{Flags, Phase};

/// Makes the tick and the list of its columns.
///
/// A line is a field and its type, the unit, `live` if the live page is sent it and `-` if not, what
/// it means with its sign, and the name of its column; a field of several columns gives each its place.
macro_rules! tick {
    ($(
        $field:ident: $type:ty, $unit:literal, $live:tt, $meaning:literal,
        $( $name:literal $(@ $place:literal)? ),+;
    )+) => {
        /// What is seen from outside of one tick of a loop with a device.
        ///
        /// Positions, velocities and forces are along the contact's axis and in the user's frame,
        /// positive along it; NaN where there is no value. `docs/signs.md` draws the axis.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Tick {$(
            #[doc = concat!($("`", $name, "`: ",)+ $meaning, " `[", $unit, "]`.")]
            pub $field: $type,
        )+}

        impl Tick {
            /// A tick of which nothing is known: NaN for each number, nothing counted, no flag.
            pub const UNKNOWN: Self = Self {
                $($field: <$type as Cells>::UNKNOWN,)+
            };
        }

        /// The columns of a tick, in the order in which files have them.
        pub const COLUMNS: &[Column] = &[$($(
            Column {
                name: $name,
                unit: $unit,
                meaning: $meaning,
                is_live: tick!(@is_live $live),
                kind: <$type as Cells>::KIND,
                get: |tick| tick.$field.get(tick!(@place $($place)?)),
                set: |tick, value| tick.$field.set(tick!(@place $($place)?), value),
            },
        )+)+];
    };
    (@is_live live) => { true };
    (@is_live -) => { false };
    (@place) => { 0 };
    (@place $place:literal) => { $place };
}

tick! {
    sequence: u64, "1", -,
        "number of the tick: 0, 1, 2, ...; a number that is missing is a tick that was lost",
        "sequence";
    time: f64, "s", -,
        "when the device was sampled, since the loop's start",
        "t_s";
    lateness: f64, "s", live,
        "time past the instant that was planned for the sample; negative if early",
        "lateness_s";
    period: f64, "s", -,
        "measured time since the sample before; NaN for the first",
        "period_s";
    device_axes: [f64; 3], "m", -,
        "end-point of the device in its own frame; NaN beyond the axes it has",
        "device_axis_1_m" @ 0, "device_axis_2_m" @ 1, "device_axis_3_m" @ 2;
    device_position: f64, "m", live,
        "position of the device along the contact's normal, as the renderer saw it",
        "device_position_m";
    object_position: f64, "m", live,
        "position of the object along the contact's normal",
        "object_position_m";
    object_velocity: f64, "m/s", live,
        "velocity of the object along the contact's normal",
        "object_velocity_m_per_s";
    penetration: f64, "m", live,
        "penetration of the device into the object; positive in contact, whichever side the object lies on",
        "penetration_m";
    placement_shift: f64, "m", -,
        "how far `coupled` has shifted the object over the interval before the sample; 0 for other methods",
        "placement_shift_m";
    force_on_object: f64, "N", -,
        "force on the object as the renderer answered, before the limits of the safety",
        "force_on_object_n";
    force_on_device: f64, "N", live,
        "force on the device as really sent, after the limits of the safety",
        "force_on_device_n";
    stored_energy: f64, "J", live,
        "energy stored in object and contact",
        "stored_energy_j";
    port_work: f64, "J", live,
        "work of the held force through the port since the start; positive into the object",
        "port_work_j";
    virtual_force_work: f64, "J", live,
        "work of the virtual force f_V on the object since the start",
        "virtual_force_work_j";
    outside_work: f64, "J", live,
        "work from outside since the start: teleports, changed parameters, time without samples, and the leak of intervals in which the motors were off",
        "outside_work_j";
    original_leak: f64, "J", live,
        "accumulated leak of the spring force on the same motion; positive where energy was created",
        "leak_original_j";
    held_leak: f64, "J", live,
        "accumulated leak of the force that was held; positive where energy was created",
        "leak_held_j";
    tick_duration: f64, "s", live,
        "how long the tick took, from the sample to the command",
        "tick_duration_s";
    device_round_trip: f64, "s", -,
        "how long the device took to answer; NaN where that is not known",
        "device_round_trip_s";
    generation: u32, "1", -,
        "which parameters were in force: 0 for those of the receipt, one more with every change",
        "generation";
    flags: Flags, "1", live,
        "what is to be said of the tick, a bit each",
        "flags";
    phase: Phase, "1", -,
        "what the coming interval was predicted to hold",
        "phase";
}

impl Tick {
    /// Appends the message: the columns in their order, each at a multiple of its size.
    pub(super) fn encode(&self, message: &mut Vec<u8>) {
        let mut out = Writer::begin(message);
        for column in COLUMNS {
            column.value(self).encode(&mut out);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::schema;
    use super::*;

    /// A tick in which every quantity has a value of its own.
    #[allow(clippy::needless_update, reason = "columns may come")]
    pub fn tick(sequence: u64) -> Tick {
        let of = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity) / 3.0;
        Tick {
            sequence,
            time: sequence as f64 * 1e-3,
            lateness: of(1),
            period: of(2),
            device_axes: [of(3), -of(4), f64::NAN],
            device_position: of(5),
            object_position: of(6),
            object_velocity: of(7),
            penetration: of(8),
            placement_shift: of(9),
            force_on_object: of(10),
            force_on_device: of(11),
            stored_energy: of(12),
            port_work: of(13),
            virtual_force_work: of(14),
            outside_work: of(15),
            original_leak: of(16),
            held_leak: of(17),
            tick_duration: of(18),
            device_round_trip: of(19),
            generation: 3,
            flags: Flags::CONTACT.with(Flags::MISSED_DEADLINE, true),
            phase: Phase::Leaves,
            ..Tick::UNKNOWN
        }
    }

    /// What a program reads that knows the message type only: the names and values of its fields.
    fn by_schema(message: &[u8]) -> Vec<(String, f64)> {
        assert_eq!(message[..4], [0, 1, 0, 0], "little-endian CDR");
        let body = &message[4..];
        let mut at = 0;
        let mut fields = Vec::new();
        for line in schema::tick().lines() {
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

    #[test]
    fn a_program_that_knows_the_message_type_reads_every_quantity_by_its_name() {
        let tick = tick(7);
        let mut message = Vec::new();
        tick.encode(&mut message);
        let fields = by_schema(&message);
        let expected = [
            ("sequence", 7.0),
            ("t_s", tick.time),
            ("lateness_s", tick.lateness),
            ("period_s", tick.period),
            ("device_axis_1_m", tick.device_axes[0]),
            ("device_axis_2_m", tick.device_axes[1]),
            ("device_axis_3_m", tick.device_axes[2]),
            ("device_position_m", tick.device_position),
            ("object_position_m", tick.object_position),
            ("object_velocity_m_per_s", tick.object_velocity),
            ("penetration_m", tick.penetration),
            ("placement_shift_m", tick.placement_shift),
            ("force_on_object_n", tick.force_on_object),
            ("force_on_device_n", tick.force_on_device),
            ("stored_energy_j", tick.stored_energy),
            ("port_work_j", tick.port_work),
            ("virtual_force_work_j", tick.virtual_force_work),
            ("outside_work_j", tick.outside_work),
            ("leak_original_j", tick.original_leak),
            ("leak_held_j", tick.held_leak),
            ("tick_duration_s", tick.tick_duration),
            ("device_round_trip_s", tick.device_round_trip),
            ("generation", 3.0),
            ("flags", 257.0),
            ("phase", 3.0),
        ];
        assert_eq!(fields.len(), COLUMNS.len());
        assert!(fields.len() >= expected.len());
        for (name, expected) in expected {
            let (_, value) = fields.iter().find(|(field, _)| field == name).unwrap();
            assert!(
                value.to_bits() == expected.to_bits(),
                "{name}: {value} for {expected}"
            );
        }
    }

    #[test]
    fn the_message_type_names_every_flag_and_phase_with_its_number() {
        let schema = schema::tick();
        let constant = |name: &str| name.to_uppercase().replace('-', "_");
        for (flag, name) in Flags::NAMED {
            let line = format!("uint32 FLAG_{}={}\n", constant(name), flag.0);
            assert!(schema.contains(&line), "{line}");
        }
        for phase in Phase::ALL {
            let line = format!(
                "uint8 PHASE_{}={}\n",
                constant(phase.name()),
                phase.number()
            );
            assert!(schema.contains(&line), "{line}");
            assert_eq!(Phase::ALL[usize::from(phase.number())], phase);
        }
    }
}

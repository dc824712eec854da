//! One tick of a loop, and its place in a recording.

use super::cdr::{Reader, Writer};
use super::state::{Flags, Phase};

/// What is seen from outside of one tick of a loop with a device.
///
/// Positions, velocities and forces are along the contact's axis and in the user's frame, positive
/// along it; NaN where there is no value. `docs/signs.md` draws the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tick {
    /// Number of the tick. The first of a recording is 0, and each is one more than the one before:
    /// a number that is missing is a tick that was lost.
    pub sequence: u64,
    /// When the device was sampled, since the loop's start `[s]`.
    pub time: f64,
    /// How late that was: time past the instant that was planned for it `[s]`; negative if early.
    pub lateness: f64,
    /// Measured time since the sample before `[s]`; NaN for the first.
    pub period: f64,
    /// The device's own axes `[m]`: its end-point in its own frame; NaN beyond the axes it has.
    pub device_axes: [f64; 3],
    /// Position of the device along the contact's normal, as the renderer saw it `[m]`.
    pub device_position: f64,
    /// Position of the object `[m]`.
    pub object_position: f64,
    /// Velocity of the object `[m/s]`.
    pub object_velocity: f64,
    /// Penetration of the device into the object `[m]`; positive in contact, whichever side the
    /// object lies on.
    pub penetration: f64,
    /// How far the object was shifted over the last interval by a method that places it `[m]`.
    pub placement_shift: f64,
    /// Force on the object as the renderer answered `[N]`, before safety had its say.
    pub force_on_object: f64,
    /// Force on the device that was really sent `[N]`.
    pub force_on_device: f64,
    /// Energy stored in object and contact `[J]`.
    pub stored_energy: f64,
    /// Work of the held force through the port since the start, positive into the object `[J]`.
    pub port_work: f64,
    /// Work of the virtual force f_V on the object since the start `[J]`.
    pub virtual_force_work: f64,
    /// Work from outside since the start: teleports, changed parameters, time without samples `[J]`.
    pub outside_work: f64,
    /// Accumulated leak of the spring force on the same motion, positive where energy was created
    /// `[J]`.
    pub original_leak: f64,
    /// Accumulated leak of the force that was held `[J]`.
    pub held_leak: f64,
    /// How long the tick took, from the sample to the command `[s]`.
    pub tick_duration: f64,
    /// How long the device took to answer `[s]`; NaN where that is not known.
    pub device_round_trip: f64,
    /// Which parameters were in force: 0 for those of the receipt, one more with every change.
    pub generation: u32,
    /// What is to be said of the tick.
    pub flags: Flags,
    /// What the coming interval was predicted to hold.
    pub phase: Phase,
}

/// Quantities of a tick, and the fields and columns they stand in.
pub(super) const NUMBERS: [&str; 21] = [
    "t_s",
    "lateness_s",
    "period_s",
    "device_axis_1_m",
    "device_axis_2_m",
    "device_axis_3_m",
    "device_position_m",
    "object_position_m",
    "object_velocity_m_per_s",
    "penetration_m",
    "placement_shift_m",
    "force_on_object_n",
    "force_on_device_n",
    "stored_energy_j",
    "port_work_j",
    "virtual_force_work_j",
    "outside_work_j",
    "leak_original_j",
    "leak_held_j",
    "tick_duration_s",
    "device_round_trip_s",
];

/// Name of the message type.
pub(super) const SCHEMA_NAME: &str = "palpate_msgs/msg/Tick";
/// The message type, as ROS 2 writes it: what tells Foxglove and PlotJuggler which bytes are what.
pub(super) const SCHEMA: &str = "\
# One tick of a haptic loop, palpate recording format 1. SI units, each in the name of its field.
# Positions, velocities and forces are along the contact's axis; NaN where there is no value.
uint64 sequence                  # 0, 1, 2, ...; a number that is missing is a tick that was lost
float64 t_s                      # when the device was sampled, since the loop's start [s]
float64 lateness_s               # past the planned instant [s]
float64 period_s                 # measured time since the sample before [s]
float64 device_axis_1_m          # end-point in the device's own frame [m]
float64 device_axis_2_m
float64 device_axis_3_m
float64 device_position_m        # along the contact's normal, as the renderer saw it [m]
float64 object_position_m        # [m]
float64 object_velocity_m_per_s  # [m/s]
float64 penetration_m            # positive in contact [m]
float64 placement_shift_m        # shift of the object over the last interval [m]
float64 force_on_object_n        # as the renderer answered [N]
float64 force_on_device_n        # as really sent [N]
float64 stored_energy_j          # in object and contact [J]
float64 port_work_j              # since the start, into the object [J]
float64 virtual_force_work_j     # since the start [J]
float64 outside_work_j           # since the start [J]
float64 leak_original_j          # of the spring force on the same motion [J]
float64 leak_held_j              # of the force that was held; positive: created [J]
float64 tick_duration_s          # from the sample to the command [s]
float64 device_round_trip_s      # [s]
uint32 generation                # of the parameters; 0: those of the receipt
uint32 flags                     # bits, see the constants
uint8 phase                      # predicted of the coming interval, see the constants
uint32 FLAG_CONTACT=1
uint32 FLAG_LIMITED_PULL=2
uint32 FLAG_LIMITED_FORCE=4
uint32 FLAG_LIMITED_SLEW=8
uint32 FLAG_LIMITED_GUARD=16
uint32 FLAG_FAULT=32
uint32 FLAG_SAFETY_LIMITED=64
uint32 FLAG_SAFETY_TRIPPED=128
uint32 FLAG_MISSED_DEADLINE=256
uint32 FLAG_DEVICE_FAULT=512
uint8 PHASE_FREE=0
uint8 PHASE_CONTACT=1
uint8 PHASE_ENTERS=2
uint8 PHASE_LEAVES=3
uint8 PHASE_WAITING=4
";

impl Tick {
    /// The quantities, in the order of [`NUMBERS`].
    pub(super) fn numbers(&self) -> [f64; NUMBERS.len()] {
        let [axis_1, axis_2, axis_3] = self.device_axes;
        [
            self.time,
            self.lateness,
            self.period,
            axis_1,
            axis_2,
            axis_3,
            self.device_position,
            self.object_position,
            self.object_velocity,
            self.penetration,
            self.placement_shift,
            self.force_on_object,
            self.force_on_device,
            self.stored_energy,
            self.port_work,
            self.virtual_force_work,
            self.outside_work,
            self.original_leak,
            self.held_leak,
            self.tick_duration,
            self.device_round_trip,
        ]
    }

    /// Appends the message; eight-byte fields come first, so nothing has to be padded.
    pub(super) fn encode(&self, message: &mut Vec<u8>) {
        let mut out = Writer::begin(message);
        out.u64(self.sequence);
        for number in self.numbers() {
            out.u64(number.to_bits());
        }
        out.u32(self.generation);
        out.u32(self.flags.0);
        out.u8(self.phase.number());
    }

    /// Reads a message; none if it is not that of a tick.
    pub(super) fn decode(message: &[u8]) -> Option<Self> {
        let mut bytes = Reader::begin(message)?;
        let sequence = bytes.u64()?;
        let mut number = || bytes.u64().map(f64::from_bits);
        let tick = Self {
            sequence,
            time: number()?,
            lateness: number()?,
            period: number()?,
            device_axes: [number()?, number()?, number()?],
            device_position: number()?,
            object_position: number()?,
            object_velocity: number()?,
            penetration: number()?,
            placement_shift: number()?,
            force_on_object: number()?,
            force_on_device: number()?,
            stored_energy: number()?,
            port_work: number()?,
            virtual_force_work: number()?,
            outside_work: number()?,
            original_leak: number()?,
            held_leak: number()?,
            tick_duration: number()?,
            device_round_trip: number()?,
            generation: bytes.u32()?,
            flags: Flags(bytes.u32()?),
            phase: *Phase::ALL.get(usize::from(bytes.u8()?))?,
        };
        bytes.is_at_end().then_some(tick)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A tick in which every quantity has a value of its own.
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
        }
    }

    /// What a program reads that knows the message type only: the names and values of its fields.
    fn by_schema(message: &[u8]) -> Vec<(String, f64)> {
        assert_eq!(message[..4], [0, 1, 0, 0], "little-endian CDR");
        let body = &message[4..];
        let mut at = 0;
        let mut fields = Vec::new();
        for line in SCHEMA.lines() {
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
        assert_eq!(fields.len(), expected.len());
        for ((field, value), (name, expected)) in fields.iter().zip(expected) {
            assert_eq!(field, name);
            assert!(
                value.to_bits() == expected.to_bits(),
                "{name}: {value} for {expected}"
            );
        }
        let numbers: Vec<&str> = fields[1..22].iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(numbers, NUMBERS);
    }

    #[test]
    fn the_message_type_names_every_flag_and_phase_with_its_number() {
        let constant = |name: &str| name.to_uppercase().replace('-', "_");
        for (flag, name) in Flags::NAMED {
            let line = format!("uint32 FLAG_{}={}\n", constant(name), flag.0);
            assert!(SCHEMA.contains(&line), "{line}");
        }
        for phase in Phase::ALL {
            let line = format!(
                "uint8 PHASE_{}={}\n",
                constant(phase.name()),
                phase.number()
            );
            assert!(SCHEMA.contains(&line), "{line}");
            assert_eq!(Phase::ALL[usize::from(phase.number())], phase);
        }
    }

    #[test]
    fn a_message_of_another_length_or_phase_is_no_tick() {
        let mut message = Vec::new();
        tick(1).encode(&mut message);
        assert_eq!(message.len(), 189);
        for length in 0..message.len() {
            assert_eq!(Tick::decode(&message[..length]), None, "{length}");
        }
        let with = |at: usize, byte: u8| {
            let mut changed = message.clone();
            changed[at] = byte;
            Tick::decode(&changed)
        };
        assert_eq!(with(188, 5), None, "phase 5");
        assert_eq!(with(1, 0), None, "big-endian");
        message.push(0);
        assert_eq!(Tick::decode(&message), None, "a byte more");
    }
}

//! Layout of the messages of a recording, as stored in the recording.
//!
//! A recording contains the types of its messages. A recording from before a column existed is read without it, and
//! an unknown column of a newer one is skipped.

use super::cdr::Reader;
use super::column::Column;
use super::{BodyTick, ContactTick, DeviceTick, Row, Tick, schema};

/// The fields of a message, in order.
#[derive(Debug)]
pub(super) struct Layout {
    pub holds: Holds,
    fields: Vec<Field>,
}

/// Part of a row in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holds {
    /// The tick; its contacts are separate messages.
    Tick,
    /// One of the contacts of a tick.
    Contact,
    /// One of the bodies of a tick.
    Body,
    /// One of the devices of a tick.
    Device,
}

#[derive(Clone, Copy, Debug)]
enum Field {
    /// A known column.
    Column(&'static Column),
    /// An unknown field of this number of bytes.
    Unknown(usize),
    /// An unknown text.
    UnknownText,
}

impl Holds {
    /// Returns the column of this name, if these messages have one.
    fn column(self, name: &str) -> Option<&'static Column> {
        let of = |columns: &'static [Column]| columns.iter().find(|column| column.name == name);
        match self {
            Self::Tick => of(Tick::COLUMNS),
            Self::Contact => of(ContactTick::COLUMNS),
            Self::Body => of(BodyTick::COLUMNS),
            Self::Device => of(DeviceTick::COLUMNS),
        }
    }

    /// Returns the columns that a message must have.
    fn needed(self) -> [&'static str; 2] {
        match self {
            Self::Tick => ["sequence", "t_s"],
            Self::Contact => ["sequence", "contact"],
            Self::Body => ["sequence", "body"],
            Self::Device => ["sequence", "device"],
        }
    }
}

impl Layout {
    /// Returns the layout in which this version writes a tick.
    pub fn of_tick() -> Self {
        let fields = Tick::COLUMNS.iter().map(Field::Column).collect();
        Self::new(Holds::Tick, fields)
    }

    /// Returns the layout in which this version writes a contact.
    pub fn of_contact() -> Self {
        let fields = ContactTick::COLUMNS.iter().map(Field::Column).collect();
        Self::new(Holds::Contact, fields)
    }

    /// Returns the layout in which this version writes a body.
    pub fn of_body() -> Self {
        let fields = BodyTick::COLUMNS.iter().map(Field::Column).collect();
        Self::new(Holds::Body, fields)
    }

    /// Returns the layout in which this version writes a device.
    pub fn of_device() -> Self {
        let fields = DeviceTick::COLUMNS.iter().map(Field::Column).collect();
        Self::new(Holds::Device, fields)
    }

    /// Parses the type of a message of this name, or returns the reason why it is not that of a tick, a contact, a
    /// body or a device.
    pub fn of_schema(name: &str, text: &str) -> Result<Self, String> {
        let mut fields = Vec::new();
        for line in text.lines() {
            let code = line.split('#').next().unwrap_or_default();
            if code.contains('=') || code.trim().is_empty() {
                continue;
            }
            let mut words = code.split_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(format!("`{}` is not a field", code.trim().escape_debug()));
            };
            fields.push((kind, name));
        }
        let has = |wanted: &str| fields.iter().any(|(_, name)| *name == wanted);
        let holds = match name {
            schema::CONTACT => Holds::Contact,
            schema::BODY => Holds::Body,
            schema::DEVICE => Holds::Device,
            _ => Holds::Tick,
        };
        for needed in holds.needed() {
            if !has(needed) {
                return Err(format!("it has no field `{needed}`"));
            }
        }
        let fields = fields
            .into_iter()
            .map(|(kind, name)| Field::of(kind, name, holds));
        Ok(Self::new(holds, fields.collect::<Result<_, _>>()?))
    }

    fn new(holds: Holds, fields: Vec<Field>) -> Self {
        Self { holds, fields }
    }

    /// Decodes a message into a row; `None` if the message is invalid.
    pub fn decode(&self, message: &[u8]) -> Option<Row> {
        let mut bytes = Reader::begin(message)?;
        let mut row = Row::UNKNOWN;
        for field in &self.fields {
            match field {
                Field::Column(column) => (column.set)(&mut row, column.kind.decode(&mut bytes)?),
                Field::Unknown(size) => bytes.skip(*size)?,
                Field::UnknownText => drop(bytes.text()?),
            }
        }
        bytes.is_at_end().then_some(row)
    }
}

impl Field {
    fn of(kind: &str, name: &str, holds: Holds) -> Result<Self, String> {
        if let Some(column) = holds.column(name) {
            let own = column.kind.message_type();
            return if kind == own {
                Ok(Self::Column(column))
            } else {
                Err(format!("its field `{name}` is {kind}, but must be {own}"))
            };
        }
        Ok(match kind {
            "bool" | "byte" | "char" | "int8" | "uint8" => Self::Unknown(1),
            "int16" | "uint16" => Self::Unknown(2),
            "float32" | "int32" | "uint32" => Self::Unknown(4),
            "float64" | "int64" | "uint64" => Self::Unknown(8),
            "string" => Self::UnknownText,
            _ => {
                return Err(format!(
                    "its field `{}` is {}, which this version cannot skip",
                    name.escape_debug(),
                    kind.escape_debug()
                ));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::row;
    use super::super::stream::{encode_contact, encode_tick};
    use super::*;

    /// Returns the messages of a tick and of its second contact.
    fn messages() -> [Vec<u8>; 2] {
        let Row { tick, contact, .. } = row(7, 1);
        let [mut of_tick, mut of_contact] = [Vec::new(), Vec::new()];
        encode_tick(&tick, &mut of_tick);
        encode_contact(&contact, &mut of_contact);
        [of_tick, of_contact]
    }

    #[test]
    fn what_is_written_reads_as_its_type_says() {
        let [of_tick, of_contact] = messages();
        let by_type = |name, text: &str| Layout::of_schema(name, text).unwrap();
        let said = |part: &dyn std::fmt::Debug| format!("{part:?}");
        for layout in [Layout::of_tick(), by_type(schema::TICK, &schema::tick())] {
            assert_eq!(layout.holds, Holds::Tick);
            let read = layout.decode(&of_tick).unwrap();
            assert_eq!(said(&read.tick), said(&row(7, 1).tick));
        }
        for layout in [
            Layout::of_contact(),
            by_type(schema::CONTACT, &schema::contact()),
        ] {
            assert_eq!(layout.holds, Holds::Contact);
            let read = layout.decode(&of_contact).unwrap();
            assert_eq!(said(&read.contact), said(&row(7, 1).contact));
        }
    }

    #[test]
    fn a_column_that_is_not_there_has_no_value_and_one_that_is_not_known_is_passed_over() {
        let layout = Layout::of_schema(
            schema::TICK,
            "uint8 spin\nuint64 sequence # all of them\nstring colour\nfloat64 t_s\n\
             uint8 SPIN_UP=1\n\nfloat32 heat\nfloat64 lateness_s\n",
        )
        .unwrap();
        let mut message = vec![0, 1, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0];
        message.extend(5_u64.to_le_bytes());
        message.extend(*b"\x04\0\0\0red\0");
        message.extend(0.25_f64.to_le_bytes());
        message.extend(36.6_f32.to_le_bytes());
        // The next field is aligned to a multiple of eight.
        message.extend([0; 4]);
        message.extend((-0.5_f64).to_le_bytes());
        let Row { tick, .. } = layout.decode(&message).unwrap();
        assert_eq!((tick.sequence, tick.time, tick.lateness), (5, 0.25, -0.5));
        assert!(tick.period.is_nan() && tick.device_axes[2].is_nan());
        assert_eq!(tick.generation, 0);
        message.push(0);
        assert_eq!(layout.decode(&message), None, "a byte more");
        for length in 0..message.len() - 1 {
            assert_eq!(layout.decode(&message[..length]), None, "{length}");
        }
    }

    #[test]
    fn a_type_that_is_not_that_of_a_tick_says_why() {
        let refused = |schema: &str| Layout::of_schema(schema::TICK, schema).unwrap_err();
        assert_eq!(refused("float64 t_s"), "it has no field `sequence`");
        assert_eq!(
            refused("uint64 sequence\nfloat32 t_s"),
            "its field `t_s` is float32, but must be float64"
        );
        assert_eq!(
            refused("uint64 sequence\nfloat64 t_s\nfloat64[3] pose"),
            "its field `pose` is float64[3], which this version cannot skip"
        );
        assert_eq!(refused("what"), "`what` is not a field");
        let of_contact = Layout::of_schema(schema::CONTACT, "uint64 sequence");
        assert_eq!(of_contact.unwrap_err(), "it has no field `contact`");
    }

    #[test]
    fn a_message_of_another_length_or_phase_is_none() {
        let layouts = [Layout::of_tick(), Layout::of_contact()];
        for (layout, whole) in layouts.iter().zip(messages()) {
            for length in 0..whole.len() {
                assert_eq!(layout.decode(&whole[..length]), None, "{length}");
            }
            let with = |at: usize, byte: u8| {
                let mut changed = whole.clone();
                changed[at] = byte;
                layout.decode(&changed)
            };
            assert_eq!(with(1, 0), None, "big-endian");
            if layout.holds == Holds::Contact {
                let phase = whole.len() - 1;
                assert_eq!(with(phase, 5), None, "phase 5");
            }
        }
    }
}

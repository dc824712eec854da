//! Where the columns stand in the messages of a recording, as the recording itself says.
//!
//! A recording carries the type of its ticks. So one that was made before a column was there is read
//! without it, and one with a column that this version does not know is read but for that column.

use super::cdr::Reader;
use super::column::Column;
use super::{COLUMNS, Tick};

/// The fields of a tick's message, one after the other.
#[derive(Debug)]
pub(super) struct Layout {
    fields: Vec<Field>,
}

#[derive(Clone, Copy, Debug)]
enum Field {
    /// A column that is known.
    Column(&'static Column),
    /// A field that is not, of so many bytes.
    Unknown(usize),
    /// A text that is not.
    UnknownText,
}

impl Layout {
    /// As this version writes it.
    pub fn own() -> Self {
        Self::new(COLUMNS.iter().map(Field::Column).collect())
    }

    /// As the type of a message says; why it is not that of a tick.
    pub fn of_schema(schema: &str) -> Result<Self, String> {
        let mut fields = Vec::new();
        for line in schema.lines() {
            let code = line.split('#').next().unwrap_or_default();
            if code.contains('=') || code.trim().is_empty() {
                continue;
            }
            let mut words = code.split_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(format!("`{}` is no field", code.trim().escape_debug()));
            };
            fields.push(Field::of(kind, name)?);
        }
        let has = |wanted: &str| {
            let is_it = |field: &Field| matches!(field, Field::Column(c) if c.name == wanted);
            fields.iter().any(is_it)
        };
        for needed in ["sequence", "t_s"] {
            if !has(needed) {
                return Err(format!("it has no field `{needed}`"));
            }
        }
        Ok(Self::new(fields))
    }

    fn new(fields: Vec<Field>) -> Self {
        Self { fields }
    }

    /// Reads a message; none if it is not that of a tick.
    pub fn decode(&self, message: &[u8]) -> Option<Tick> {
        let mut bytes = Reader::begin(message)?;
        let mut tick = Tick::UNKNOWN;
        for field in &self.fields {
            match field {
                Field::Column(column) => (column.set)(&mut tick, column.kind.decode(&mut bytes)?),
                Field::Unknown(size) => bytes.skip(*size)?,
                Field::UnknownText => drop(bytes.text()?),
            }
        }
        bytes.is_at_end().then_some(tick)
    }
}

impl Field {
    fn of(kind: &str, name: &str) -> Result<Self, String> {
        if let Some(column) = Column::named(name) {
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
                    "its field `{}` is {}, which this version cannot read past",
                    name.escape_debug(),
                    kind.escape_debug()
                ));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::schema;
    use super::super::tick::tests::tick;
    use super::*;

    fn message() -> Vec<u8> {
        let mut message = Vec::new();
        tick(7).encode(&mut message);
        message
    }

    #[test]
    fn what_is_written_reads_as_its_type_says() {
        for layout in [Layout::own(), Layout::of_schema(&schema::tick()).unwrap()] {
            let read = layout.decode(&message()).unwrap();
            assert_eq!(format!("{read:?}"), format!("{:?}", tick(7)));
        }
    }

    #[test]
    fn a_column_that_is_not_there_has_no_value_and_one_that_is_not_known_is_passed_over() {
        let layout = Layout::of_schema(
            "uint8 spin\nuint64 sequence # all of them\nstring colour\nfloat64 t_s\n\
             uint8 SPIN_UP=1\n\nfloat32 heat\nfloat64 penetration_m\n",
        )
        .unwrap();
        let mut message = vec![0, 1, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0];
        message.extend(5_u64.to_le_bytes());
        message.extend(*b"\x04\0\0\0red\0");
        message.extend(0.25_f64.to_le_bytes());
        message.extend(36.6_f32.to_le_bytes());
        // The next stands at a multiple of eight.
        message.extend([0; 4]);
        message.extend((-0.5_f64).to_le_bytes());
        let read = layout.decode(&message).unwrap();
        assert_eq!(
            (read.sequence, read.time, read.penetration),
            (5, 0.25, -0.5)
        );
        assert!(read.force_on_device.is_nan() && read.device_axes[2].is_nan());
        assert_eq!(read.generation, 0);
        message.push(0);
        assert_eq!(layout.decode(&message), None, "a byte more");
        for length in 0..message.len() - 1 {
            assert_eq!(layout.decode(&message[..length]), None, "{length}");
        }
    }

    #[test]
    fn a_type_that_is_not_that_of_a_tick_says_why() {
        let refused = |schema: &str| Layout::of_schema(schema).unwrap_err();
        assert_eq!(refused("float64 t_s"), "it has no field `sequence`");
        assert_eq!(
            refused("uint64 sequence\nfloat32 t_s"),
            "its field `t_s` is float32, but must be float64"
        );
        assert_eq!(
            refused("uint64 sequence\nfloat64 t_s\nfloat64[3] pose"),
            "its field `pose` is float64[3], which this version cannot read past"
        );
        assert_eq!(refused("what"), "`what` is no field");
    }

    #[test]
    fn a_message_of_another_length_or_phase_is_no_tick() {
        let layout = Layout::own();
        let whole = message();
        for length in 0..whole.len() {
            assert_eq!(layout.decode(&whole[..length]), None, "{length}");
        }
        let with = |at: usize, byte: u8| {
            let mut changed = whole.clone();
            changed[at] = byte;
            layout.decode(&changed)
        };
        let phase = whole.len() - 1;
        assert_eq!(with(phase, 5), None, "phase 5");
        assert_eq!(with(1, 0), None, "big-endian");
    }
}

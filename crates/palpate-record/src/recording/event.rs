//! Events between ticks.

use super::cdr::{Reader, Writer};

/// An event at a tick: a fault, a change of parameters, the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Number of the tick of the event. That tick was made, even if it is lost.
    pub sequence: u64,
    /// Time since the loop's start `[s]`.
    pub time: f64,
    /// Kind of the event, in kebab case.
    pub kind: String,
    /// Description. It ends at the first NUL character, which the encoding cannot contain.
    pub text: String,
}

/// A column of the events.
pub(super) struct EventColumn {
    pub name: &'static str,
    /// Name of the type of its values in ROS 2.
    pub message_type: &'static str,
    pub meaning: &'static str,
}

/// Columns of the events, in the order of the files.
pub(super) const COLUMNS: [EventColumn; 4] = [
    EventColumn {
        name: "sequence",
        message_type: "uint64",
        meaning: "number of the tick",
    },
    EventColumn {
        name: "t_s",
        message_type: "float64",
        meaning: "time since the loop's start [s]",
    },
    EventColumn {
        name: "kind",
        message_type: "string",
        meaning: "kind of the event, in kebab case",
    },
    EventColumn {
        name: "text",
        message_type: "string",
        meaning: "description of the event",
    },
];

impl Event {
    pub(super) fn encode(&self, message: &mut Vec<u8>) {
        let mut out = Writer::begin(message);
        out.u64(self.sequence);
        out.u64(self.time.to_bits());
        out.text(&self.kind);
        out.text(&self.text);
    }

    /// Reads a message; `None` if it is not an event.
    pub(super) fn decode(message: &[u8]) -> Option<Self> {
        let mut bytes = Reader::begin(message)?;
        let event = Self {
            sequence: bytes.u64()?,
            time: f64::from_bits(bytes.u64()?),
            kind: bytes.text()?.to_owned(),
            text: bytes.text()?.to_owned(),
        };
        bytes.is_at_end().then_some(event)
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::Layout;
    use super::*;

    fn event() -> Event {
        Event {
            sequence: 258,
            time: 0.5,
            kind: "abc".into(),
            text: "µ".into(),
        }
    }

    #[test]
    fn the_bytes_of_an_event() {
        let mut message = Vec::new();
        event().encode(&mut message);
        let mut expected = vec![0, 1, 0, 0];
        expected.extend([2, 1, 0, 0, 0, 0, 0, 0]);
        expected.extend(0.5_f64.to_le_bytes());
        expected.extend(*b"\x04\0\0\0abc\0");
        expected.extend(*b"\x03\0\0\0\xc2\xb5\0");
        assert_eq!(message, expected);
        assert_eq!(Event::decode(&message), Some(event()));
        for length in 0..message.len() {
            assert_eq!(Event::decode(&message[..length]), None, "{length}");
        }
        message.push(0);
        assert_eq!(Event::decode(&message), None);
    }

    #[test]
    fn numbers_after_texts_stand_at_multiples_of_their_size() {
        let mut message = Vec::new();
        let odd = Event {
            kind: "abcd".into(),
            ..event()
        };
        odd.encode(&mut message);
        // 16 bytes of numbers, a length, five bytes of text, and three of padding.
        assert_eq!(message[4 + 25..4 + 28], [0, 0, 0]);
        assert_eq!(Event::decode(&message), Some(odd));
    }

    #[test]
    fn a_text_ends_where_no_text_can_go_on() {
        let mut message = Vec::new();
        let torn = Event {
            text: "one\0two".into(),
            ..event()
        };
        torn.encode(&mut message);
        assert_eq!(Event::decode(&message).unwrap().text, "one");
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes: Vec<u8>) {
            let _ = Event::decode(&bytes);
            let marked = [&[0, 1, 0, 0], bytes.as_slice()].concat();
            let _ = Event::decode(&marked);
            for layout in [Layout::of_tick(), Layout::of_contact(), Layout::of_device()] {
                let _ = (layout.decode(&bytes), layout.decode(&marked));
            }
        }

        #[test]
        fn every_event_reads_back(
            sequence: u64, bits: u64, kind in "[^\0]{0,9}", text in "[^\0]{0,40}",
        ) {
            let event = Event { sequence, time: f64::from_bits(bits), kind, text };
            let mut message = Vec::new();
            event.encode(&mut message);
            let read = Event::decode(&message).unwrap();
            assert_eq!(read.time.to_bits(), event.time.to_bits());
            assert_eq!(Event { time: 0.0, ..read }, Event { time: 0.0, ..event });
        }
    }
}

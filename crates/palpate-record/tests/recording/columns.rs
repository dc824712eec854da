//! Recordings whose ticks have other columns than this version writes.

use std::borrow::Cow;
use std::io::Cursor;
use std::sync::Arc;

use mcap::records::Record;
use mcap::{Channel, Message, MessageStream, Schema, WriteOptions, read::LinearReader};

use super::common::{Scratch, bits, content, row, small};

/// Returns the small recording, with the types and messages of its ticks and contacts changed by `retype` and
/// `rewrite`, whose first argument is the topic.
fn changed(
    retype: impl Fn(&str, &str) -> String,
    rewrite: impl Fn(&str, &[u8]) -> Vec<u8>,
) -> Vec<u8> {
    let (bytes, _) = small(true);
    let mut out = WriteOptions::new()
        .compression(None)
        .library("another tool")
        .create(Cursor::new(Vec::new()))
        .unwrap();
    for record in LinearReader::new(&bytes).unwrap() {
        if let Record::Metadata(metadata) = record.unwrap() {
            out.write_metadata(&metadata).unwrap();
        }
    }
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        if topic == "/event" {
            out.write(&message).unwrap();
            continue;
        }
        let schema = message.channel.schema.as_ref().unwrap();
        let text = std::str::from_utf8(&schema.data).unwrap();
        let schema = Schema {
            data: Cow::Owned(retype(&topic, text).into_bytes()),
            ..(**schema).clone()
        };
        let channel = Channel {
            schema: Some(Arc::new(schema)),
            ..(*message.channel).clone()
        };
        let message = Message {
            channel: Arc::new(channel),
            data: Cow::Owned(rewrite(&topic, &message.data)),
            ..message
        };
        out.write(&message).unwrap();
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

/// Contacts without the penetration, which is 40 bytes after the mark of four bytes, and ticks with an unknown field
/// after their number.
#[test]
fn ticks_and_contacts_are_read_by_the_types_that_the_file_gives_them() {
    let retype = |topic: &str, text: &str| {
        let lines = text.lines().filter(|line| !line.contains("penetration_m"));
        let lines = lines.flat_map(|line| {
            let more = (topic == "/tick" && line.starts_with("uint64 sequence"))
                .then_some("float32 temperature_k");
            [line].into_iter().chain(more)
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let rewrite = |topic: &str, data: &[u8]| match topic {
        "/tick" => {
            let temperature = 300_f32.to_le_bytes();
            [&data[..12], &temperature, &[0; 4], &data[12..]].concat()
        }
        _ => [&data[..44], &data[52..]].concat(),
    };
    let scratch = Scratch::new();
    let recording = scratch.open(&changed(retype, rewrite)).unwrap();
    assert_eq!(recording.damage, [] as [String; 0]);
    assert!(recording.is_complete());
    let (ticks, _) = content(&recording);
    assert_eq!(ticks.len(), 9);
    for (sequence, read) in (0..).zip(&ticks) {
        let mut expected = row(sequence);
        expected.contact.penetration = f64::NAN;
        assert_eq!(bits(read), bits(&expected));
    }
}

#[test]
fn a_column_of_another_type_is_named() {
    let retype =
        |_: &str, text: &str| text.replace("float64 penetration_m", "float32 penetration_m");
    let recording = Scratch::new()
        .open(&changed(retype, |_, data| data.to_vec()))
        .unwrap();
    assert_eq!(recording.ticks, 0);
    let why = "the type of the contacts: its field `penetration_m` is float32, but must be float64";
    assert!(recording.damage[0].ends_with(why), "{:?}", recording.damage);
}

//! Recordings whose ticks have other columns than this version writes.

use std::borrow::Cow;
use std::io::Cursor;
use std::sync::Arc;

use mcap::records::Record;
use mcap::{Channel, Message, MessageStream, Schema, WriteOptions, read::LinearReader};

use super::common::{Scratch, bits, content, small, tick};

/// The small recording, its type of ticks and their messages changed by `retype` and `rewrite`.
fn changed(retype: impl Fn(&str) -> String, rewrite: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
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
        if message.channel.topic != "/tick" {
            out.write(&message).unwrap();
            continue;
        }
        let schema = message.channel.schema.as_ref().unwrap();
        let text = std::str::from_utf8(&schema.data).unwrap();
        let schema = Schema {
            data: Cow::Owned(retype(text).into_bytes()),
            ..(**schema).clone()
        };
        let channel = Channel {
            schema: Some(Arc::new(schema)),
            ..(*message.channel).clone()
        };
        let message = Message {
            channel: Arc::new(channel),
            data: Cow::Owned(rewrite(&message.data)),
            ..message
        };
        out.write(&message).unwrap();
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

/// Without the penetration, which stands 80 bytes behind the mark of four, and with a field that this
/// version does not know behind the number of the tick.
#[test]
fn ticks_are_read_by_the_type_that_the_file_gives_them() {
    let retype = |text: &str| {
        let lines = text.lines().filter(|line| !line.contains("penetration_m"));
        let lines = lines.flat_map(|line| {
            let more = line
                .starts_with("uint64 sequence")
                .then_some("float32 temperature_k");
            [line].into_iter().chain(more)
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let rewrite = |data: &[u8]| {
        let temperature = 300_f32.to_le_bytes();
        [
            &data[..12],
            &temperature,
            &[0; 4],
            &data[12..84],
            &data[92..],
        ]
        .concat()
    };
    let scratch = Scratch::new();
    let recording = scratch.open(&changed(retype, rewrite)).unwrap();
    assert_eq!(recording.damage, [] as [String; 0]);
    assert!(recording.is_complete());
    let (ticks, _) = content(&recording);
    assert_eq!(ticks.len(), 9);
    for (sequence, read) in (0..).zip(&ticks) {
        let mut expected = tick(sequence);
        expected.penetration = f64::NAN;
        assert_eq!(bits(read), bits(&expected));
    }
}

#[test]
fn a_column_of_another_type_is_named() {
    let retype = |text: &str| text.replace("float64 penetration_m", "float32 penetration_m");
    let recording = Scratch::new()
        .open(&changed(retype, <[u8]>::to_vec))
        .unwrap();
    assert_eq!(recording.ticks, 0);
    let why = "the type of the ticks: its field `penetration_m` is float32, but must be float64";
    assert!(recording.damage[0].ends_with(why), "{:?}", recording.damage);
}

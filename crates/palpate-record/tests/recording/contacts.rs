//! Ticks with several contacts, and without contacts.

use std::io::Cursor;

use mcap::records::Record;
use mcap::{Channel, MessageStream, WriteOptions, read::LinearReader};
use palpate_record::recording::{ContactTick, Entry, Recording, RecordingWriter, Row, Tick};
use palpate_record::run;

use super::common::{Scratch, bits, count, event, metadata, row};

/// Returns the contacts of a tick: three, and none for every fifth tick.
fn contacts(sequence: u64) -> Vec<ContactTick> {
    let of_row = row(sequence).contact;
    let number = if sequence % 5 == 4 { 0 } else { 3 };
    let contact = |number: u32| ContactTick {
        contact: number,
        penetration: f64::from(number) - 0.5,
        port_work: of_row.port_work * f64::from(number),
        ..of_row
    };
    (0..number).map(contact).collect()
}

/// Returns a recording of twelve ticks, flushed after every fourth, and the length of the file after each flush.
fn small(finished: bool) -> (Vec<u8>, Vec<usize>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    let part = writer.part().to_owned();
    let mut sizes = Vec::new();
    for sequence in 0..12 {
        let tick = row(sequence).tick;
        writer.append(&tick, &contacts(sequence)).unwrap();
        if sequence % 4 == 3 {
            writer.flush().unwrap();
            sizes.push(usize::try_from(std::fs::metadata(&part).unwrap().len()).unwrap());
        }
    }
    writer.event(&event(11)).unwrap();
    if finished {
        writer.count(&count(12, 1)).unwrap();
        writer.finish().unwrap();
        (std::fs::read(path).unwrap(), sizes)
    } else {
        drop(writer);
        (std::fs::read(part).unwrap(), sizes)
    }
}

/// Returns the numbers of the ticks of a recording; checks that each is as written, with all its contacts.
fn numbers(recording: &Recording) -> Vec<u64> {
    let mut numbers = Vec::new();
    for entry in recording.entries().unwrap() {
        let Entry::Tick(tick, read, _, _) = entry.unwrap() else {
            continue;
        };
        let written = contacts(tick.sequence);
        let said = |contacts: &[ContactTick], tick: Tick| -> Vec<_> {
            Row::new(tick, contacts).map(|row| bits(&row)).collect()
        };
        let expected = Tick {
            contacts: u32::try_from(written.len()).unwrap(),
            ..row(tick.sequence).tick
        };
        assert_eq!(said(&read, tick), said(&written, expected));
        numbers.push(tick.sequence);
    }
    assert_eq!(numbers.len() as u64, recording.ticks);
    numbers
}

#[test]
fn every_contact_of_every_tick_is_read() {
    let scratch = Scratch::new();
    let recording = scratch.open(&small(true).0).unwrap();
    assert!(recording.is_complete() && !recording.has_one_contact_each);
    assert_eq!(numbers(&recording), (0..12).collect::<Vec<_>>());
    // Three rows for most ticks, and one for each of two ticks without contacts.
    assert_eq!(recording.rows().unwrap().count(), 3 * 10 + 2);
}

/// The size of the tick is constant, and each contact adds the same size.
#[test]
fn a_tick_does_not_grow_with_the_number_of_its_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let size = |number: usize| {
        let path = folder.path().join(format!("{number}.mcap"));
        let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
        for sequence in 0..100 {
            let Row { tick, contact, .. } = row(sequence);
            writer.append(&tick, &vec![contact; number]).unwrap();
        }
        writer.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let longest = |topic: &str| {
            let messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
            let of_topic = messages.filter(|message| message.channel.topic == topic);
            let lengths: Vec<usize> = of_topic.map(|message| message.data.len()).collect();
            (lengths.len(), lengths.iter().max().copied())
        };
        (longest("/tick"), longest("/contact"))
    };
    let (one, three) = (size(1), size(3));
    assert_eq!(one.0, three.0);
    assert_eq!((one.1.0, three.1.0), (100, 300));
    assert_eq!(one.1.1, three.1.1);
}

#[test]
fn a_tick_that_was_lost_is_lost_with_its_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in [0, 1, 5, 6] {
        let tick = row(sequence).tick;
        writer.append(&tick, &contacts(sequence)).unwrap();
    }
    writer.count(&count(9, 0)).unwrap();
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    assert_eq!(numbers(&recording), [0, 1, 5, 6]);
    assert_eq!((recording.lost(), recording.missing.len()), (5, 2));
}

#[test]
fn cut_anywhere_it_has_no_tick_without_all_its_contacts() {
    for finished in [false, true] {
        let (bytes, sizes) = small(finished);
        let scratch = Scratch::new();
        let (mut within_a_chunk, mut most) = (0, 0);
        for length in sizes[0]..bytes.len() {
            let recording = scratch.open(&bytes[..length]).unwrap();
            assert!(!recording.is_whole(), "{length}");
            assert_eq!(recording.lost(), 0, "{length}");
            let numbers = numbers(&recording);
            let flushed = 4 * sizes.iter().filter(|size| **size <= length).count();
            assert!(numbers.len() >= flushed, "{length}: {numbers:?}");
            let there = numbers.len() as u64;
            assert!(numbers.iter().copied().eq(0..there), "{numbers:?}");
            within_a_chunk += usize::from(!there.is_multiple_of(4));
            most = most.max(there);
        }
        // A cut chunk is read from where its only lz4 block is whole.
        assert!(within_a_chunk > 0 && most == 12, "{within_a_chunk} {most}");
    }
}

#[test]
fn a_damaged_chunk_takes_its_ticks_with_their_contacts() {
    let (mut bytes, sizes) = small(true);
    bytes[sizes[0] + 200] ^= 1;
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert_eq!(numbers(&recording), [0, 1, 2, 3, 8, 9, 10, 11]);
    assert_eq!(recording.lost(), 4);
}

/// Rewrites the recording as another tool may do: with a few messages per chunk, so that most ticks are in another
/// chunk than their contacts, and only the messages for which `keeps` is true.
fn rewritten(bytes: &[u8], keeps: impl Fn(&str, u32, usize) -> bool) -> Vec<u8> {
    let mut out = WriteOptions::new()
        .compression(None)
        .library("another tool")
        .chunk_size(Some(300))
        .create(Cursor::new(Vec::new()))
        .unwrap();
    for record in LinearReader::new(bytes).unwrap() {
        if let Record::Metadata(metadata) = record.unwrap() {
            out.write_metadata(&metadata).unwrap();
        }
    }
    let mut of_tick = 0;
    for message in MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let Channel { topic, .. } = &*message.channel;
        of_tick = if topic == "/tick" { 0 } else { of_tick + 1 };
        if keeps(topic, message.sequence, of_tick) {
            out.write(&message).unwrap();
        }
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

#[test]
fn a_tick_is_put_together_across_chunks() {
    let bytes = rewritten(&small(true).0, |_, _, _| true);
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    assert!(chunks.len() > 15, "{}", chunks.len());
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert!(recording.is_complete(), "{:?}", recording.damage);
    assert_eq!(numbers(&recording).len(), 12);
}

#[test]
fn a_tick_whose_contacts_are_not_all_there_is_missing() {
    let scratch = Scratch::new();
    let (bytes, _) = small(true);
    // Tick 2 lacks its last contact, and tick 6 has only contacts.
    let keeps = |topic: &str, sequence: u32, of_tick: usize| match (topic, sequence) {
        ("/contact", 2) => of_tick < 3,
        ("/tick", 6) => false,
        _ => true,
    };
    let recording = scratch.open(&rewritten(&bytes, keeps)).unwrap();
    assert_eq!(recording.damage, [] as [String; 0]);
    assert_eq!(numbers(&recording), [0, 1, 3, 4, 5, 7, 8, 9, 10, 11]);
    assert_eq!(recording.lost(), 2);
    // Without the first contact, the second one marks the chunk as damaged.
    let keeps = |topic: &str, sequence: u32, of_tick: usize| {
        (topic, sequence, of_tick) != ("/contact", 2, 1)
    };
    let recording = scratch.open(&rewritten(&bytes, keeps)).unwrap();
    let why = "contact 1 of tick 2 is in the position of contact 0";
    assert!(recording.damage[0].ends_with(why), "{:?}", recording.damage);
    assert!(!numbers(&recording).contains(&2));
}

#[test]
fn a_table_has_a_line_for_each_contact() {
    let scratch = Scratch::new();
    let recording = scratch.open(&small(true).0).unwrap();
    let mut csv = Vec::new();
    recording.write_csv(&mut csv).unwrap();
    let table = run::read(csv.as_slice(), "r.csv").unwrap();
    let column = |name: &str| table.numbers(name).unwrap()[9..14].to_vec();
    assert_eq!(column("sequence"), [3., 3., 3., 4., 5.]);
    assert_eq!(column("contact"), [0., 1., 2., 0., 0.]);
    assert_eq!(column("contacts"), [3., 3., 3., 0., 3.]);
    assert_eq!(column("penetration_m")[..3], [-0.5, 0.5, 1.5]);
    assert!(column("penetration_m")[3].is_nan());
}

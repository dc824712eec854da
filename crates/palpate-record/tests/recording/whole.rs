//! Round trips of recordings.

use palpate_record::recording::{
    BodyTick, ContactTick, Entry, Event, Flags, Gap, Phase, Recording, RecordingMetadata,
    RecordingWriter, Tick,
};
use proptest::collection::{btree_set, vec};
use proptest::prelude::*;

use super::common::{append, bits, content, event, metadata, row, small};

#[test]
fn a_recording_reads_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in 0..100 {
        append(&mut writer, sequence).unwrap();
    }
    writer.event(&event(99)).unwrap();
    let summary = writer.finish().unwrap();
    assert_eq!((summary.ticks, summary.events), (100, 1));
    assert_eq!(summary.bytes, std::fs::metadata(&path).unwrap().len());

    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.metadata, metadata());
    assert!(recording.is_whole(), "{recording:?}");
    assert_eq!((recording.tail.as_deref(), recording.generation), (None, 1));
    let (ticks, events) = content(&recording);
    assert_eq!(events, [event(99)]);
    let again = recording.rows().unwrap().map(|row| bits(&row.unwrap()));
    assert!(again.eq(ticks.iter().map(bits)));
    for (sequence, read) in (0..100).zip(&ticks) {
        assert_eq!(bits(read), bits(&row(sequence)));
    }
}

#[test]
fn what_is_lost_is_counted_from_the_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in [2, 3, 7, 8] {
        append(&mut writer, sequence).unwrap();
        writer.flush().unwrap();
    }
    writer.event(&event(9)).unwrap();
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    let gap = |after, count| Gap { after, count };
    assert_eq!(
        recording.missing,
        [gap(None, 2), gap(Some(3), 3), gap(Some(8), 1)]
    );
    assert_eq!(recording.lost(), 6);
    assert!(recording.finished && !recording.is_whole());
}

#[test]
fn a_tick_that_does_not_come_after_the_last_is_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    append(&mut writer, 5).unwrap();
    for sequence in [5, 4] {
        let error = append(&mut writer, sequence).unwrap_err().to_string();
        let what = format!("tick {sequence} does not come after tick 5");
        assert!(error.contains(&what), "{error}");
    }
    append(&mut writer, 6).unwrap();
    writer.finish().unwrap();
    assert_eq!(Recording::open(&path).unwrap().ticks, 2);
}

#[test]
fn a_recording_without_a_tick_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nothing.mcap");
    let writer = RecordingWriter::create(&path, &metadata()).unwrap();
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    assert!(recording.is_whole());
    assert_eq!((recording.ticks, recording.first), (0, None));
    assert_eq!(recording.entries().unwrap().count(), 0);
}

#[test]
fn a_recording_that_is_being_made_is_read_as_far_as_it_is_flushed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("live.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in 0..5 {
        append(&mut writer, sequence).unwrap();
    }
    writer.flush().unwrap();
    append(&mut writer, 5).unwrap();
    let recording = Recording::open(writer.part()).unwrap();
    assert_eq!(recording.ticks, 5);
    assert_eq!(
        recording.tail.as_deref(),
        Some("never finished: it ends with its last flush")
    );
    // The writer continues, and the opened recording is unchanged.
    writer.flush().unwrap();
    content(&recording);
    assert_eq!(Recording::open(writer.part()).unwrap().ticks, 6);
}

#[test]
fn a_long_recording_is_cut_into_chunks_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in 0..12_000 {
        append(&mut writer, sequence).unwrap();
    }
    // Most of the recording is written even without a flush.
    let there = Recording::open(writer.part()).unwrap().ticks;
    assert!((5_000..12_000).contains(&there), "{there}");
    writer.finish().unwrap();
    assert_eq!(Recording::open(&path).unwrap().ticks, 12_000);
}

#[test]
fn other_programs_find_its_index() {
    let (bytes, _) = small(true);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let counts = summary.stats.unwrap();
    assert_eq!((counts.message_count, counts.metadata_count), (19, 2));
    assert_eq!(counts.message_end_time, 8_000_000);
    // The channels, and three flushes.
    assert_eq!(summary.chunk_indexes.len(), 4);
    for (topic, name) in [
        ("/tick", "Tick"),
        ("/contact", "Contact"),
        ("/event", "Event"),
    ] {
        let channel = summary
            .channels
            .values()
            .find(|c| c.topic == topic)
            .unwrap();
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(channel.message_encoding, "cdr");
        assert_eq!(
            (&schema.name[..], &schema.encoding[..]),
            (&format!("palpate_msgs/msg/{name}")[..], "ros2msg")
        );
    }
    let messages: Vec<_> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let topics = messages
        .iter()
        .map(|message| message.channel.topic.as_str());
    assert!(
        topics
            .take(4)
            .eq(["/tick", "/contact", "/tick", "/contact"])
    );
    for message in &messages[2..4] {
        assert_eq!((message.log_time, message.sequence), (1_000_000, 1));
    }
}

#[test]
fn metadata_is_the_first_record_after_the_header() {
    let (bytes, sizes) = small(false);
    let records = mcap::read::LinearReader::sans_magic(&bytes[8..sizes[0]]);
    let kinds: Vec<u8> = records
        .take(2)
        .map(|record| record.unwrap().opcode())
        .collect();
    use mcap::records::op;
    assert_eq!(kinds, [op::HEADER, op::METADATA]);
}

fn any_tick() -> impl Strategy<Value = Tick> {
    (vec(any::<u64>(), 28), any::<u32>(), any::<u32>()).prop_map(|(bits, generation, flags)| {
        let of = |quantity: usize| f64::from_bits(bits[quantity]);
        let vector = |quantity: usize| [of(quantity), of(quantity + 1), of(quantity + 2)];
        Tick {
            sequence: 0,
            time: of(0),
            lateness: of(1),
            period: of(2),
            device_axes: vector(3),
            device_orientation: [of(6), of(7), of(8), of(9)],
            commanded_force: vector(10),
            commanded_torque: vector(13),
            delivered_force: vector(16),
            delivered_slope: vector(25),
            delivered_torque: vector(19),
            tick_duration: of(22),
            device_round_trip: of(23),
            generation,
            contacts: 0,
            bodies: 0,
            created_energy: of(24),
            flags: Flags(flags),
        }
    })
}

fn any_contact() -> impl Strategy<Value = ContactTick> {
    (vec(any::<u64>(), 22), any::<u32>(), 0..5_usize).prop_map(|(bits, flags, phase)| {
        let of = |quantity: usize| f64::from_bits(bits[quantity]);
        ContactTick {
            sequence: 0,
            contact: 0,
            pair: flags.rotate_left(7),
            flags: Flags(flags),
            device_position: of(0),
            object_position: of(1),
            object_velocity: of(2),
            penetration: of(3),
            proxy_shift: of(4),
            force_on_object: of(5),
            force_on_device: of(6),
            stored_energy: of(7),
            port_work: of(8),
            virtual_force_work: of(9),
            outside_work: of(10),
            original_leak: of(11),
            held_leak: of(12),
            point: [of(13), of(14), of(15)],
            normal: [of(16), of(17), of(18)],
            force: [of(19), of(20), of(21)],
            phase: Phase::ALL[phase],
        }
    })
}

fn any_body() -> impl Strategy<Value = BodyTick> {
    (vec(any::<u64>(), 13), any::<u32>()).prop_map(|(bits, body)| {
        let of = |quantity: usize| f64::from_bits(bits[quantity]);
        let vector = |quantity: usize| [of(quantity), of(quantity + 1), of(quantity + 2)];
        BodyTick {
            sequence: 0,
            body,
            position: vector(0),
            orientation: [of(3), of(4), of(5), of(6)],
            velocity: vector(7),
            angular_velocity: vector(10),
        }
    })
}

/// Returns a tick, its contacts and its bodies as read: numbered, and with the flags of all contacts.
fn numbered(
    tick: Tick,
    contacts: &[ContactTick],
    bodies: &[BodyTick],
) -> (Tick, Vec<ContactTick>, Vec<BodyTick>) {
    let of_body = |body: &BodyTick| BodyTick {
        sequence: tick.sequence,
        ..*body
    };
    let bodies: Vec<_> = bodies.iter().map(of_body).collect();
    let flags = contacts
        .iter()
        .fold(tick.flags.0, |flags, contact| flags | contact.flags.0);
    let of_tick = |(number, contact): (u32, &ContactTick)| ContactTick {
        sequence: tick.sequence,
        contact: number,
        ..*contact
    };
    let tick = Tick {
        contacts: u32::try_from(contacts.len()).unwrap(),
        bodies: u32::try_from(bodies.len()).unwrap(),
        flags: Flags(flags),
        ..tick
    };
    let contacts = (0..).zip(contacts).map(of_tick).collect();
    (tick, contacts, bodies)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_recording_reads_back(
        ticks in vec((any_tick(), vec(any_contact(), 0..4), vec(any_body(), 0..3)), 0..20),
        sequences in btree_set(any::<u64>(), 20),
        flushes in vec(any::<bool>(), 20),
        texts in proptest::collection::btree_map("[^\0]{1,9}", ".{0,40}", 0..4),
        words in vec(("[^\0]{0,9}", "[^\0]{0,40}"), 0..5),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("any.mcap");
        let metadata = RecordingMetadata { palpate_version: "1.2.3".into(), texts };
        let mut writer = RecordingWriter::create(&path, &metadata).unwrap();
        let mut written = Vec::new();
        let mut events = Vec::new();
        for (i, ((tick, contacts, bodies), sequence)) in ticks.into_iter().zip(sequences).enumerate() {
            let tick = Tick { sequence, ..tick };
            writer.append_with_bodies(&tick, &contacts, &bodies).unwrap();
            if let Some((kind, text)) = words.get(i) {
                let event = Event { sequence, time: 0.5, kind: kind.clone(), text: text.clone() };
                writer.event(&event).unwrap();
                events.push(event);
            }
            if flushes[i] {
                writer.flush().unwrap();
            }
            written.push(numbered(tick, &contacts, &bodies));
        }
        writer.finish().unwrap();
        let recording = Recording::open(&path).unwrap();
        prop_assert_eq!(&recording.metadata, &metadata);
        prop_assert!(recording.finished && recording.damage.is_empty());
        let (mut read, mut said) = (Vec::new(), Vec::new());
        for entry in recording.entries().unwrap() {
            match entry.unwrap() {
                Entry::Tick(tick, contacts, bodies, _) => read.push((tick, contacts, bodies)),
                Entry::Event(event) => said.push(event),
            }
        }
        prop_assert_eq!(said, events);
        // The shortest text that parses to the same bits.
        prop_assert_eq!(format!("{read:?}"), format!("{written:?}"));
        let written: Vec<Tick> = written.into_iter().map(|(tick, ..)| tick).collect();
        let first = written.first().map_or(0, |tick| tick.sequence);
        let last = written.last().map_or(0, |tick| tick.sequence);
        let steps = written.windows(2).filter(|pair| pair[1].sequence > pair[0].sequence + 1);
        prop_assert_eq!(recording.missing.len(), steps.count() + usize::from(first > 0));
        if !written.is_empty() {
            prop_assert_eq!(recording.lost(), last - (written.len() as u64 - 1));
        }
    }
}

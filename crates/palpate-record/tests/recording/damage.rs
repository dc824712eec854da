//! Truncated and damaged files.

use std::sync::LazyLock;

use palpate_record::recording::{Recording, RecordingWriter};

use super::common::{Scratch, append, bits, content, event, metadata, row, small};

/// Returns the number of complete ticks in the first `length` bytes: those of chunks that end there. `sizes` includes
/// the index after each chunk, which is not needed to read it.
fn whole_ticks(length: usize, sizes: &[usize]) -> u64 {
    3 * sizes[1..].iter().filter(|size| **size <= length).count() as u64
}

#[test]
fn cut_anywhere_it_reads_what_was_flushed_and_says_that_there_is_no_end() {
    for finished in [false, true] {
        let (bytes, sizes) = small(finished);
        let scratch = Scratch::new();
        let (mut opened, mut torn, mut within_a_chunk) = (0, 0, 0);
        for length in 0..bytes.len() {
            let recording = match scratch.open(&bytes[..length]) {
                Ok(recording) => recording,
                Err(error) => {
                    // The file ends before the first possible tick.
                    assert!(length < sizes[0], "{length}: {error}");
                    continue;
                }
            };
            opened += 1;
            assert!(!recording.finished && !recording.is_whole(), "{length}");
            let tail = recording.tail.as_ref().unwrap();
            torn += usize::from(tail.starts_with("cut off"));
            assert!(
                tail.starts_with("cut off") || tail.starts_with("never finished"),
                "{tail}"
            );
            let (ticks, events) = content(&recording);
            assert!(recording.ticks >= whole_ticks(length, &sizes), "{length}");
            // A chunk is complete, or is read up to its last message but one and reported.
            let checked = recording.ticks + recording.events - recording.unchecked;
            assert!([0, 3, 7, 10].contains(&checked), "{length}: {checked}");
            assert_eq!(tail.contains("last chunk"), recording.unchecked > 0);
            within_a_chunk += usize::from(recording.unchecked > 0);
            assert_eq!(
                recording.events,
                u64::from(recording.ticks + recording.events > 5)
            );
            for (sequence, read) in (0..).zip(&ticks) {
                assert_eq!(bits(read), bits(&row(sequence)), "{length}");
            }
            assert!(events.iter().all(|read| *read == event(4)));
            assert_eq!(recording.lost(), 0);
        }
        assert!(
            opened > 2_000 && torn > opened * 9 / 10,
            "{torn} of {opened}"
        );
        // A cut chunk is read from where its only lz4 block is whole.
        assert!(within_a_chunk > 0, "{within_a_chunk}");
    }
}

/// A file after a crash of the machine: with its full length, and zeros in place of unwritten data.
#[test]
fn zeros_in_place_of_an_end_are_no_tick() {
    let (bytes, sizes) = small(false);
    let scratch = Scratch::new();
    for cut in (sizes[1]..bytes.len()).step_by(5) {
        let mut zeroed = bytes.clone();
        zeroed[cut..].fill(0);
        // Zeros to the end of the file, or only to the end of a message, within a truncated chunk.
        let lengths = [cut + 40, cut + 150, cut + 400].map(|length| length.min(bytes.len() - 1));
        for length in lengths.into_iter().chain([bytes.len()]) {
            let recording = scratch.open(&zeroed[..length]).unwrap();
            assert!(!recording.is_whole(), "{cut}");
            assert_true_ticks(&recording, cut);
            assert!(recording.ticks >= whole_ticks(cut, &sizes), "{cut}");
        }
    }
}

#[test]
fn a_changed_bit_in_any_byte_of_a_finished_recording_is_noticed_and_no_wrong_tick_is_believed() {
    let (bytes, _) = small(true);
    let scratch = Scratch::new();
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at % 8);
        if let Ok(recording) = scratch.open(&changed) {
            assert!(!recording.is_whole(), "byte {at} is not what it was");
            assert_true_ticks(&recording, at);
        }
    }
}

#[test]
fn of_an_unfinished_recording_no_wrong_tick_is_believed_either() {
    let (bytes, sizes) = small(false);
    let scratch = Scratch::new();
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at % 8);
        match scratch.open(&changed) {
            Ok(recording) => assert_true_ticks(&recording, at),
            Err(_) => assert!(at < sizes[0], "byte {at}: the metadata is sound"),
        }
    }
}

fn assert_true_ticks(recording: &Recording, at: usize) {
    let (ticks, events) = content(recording);
    for read in &ticks {
        assert!(read.tick.sequence < 9, "byte {at}");
        assert_eq!(bits(read), bits(&row(read.tick.sequence)), "byte {at}");
    }
    assert!(events.iter().all(|read| *read == event(4)), "byte {at}");
}

#[test]
fn a_damaged_chunk_is_left_out_and_what_follows_is_read() {
    let (mut bytes, sizes) = small(true);
    let within = sizes[1] + 200;
    bytes[within] ^= 1;
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert!(recording.finished && !recording.is_whole());
    let chunk = format!("the chunk at byte {}: ", sizes[1]);
    assert!(recording.damage[0].starts_with(&chunk), "{recording:?}");
    assert_eq!((recording.ticks, recording.lost()), (6, 3));
    let (ticks, _) = content(&recording);
    let numbers: Vec<u64> = ticks.iter().map(|row| row.tick.sequence).collect();
    assert_eq!(numbers, [0, 1, 2, 6, 7, 8]);
}

#[test]
fn a_chunk_whose_numbers_do_not_rise_is_left_out_and_counted() {
    let (bytes, sizes) = small(false);
    // The second flush occurs twice.
    let twice = [&bytes[..sizes[2]], &bytes[sizes[1]..]].concat();
    let scratch = Scratch::new();
    let recording = scratch.open(&twice).unwrap();
    assert_eq!(
        (recording.ticks, recording.events, recording.lost()),
        (9, 1, 0)
    );
    assert_eq!(
        recording.damage,
        [format!(
            "the chunk at byte {}: tick 3 does not come after the previous one",
            sizes[2]
        )]
    );
    assert_true_ticks(&recording, sizes[2]);
}

#[test]
fn a_recording_whose_first_chunk_is_damaged_still_has_its_ticks() {
    let (mut bytes, sizes) = small(true);
    // The chunk that defines the channels.
    bytes[sizes[0] - 20] ^= 1;
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert_eq!((recording.ticks, recording.damage.len()), (9, 2));
    assert_true_ticks(&recording, sizes[0] - 20);
    assert_eq!(recording.events, 1);
}

#[test]
fn bytes_behind_the_end_are_counted_and_nothing_else_is_wrong() {
    let (bytes, _) = small(true);
    for (count, words) in [
        (1, "1 byte follows the end of the recording"),
        (20_000, "20000 bytes follow the end of the recording"),
        (
            bytes.len(),
            &format!("{} bytes follow the end of the recording", bytes.len()),
        ),
    ] {
        let behind = bytes.iter().cycle().take(count);
        let longer: Vec<u8> = bytes.iter().chain(behind).copied().collect();
        let scratch = Scratch::new();
        let recording = scratch.open(&longer).unwrap();
        assert_eq!((recording.finished, recording.ticks), (true, 9));
        assert!(!recording.is_whole() && recording.lost() == 0, "{count}");
        assert_eq!(
            (&recording.tail, recording.bytes),
            (&None, longer.len() as u64)
        );
        assert_eq!(recording.damage, [format!("the file as a whole: {words}")]);
        let read = recording.entries().unwrap().filter(Result::is_ok).count();
        assert_eq!(read, 10, "{count}");
    }
    // The index has its own checksum.
    let mut changed = bytes.clone();
    let at = bytes.len() - mcap::MAGIC.len() - 30;
    changed[at] ^= 1;
    let recording = Scratch::new().open(&changed).unwrap();
    assert_eq!(
        recording.tail.as_deref(),
        Some("the index at its end is damaged")
    );
}

#[test]
fn what_is_no_recording_is_refused_by_name() {
    let scratch = Scratch::new();
    let path = scratch.path.display().to_string();
    let message = |bytes: &[u8]| scratch.open(bytes).unwrap_err().to_string();
    for other in [&b""[..], b"t_s,position_m\n0,0\n", &[0; 64]] {
        assert_eq!(
            message(other),
            format!("{path}: not an MCAP file, so no recording")
        );
    }
    let (bytes, _) = small(true);
    assert_eq!(
        message(&bytes[..100]),
        format!("{path}: cut off within its metadata: it contains no recorded data")
    );
    let mut other = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    other.finish().unwrap();
    let other = other.into_inner().into_inner();
    assert_eq!(
        message(&other),
        format!("{path}: an MCAP file, but not a recording of palpate")
    );
    let missing = scratch.path.with_file_name("missing.mcap");
    let error = Recording::open(&missing).unwrap_err().to_string();
    assert!(error.contains("missing.mcap: cannot be read: "), "{error}");
}

#[test]
fn a_recording_of_a_newer_format_is_refused_by_its_number() {
    let (bytes, _) = small(true);
    let from = b"recording_format\x01\x00\x00\x002";
    let at = bytes.windows(from.len()).position(|window| window == from);
    let mut newer = bytes;
    newer[at.unwrap() + from.len() - 1] = b'3';
    let error = Scratch::new().open(&newer).unwrap_err().to_string();
    assert!(
        error.ends_with("a recording of format 3; this version of palpate reads format 2"),
        "{error}"
    );
}

#[test]
fn a_writer_that_is_dropped_leaves_no_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let part = {
        let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
        append(&mut writer, 0).unwrap();
        writer.part().to_owned()
    };
    assert!(!path.exists());
    let recording = Recording::open(&part).unwrap();
    assert_eq!((recording.ticks, recording.finished), (1, false));
}

/// Returns a chunk with these records, as another program might write it.
fn chunk(records: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut data = Vec::new();
    for (opcode, body) in records {
        data.push(*opcode);
        data.extend((body.len() as u64).to_le_bytes());
        data.extend(body);
    }
    let mut body = vec![0; 16];
    body.extend((data.len() as u64).to_le_bytes());
    body.extend(crc32fast::hash(&data).to_le_bytes());
    body.extend([0; 4]);
    body.extend((data.len() as u64).to_le_bytes());
    body.extend(&data);
    let mut chunk = vec![6];
    chunk.extend((body.len() as u64).to_le_bytes());
    chunk.extend(&body);
    chunk
}

#[test]
fn records_of_others_are_passed_over() {
    let (mut bytes, _) = small(false);
    // An attachment that is too short and in an invalid position, and a record of unknown type.
    bytes.extend(chunk(&[(9, vec![0; 2]), (0x80, vec![1, 2, 3])]));
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert_eq!((recording.ticks, recording.damage.len()), (9, 0));
    // A message on an undefined channel, and an invalid tick on a valid one.
    let message = |channel: u8| {
        let mut message = vec![channel, 0];
        message.extend([0; 20]);
        (5, message)
    };
    bytes.extend(chunk(&[message(7)]));
    let at = bytes.len();
    bytes.extend(chunk(&[message(1)]));
    let recording = scratch.open(&bytes).unwrap();
    assert_eq!(recording.ticks, 9);
    assert_eq!(
        recording.damage,
        [format!("the chunk at byte {at}: a message is not a tick")]
    );
}

proptest::proptest! {
    #[test]
    fn no_chunk_makes_the_reader_panic(
        records in proptest::collection::vec((0..20_u8, proptest::prelude::any::<Vec<u8>>()), 0..4),
    ) {
        static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| small(false).0);
        let bytes = [&SOUND[..], &chunk(&records)].concat();
        let recording = Scratch::new().open(&bytes).unwrap();
        proptest::prop_assert_eq!(recording.ticks, 9);
    }

    #[test]
    fn no_bytes_make_the_reader_panic(at in 0..9_000_usize, tail: Vec<u8>) {
        static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| small(true).0);
        let mut changed = SOUND[..at.min(SOUND.len())].to_vec();
        changed.extend(tail);
        if let Ok(recording) = Scratch::new().open(&changed) {
            assert_true_ticks(&recording, at);
        }
    }
}

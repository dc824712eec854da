//! Ticks of a loop with several devices.

use palpate_record::recording::{DeviceTick, Entry, Flags, Recording, RecordingWriter};

use super::common::{Scratch, count, metadata, row};

/// Returns the devices of a tick, in which every quantity has a distinct value.
fn devices(sequence: u64, number: u32) -> Vec<DeviceTick> {
    let device = |device: u32| {
        let of = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity + 100 * device) / 3.0;
        let three = |first: u32| [of(first), of(first + 1), of(first + 2)];
        DeviceTick {
            sequence,
            device,
            devices: number,
            flags: Flags::DEVICE_FAULT.with(Flags::SAFETY_STOPPED, device == 1),
            time: of(1),
            round_trip: of(2),
            axes: three(3),
            orientation: [of(6), of(7), of(8), of(9)],
            commanded_force: three(10),
            commanded_torque: three(13),
            delivered_force: three(16),
            delivered_slope: three(22),
            delivered_torque: three(19),
        }
    };
    (0..number).map(device).collect()
}

/// Returns a recording of twelve ticks of a loop with `number` devices, and the length of the file after every fourth
/// tick.
fn small(number: u32) -> (Vec<u8>, Vec<usize>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    let part = writer.part().to_owned();
    let mut sizes = Vec::new();
    for sequence in 0..12 {
        let (tick, contact) = (row(sequence).tick, row(sequence).contact);
        // The writer replaces these numbers.
        let mut devices = devices(sequence, number);
        for device in &mut devices {
            (device.sequence, device.device, device.devices) = (99, 99, 99);
        }
        if number == 1 {
            writer.append(&tick, &[contact]).unwrap();
        } else {
            let written = writer.append_with_devices(&tick, &[contact], &[], &devices);
            written.unwrap();
        }
        if sequence % 4 == 3 {
            writer.flush().unwrap();
            sizes.push(usize::try_from(std::fs::metadata(&part).unwrap().len()).unwrap());
        }
    }
    writer.count(&count(12, 0)).unwrap();
    writer.finish().unwrap();
    (std::fs::read(path).unwrap(), sizes)
}

/// Returns the numbers of the ticks of a recording; checks that each has all its devices as written.
fn numbers(recording: &Recording) -> Vec<u64> {
    let mut numbers = Vec::new();
    for entry in recording.entries().unwrap() {
        let Entry::Tick(tick, contacts, _, read) = entry.unwrap() else {
            panic!("there is no event");
        };
        assert_eq!(contacts.len(), 1);
        assert_eq!(read, devices(tick.sequence, 2));
        numbers.push(tick.sequence);
    }
    numbers
}

#[test]
fn each_device_of_each_tick_is_read_as_it_was_written() {
    let (bytes, _) = small(2);
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert!(recording.is_complete());
    assert_eq!(recording.devices, 2);
    assert!(numbers(&recording).into_iter().eq(0..12));
    // One row for each contact only.
    assert_eq!(recording.rows().unwrap().count(), 12);
}

#[test]
fn a_recording_of_one_device_knows_nothing_of_several() {
    let (bytes, _) = small(1);
    let word = b"/device";
    assert!(!bytes.windows(word.len()).any(|part| part == word));
    assert!(!bytes.windows(10).any(|part| part == b"msg/Device"));
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert!(recording.is_complete() && recording.devices == 1);
}

#[test]
fn cut_anywhere_it_has_no_tick_without_all_its_devices() {
    let (bytes, sizes) = small(2);
    let scratch = Scratch::new();
    let mut within_a_chunk = 0;
    for length in (sizes[0]..bytes.len()).step_by(7) {
        let recording = scratch.open(&bytes[..length]).unwrap();
        assert!(!recording.is_whole(), "{length}");
        let numbers = numbers(&recording);
        let flushed = 4 * sizes.iter().filter(|size| **size <= length).count();
        assert!(numbers.len() >= flushed, "{length}: {numbers:?}");
        let there = numbers.len() as u64;
        assert!(numbers.iter().copied().eq(0..there), "{numbers:?}");
        within_a_chunk += usize::from(!there.is_multiple_of(4));
    }
    // A cut chunk is read from where its only lz4 block is whole.
    assert!(within_a_chunk > 0, "{within_a_chunk}");
}

/// The first chunk contains the type of the devices: they are readable without it.
#[test]
fn a_damaged_chunk_takes_its_ticks_with_their_devices() {
    let (bytes, sizes) = small(2);
    for (byte, expected) in [
        (sizes[0] - 2500, [4, 5, 6, 7, 8, 9, 10, 11]),
        (sizes[0] + 200, [0, 1, 2, 3, 8, 9, 10, 11]),
    ] {
        let mut damaged = bytes.clone();
        damaged[byte] ^= 1;
        let scratch = Scratch::new();
        let recording = scratch.open(&damaged).unwrap();
        assert_eq!(numbers(&recording), expected);
        assert_eq!(recording.lost(), 4);
    }
}

#[test]
fn devices_are_a_table_of_their_own() {
    let (bytes, _) = small(2);
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    let mut table = Vec::new();
    recording.write_devices_csv(&mut table).unwrap();
    let table = String::from_utf8(table).unwrap();
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let head = lines.next().unwrap();
    assert!(
        head.starts_with("sequence,device,devices,flags,t_s,device_round_trip_s,device_axis_1_m"),
        "{head}"
    );
    assert!(head.contains(",delivered_force_3_n,"), "{head}");
    let lines: Vec<&str> = lines.collect();
    assert_eq!(lines.len(), 24);
    assert!(lines[0].starts_with("0,0,2,device-fault,"), "{}", lines[0]);
    let expected = "7,1,2,safety-stopped device-fault,";
    assert!(lines[15].starts_with(expected), "{}", lines[15]);
}

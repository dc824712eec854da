//! Recordings as tables.

use palpate_record::recording::Recording;
use palpate_record::run;

use super::common::{Scratch, metadata, row, small};

fn recording(scratch: &Scratch) -> Recording {
    let (bytes, sizes) = small(true);
    let mut damaged = bytes;
    // The second flush is damaged: ticks 3 to 5 and the event are lost.
    damaged[sizes[1] + 200] ^= 1;
    scratch.open(&damaged).unwrap()
}

#[test]
fn a_table_has_every_tick_and_says_what_it_has_not() {
    let scratch = Scratch::new();
    let mut csv = Vec::new();
    recording(&scratch).write_csv(&mut csv).unwrap();
    let table = run::read(csv.as_slice(), "r.csv").unwrap();
    assert_eq!(table.numbers("sequence").unwrap(), [0., 1., 2., 6., 7., 8.]);
    assert_eq!(table.texts("flags").unwrap()[0], "contact limited-slew");
    assert_eq!(table.texts("phase").unwrap()[1], "contact");
    let column = |name: &str| table.numbers(name).unwrap()[3].to_bits();
    let six = row(6);
    assert_eq!(column("t_s"), six.tick.time.to_bits());
    assert_eq!(column("device_axis_2_m"), six.tick.device_axes[1].to_bits());
    assert_eq!(column("leak_held_j"), six.contact.held_leak.to_bits());
    assert_eq!(
        column("device_round_trip_s"),
        six.tick.device_round_trip.to_bits()
    );
    let said = |key: &str| {
        let found = table.metadata().iter().find(|(name, _)| name == key);
        found.unwrap_or_else(|| panic!("no {key}")).1.as_str()
    };
    assert_eq!((said("ticks_lost"), said("events_lost")), ("3", "1"));
    assert_eq!((said("complete"), said("finished")), ("false", "true"));
    assert_eq!(
        (said("damaged_parts"), said("palpate_version")),
        ("2", "0.1.0")
    );
    assert_eq!(said("metadata scene"), metadata().texts["scene"]);
}

#[test]
fn events_are_a_table_of_their_own() {
    let scratch = Scratch::new();
    let (bytes, _) = small(true);
    let mut csv = Vec::new();
    scratch
        .open(&bytes)
        .unwrap()
        .write_events_csv(&mut csv)
        .unwrap();
    let table = run::read(csv.as_slice(), "e.csv").unwrap();
    assert_eq!(table.numbers("sequence").unwrap(), [4.0]);
    assert_eq!(table.numbers("t_s").unwrap(), [0.004]);
    assert_eq!(table.texts("kind").unwrap(), ["parameters"]);
    assert_eq!(
        table.texts("text").unwrap(),
        ["stiffness now 4 N/m, µ as before"]
    );
}

#[cfg(feature = "parquet")]
mod as_parquet {
    use palpate_record::recording::RecordingWriter;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    use super::super::common::append;
    use super::*;

    fn read(recording: &Recording) -> SerializedFileReader<bytes::Bytes> {
        let mut written = Vec::new();
        recording.write_parquet(&mut written).unwrap();
        SerializedFileReader::new(bytes::Bytes::from(written)).unwrap()
    }

    #[test]
    fn it_is_the_same_table() {
        let scratch = Scratch::new();
        let recording = recording(&scratch);
        let mut csv = Vec::new();
        recording.write_csv(&mut csv).unwrap();
        let table = run::read(csv.as_slice(), "r.csv").unwrap();
        let file = read(&recording);
        let metadata = file.metadata().file_metadata();
        let schema = metadata.schema_descr();
        let names: Vec<&str> = schema
            .columns()
            .iter()
            .map(|column| column.name())
            .collect();
        assert_eq!(names, table.columns());
        let said = metadata.key_value_metadata().unwrap();
        assert!(
            said.iter()
                .any(|entry| entry.key == "ticks_lost" && entry.value.as_deref() == Some("3"))
        );
        let rows: Vec<_> = file
            .get_row_iter(None)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(rows.len(), 6);
        for (at, name) in names.iter().enumerate() {
            for (row, cells) in rows.iter().enumerate() {
                match *name {
                    "sequence" | "generation" => {
                        let number = cells.get_long(at).unwrap() as f64;
                        assert_eq!(number, table.numbers(name).unwrap()[row]);
                    }
                    "flags" | "phase" => {
                        assert_eq!(
                            cells.get_string(at).unwrap(),
                            &table.texts(name).unwrap()[row]
                        );
                    }
                    _ => {
                        let (a, b) = (
                            cells.get_double(at).unwrap(),
                            table.numbers(name).unwrap()[row],
                        );
                        assert!(
                            a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
                            "{name}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_long_recording_is_written_in_groups() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long.mcap");
        let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
        for sequence in 0..70_000 {
            append(&mut writer, sequence).unwrap();
        }
        writer.finish().unwrap();
        let file = read(&Recording::open(&path).unwrap());
        assert_eq!(file.metadata().num_row_groups(), 2);
        let last = file.get_row_iter(None).unwrap().last().unwrap().unwrap();
        assert_eq!(last.get_long(0).unwrap(), 69_999);
    }
}

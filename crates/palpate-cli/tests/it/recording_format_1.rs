//! A recording of format 1, written by the program before format 2: `palpate record experiment1.toml format-1.mcap
//! --duration 1.5 --fast`, and the output of `palpate convert`.

use crate::common::{Folder, parse};
use palpate_record::recording::{Entry, Recording, RecordingWriter};

const RECORDING: &[u8] = include_bytes!("recordings/format-1.mcap");
const TABLE: &str = include_str!("recordings/format-1.csv");

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("format-1.mcap", RECORDING);
    folder
}

#[test]
fn its_table_is_what_it_was_byte_for_byte() {
    let folder = folder();
    folder.succeed("convert format-1.mcap");
    assert!(folder.read("format-1.csv") == TABLE);
    let info = parse(&folder.succeed("info format-1.mcap --json"));
    assert_eq!(
        (&info["complete"], &info["ticks"]),
        (&true.into(), &75.into())
    );
}

/// Rewritten in format 2, the columns of format 1 have the same values, in the same order.
#[test]
fn what_it_holds_has_the_same_table_and_the_same_replay_in_format_2() {
    let folder = folder();
    let before = Recording::open(&folder.path("format-1.mcap")).unwrap();
    let metadata = &before.metadata;
    let mut writer = RecordingWriter::create(&folder.path("format-2.mcap"), metadata).unwrap();
    for entry in before.entries().unwrap() {
        match entry.unwrap() {
            Entry::Tick(tick, contacts, _, _) => writer.append(&tick, &contacts).unwrap(),
            Entry::Event(event) => writer.event(&event).unwrap(),
        }
    }
    writer.count(before.counted.as_ref().unwrap()).unwrap();
    writer.finish().unwrap();
    let after = Recording::open(&folder.path("format-2.mcap")).unwrap();
    assert_eq!((before.format, after.format), (1, 2));
    folder.succeed("convert format-2.mcap");
    let now = folder.read("format-2.csv");
    let lines = |text: &str| -> Vec<Vec<String>> {
        let cells = |line: &str| line.split(',').take(25).map(str::to_owned).collect();
        text.lines().map(cells).collect()
    };
    let (before, now) = (lines(TABLE), lines(&now));
    assert_eq!(before[0].last().unwrap(), "phase");
    assert_eq!((before.len(), now.len()), (76, 76));
    for (before, now) in before.iter().zip(&now) {
        assert_eq!(before, now);
    }
    let replay = |name: &str| {
        let replayed = folder.succeed(&format!("replay {name}.mcap --json"));
        replayed.replace(name, "NAME")
    };
    assert_eq!(replay("format-1"), replay("format-2"));
}

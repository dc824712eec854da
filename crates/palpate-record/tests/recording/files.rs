//! File names of a recording, and existing files.

use std::fs;

use palpate_record::recording::{Recording, RecordingWriter};

use super::common::{append, metadata, names};

#[test]
fn a_recording_gets_its_name_when_it_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    append(&mut writer, 0).unwrap();
    writer.flush().unwrap();
    assert_eq!(names(folder.path()), ["tap.mcap.part"]);
    writer.finish().unwrap();
    assert_eq!(names(folder.path()), ["tap.mcap"]);
}

#[test]
fn a_writer_can_go_to_a_thread_of_its_own() {
    fn moves<T: Send + 'static>() {}
    moves::<RecordingWriter>();
}

#[test]
fn a_recording_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    fs::write(&path, "the first").unwrap();
    let error = RecordingWriter::create(&path, &metadata()).err().unwrap();
    assert_eq!(
        error.to_string(),
        format!(
            "cannot write `{}`: there is a file of that name; a recording overwrites no file, so \
             name another or move it away",
            path.display()
        )
    );
    assert_eq!(fs::read(&path).unwrap(), b"the first");
    assert_eq!(names(folder.path()), ["tap.mcap"]);
}

#[cfg(unix)]
#[test]
fn what_can_be_no_recording_is_named_for_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().display().to_string();
    let no_file = "it is not a regular file; a recording is a file in a folder and grows there under \
                   its name with `.part` appended";
    for (path, words) in [
        ("/dev/full".to_owned(), no_file),
        ("/dev/null".to_owned(), no_file),
        (inside.clone(), "it is a directory"),
        (format!("{inside}/"), "it is a directory"),
        (format!("{inside}/new/"), "it is a directory"),
        (String::new(), "the path names no file"),
        (format!("{inside}/new/.."), "the path names no file"),
    ] {
        let error = RecordingWriter::create(path.as_ref(), &metadata()).err();
        assert_eq!(
            error.unwrap().to_string(),
            format!("cannot write `{path}`: {words}")
        );
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn neither_does_it_overwrite_what_was_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    append(&mut writer, 0).unwrap();
    drop(writer);
    let error = RecordingWriter::create(&path, &metadata()).err().unwrap();
    assert!(
        error
            .to_string()
            .contains("tap.mcap.part` is an unfinished recording"),
        "{error}"
    );
    let part = folder.path().join("tap.mcap.part");
    assert_eq!(Recording::open(&part).unwrap().ticks, 1);
}

#[test]
fn a_file_that_has_appeared_since_is_kept_and_so_is_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    append(&mut writer, 0).unwrap();
    fs::write(&path, "another's").unwrap();
    let error = writer.finish().unwrap_err().to_string();
    assert!(
        error.contains("a file of that name has appeared"),
        "{error}"
    );
    assert_eq!(fs::read(&path).unwrap(), b"another's");
    let part = folder.path().join("tap.mcap.part");
    assert!(Recording::open(&part).unwrap().is_whole());
}

#[test]
fn what_cannot_be_begun_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let named = metadata().with("checksum", "mine");
    let error = RecordingWriter::create(&path, &named).err().unwrap();
    assert!(error.to_string().contains("an entry `checksum`"), "{error}");
    assert!(names(folder.path()).is_empty());
    let nowhere = folder.path().join("nowhere/tap.mcap");
    let error = RecordingWriter::create(&nowhere, &metadata())
        .err()
        .unwrap();
    assert!(
        error.to_string().contains("there is no directory"),
        "{error}"
    );
}

/// A limit on the size of files emulates a full disk: it needs no permission, and the write fails in the system.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_is_reported_and_what_was_flushed_is_readable() {
    use std::process::Command;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tap.mcap");
    let program = std::env::current_exe().unwrap();
    let output = Command::new("sh")
        // Without the trap the system ends the program; 96 blocks of 512 bytes.
        .args(["-c", "trap '' XFSZ; ulimit -f 96; exec \"$0\" \"$@\""])
        .arg(program)
        .args([
            "--exact",
            "files::fill_the_disk",
            "--ignored",
            "--nocapture",
        ])
        .env("PALPATE_RECORDING", &path)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{said}");
    let flushed: u64 = said
        .lines()
        .filter_map(|line| line.strip_prefix("flushed "))
        .map(|count| count.parse().unwrap())
        .next_back()
        .unwrap();
    assert!(flushed >= 50, "{flushed}");
    assert!(said.contains("cannot write `"), "{said}");
    let recording = Recording::open(&folder.path().join("tap.mcap.part")).unwrap();
    assert!(
        recording.ticks >= flushed,
        "{} of {flushed}",
        recording.ticks
    );
    assert!(!recording.finished && recording.lost() == 0);
    assert!(!path.exists());
}

/// Not a separate test: the program that the test above runs.
#[test]
#[ignore = "run by a_disk_that_fills_up_is_reported_and_what_was_flushed_is_readable"]
fn fill_the_disk() {
    let path = std::env::var_os("PALPATE_RECORDING").expect("run by its test");
    let mut writer = RecordingWriter::create(path.as_ref(), &metadata()).unwrap();
    for sequence in 0..100_000 {
        let outcome = append(&mut writer, sequence).and_then(|()| {
            if sequence % 7 == 6 {
                writer.flush()?;
                say(&format!("flushed {}", sequence + 1));
            }
            Ok(())
        });
        if let Err(error) = outcome {
            say(&error.to_string());
            // Further writes fail without a panic.
            assert!(append(&mut writer, sequence + 1).is_err() || writer.flush().is_err());
            assert!(writer.finish().is_err());
            return;
        }
    }
    panic!("the disk did not fill up");
}

/// Prints a line and flushes it.
pub fn say(line: &str) {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}").and_then(|()| out.flush()).unwrap();
}

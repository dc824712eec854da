//! A journal of work in progress, whose lines survive a crash of the program.
//!
//! Each line carries a checksum, so an incomplete last line is detected after a crash of the program or the machine.
//! A result file is not a journal: it appears complete, by [`atomic::write`](crate::files::atomic::write), and its
//! journal is then removed.
//!
//! One program at a time uses a journal. It locks the journal from opening until the program ends, and writes a line
//! that identifies it. Complete lines are never overwritten.

use std::fs::{self, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::files::atomic::WriteError;
use crate::files::bounded::JOURNAL;
use crate::files::checksum::Checksum;
pub use crate::files::lock::Holder;
use crate::files::lock::{Locked, UnlockOnDrop, is_at, try_lock};

/// Maximum time between synchronisations to disk while lines are appended.
const SYNC_EVERY: Duration = Duration::from_secs(2);

/// Prefix of a line that identifies the holder of the journal.
const HOLDER: &str = "#";

/// Interval and maximum number of attempts to read the holder of a locked journal: a program that has just locked it
/// has not yet written its line.
const LOOK_EVERY: Duration = Duration::from_millis(20);
const LOOKS: usize = 50;

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: UnlockOnDrop,
    synced: Instant,
    /// Whether the journal has a first line; without one, its subject is undefined.
    begun: bool,
}

/// An opened journal and the content left by earlier programs.
#[derive(Debug)]
pub struct Found {
    /// First line: the subject of the journal. `None` for a new journal, or if the line is incomplete;
    /// [`Journal::begin`] then writes one.
    pub head: Option<String>,
    /// The lines after it, in the order of writing.
    pub lines: Vec<String>,
    /// The journal, ready for appending. An incomplete last line has been removed.
    pub journal: Journal,
    /// Error of a file system without locks, as on some network disks: another program can then open the same
    /// journal.
    pub unlocked: Option<io::Error>,
}

/// Reason why a journal cannot be continued.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The system cannot read or write the journal.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Another program holds the journal.
    #[error(
        "`{}` is held by {}",
        path.display(),
        holder.as_ref().map_or("another process".to_owned(), Holder::to_string)
    )]
    Held {
        /// The journal.
        path: PathBuf,
        /// The holder, if it has identified itself.
        holder: Option<Holder>,
    },
    /// A line has a wrong checksum, and other lines follow it.
    #[error(
        "`{}`, line {line}: damaged; delete the file and start again",
        path.display()
    )]
    Damaged {
        /// The journal.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
    },
}

/// The complete lines of a journal.
struct Lines {
    texts: Vec<String>,
    /// Length of all of them `[bytes]`.
    length: usize,
}

impl Journal {
    /// Opens the journal at `path` with exclusive access and returns the content left by earlier programs. A missing
    /// journal is created. A journal that is dropped before [`begin`](Self::begin) is removed.
    ///
    /// # Errors
    /// Another program holds it; an error of the system; a damaged line that is not the last one. The journal is then
    /// unchanged.
    pub fn open(path: &Path) -> Result<Found, JournalError> {
        let failed = |source| JournalError::from(WriteError::new(path, source));
        let (mut file, unlocked) = lock(path)?;
        let mut bytes = Vec::new();
        JOURNAL
            .reader(&mut file.0)
            .read_to_end(&mut bytes)
            .map_err(failed)?;
        let lines = whole_lines(&bytes).map_err(|line| JournalError::Damaged {
            path: path.to_owned(),
            line,
        })?;
        let mut texts = lines.texts;
        texts.retain(|text| !text.starts_with(HOLDER));
        let mut journal = Self {
            path: path.to_owned(),
            file,
            synced: Instant::now(),
            begun: !texts.is_empty(),
        };
        if lines.length < bytes.len() {
            // Remove the incomplete last line.
            journal
                .file
                .0
                .set_len(lines.length as u64)
                .map_err(failed)?;
        }
        journal.append(&format!("{HOLDER}{}", Holder::this()))?;
        let mut texts = texts.into_iter();
        Ok(Found {
            head: texts.next(),
            lines: texts.collect(),
            journal,
            unlocked,
        })
    }

    /// Writes the first line, the subject of the journal. The journal must not have one.
    ///
    /// # Errors
    /// An error of the system.
    pub fn begin(&mut self, head: &str) -> Result<(), JournalError> {
        debug_assert!(!self.begun, "it has a first line");
        self.append(head)?;
        self.begun = true;
        Ok(())
    }

    /// Appends a line, which must not contain a line end or begin with `#`. On return the system holds the line, so
    /// it survives a crash of the program.
    ///
    /// # Errors
    /// An error of the system, such as a full disk.
    pub fn append(&mut self, line: &str) -> Result<(), JournalError> {
        debug_assert!(!line.contains('\n'), "one line");
        let written = format!("{line}\t{}\n", Checksum::of(line));
        let outcome = self.file.0.write_all(written.as_bytes()).and_then(|()| {
            if self.synced.elapsed() < SYNC_EVERY {
                return Ok(());
            }
            self.synced = Instant::now();
            self.file.0.sync_data()
        });
        outcome.map_err(|source| WriteError::new(&self.path, source).into())
    }

    /// Removes the journal because its result is complete.
    ///
    /// # Errors
    /// An error of the system, with the path.
    pub fn remove(mut self) -> Result<(), JournalError> {
        // Prevents `drop` from removing it a second time.
        self.begun = true;
        fs::remove_file(&self.path).map_err(|source| WriteError::new(&self.path, source).into())
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        if !self.begun {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Opens and locks the journal at `path`. Also returns the error of a system without locks.
fn lock(path: &Path) -> Result<(UnlockOnDrop, Option<io::Error>), JournalError> {
    let failed = |source| JournalError::from(WriteError::new(path, source));
    for _ in 0..LOOKS {
        let mut options = OpenOptions::new();
        options.read(true).append(true).create(true);
        let file = options.open(path).map_err(failed)?;
        if !file.metadata().map_err(failed)?.is_file() {
            return Err(failed(io::Error::other("it is not a regular file")));
        }
        match try_lock(&file).map_err(failed)? {
            // Its holder may have removed the file between opening and locking. Another file, or none, is then at the
            // path.
            Locked::Held if is_at(&file, path).map_err(failed)? => {
                return Ok((UnlockOnDrop(file), None));
            }
            Locked::Held => continue,
            Locked::Unsupported(why) => return Ok((UnlockOnDrop(file), Some(why))),
            Locked::ByAnother => {
                let holder = last_holder(path).map_err(failed)?;
                if holder.as_ref().is_some_and(Holder::may_run) {
                    let path = path.to_owned();
                    return Err(JournalError::Held { path, holder });
                }
            }
        }
        std::thread::sleep(LOOK_EVERY);
    }
    Err(JournalError::Held {
        path: path.to_owned(),
        holder: None,
    })
}

/// Returns the program that last opened the journal at `path`, if it has identified itself.
fn last_holder(path: &Path) -> io::Result<Option<Holder>> {
    let bytes = match JOURNAL.bytes(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    let lines = bytes.split(|byte| *byte == b'\n').rev();
    Ok(lines
        .filter_map(verified)
        .find_map(|line| Holder::parse(line.strip_prefix(HOLDER)?)))
}

/// Returns the complete lines of a journal without an incomplete last line, or the number, from 1, of a damaged line.
fn whole_lines(bytes: &[u8]) -> Result<Lines, usize> {
    let mut lines = Lines {
        texts: Vec::new(),
        length: 0,
    };
    let mut rest = bytes;
    while !rest.is_empty() {
        let end = rest.iter().position(|byte| *byte == b'\n');
        let line = end.and_then(|end| verified(&rest[..end]));
        let length = end.map_or(rest.len(), |end| end + 1);
        rest = &rest[length..];
        match line {
            Some(line) => {
                lines.length += length;
                lines.texts.push(line);
            }
            None if rest.is_empty() => break,
            None => return Err(lines.texts.len() + 1),
        }
    }
    Ok(lines)
}

/// Returns the text of a line whose checksum is correct.
fn verified(line: &[u8]) -> Option<String> {
    let (text, checksum) = std::str::from_utf8(line).ok()?.rsplit_once('\t')?;
    (Checksum::of(text) == checksum).then(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    fn written() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.journal");
        let mut journal = Journal::open(&path).unwrap().journal;
        journal.begin("a map").unwrap();
        for line in ["one", "two", "three"] {
            journal.append(line).unwrap();
        }
        let bytes = fs::read(&path).unwrap();
        (folder, path, bytes)
    }

    #[test]
    fn what_was_written_is_found_and_gone_on_with() {
        let (_folder, path, _) = written();
        let mut found = Journal::open(&path).unwrap();
        assert_eq!(found.head.as_deref(), Some("a map"));
        assert_eq!(found.lines, ["one", "two", "three"]);
        found.journal.append("four").unwrap();
        drop(found);
        let again = Journal::open(&path).unwrap();
        assert_eq!(again.lines.len(), 4);
        again.journal.remove().unwrap();
        assert!(Journal::open(&path).unwrap().head.is_none());
        assert!(!path.exists(), "a journal of nothing stays");
    }

    #[test]
    fn wherever_the_end_is_torn_the_whole_lines_before_it_are_kept() {
        let (_folder, path, bytes) = written();
        let ends: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i] == b'\n').collect();
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            // The first line identifies the writer, the second the subject.
            let whole = ends.iter().filter(|end| **end < length).count();
            let mut found = Journal::open(&path).unwrap();
            if found.head.is_none() {
                assert!(whole < 2, "{length}");
                continue;
            }
            assert_eq!(found.lines.len() + 2, whole, "{length}");
            found.journal.append("more").unwrap();
            drop(found);
            let again = Journal::open(&path).unwrap();
            assert_eq!(again.lines.last().unwrap(), "more");
            assert_eq!(again.lines.len() + 1, whole);
        }
    }

    #[test]
    fn a_line_torn_in_the_middle_is_named_and_nothing_is_changed() {
        let (_folder, path, mut bytes) = written();
        let at = bytes.windows(3).position(|three| three == b"two").unwrap();
        bytes[at] = b'x';
        fs::write(&path, &bytes).unwrap();
        let error = Journal::open(&path).unwrap_err().to_string();
        assert!(error.contains("line 4: damaged"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }

    #[cfg(unix)]
    #[test]
    fn second_open_of_journal_names_holder_and_changes_nothing() {
        let (_folder, path, _) = written();
        let mut found = Journal::open(&path).unwrap();
        // An incomplete line that the first program is writing.
        found.journal.file.0.write_all(b"fou").unwrap();
        let before = fs::read(&path).unwrap();
        let error = Journal::open(&path).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("`{}` is held by {}", path.display(), Holder::this())
        );
        assert_eq!(fs::read(&path).unwrap(), before);
        // A copy of the descriptor, as a child has one until it executes its program.
        let copy = found.journal.file.0.try_clone().unwrap();
        drop(found);
        assert_eq!(Journal::open(&path).unwrap().lines.len(), 3);
        drop(copy);
    }

    #[cfg(unix)]
    #[test]
    fn a_second_opener_waits_for_nobody_whose_name_is_old() {
        let (_folder, path, bytes) = written();
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let ended = Holder {
            process: child.id(),
            ..Holder::this()
        };
        child.wait().unwrap();
        // The lock is held by a program that has not identified itself; the last identified holder has ended.
        let text = String::from_utf8(bytes).unwrap();
        let line = format!("{HOLDER}{ended}");
        let line = format!("{line}\t{}\n", Checksum::of(&line));
        fs::write(&path, text + &line).unwrap();
        let silent = File::open(&path).unwrap();
        assert!(matches!(try_lock(&silent).unwrap(), Locked::Held));
        let error = Journal::open(&path).unwrap_err().to_string();
        assert!(error.ends_with("is held by another process"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_keeps_no_journal() {
        let error = Journal::open(Path::new("/dev/null")).unwrap_err();
        assert!(error.to_string().contains("not a regular file"), "{error}");
    }
}

//! A journal of work in progress: lines that are kept whatever happens to the program.
//!
//! Each line carries a checksum, so what was being written when the program or the machine went
//! down is told from what was written. A journal is not a result: a result appears whole, by
//! [`atomic::write`](crate::atomic::write), and its journal is then removed.
//!
//! One program at a time has a journal: it holds a lock on it from opening it until it ends, and
//! leaves a line that says who it is. Nothing that was written whole is ever written over.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::atomic::WriteError;
use crate::bounded::JOURNAL;
use crate::checksum::Checksum;
pub use crate::lock::Holder;
use crate::lock::{Locked, is_at, try_lock};

/// Lines reach the disk itself at least this often while they come.
const SYNC_EVERY: Duration = Duration::from_secs(2);

/// What a line begins with that says who has the journal.
const HOLDER: &str = "#";

/// How often, and how often at most, a journal that is held is looked at for its holder: a program
/// that has just locked it has its name still to write.
const LOOK_EVERY: Duration = Duration::from_millis(20);
const LOOKS: usize = 50;

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    synced: Instant,
    /// Whether it has a first line; a journal without one is of nothing.
    begun: bool,
}

/// A journal that was opened, and what earlier programs left in it.
#[derive(Debug)]
pub struct Found {
    /// Its first line: what it is a journal of. None if it was not there, or was torn before that
    /// line was complete; [`Journal::begin`] then writes one.
    pub head: Option<String>,
    /// The lines after it, in the order they were written.
    pub lines: Vec<String>,
    /// The journal, ready for more. What was torn at its end is gone.
    pub journal: Journal,
    /// What the system said where it has no locks, as on some network disks: nothing keeps another
    /// program from the same journal.
    pub unlocked: Option<io::Error>,
}

/// Why a journal cannot be gone on with.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The system does not let it be read or written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Another program has it.
    #[error(
        "`{}` is held by {}",
        path.display(),
        holder.as_ref().map_or("another process".to_owned(), Holder::to_string)
    )]
    Held {
        /// The journal.
        path: PathBuf,
        /// Who has it, if it has said so.
        holder: Option<Holder>,
    },
    /// A line is not as it was written, and others follow it.
    #[error(
        "`{}`, line {line}: not what was written there; delete the file and begin anew",
        path.display()
    )]
    Damaged {
        /// The journal.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
    },
}

/// The whole lines of a journal.
struct Lines {
    texts: Vec<String>,
    /// Length of all of them `[bytes]`.
    length: usize,
}

impl Journal {
    /// Opens the journal at `path` for this program alone, with what earlier programs left in it; it
    /// is made if it is not there. A journal that is dropped before it is [begun](Self::begin) is
    /// removed.
    ///
    /// # Errors
    /// Another program has it; what the system says; a line in the middle that is not what was
    /// written. It is then as it was.
    pub fn open(path: &Path) -> Result<Found, JournalError> {
        let failed = |source| JournalError::from(WriteError::new(path, source));
        let (mut file, unlocked) = lock(path)?;
        let mut bytes = Vec::new();
        JOURNAL
            .reader(&mut file)
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
            // The last thing that was being written.
            journal.file.set_len(lines.length as u64).map_err(failed)?;
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

    /// Writes the first line of a journal that has none: what it is a journal of.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(&mut self, head: &str) -> Result<(), JournalError> {
        debug_assert!(!self.begun, "it has a first line");
        self.append(head)?;
        self.begun = true;
        Ok(())
    }

    /// Adds a line, which must not hold a line end nor begin with `#`. It is with the system when
    /// this returns, and so outlives the program.
    ///
    /// # Errors
    /// What the system says: a full disk, above all.
    pub fn append(&mut self, line: &str) -> Result<(), JournalError> {
        debug_assert!(!line.contains('\n'), "one line");
        let written = format!("{line}\t{}\n", Checksum::of(line));
        let outcome = self.file.write_all(written.as_bytes()).and_then(|()| {
            if self.synced.elapsed() < SYNC_EVERY {
                return Ok(());
            }
            self.synced = Instant::now();
            self.file.sync_data()
        });
        outcome.map_err(|source| WriteError::new(&self.path, source).into())
    }

    /// Removes the journal: its result is complete.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn remove(mut self) -> Result<(), JournalError> {
        // Else it would be tried again.
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

/// Opens the journal at `path` and locks it; what the system said where it cannot be locked.
fn lock(path: &Path) -> Result<(File, Option<io::Error>), JournalError> {
    let failed = |source| JournalError::from(WriteError::new(path, source));
    for _ in 0..LOOKS {
        let mut options = OpenOptions::new();
        options.read(true).append(true).create(true);
        let file = options.open(path).map_err(failed)?;
        if !file.metadata().map_err(failed)?.is_file() {
            return Err(failed(io::Error::other("it is not a regular file")));
        }
        match try_lock(&file).map_err(failed)? {
            // Its holder may have removed it between the two: then there is another, or none.
            Locked::Held if is_at(&file, path).map_err(failed)? => return Ok((file, None)),
            Locked::Held => continue,
            Locked::Unsupported(why) => return Ok((file, Some(why))),
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

/// Who last opened the journal at `path`, as far as it says.
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

/// The lines of a journal, without what was torn at its end; or the number, from 1, of one that is
/// not what was written.
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

/// The text of a line whose checksum is right.
fn verified(line: &[u8]) -> Option<String> {
    let (text, checksum) = std::str::from_utf8(line).ok()?.rsplit_once('\t')?;
    (Checksum::of(text) == checksum).then(|| text.to_owned())
}

#[cfg(test)]
mod tests {
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
            // The first says who wrote it, the second what it is a journal of.
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
        assert!(error.contains("line 4: not what was written"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }

    #[cfg(unix)]
    #[test]
    fn a_second_opener_is_told_who_has_it_and_changes_nothing() {
        let (_folder, path, _) = written();
        let mut found = Journal::open(&path).unwrap();
        // Half of what the first has just begun to write.
        found.journal.file.write_all(b"fou").unwrap();
        let before = fs::read(&path).unwrap();
        let error = Journal::open(&path).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("`{}` is held by {}", path.display(), Holder::this())
        );
        assert_eq!(fs::read(&path).unwrap(), before);
        drop(found);
        assert_eq!(Journal::open(&path).unwrap().lines.len(), 3);
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
        // Locked by somebody who has not said so; the last who has is no more.
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

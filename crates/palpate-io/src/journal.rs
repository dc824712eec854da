//! A journal of work in progress: lines that are kept whatever happens to the program.
//!
//! Each line carries a checksum, so what was being written when the program or the machine went
//! down is told from what was written. A journal is not a result: a result appears whole, by
//! [`atomic::write`](crate::atomic::write), and its journal is then removed.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::atomic::WriteError;
use crate::checksum::Checksum;

/// Lines reach the disk itself at least this often while they come.
const SYNC_EVERY: Duration = Duration::from_secs(2);

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    synced: Instant,
}

/// What an earlier program left.
#[derive(Debug)]
pub struct Found {
    /// Its first line: what it is a journal of.
    pub head: String,
    /// The lines after it, in the order they were written.
    pub lines: Vec<String>,
    /// The journal, ready for more. What was torn at its end is gone.
    pub journal: Journal,
}

/// Why a journal cannot be gone on with.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The system does not let it be read or written.
    #[error(transparent)]
    Write(#[from] WriteError),
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

impl Journal {
    /// Begins a journal, in place of what was there.
    ///
    /// # Errors
    /// What the system says, with the path.
    pub fn create(path: &Path, head: &str) -> Result<Self, JournalError> {
        let file = File::create(path).map_err(|source| WriteError::new(path, source))?;
        let mut journal = Self {
            path: path.to_owned(),
            file,
            synced: Instant::now(),
        };
        journal.append(head)?;
        Ok(journal)
    }

    /// Opens what an earlier program left at `path`; `None` if nothing is there, or it was torn
    /// before its first line was complete.
    ///
    /// # Errors
    /// What the system says, or a line in the middle that is not what was written.
    pub fn open(path: &Path) -> Result<Option<Found>, JournalError> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(WriteError::new(path, source).into()),
        };
        let mut lines = Vec::new();
        let mut whole = 0;
        let mut rest = bytes.as_slice();
        let mut number = 0;
        while !rest.is_empty() {
            number += 1;
            let end = rest.iter().position(|byte| *byte == b'\n');
            let line = end.and_then(|end| verified(&rest[..end]));
            let length = end.map_or(rest.len(), |end| end + 1);
            rest = &rest[length..];
            match line {
                Some(line) => {
                    whole += length;
                    lines.push(line);
                }
                // The last thing that was being written.
                None if rest.is_empty() => break,
                None => {
                    return Err(JournalError::Damaged {
                        path: path.to_owned(),
                        line: number,
                    });
                }
            }
        }
        if lines.is_empty() {
            return Ok(None);
        }
        let append = || -> io::Result<File> {
            let file = OpenOptions::new().append(true).open(path)?;
            file.set_len(whole as u64)?;
            Ok(file)
        };
        let file = append().map_err(|source| WriteError::new(path, source))?;
        let head = lines.remove(0);
        Ok(Some(Found {
            head,
            lines,
            journal: Self {
                path: path.to_owned(),
                file,
                synced: Instant::now(),
            },
        }))
    }

    /// Adds a line, which must not hold a line end. It is with the system when this returns, and so
    /// outlives the program.
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
    pub fn remove(self) -> Result<(), JournalError> {
        fs::remove_file(&self.path).map_err(|source| WriteError::new(&self.path, source).into())
    }
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
        let mut journal = Journal::create(&path, "a map").unwrap();
        for line in ["one", "two", "three"] {
            journal.append(line).unwrap();
        }
        let bytes = fs::read(&path).unwrap();
        (folder, path, bytes)
    }

    #[test]
    fn what_was_written_is_found_and_gone_on_with() {
        let (_folder, path, _) = written();
        let mut found = Journal::open(&path).unwrap().unwrap();
        assert_eq!(found.head, "a map");
        assert_eq!(found.lines, ["one", "two", "three"]);
        found.journal.append("four").unwrap();
        let again = Journal::open(&path).unwrap().unwrap();
        assert_eq!(again.lines.len(), 4);
        again.journal.remove().unwrap();
        assert!(Journal::open(&path).unwrap().is_none());
    }

    #[test]
    fn wherever_the_end_is_torn_the_whole_lines_before_it_are_kept() {
        let (_folder, path, bytes) = written();
        let ends: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i] == b'\n').collect();
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            let whole = ends.iter().filter(|end| **end < length).count();
            match Journal::open(&path).unwrap() {
                None => assert_eq!(whole, 0, "{length}"),
                Some(mut found) => {
                    assert_eq!(found.lines.len() + 1, whole, "{length}");
                    found.journal.append("more").unwrap();
                    let again = Journal::open(&path).unwrap().unwrap();
                    assert_eq!(again.lines.last().unwrap(), "more");
                    assert_eq!(again.lines.len(), whole);
                }
            }
        }
    }

    #[test]
    fn a_line_torn_in_the_middle_is_named() {
        let (_folder, path, mut bytes) = written();
        let at = bytes.windows(3).position(|three| three == b"two").unwrap();
        bytes[at] = b'x';
        fs::write(&path, &bytes).unwrap();
        let error = Journal::open(&path).unwrap_err().to_string();
        assert!(error.contains("line 3: not what was written"), "{error}");
    }

    #[test]
    fn a_full_disk_is_reported() {
        let full = Path::new("/dev/full");
        if full.exists() {
            let error = Journal::create(full, "a map").unwrap_err().to_string();
            assert_eq!(
                error,
                "cannot write `/dev/full`: no space left on the device"
            );
        }
    }
}

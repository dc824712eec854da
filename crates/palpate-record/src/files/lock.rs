//! Exclusive access of a program to a file, and identification of the holder.
//!
//! The lock belongs to the system, which releases it when the holder ends for any reason.

use std::fmt;
use std::fs::File;
use std::io;

/// Result of a lock request.
#[derive(Debug)]
#[cfg_attr(not(unix), expect(dead_code, reason = "requested on Unix only"))]
pub(crate) enum Locked {
    /// The lock is held until it is released ([`UnlockOnDrop`]) or the program ends.
    Held,
    /// Another open file holds the lock.
    ByAnother,
    /// The file system has no locks.
    Unsupported(io::Error),
}

/// The program that holds a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Process id.
    pub process: u32,
    /// Name of its machine.
    pub machine: String,
}

impl Holder {
    /// Identifies this program.
    pub(crate) fn this() -> Self {
        Self {
            process: std::process::id(),
            machine: machine(),
        }
    }

    /// Returns whether the program may still run. The state of a process on another machine is unknown.
    pub(crate) fn may_run(&self) -> bool {
        self.machine != machine() || is_running(self.process)
    }

    /// Parses the output of [`Display`](fmt::Display).
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (process, machine) = text.strip_prefix("process ")?.split_once(" on ")?;
        Some(Self {
            process: process.parse().ok()?,
            machine: machine.to_owned(),
        })
    }
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {} on {}", self.process, self.machine)
    }
}

/// A file that is unlocked when it is dropped, also while a process that is about to start still shares it.
///
/// Closing the file does not release the lock then: a child has a copy of every descriptor until it executes its
/// program.
#[derive(Debug)]
pub(crate) struct UnlockOnDrop(pub(crate) File);

impl Drop for UnlockOnDrop {
    fn drop(&mut self) {
        #[cfg(unix)]
        let _ = rustix::fs::flock(&self.0, rustix::fs::FlockOperation::Unlock);
    }
}

/// Requests the lock of an open file without waiting.
#[cfg(unix)]
pub(crate) fn try_lock(file: &File) -> io::Result<Locked> {
    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;
    loop {
        return match flock(file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(Locked::Held),
            Err(Errno::INTR) => continue,
            Err(Errno::WOULDBLOCK) => Ok(Locked::ByAnother),
            // Some network file systems.
            Err(error @ (Errno::NOLCK | Errno::NOSYS | Errno::OPNOTSUPP)) => {
                Ok(Locked::Unsupported(error.into()))
            }
            Err(error) => Err(error.into()),
        };
    }
}

#[cfg(not(unix))]
pub(crate) fn try_lock(_: &File) -> io::Result<Locked> {
    Ok(Locked::Unsupported(io::ErrorKind::Unsupported.into()))
}

/// Returns whether `path` still denotes the opened file.
#[cfg(unix)]
pub(crate) fn is_at(file: &File, path: &std::path::Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let opened = file.metadata()?;
    match std::fs::metadata(path) {
        Ok(there) => Ok((there.dev(), there.ino()) == (opened.dev(), opened.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(not(unix))]
pub(crate) fn is_at(_: &File, _: &std::path::Path) -> io::Result<bool> {
    Ok(true)
}

#[cfg(unix)]
fn machine() -> String {
    rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned()
}

#[cfg(not(unix))]
fn machine() -> String {
    "this machine".to_owned()
}

#[cfg(unix)]
fn is_running(process: u32) -> bool {
    use rustix::io::Errno;
    use rustix::process::{Pid, test_kill_process};
    let id = i32::try_from(process).ok().and_then(Pid::from_raw);
    id.is_some_and(|id| !matches!(test_kill_process(id), Err(Errno::SRCH)))
}

#[cfg(not(unix))]
fn is_running(_: u32) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_holder_is_read_as_it_is_written() {
        let this = Holder::this();
        assert_eq!(Holder::parse(&this.to_string()), Some(this.clone()));
        assert!(this.may_run());
        for text in ["", "process", "process x on y", "process 1"] {
            assert_eq!(Holder::parse(text), None, "{text}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_in_place_of_one_that_was_removed_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.journal");
        let first = File::create(&path).unwrap();
        assert!(is_at(&first, &path).unwrap());
        std::fs::remove_file(&path).unwrap();
        assert!(!is_at(&first, &path).unwrap());
        File::create(&path).unwrap();
        assert!(!is_at(&first, &path).unwrap());
    }

    #[cfg(unix)]
    #[test]
    fn a_process_that_has_ended_does_not_run() {
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let ended = Holder {
            process: child.id(),
            ..Holder::this()
        };
        child.wait().unwrap();
        assert!(!ended.may_run());
    }
}

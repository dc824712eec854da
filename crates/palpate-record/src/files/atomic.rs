//! Atomic file output: a file appears complete or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Maximum number of symbolic links followed before the path is rejected as a cycle.
const MAX_LINKS: usize = 40;

/// Failure to write a file. A file that existed at the path is unchanged.
#[derive(Debug, Error)]
#[error("cannot write `{}`: {fault}", path.display())]
pub struct WriteError {
    /// The path the caller gave.
    pub path: PathBuf,
    /// Kind of the failure.
    pub fault: WriteFault,
    /// Error of the operating system.
    pub source: io::Error,
}

/// Kinds of write failures.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WriteFault {
    /// The file's directory does not exist.
    #[error("there is no directory `{}`", directory.display())]
    DirectoryMissing {
        /// The missing directory.
        directory: PathBuf,
    },
    /// The path is a directory.
    #[error("it is a directory")]
    IsDirectory,
    /// No permission to change the file or its directory.
    #[error("permission denied")]
    PermissionDenied,
    /// The disk or the quota is full.
    #[error("no space left on the device")]
    DiskFull,
    /// The file exists and must not be replaced.
    #[error("there is a file of that name")]
    Exists,
    /// Any other failure, with the message of the system.
    #[error("{0}")]
    Other(String),
}

/// Treatment of an existing file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// The file is kept, and the write fails.
    #[default]
    Keep,
    /// The new file replaces it.
    Replace,
}

/// Checks, before any work is done, that a file can be written at `path`.
///
/// The check writes a byte into a temporary file in the same directory and removes it. It opens non-regular files
/// except pipes, and writes nothing into them.
///
/// # Errors
///
/// Those of [`write`](fn@write): a missing or read-only directory, a full disk, a path that is a directory. With
/// [`Existing::Keep`] also an existing file.
pub fn check(path: &Path, existing: Existing) -> Result<(), WriteError> {
    check_target(path, existing).map_err(|source| WriteError::new(path, source))
}

/// Writes the file at `path` through `write`.
///
/// The bytes go to a temporary file in the same directory, are synchronised to disk, and the file is then renamed
/// atomically: a reader sees the old file or the new one, never a part. If any step fails, including `write`, the old
/// file is unchanged and the temporary file is removed.
///
/// A new file gets the default permissions of the process; a replaced file keeps its permissions. A symbolic link is
/// kept, and its target is replaced. Non-regular files (a pipe, a terminal, `/dev/null`) are written directly, and so
/// is the program's own output (`/dev/stdout`, `/dev/fd/1`), wherever it is redirected.
///
/// # Errors
///
/// [`WriteError`], which names the path.
pub fn write<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> Result<T, WriteError> {
    write_over(path, Existing::Replace, write)
}

/// Writes the file at `path` through `write`, as [`write`](fn@write) does; `existing` selects the treatment of an
/// existing regular file.
///
/// # Errors
///
/// [`WriteError`], which names the path. With [`Existing::Keep`], a file that appears while `write` runs is also
/// kept.
pub fn write_over<T>(
    path: &Path,
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> Result<T, WriteError> {
    let outcome = if is_stream(path) {
        open_stream(path).and_then(|file| buffered(&file, write))
    } else {
        put(path, existing, write)
    };
    outcome.map_err(|source| WriteError::new(path, source))
}

impl WriteError {
    /// Creates the error for a failed write at `path` from the error of the system.
    #[must_use]
    pub fn new(path: &Path, source: io::Error) -> Self {
        Self {
            path: path.to_owned(),
            fault: fault(path, &source),
            source,
        }
    }
}

/// Returns whether `path` accepts bytes but cannot be replaced: a pipe, a terminal, `/dev/null`, or the program's own
/// output.
#[must_use]
pub fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| is_inherited(path) || !(found.is_file() || found.is_dir()))
}

/// Returns whether `path` names a file descriptor inherited by this program. Redirected standard output is a regular
/// file, but it belongs to the shell and must not be replaced.
fn is_inherited(path: &Path) -> bool {
    let named = ["/dev/stdout", "/dev/stderr"].map(Path::new);
    if named.contains(&path) || path.parent() == Some(Path::new("/dev/fd")) {
        return true;
    }
    // Other paths below /proc, such as /proc/self/cwd, can lead to any file.
    let descriptors = path.parent().filter(|parent| parent.ends_with("fd"));
    path.starts_with("/proc") && descriptors.is_some_and(|parent| parent.components().count() == 4)
}

fn buffered<T>(file: &File, write: impl FnOnce(&mut dyn Write) -> io::Result<T>) -> io::Result<T> {
    let mut writer = BufWriter::new(file);
    let value = write(&mut writer)?;
    writer.flush()?;
    Ok(value)
}

/// Opens for appending, which preserves the content that a shell's `>>` keeps.
fn open_stream(path: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).open(path)
}

fn check_target(path: &Path, existing: Existing) -> io::Result<()> {
    if is_stream(path) {
        // Opening a pipe waits for its reader, and the reader would take the closing for the end of the data.
        if is_pipe(path) {
            return Ok(());
        }
        // A device that accepts no data fails even for zero bytes.
        return open_stream(path)?.write(&[]).map(|_| ());
    }
    let target = follow_links(path)?;
    permissions_of_old(&target, existing)?;
    // Write one byte: on a full disk an empty file can still be created.
    temporary_in(directory_of(&target))?
        .as_file_mut()
        .write_all(&[0])
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

/// Returns the permissions of the file at `target`, if it exists and may be replaced.
fn permissions_of_old(target: &Path, existing: Existing) -> io::Result<Option<fs::Permissions>> {
    if existing == Existing::Keep && fs::symlink_metadata(target).is_ok_and(|old| !old.is_dir()) {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    // A path that ends in a separator denotes a directory, even if it does not exist.
    if target
        .as_os_str()
        .to_string_lossy()
        .ends_with(std::path::is_separator)
    {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    match OpenOptions::new().write(true).open(target) {
        Ok(file) => Ok(Some(file.metadata()?.permissions())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

fn put<T>(
    path: &Path,
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> io::Result<T> {
    let target = follow_links(path)?;
    let old = permissions_of_old(&target, existing)?;
    let temporary = temporary_in(directory_of(&target))?;
    let value = buffered(temporary.as_file(), write)?;
    if let Some(permissions) = old {
        temporary.as_file().set_permissions(permissions)?;
    }
    temporary.as_file().sync_all()?;
    match existing {
        Existing::Replace => temporary.persist(&target)?,
        Existing::Keep => temporary.persist_noclobber(&target)?,
    };
    Ok(value)
}

fn temporary_in(directory: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".palpate-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The default mode of open(2) for a new file; the umask reduces it.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(directory)
}

pub(crate) fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Resolves all symbolic links; the target need not exist.
pub(crate) fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = directory_of(&target).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many levels of symbolic links"))
}

fn fault(path: &Path, error: &io::Error) -> WriteFault {
    let target = follow_links(path).unwrap_or_else(|_| path.to_owned());
    let directory = directory_of(&target);
    match error.kind() {
        io::ErrorKind::NotFound if !directory.exists() => WriteFault::DirectoryMissing {
            directory: directory.to_owned(),
        },
        io::ErrorKind::IsADirectory => WriteFault::IsDirectory,
        // An error with a message of its own is reported by that message.
        io::ErrorKind::AlreadyExists if error.get_ref().is_none() => WriteFault::Exists,
        io::ErrorKind::PermissionDenied => WriteFault::PermissionDenied,
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => WriteFault::DiskFull,
        _ => WriteFault::Other(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_new_file_holds_what_was_written() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.csv");
        let value = write(&path, |out| {
            out.write_all(b"whole")?;
            Ok(7)
        });
        assert_eq!(value.unwrap(), 7);
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(directory.path()), ["run.csv"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.csv");
        fs::write(&path, "old").unwrap();
        let error = write(&path, |out| {
            out.write_all(&[b'x'; 1 << 16])?;
            Err::<(), _>(io::Error::from(io::ErrorKind::StorageFull))
        })
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "cannot write `{}`: no space left on the device",
                path.display()
            )
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(directory.path()), ["run.csv"]);
    }

    #[test]
    fn a_panic_leaves_the_old_file_and_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.csv");
        fs::write(&path, "old").unwrap();
        let outcome = std::panic::catch_unwind(|| {
            write(&path, |_| -> io::Result<()> {
                panic!("the renderer fell over")
            })
        });
        assert!(outcome.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(directory.path()), ["run.csv"]);
    }

    #[test]
    fn a_file_that_is_to_be_kept_is_kept_before_and_after_the_work() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.csv");
        check(&path, Existing::Keep).unwrap();
        assert!(names(directory.path()).is_empty(), "a check leaves nothing");
        let error = write_over(&path, Existing::Keep, |out| {
            // Another program creates the file first.
            fs::write(&path, "theirs")?;
            out.write_all(b"ours")
        })
        .unwrap_err();
        assert_eq!(error.fault, WriteFault::Exists);
        let error = check(&path, Existing::Keep).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "cannot write `{}`: there is a file of that name",
                path.display()
            )
        );
        let mut called = false;
        let outcome = write_over(&path, Existing::Keep, |_| {
            called = true;
            Ok(())
        });
        assert!(outcome.is_err() && !called);
        assert_eq!(fs::read(&path).unwrap(), b"theirs");
        assert_eq!(names(directory.path()), ["run.csv"]);
        check(&path, Existing::Replace).unwrap();
        write_over(&path, Existing::Replace, |out| out.write_all(b"ours")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"ours");
    }

    #[test]
    fn a_check_finds_what_a_write_would() {
        let directory = tempfile::tempdir().unwrap();
        let fault = |path: PathBuf| check(&path, Existing::Replace).unwrap_err().fault;
        assert_eq!(fault(directory.path().into()), WriteFault::IsDirectory);
        let missing = directory.path().join("out");
        assert_eq!(fault(missing.join("")), WriteFault::IsDirectory);
        assert_eq!(
            fault(missing.join("run.csv")),
            WriteFault::DirectoryMissing { directory: missing }
        );
        let long = directory.path().join("n".repeat(300));
        assert!(matches!(fault(long), WriteFault::Other(_)));
    }

    #[test]
    fn an_error_of_the_writer_is_passed_on_in_its_own_words() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.csv");
        let error = write(&path, |_| {
            Err::<(), _>(io::Error::new(io::ErrorKind::NotFound, "no samples"))
        })
        .unwrap_err();
        assert_eq!(error.fault, WriteFault::Other("no samples".to_owned()));
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_missing_directory_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let missing = directory.path().join("out");
        let path = missing.join("run.csv");
        assert_eq!(
            write(&path, |_| Ok(())).unwrap_err().to_string(),
            format!(
                "cannot write `{}`: there is no directory `{}`",
                path.display(),
                missing.display()
            )
        );
    }

    #[test]
    fn a_directory_is_not_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let error = write(directory.path(), |_| Ok(())).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "cannot write `{}`: it is a directory",
                directory.path().display()
            )
        );
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{PermissionsExt, symlink};
        use std::process::Command;

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).unwrap().permissions().mode() & 0o7777
        }

        #[test]
        fn a_new_file_gets_the_permissions_of_any_new_file() {
            let directory = tempfile::tempdir().unwrap();
            let plain = directory.path().join("plain");
            File::create(&plain).unwrap();
            let ours = directory.path().join("ours");
            write(&ours, |_| Ok(())).unwrap();
            assert_eq!(mode(&ours), mode(&plain));
        }

        #[test]
        fn a_replaced_file_keeps_its_permissions() {
            let directory = tempfile::tempdir().unwrap();
            let path = directory.path().join("run.csv");
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
            write(&path, |out| out.write_all(b"new")).unwrap();
            assert_eq!(mode(&path), 0o640);
            assert_eq!(fs::read(&path).unwrap(), b"new");
        }

        #[test]
        fn a_link_stays_and_its_target_is_replaced() {
            let directory = tempfile::tempdir().unwrap();
            let data = directory.path().join("data");
            fs::create_dir(&data).unwrap();
            fs::write(data.join("run.csv"), "old").unwrap();
            let link = directory.path().join("latest.csv");
            symlink("data/run.csv", &link).unwrap();
            write(&link, |out| out.write_all(b"new")).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read(data.join("run.csv")).unwrap(), b"new");
            assert_eq!(names(&data), ["run.csv"]);
        }

        #[test]
        fn a_link_to_no_file_yet_makes_the_file() {
            let directory = tempfile::tempdir().unwrap();
            let link = directory.path().join("latest.csv");
            symlink("run.csv", &link).unwrap();
            write(&link, |out| out.write_all(b"new")).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read(directory.path().join("run.csv")).unwrap(), b"new");
        }

        #[test]
        fn links_in_a_ring_are_refused() {
            let directory = tempfile::tempdir().unwrap();
            let (a, b) = (directory.path().join("a"), directory.path().join("b"));
            symlink(&a, &b).unwrap();
            symlink(&b, &a).unwrap();
            let error = write(&a, |_| Ok(())).unwrap_err().to_string();
            assert!(
                error.ends_with("too many levels of symbolic links"),
                "{error}"
            );
        }

        #[test]
        fn a_directory_that_may_not_be_changed_is_refused() {
            let directory = tempfile::tempdir().unwrap();
            let closed = directory.path().join("closed");
            fs::create_dir(&closed).unwrap();
            fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
            if File::create(closed.join("probe")).is_ok() {
                return; // root may write anywhere
            }
            let path = closed.join("run.csv");
            let error = check(&path, Existing::Keep).unwrap_err();
            assert_eq!(error.fault, WriteFault::PermissionDenied);
            assert_eq!(
                write(&path, |_| Ok(())).unwrap_err().to_string(),
                format!("cannot write `{}`: permission denied", path.display())
            );
        }

        #[test]
        fn a_file_that_may_not_be_changed_is_not_replaced() {
            let directory = tempfile::tempdir().unwrap();
            let path = directory.path().join("run.csv");
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
            if OpenOptions::new().write(true).open(&path).is_ok() {
                return; // root may write anything
            }
            let error = write(&path, |out| out.write_all(b"new")).unwrap_err();
            assert_eq!(error.fault, WriteFault::PermissionDenied);
            assert_eq!(fs::read(&path).unwrap(), b"old");
        }

        #[test]
        fn what_is_no_file_is_written_through() {
            write(Path::new("/dev/null"), |out| out.write_all(b"gone")).unwrap();
            assert!(!fs::metadata("/dev/null").unwrap().is_file());
        }

        #[test]
        fn a_full_disk_is_reported() {
            let full = Path::new("/dev/full");
            if !full.exists() {
                return;
            }
            assert_eq!(
                write(full, |out| out.write_all(b"too much"))
                    .unwrap_err()
                    .to_string(),
                "cannot write `/dev/full`: no space left on the device"
            );
            let error = check(full, Existing::Keep).unwrap_err();
            assert_eq!(error.fault, WriteFault::DiskFull);
            check(Path::new("/dev/null"), Existing::Keep).unwrap();
        }

        #[test]
        fn a_pipe_is_written_through() {
            let directory = tempfile::tempdir().unwrap();
            let pipe = directory.path().join("pipe");
            match Command::new("mkfifo").arg(&pipe).status() {
                Ok(status) if status.success() => {}
                _ => return,
            }
            // Opening the pipe in the check would block forever.
            check(&pipe, Existing::Keep).unwrap();
            let reader = std::thread::spawn({
                let pipe = pipe.clone();
                move || fs::read(pipe).unwrap()
            });
            write(&pipe, |out| out.write_all(b"through")).unwrap();
            assert_eq!(reader.join().unwrap(), b"through");
            assert_eq!(names(directory.path()), ["pipe"]);
        }
    }
}

//! Reading of whole files up to a maximum length. A device file such as `/dev/zero` or a pipe may never end.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::files::inputs;

/// A kind of file and its maximum length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Kind of the file, for messages.
    kind: &'static str,
    /// Maximum length `[bytes]`.
    bytes: u64,
}

const MEBIBYTE: u64 = 1 << 20;

/// Scene files, lists of columns and other settings files.
pub const SCENE: Limit = Limit::new("a scene or a list of settings", 16 * MEBIBYTE);
/// Device files and calibration reports.
pub const DEVICE: Limit = Limit::new("a device file or a calibration", 64 * MEBIBYTE);
/// Triangle meshes.
pub const MESH: Limit = Limit::new("a mesh", 256 * MEBIBYTE);
/// Distance grids of meshes.
pub const DISTANCE_GRID: Limit = Limit::new("a distance grid", 64 * MEBIBYTE);
/// Tables: traces, runs, maps.
pub const TABLE: Limit = Limit::new("a table", 256 * MEBIBYTE);
/// Journals of work in progress.
pub const JOURNAL: Limit = Limit::new("a journal", 512 * MEBIBYTE);

impl Limit {
    /// Creates a limit of `bytes` `[bytes]` for files of a kind.
    #[must_use]
    pub const fn new(kind: &'static str, bytes: u64) -> Self {
        Self { kind, bytes }
    }

    /// Reads the whole file at `path`.
    ///
    /// # Errors
    /// The error of the system; a file longer than the limit, as [`io::ErrorKind::FileTooLarge`].
    pub fn bytes(self, path: &Path) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.reader(File::open(path)?).read_to_end(&mut bytes)?;
        inputs::note(path);
        Ok(bytes)
    }

    /// Reads the whole text file at `path`.
    ///
    /// # Errors
    /// Those of [`bytes`](Self::bytes); bytes that are not UTF-8, as [`io::ErrorKind::InvalidData`].
    pub fn text(self, path: &Path) -> io::Result<String> {
        let mut text = String::new();
        self.reader(File::open(path)?).read_to_string(&mut text)?;
        inputs::note(path);
        Ok(text)
    }

    /// Wraps `source`; reading beyond the limit fails with [`io::ErrorKind::FileTooLarge`].
    pub fn reader<R: Read>(self, source: R) -> Bounded<R> {
        Bounded {
            source,
            limit: self,
            rest: self.bytes,
        }
    }

    fn exceeded(self) -> io::Error {
        let Self { kind, bytes } = self;
        let length = if bytes.is_multiple_of(MEBIBYTE) {
            format!("{} MiB", bytes / MEBIBYTE)
        } else {
            format!("{bytes} bytes")
        };
        let words = format!("the file is longer than {length}, the limit for {kind}");
        io::Error::new(io::ErrorKind::FileTooLarge, words)
    }
}

/// A reader with a maximum length.
#[derive(Debug)]
pub struct Bounded<R> {
    source: R,
    limit: Limit,
    /// Remaining length `[bytes]`.
    rest: u64,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // Read one byte beyond the limit to detect a source that does not end there.
        let room = self.rest.saturating_add(1);
        let room = usize::try_from(room).map_or(buffer.len(), |room| room.min(buffer.len()));
        let length = self.source.read(&mut buffer[..room])?;
        match self.rest.checked_sub(length as u64) {
            Some(rest) => self.rest = rest,
            None => return Err(self.limit.exceeded()),
        }
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUR: Limit = Limit::new("a test", 4);

    fn read(source: &[u8]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        FOUR.reader(source).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    #[test]
    fn a_source_as_long_as_the_limit_is_read_and_a_longer_one_is_refused() {
        assert_eq!(read(b"abcd").unwrap(), b"abcd");
        let error = read(b"abcde").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(
            error.to_string().contains("4 bytes") && error.to_string().contains("a test"),
            "{error}"
        );
        // Reading into an empty buffer returns 0 without an error.
        assert_eq!(FOUR.reader(&b"abcde"[..]).read(&mut []).unwrap(), 0);
    }

    #[test]
    fn a_source_without_end_is_refused() {
        let mut bytes = Vec::new();
        let mut reader = Limit::new("a test", MEBIBYTE).reader(io::repeat(0));
        let error = reader.read_to_end(&mut bytes).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("1 MiB"), "{error}");
        assert!(bytes.len() as u64 <= MEBIBYTE + 1);
    }
}

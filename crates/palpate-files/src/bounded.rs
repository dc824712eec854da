//! Files that are read whole, up to a stated length: a device file such as `/dev/zero` and a pipe may never end.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::inputs;

/// A kind of file, and the most that is read of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// What the file is, for messages.
    kind: &'static str,
    /// The most that is read `[bytes]`.
    bytes: u64,
}

const MEBIBYTE: u64 = 1 << 20;

/// Scene files, lists of columns, and other settings that people write.
pub const SCENE: Limit = Limit::of("a scene or a list of settings", 16 * MEBIBYTE);
/// Device files and reports of calibrations.
pub const DEVICE: Limit = Limit::of("a device file or a calibration", 64 * MEBIBYTE);
/// Files of triangles.
pub const MESH: Limit = Limit::of("a mesh", 256 * MEBIBYTE);
/// Grids of distances from a mesh.
pub const DISTANCE_GRID: Limit = Limit::of("a distance grid", 64 * MEBIBYTE);
/// Tables: traces, runs, maps.
pub const TABLE: Limit = Limit::of("a table", 256 * MEBIBYTE);
/// Journals of work in progress.
pub const JOURNAL: Limit = Limit::of("a journal", 512 * MEBIBYTE);

impl Limit {
    /// At most `bytes` `[bytes]` of files of a kind.
    #[must_use]
    pub const fn of(kind: &'static str, bytes: u64) -> Self {
        Self { kind, bytes }
    }

    /// The whole of the file at `path`.
    ///
    /// # Errors
    /// What the system says; a file that is longer than the limit, as [`io::ErrorKind::FileTooLarge`].
    pub fn bytes(self, path: &Path) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.reader(File::open(path)?).read_to_end(&mut bytes)?;
        inputs::note(path);
        Ok(bytes)
    }

    /// The whole of the file at `path`, which is text.
    ///
    /// # Errors
    /// Those of [`bytes`](Self::bytes); bytes that are not UTF-8, as [`io::ErrorKind::InvalidData`].
    pub fn text(self, path: &Path) -> io::Result<String> {
        let mut text = String::new();
        self.reader(File::open(path)?).read_to_string(&mut text)?;
        inputs::note(path);
        Ok(text)
    }

    /// `source`, with an error of kind [`io::ErrorKind::FileTooLarge`] in place of what is beyond the limit.
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
        let words =
            format!("the file does not end within {length}, the most that is read of {kind}");
        io::Error::new(io::ErrorKind::FileTooLarge, words)
    }
}

/// A source that is read up to a limit.
#[derive(Debug)]
pub struct Bounded<R> {
    source: R,
    limit: Limit,
    /// What may still be read `[bytes]`.
    rest: u64,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // One byte beyond the limit tells a source that ends there from one that goes on.
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

    const FOUR: Limit = Limit::of("a test", 4);

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
        // An empty buffer reads nothing and fails for nothing.
        assert_eq!(FOUR.reader(&b"abcde"[..]).read(&mut []).unwrap(), 0);
    }

    #[test]
    fn a_source_without_end_is_refused() {
        let mut bytes = Vec::new();
        let mut reader = Limit::of("a test", MEBIBYTE).reader(io::repeat(0));
        let error = reader.read_to_end(&mut bytes).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("1 MiB"), "{error}");
        assert!(bytes.len() as u64 <= MEBIBYTE + 1);
    }
}

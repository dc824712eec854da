//! Incremental reader that keeps the text for error messages.

use std::io::{self, Read};

const MARK: &[u8] = b"\xef\xbb\xbf";

/// Longest line of a trace `[bytes]`. A file without lines, such as `/dev/zero`, is rejected there and not read up to
/// the limit of a table.
const LONGEST_LINE: usize = 1 << 20;

/// A reader that keeps the bytes it has passed on. A byte order mark at the start is kept, but not passed on.
pub(super) struct Growing<R> {
    reader: R,
    kept: Vec<u8>,
    /// Number of bytes passed on.
    passed: usize,
    /// Offset of the last line.
    line: usize,
    /// Number of bytes known to be UTF-8.
    valid: usize,
    begun: bool,
    ended: bool,
    fault: Option<Unread>,
}

/// Reason for the end of reading.
pub(super) enum Unread {
    /// An error of the system.
    Io(io::Error),
    /// A byte that is not UTF-8.
    NotUtf8(u8),
}

impl<R: Read> Growing<R> {
    pub fn new(reader: R) -> Self {
        Self {
            reader,
            kept: Vec::new(),
            passed: 0,
            line: 0,
            valid: 0,
            begun: false,
            ended: false,
            fault: None,
        }
    }

    /// Returns the length of the byte order mark at the start.
    pub fn mark(&self) -> usize {
        if self.kept.starts_with(MARK) {
            MARK.len()
        } else {
            0
        }
    }

    /// Returns the text read so far.
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.kept[..self.valid]).unwrap_or_default()
    }

    /// Returns the first line with data, which is read ahead and not yet passed on.
    pub fn first_line(&mut self) -> &str {
        while self.header().is_none_or(|(_, ended)| !ended) && self.more() {}
        self.header().map_or("", |(line, _)| line)
    }

    /// Returns the available part of that line, and whether it ends.
    fn header(&self) -> Option<(&str, bool)> {
        let text = self.text();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = text.split_inclusive(['\n', '\r']);
        let line = lines.find(|line| !line.trim().is_empty() && !line.starts_with('#'))?;
        Some((line.trim_end(), line.ends_with(['\n', '\r'])))
    }

    /// Returns the reason for an early end of reading, if any.
    pub fn take_fault(&mut self) -> Option<Unread> {
        self.fault.take()
    }

    /// Reads on until the line after the one at `from` has ended, for the context of an error.
    pub fn read_past(&mut self, from: usize) {
        let feeds = |kept: &[u8]| {
            let rest = kept.get(from..).unwrap_or_default();
            rest.iter().filter(|byte| **byte == b'\n').count()
        };
        while feeds(&self.kept) < 2 && self.more() {}
    }

    /// Reads one block; returns whether it contained usable text.
    fn more(&mut self) -> bool {
        if self.ended {
            return false;
        }
        let before = self.kept.len();
        self.kept.resize(before + (1 << 16), 0);
        let read = loop {
            match self.reader.read(&mut self.kept[before..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read,
            }
        };
        self.kept.truncate(before + *read.as_ref().unwrap_or(&0));
        match read {
            Ok(0) => {
                self.ended = true;
                // An incomplete character.
                if let Some(byte) = self.kept.get(self.valid) {
                    self.fault = Some(Unread::NotUtf8(*byte));
                }
            }
            Ok(_) => {
                if let Err(error) = std::str::from_utf8(&self.kept[self.valid..]) {
                    self.valid += error.valid_up_to();
                    if error.error_len().is_some() {
                        self.ended = true;
                        self.fault = Some(Unread::NotUtf8(self.kept[self.valid]));
                    }
                } else {
                    self.valid = self.kept.len();
                }
            }
            Err(error) => {
                self.ended = true;
                self.fault = Some(Unread::Io(error));
            }
        }
        let feed = self.kept[before..].iter().rposition(|byte| *byte == b'\n');
        self.line = feed.map_or(self.line, |at| before + at + 1);
        if self.kept.len() - self.line > LONGEST_LINE && !self.ended {
            self.ended = true;
            self.fault = Some(Unread::Io(io::Error::new(
                io::ErrorKind::FileTooLarge,
                "a line is longer than 1 MiB, the limit for a line",
            )));
        }
        !self.ended
    }
}

impl<R: Read> Read for Growing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while !self.begun {
            let whole = self.kept.len() >= MARK.len() || !MARK.starts_with(&self.kept);
            if whole || !self.more() {
                self.begun = true;
                self.passed = self.mark();
            }
        }
        while self.passed >= self.valid && self.more() {}
        if self.fault.is_some() {
            return Err(io::Error::other("not text"));
        }
        let rest = &self.kept[self.passed..self.valid];
        let length = rest.len().min(buffer.len());
        buffer[..length].copy_from_slice(&rest[..length]);
        self.passed += length;
        Ok(length)
    }
}

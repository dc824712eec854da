//! Incremental reader that keeps the text for error messages.

use std::io::{self, Read};

/// Byte order mark.
const MARK: char = '\u{feff}';

/// Longest line of a trace `[bytes]`. A file without lines, such as `/dev/zero`, is rejected there and not read up to
/// the limit of a table.
const LONGEST_LINE: usize = 1 << 20;

/// A reader that keeps the text it has passed on. A byte order mark at the start is kept, but not passed on.
pub(super) struct Growing<R> {
    reader: R,
    /// Text read so far.
    text: String,
    /// Bytes after the text: an incomplete character, or a block with a byte that is not UTF-8.
    rest: Vec<u8>,
    /// Number of bytes of the text passed on.
    passed: usize,
    /// Offset of the last line.
    line: usize,
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
            text: String::new(),
            rest: Vec::new(),
            passed: 0,
            line: 0,
            begun: false,
            ended: false,
            fault: None,
        }
    }

    /// Returns the length of the byte order mark at the start.
    pub fn mark(&self) -> usize {
        if self.text.starts_with(MARK) {
            MARK.len_utf8()
        } else {
            0
        }
    }

    /// Returns the text read so far.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the first line with data, which is read ahead and not yet passed on.
    pub fn first_line(&mut self) -> &str {
        while self.header().is_none_or(|(_, ended)| !ended) && self.more() {}
        self.header().map_or("", |(line, _)| line)
    }

    /// Returns the available part of that line, and whether it ends.
    fn header(&self) -> Option<(&str, bool)> {
        let text = self.text.strip_prefix(MARK).unwrap_or(&self.text);
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
        let feeds = |text: &str| {
            let after = text.as_bytes().get(from..).unwrap_or_default();
            after.iter().filter(|byte| **byte == b'\n').count()
        };
        while feeds(&self.text) < 2 && self.more() {}
    }

    /// Reads one block; returns whether it contained usable text.
    fn more(&mut self) -> bool {
        if self.ended {
            return false;
        }
        let before = self.rest.len();
        self.rest.resize(before + (1 << 16), 0);
        let read = loop {
            match self.reader.read(&mut self.rest[before..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read,
            }
        };
        self.rest.truncate(before + *read.as_ref().unwrap_or(&0));
        match read {
            Ok(0) => {
                self.ended = true;
                // An incomplete character.
                self.fault = self.rest.first().map(|byte| Unread::NotUtf8(*byte));
            }
            Ok(_) => self.take_text(),
            Err(error) => {
                self.ended = true;
                self.fault = Some(Unread::Io(error));
            }
        }
        if self.text.len() + self.rest.len() - self.line > LONGEST_LINE && !self.ended {
            self.ended = true;
            self.fault = Some(Unread::Io(io::Error::new(
                io::ErrorKind::FileTooLarge,
                "a line is longer than 1 MiB, the limit for a line",
            )));
        }
        !self.ended
    }

    /// Moves the valid part of the bytes to the text.
    fn take_text(&mut self) {
        let before = self.text.len();
        let (valid, invalid) = match std::str::from_utf8(&self.rest) {
            Ok(text) => (text, None),
            Err(error) => {
                let (valid, after) = self.rest.split_at(error.valid_up_to());
                let is_incomplete = error.error_len().is_none();
                let invalid = after.first().filter(|_| !is_incomplete).copied();
                (std::str::from_utf8(valid).unwrap_or_default(), invalid)
            }
        };
        self.text.push_str(valid);
        self.rest.drain(..valid.len());
        if let Some(byte) = invalid {
            self.ended = true;
            self.fault = Some(Unread::NotUtf8(byte));
        }
        let feed = self.text[before..].rfind('\n');
        self.line = feed.map_or(self.line, |at| before + at + 1);
    }
}

impl<R: Read> Read for Growing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.text.is_empty() && self.more() {}
        if !std::mem::replace(&mut self.begun, true) {
            self.passed = self.mark();
        }
        while self.passed >= self.text.len() && self.more() {}
        if self.fault.is_some() {
            return Err(io::Error::other("not text"));
        }
        let rest = &self.text.as_bytes()[self.passed..];
        let length = rest.len().min(buffer.len());
        buffer[..length].copy_from_slice(&rest[..length]);
        self.passed += length;
        Ok(length)
    }
}

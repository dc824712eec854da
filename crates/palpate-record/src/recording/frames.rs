//! Complete records of an MCAP file, in sequence.

use std::io::{self, Read};

use mcap::MAGIC;

use super::LONGEST_RECORD;

/// Reader of records that computes the checksum of the bytes passed.
pub(super) struct Frames<R> {
    source: R,
    /// Bytes of complete records taken so far, with the magic at the start.
    pub offset: u64,
    passed: crc32fast::Hasher,
}

/// Next item of a file.
pub(super) enum Frame {
    /// A complete record.
    Record {
        opcode: u8,
        /// Offset of its first byte.
        at: u64,
        body: Vec<u8>,
        /// Checksum of everything before it, since the last [`Frames::forget`].
        before: crc32fast::Hasher,
    },
    /// The file ends here.
    End,
    /// The file ends within a record.
    Torn {
        /// Available bytes of the record.
        size: u64,
        /// Opcode, if available.
        opcode: Option<u8>,
        /// Available part of its body.
        body: Vec<u8>,
    },
    /// The record's length is invalid, because no record is this long.
    Endless,
}

impl<R: Read> Frames<R> {
    /// Starts reading a file; `None` if it does not start with the MCAP magic.
    pub fn begin(mut source: R) -> io::Result<Option<Self>> {
        let mut magic = [0; MAGIC.len()];
        if fill(&mut source, &mut magic)? < magic.len() || magic != *MAGIC {
            return Ok(None);
        }
        let mut passed = crc32fast::Hasher::new();
        passed.update(MAGIC);
        let offset = MAGIC.len() as u64;
        Ok(Some(Self {
            source,
            offset,
            passed,
        }))
    }

    pub fn next(&mut self) -> io::Result<Frame> {
        let mut head = [0; 9];
        let begun = fill(&mut self.source, &mut head)?;
        if begun == 0 {
            return Ok(Frame::End);
        }
        if begun < head.len() {
            return Ok(Frame::Torn {
                size: begun as u64,
                opcode: None,
                body: Vec::new(),
            });
        }
        let (opcode, length) = (head[0], length(&head));
        if length > LONGEST_RECORD {
            return Ok(Frame::Endless);
        }
        let mut body = Vec::new();
        let taken = Read::take(&mut self.source, length).read_to_end(&mut body)? as u64;
        let size = head.len() as u64 + taken;
        if taken < length {
            return Ok(Frame::Torn {
                size,
                opcode: Some(opcode),
                body,
            });
        }
        let before = self.passed.clone();
        self.passed.update(&head);
        self.passed.update(&body);
        let at = self.offset;
        self.offset += size;
        Ok(Frame::Record {
            opcode,
            at,
            body,
            before,
        })
    }

    /// Restarts the checksum.
    pub fn forget(&mut self) {
        self.passed = crc32fast::Hasher::new();
    }

    /// Returns the magic after the last record, as far as available, and the number of bytes after it.
    pub fn rest(&mut self) -> io::Result<(Vec<u8>, u64)> {
        let mut rest = [0; MAGIC.len()];
        let taken = fill(&mut self.source, &mut rest)?;
        let behind = io::copy(&mut self.source, &mut io::sink())?;
        Ok((rest[..taken].to_vec(), behind))
    }
}

/// A record: opcode and body.
type RawRecord<'a> = (u8, &'a [u8]);

/// Returns the complete records within a chunk, and whether they extend to its end.
pub(super) fn records(mut bytes: &[u8]) -> (Vec<RawRecord<'_>>, bool) {
    let mut records = Vec::new();
    while !bytes.is_empty() {
        let Some((record, rest)) = first_record(bytes) else {
            return (records, false);
        };
        records.push(record);
        bytes = rest;
    }
    (records, true)
}

/// Returns the first record and the remaining bytes.
fn first_record(bytes: &[u8]) -> Option<(RawRecord<'_>, &[u8])> {
    let head = bytes.first_chunk::<9>()?;
    let length = usize::try_from(length(head)).ok()?;
    let end = length.checked_add(head.len())?;
    let body = bytes.get(head.len()..end)?;
    Some(((head[0], body), &bytes[end..]))
}

/// Returns the length of a record, without its opcode.
fn length(head: &[u8; 9]) -> u64 {
    let [_, length @ ..] = *head;
    u64::from_le_bytes(length)
}

/// Reads until `buffer` is full or the source ends; returns the number of bytes.
fn fill(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

//! The records of an MCAP file, one after the other, as far as they are whole.

use std::io::{self, Read};

use mcap::MAGIC;

use super::LONGEST_RECORD;

/// Takes records off a file and keeps the checksum of what it has passed.
pub(super) struct Frames<R> {
    source: R,
    /// Bytes that were taken as whole records, with the magic at the start.
    pub offset: u64,
    passed: crc32fast::Hasher,
}

/// What comes next in a file.
pub(super) enum Frame {
    /// A whole record.
    Record {
        opcode: u8,
        /// Where it begins.
        at: u64,
        body: Vec<u8>,
        /// Checksum of everything before it, since the last [`Frames::forget`].
        before: crc32fast::Hasher,
    },
    /// The file ends here.
    End,
    /// The file ends within a record.
    Torn {
        /// Bytes that are there of it.
        size: u64,
        /// What it was to be, if that much is there.
        opcode: Option<u8>,
        /// The part of its body that is there.
        body: Vec<u8>,
    },
    /// No record is this long: its length is not what was written.
    Endless,
}

impl<R: Read> Frames<R> {
    /// A file that must begin as MCAP files do; none if it does not.
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

    /// Begins the checksum anew.
    pub fn forget(&mut self) {
        self.passed = crc32fast::Hasher::new();
    }

    /// What follows the last record, as much as should, and how many bytes stand behind that.
    pub fn rest(&mut self) -> io::Result<(Vec<u8>, u64)> {
        let mut rest = [0; MAGIC.len()];
        let taken = fill(&mut self.source, &mut rest)?;
        let behind = io::copy(&mut self.source, &mut io::sink())?;
        Ok((rest[..taken].to_vec(), behind))
    }
}

/// A record: its opcode, and its body.
type RawRecord<'a> = (u8, &'a [u8]);

/// The records within a chunk, as far as they are whole; and whether that is to its end.
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

/// The first record, and what follows it.
fn first_record(bytes: &[u8]) -> Option<(RawRecord<'_>, &[u8])> {
    let head = bytes.first_chunk::<9>()?;
    let length = usize::try_from(length(head)).ok()?;
    let end = length.checked_add(head.len())?;
    let body = bytes.get(head.len()..end)?;
    Some(((head[0], body), &bytes[end..]))
}

/// Length of a record, after its opcode.
fn length(head: &[u8; 9]) -> u64 {
    let [_, length @ ..] = *head;
    u64::from_le_bytes(length)
}

/// Reads until `buffer` is full or the source ends; how many bytes.
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

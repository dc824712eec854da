//! Sequential reading of a recording, which accepts only data with valid checksums.

use std::io::{self, Read};

use mcap::records::{Record, op};
use mcap::{MAGIC, parse_record};

use super::chunk::Content;
use super::frames::{Frame, Frames};
use super::loss::Loss;
use super::read::Entry;
use super::{LoopCount, RecordingMetadata, WHOLE, count, metadata};

/// Start of the library field in the header of this program's recordings, before a version.
pub(super) const LIBRARY: &str = "palpate ";
const NO_RECORDING: &str = "an MCAP file, but not a recording of palpate";

/// A recording, read up to its next chunk.
pub(super) struct Walk<R> {
    frames: Frames<R>,
    content: Content,
    /// Whether another tool wrote the file: this program's files meet stricter requirements than MCAP.
    is_foreign: bool,
    /// Metadata of the recording, if they have been read.
    metadata: Option<RecordingMetadata>,
    count: Option<LoopCount>,
    /// Whether all chunks have been read.
    in_summary: bool,
    /// Whether the end has been read.
    has_ended: bool,
}

/// Reason why the file is not a recording.
pub(super) enum Refused {
    Unreadable(io::Error),
    Invalid(String),
}

/// Next item of a recording.
pub(super) enum Step {
    /// A valid chunk.
    Chunk(Vec<Entry>),
    /// A damaged item, with a description.
    Damaged(String),
    /// The valid end.
    Complete,
    /// A truncated or damaged end, with a description.
    Tail(String),
    /// The entries of a truncated last chunk: no checksum covers them.
    TornChunk {
        /// Entries up to the last complete message.
        entries: Vec<Entry>,
        /// Bytes of the file that belong to the chunk.
        size: u64,
    },
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl<R: Read> Walk<R> {
    /// Reads up to the end of the metadata. This program writes them first; another tool may place them elsewhere.
    pub fn begin(source: R) -> Result<Self, Refused> {
        let invalid = |what: &str| Refused::Invalid(what.into());
        let frames = Frames::begin(source)?;
        let mut walk = Self {
            frames: frames.ok_or_else(|| invalid("not an MCAP file, so no recording"))?,
            content: Content::new(),
            is_foreign: false,
            metadata: None,
            count: None,
            in_summary: false,
            has_ended: false,
        };
        for expected in [op::HEADER, op::METADATA] {
            match walk.frames.next()? {
                Frame::End | Frame::Torn { .. } => {
                    return Err(invalid(
                        "cut off within its metadata: it contains no recorded data",
                    ));
                }
                Frame::Record { opcode, body, .. } if opcode == expected => {
                    match parse_record(opcode, &body) {
                        Ok(Record::Header(header)) => {
                            walk.is_foreign = !header.library.starts_with(LIBRARY);
                            if walk.is_foreign {
                                return Ok(walk);
                            }
                        }
                        Ok(Record::Metadata(record)) => {
                            let metadata = RecordingMetadata::from_metadata(record);
                            walk.metadata = Some(metadata.map_err(Refused::Invalid)?);
                            return Ok(walk);
                        }
                        _ => break,
                    }
                }
                _ => break,
            }
        }
        Err(invalid(NO_RECORDING))
    }

    /// Returns the metadata, which have been read; or the reason why there are none.
    pub fn metadata(&mut self) -> Result<RecordingMetadata, Refused> {
        self.metadata
            .take()
            .ok_or_else(|| Refused::Invalid(NO_RECORDING.into()))
    }

    /// Returns the counters of the loop, if they have been read.
    pub fn count(&mut self) -> Option<LoopCount> {
        self.count.take()
    }

    /// Returns the offset of the end of the last complete record.
    pub fn passed(&self) -> u64 {
        self.frames.offset
    }

    /// Returns the missing ticks, derived from all data up to here.
    pub fn loss(self) -> Loss {
        self.content.loss
    }

    pub fn next(&mut self) -> Result<Step, Refused> {
        if self.has_ended {
            return Ok(Step::Complete);
        }
        loop {
            let (opcode, at, body, before) = match self.frames.next()? {
                Frame::Record {
                    opcode,
                    at,
                    body,
                    before,
                } => (opcode, at, body, before),
                Frame::End if self.in_summary => return Ok(self.tail("within its index")),
                Frame::End => {
                    return Ok(Step::Tail(
                        "never finished: it ends with its last flush".into(),
                    ));
                }
                Frame::Torn {
                    size,
                    opcode: Some(op::CHUNK),
                    body,
                } if !self.in_summary => {
                    let entries = self.content.torn_chunk(&body);
                    if entries.is_empty() {
                        return Ok(self.torn(size));
                    }
                    return Ok(Step::TornChunk { entries, size });
                }
                Frame::Torn { size, .. } => return Ok(self.torn(size)),
                Frame::Endless => return Ok(strange(self.frames.offset)),
            };
            let step = if self.in_summary {
                self.summary_record(opcode, at, &body, before)?
            } else {
                self.data_record(opcode, at, &body, before)?
            };
            if let Some(step) = step {
                return Ok(step);
            }
        }
    }

    /// Processes a record before the summary, at byte `at`; returns the item that it gives, if any.
    fn data_record(
        &mut self,
        opcode: u8,
        at: u64,
        body: &[u8],
        before: crc32fast::Hasher,
    ) -> Result<Option<Step>, Refused> {
        match opcode {
            op::CHUNK => {
                return Ok(Some(match self.content.chunk(body, self.is_foreign) {
                    Ok(entries) => Step::Chunk(entries),
                    Err(why) => Step::Damaged(format!("the chunk at byte {at}: {why}")),
                }));
            }
            op::MESSAGE_INDEX if is_index(body) => {}
            op::METADATA => {
                if let Some(damage) = self.metadata_record(body)? {
                    let damage = format!("the record at byte {at}: {damage}");
                    return Ok(Some(Step::Damaged(damage)));
                }
            }
            op::ATTACHMENT => {}
            // Outside chunks, as other tools may place them.
            op::SCHEMA | op::CHANNEL | op::MESSAGE if self.is_foreign => {
                match self.content.record(opcode, body) {
                    Ok(None) => {}
                    Ok(Some(entry)) => return Ok(Some(Step::Chunk(vec![entry]))),
                    Err(why) => {
                        let damage = format!("the record at byte {at}: {why}");
                        return Ok(Some(Step::Damaged(damage)));
                    }
                }
            }
            op::DATA_END => return Ok(self.data_end(at, body, before)),
            _ => return Ok(Some(strange(at))),
        }
        Ok(None)
    }

    /// Begins the summary; returns an item if the end of the data, at byte `at`, is damaged or its checksum does not
    /// match.
    fn data_end(&mut self, at: u64, body: &[u8], before: crc32fast::Hasher) -> Option<Step> {
        let Ok(Record::DataEnd(end)) = parse_record(op::DATA_END, body) else {
            return Some(strange(at));
        };
        self.in_summary = true;
        self.frames.forget();
        let lacks_sum = self.is_foreign && end.data_section_crc == 0;
        if !lacks_sum && end.data_section_crc != before.finalize() {
            return Some(Step::Damaged(format!(
                "{WHOLE}: its checksum does not match its bytes"
            )));
        }
        None
    }

    /// Processes a record of the summary, at byte `at`; returns the item that it gives, if any.
    fn summary_record(
        &mut self,
        opcode: u8,
        at: u64,
        body: &[u8],
        before: crc32fast::Hasher,
    ) -> Result<Option<Step>, Refused> {
        match opcode {
            op::SCHEMA
            | op::CHANNEL
            | op::STATISTICS
            | op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::METADATA_INDEX
            | op::SUMMARY_OFFSET => Ok(None),
            op::FOOTER => self.footer(body, before).map(Some),
            _ => Ok(Some(strange(at))),
        }
    }

    /// Checks the footer and the bytes after it; returns the end of the recording.
    fn footer(&mut self, body: &[u8], before: crc32fast::Hasher) -> Result<Step, Refused> {
        let lacks_sum = self.is_foreign && body.ends_with(&[0; 4]);
        let sound = lacks_sum || summary_checksum(before, body) == body.last_chunk::<4>().copied();
        let (rest, behind) = self.frames.rest()?;
        Ok(if sound && rest == MAGIC {
            self.has_ended = true;
            if behind == 0 {
                return Ok(Step::Complete);
            }
            Step::Damaged(format!(
                "{WHOLE}: {behind} {} the end of the recording",
                if behind == 1 {
                    "byte follows"
                } else {
                    "bytes follow"
                }
            ))
        } else if sound && MAGIC.starts_with(&rest) {
            self.tail("within its last bytes")
        } else {
            Step::Tail("the index at its end is damaged".into())
        })
    }

    /// Processes a metadata record; returns a description of an error.
    fn metadata_record(&mut self, body: &[u8]) -> Result<Option<&'static str>, Refused> {
        let Ok(Record::Metadata(record)) = parse_record(op::METADATA, body) else {
            return Ok(Some("it is damaged"));
        };
        if record.name == count::RECORD {
            self.count = LoopCount::from_metadata(record);
            if self.count.is_none() {
                return Ok(Some("the counters of the loop are damaged"));
            }
        } else if record.name == metadata::RECORD && self.metadata.is_none() {
            let metadata = RecordingMetadata::from_metadata(record);
            self.metadata = Some(metadata.map_err(Refused::Invalid)?);
        }
        Ok(None)
    }

    fn torn(&self, size: u64) -> Step {
        self.tail(&format!("{size} bytes after its last whole record"))
    }

    fn tail(&self, wherever: &str) -> Step {
        Step::Tail(format!("cut off {wherever}"))
    }
}

fn strange(at: u64) -> Step {
    Step::Tail(format!(
        "damaged from byte {at} on; the rest cannot be read"
    ))
}

/// Returns whether a skipped record is an index of messages.
fn is_index(body: &[u8]) -> bool {
    let entries = body.len().saturating_sub(6);
    let claimed = body
        .get(2..6)
        .map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    claimed.is_some_and(|claimed| claimed as usize == entries) && entries.is_multiple_of(16)
}

/// Returns the checksum of the summary and the footer up to its own, as bytes of the file.
fn summary_checksum(before: crc32fast::Hasher, footer: &[u8]) -> Option<[u8; 4]> {
    let (covered, _) = footer.split_last_chunk::<4>()?;
    let mut hasher = before;
    hasher.update(&[op::FOOTER]);
    hasher.update(&(footer.len() as u64).to_le_bytes());
    hasher.update(covered);
    Some(hasher.finalize().to_le_bytes())
}

//! From the start of a recording to where it ends, believing nothing that its checksums do not.

use std::collections::BTreeMap;
use std::io::{self, Read};

use mcap::records::{Record, op};
use mcap::{MAGIC, parse_record};

use super::frames::{Frame, Frames, records};
use super::loss::Loss;
use super::read::Entry;
use super::{EVENT_TOPIC, Event, MESSAGE_ENCODING, Receipt, TICK_TOPIC, Tick};

/// A recording, read as far as its next chunk.
pub(super) struct Walk<R> {
    frames: Frames<R>,
    channels: BTreeMap<u16, Channel>,
    loss: Loss,
    /// Whether all chunks have been passed.
    in_summary: bool,
}

#[derive(Clone, Copy)]
enum Channel {
    Ticks,
    Events,
    /// Somebody else's.
    Other,
}

/// Why this is no recording.
pub(super) enum Refused {
    Unreadable(io::Error),
    Invalid(String),
}

/// What comes next in a recording.
pub(super) enum Step {
    /// A chunk that is what was written.
    Chunk(Vec<Entry>),
    /// Something that is not, in words.
    Damaged(String),
    /// The end, as it was written.
    Complete,
    /// The end, cut off or not what was written, in words.
    Tail(String),
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl<R: Read> Walk<R> {
    /// Reads up to the end of the receipt.
    pub fn begin(source: R) -> Result<(Self, Receipt), Refused> {
        let invalid = |what: &str| Refused::Invalid(what.into());
        let frames = Frames::begin(source)?;
        let mut frames = frames.ok_or_else(|| invalid("not an MCAP file, so no recording"))?;
        for expected in [op::HEADER, op::METADATA] {
            match frames.next()? {
                Frame::End | Frame::Torn(_) => {
                    return Err(invalid(
                        "cut off within its receipt: nothing was recorded in it yet",
                    ));
                }
                Frame::Record { opcode, body, .. } if opcode == expected => {
                    if let Ok(Record::Metadata(record)) = parse_record(opcode, &body) {
                        let receipt = Receipt::from_metadata(record).map_err(Refused::Invalid)?;
                        let walk = Self {
                            frames,
                            // As they are written; a chunk that says otherwise is heard.
                            channels: [(1, Channel::Ticks), (2, Channel::Events)].into(),
                            loss: Loss::default(),
                            in_summary: false,
                        };
                        return Ok((walk, receipt));
                    }
                }
                _ => break,
            }
        }
        Err(invalid("an MCAP file, but not a recording of palpate"))
    }

    /// Bytes up to the end of the last whole record.
    pub fn passed(&self) -> u64 {
        self.frames.offset
    }

    /// What is missing, told from everything up to here.
    pub fn loss(self) -> Loss {
        self.loss
    }

    pub fn next(&mut self) -> io::Result<Step> {
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
                Frame::Torn(bytes) => {
                    let last = format!("{bytes} bytes after its last whole record");
                    return Ok(self.tail(&last));
                }
                Frame::Endless => return Ok(strange(self.frames.offset)),
            };
            match opcode {
                op::CHUNK if !self.in_summary => {
                    return Ok(match self.chunk(&body) {
                        Ok(entries) => Step::Chunk(entries),
                        Err(why) => Step::Damaged(format!("the chunk at byte {at}: {why}")),
                    });
                }
                op::MESSAGE_INDEX if !self.in_summary && is_index(&body) => {}
                op::METADATA | op::ATTACHMENT if !self.in_summary => {}
                op::DATA_END if !self.in_summary => {
                    let Ok(Record::DataEnd(end)) = parse_record(opcode, &body) else {
                        return Ok(strange(at));
                    };
                    self.in_summary = true;
                    self.frames.forget();
                    if end.data_section_crc != before.finalize() {
                        return Ok(Step::Damaged(
                            "the whole: its checksum does not fit its bytes".into(),
                        ));
                    }
                }
                op::SCHEMA
                | op::CHANNEL
                | op::STATISTICS
                | op::CHUNK_INDEX
                | op::ATTACHMENT_INDEX
                | op::METADATA_INDEX
                | op::SUMMARY_OFFSET
                    if self.in_summary => {}
                op::FOOTER if self.in_summary => {
                    let sound = summary_checksum(before, &body) == body.last_chunk::<4>().copied();
                    let rest = self.frames.rest()?;
                    return Ok(if sound && rest == MAGIC {
                        Step::Complete
                    } else if sound && MAGIC.starts_with(&rest) {
                        self.tail("within its last bytes")
                    } else {
                        Step::Tail("the index at its end is damaged".into())
                    });
                }
                _ => return Ok(strange(at)),
            }
        }
    }

    fn tail(&self, wherever: &str) -> Step {
        Step::Tail(format!("cut off {wherever}"))
    }

    /// The entries of a chunk; why it is not to be believed.
    fn chunk(&mut self, body: &[u8]) -> Result<Vec<Entry>, String> {
        let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
            return Err("its head is not what was written".into());
        };
        if ["zstd", "lz4"].contains(&header.compression.as_str()) {
            return Err(format!(
                "it is compressed with {}, and this program reads what is not compressed",
                header.compression
            ));
        }
        if crc32fast::hash(&data) != header.uncompressed_crc {
            return Err("its checksum does not fit its bytes".into());
        }
        let no_records = || "it does not hold records".to_owned();
        let mut entries = Vec::new();
        let mut loss = self.loss.clone();
        for (opcode, record) in records(&data).ok_or_else(no_records)? {
            // Nothing else is of interest, and the library does not expect everything everywhere.
            if ![op::CHANNEL, op::MESSAGE].contains(&opcode) {
                continue;
            }
            match parse_record(opcode, record).map_err(|_| no_records())? {
                Record::Channel(channel) => {
                    let known = match channel.topic.as_str() {
                        _ if channel.message_encoding != MESSAGE_ENCODING => Channel::Other,
                        TICK_TOPIC => Channel::Ticks,
                        EVENT_TOPIC => Channel::Events,
                        _ => Channel::Other,
                    };
                    self.channels.insert(channel.id, known);
                }
                Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                    Some(Channel::Ticks) => {
                        let tick = Tick::decode(&data).ok_or("a message is not a tick")?;
                        if !loss.tick(tick.sequence) {
                            return Err(format!(
                                "tick {} does not come after the one before it",
                                tick.sequence
                            ));
                        }
                        entries.push(Entry::Tick(tick));
                    }
                    Some(Channel::Events) => {
                        let event = Event::decode(&data).ok_or("a message is not an event")?;
                        loss.named(event.sequence);
                        entries.push(Entry::Event(event));
                    }
                    Some(Channel::Other) | None => {}
                },
                _ => {}
            }
        }
        self.loss = loss;
        Ok(entries)
    }
}

fn strange(at: u64) -> Step {
    Step::Tail(format!(
        "from byte {at} on it is not what was written, and nothing after that can be read"
    ))
}

/// Whether a record that is passed over is an index of messages.
fn is_index(body: &[u8]) -> bool {
    let entries = body.len().saturating_sub(6);
    let claimed = body
        .get(2..6)
        .map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    claimed.is_some_and(|claimed| claimed as usize == entries) && entries.is_multiple_of(16)
}

/// Checksum of the summary and the footer up to its own, as bytes of the file.
fn summary_checksum(before: crc32fast::Hasher, footer: &[u8]) -> Option<[u8; 4]> {
    let (covered, _) = footer.split_last_chunk::<4>()?;
    let mut hasher = before;
    hasher.update(&[op::FOOTER]);
    hasher.update(&(footer.len() as u64).to_le_bytes());
    hasher.update(covered);
    Some(hasher.finalize().to_le_bytes())
}

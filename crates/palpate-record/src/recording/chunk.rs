//! The ticks and events of one chunk.

use std::collections::BTreeMap;
use std::sync::Arc;

use mcap::parse_record;
use mcap::records::{ChunkHeader, Record, op};

use super::frames::records;
use super::layout::Layout;
use super::loss::Loss;
use super::read::Entry;
use super::unpack::unpack;
use super::{EVENT_TOPIC, Event, LONGEST_RECORD, MESSAGE_ENCODING, TICK_TOPIC, schema};

#[derive(Clone)]
enum Channel {
    /// With where the columns stand in a message.
    Ticks(Arc<Layout>),
    Events,
    /// Somebody else's.
    Other,
}

/// What is known from the chunks so far: which channel is which, and which ticks are there.
#[derive(Clone)]
pub(super) struct Content {
    /// What the types of ticks say, by their numbers.
    layouts: BTreeMap<u16, Arc<Layout>>,
    channels: BTreeMap<u16, Channel>,
    pub loss: Loss,
}

impl Content {
    pub fn new() -> Self {
        let own = Channel::Ticks(Arc::new(Layout::own()));
        Self {
            layouts: BTreeMap::new(),
            // As they are written; a chunk that says otherwise is heard.
            channels: [(1, own), (2, Channel::Events)].into(),
            loss: Loss::default(),
        }
    }

    /// The entries of a chunk; why it is not to be believed. `may_lack_sum`: a checksum of 0 says that
    /// there is none, as the tools of others may write it.
    pub fn chunk(&mut self, body: &[u8], may_lack_sum: bool) -> Result<Vec<Entry>, String> {
        let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
            return Err("its head is not what was written".into());
        };
        let most = header.uncompressed_size.min(LONGEST_RECORD);
        let unpacked = unpack(&header.compression, &data, most)?;
        if let Some(fault) = unpacked.fault {
            return Err(format!("it cannot be unpacked: {fault}"));
        }
        let data = unpacked.bytes;
        let lacks_sum = may_lack_sum && header.uncompressed_crc == 0;
        if !lacks_sum && crc32fast::hash(&data) != header.uncompressed_crc {
            return Err("its checksum does not fit its bytes".into());
        }
        let (records, is_whole) = records(&data);
        if !is_whole {
            return Err("it does not hold records".into());
        }
        let mut entries = Vec::new();
        let mut content = self.clone();
        for (opcode, record) in records {
            entries.extend(content.record(opcode, record)?);
        }
        *self = content;
        Ok(entries)
    }

    /// The entries of a chunk whose end is not there, up to the last message that is whole. No checksum
    /// covers them. That last message itself is left out: a system that went down may have put zeros in
    /// place of its end.
    pub fn torn_chunk(&mut self, body: &[u8]) -> Vec<Entry> {
        let mut entries = Vec::new();
        let Some((header, data)) = head_of(body) else {
            return entries;
        };
        let most = header.uncompressed_size.min(LONGEST_RECORD);
        let Ok(unpacked) = unpack(&header.compression, data, most) else {
            return entries;
        };
        let (mut there, _) = records(&unpacked.bytes);
        let known =
            |(opcode, _): &(u8, &[u8])| [op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(opcode);
        let sound = there.iter().take_while(|record| known(record)).count();
        there.truncate(sound.saturating_sub(1));
        for (opcode, record) in there {
            match self.record(opcode, record) {
                Ok(entry) => entries.extend(entry),
                Err(_) => break,
            }
        }
        entries
    }

    /// The tick or event in a record, if there is one; why it cannot be believed.
    pub fn record(&mut self, opcode: u8, record: &[u8]) -> Result<Option<Entry>, String> {
        // Nothing else is of interest, and the library does not expect everything everywhere.
        if ![op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(&opcode) {
            return Ok(None);
        }
        match parse_record(opcode, record).map_err(|_| "it does not hold records".to_owned())? {
            Record::Schema { header, data } if header.name == schema::TICK => {
                let layout = std::str::from_utf8(&data)
                    .map_err(|_| "it is no text".to_owned())
                    .and_then(Layout::of_schema)
                    .map_err(|why| format!("the type of the ticks: {why}"))?;
                self.layouts.insert(header.id, Arc::new(layout));
            }
            Record::Channel(channel) => {
                let known = match channel.topic.as_str() {
                    _ if channel.message_encoding != MESSAGE_ENCODING => Channel::Other,
                    TICK_TOPIC => {
                        let told = self.layouts.get(&channel.schema_id).map(Arc::clone);
                        Channel::Ticks(told.unwrap_or_else(|| Arc::new(Layout::own())))
                    }
                    EVENT_TOPIC => Channel::Events,
                    _ => Channel::Other,
                };
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                Some(Channel::Ticks(layout)) => {
                    let tick = layout.decode(&data).ok_or("a message is not a tick")?;
                    if !self.loss.tick(tick.sequence) {
                        return Err(format!(
                            "tick {} does not come after the one before it",
                            tick.sequence
                        ));
                    }
                    return Ok(Some(Entry::Tick(tick)));
                }
                Some(Channel::Events) => {
                    let event = Event::decode(&data).ok_or("a message is not an event")?;
                    self.loss.named(event.sequence);
                    return Ok(Some(Entry::Event(event)));
                }
                Some(Channel::Other) | None => {}
            },
            _ => {}
        }
        Ok(None)
    }
}

/// Head and data of a chunk, as much as there is of them.
fn head_of(body: &[u8]) -> Option<(ChunkHeader, &[u8])> {
    // The library reads a head only where all of the data follows it: with a length of 0 it does.
    let compression = body.get(28..32)?;
    let name = usize::try_from(u32::from_le_bytes(compression.try_into().ok()?)).ok()?;
    let end = 32_usize.checked_add(name)?;
    let mut head = body.get(..end)?.to_vec();
    head.extend([0; 8]);
    let Ok(Record::Chunk { header, .. }) = parse_record(op::CHUNK, &head) else {
        return None;
    };
    let length = u64::from_le_bytes(body.get(end..end + 8)?.try_into().ok()?);
    let data = &body[end + 8..];
    let length = usize::try_from(length).map_or(data.len(), |length| length.min(data.len()));
    Some((header, &data[..length]))
}

//! Ticks and events of one chunk.

use std::collections::BTreeMap;
use std::sync::Arc;

use mcap::parse_record;
use mcap::records::{ChunkHeader, Record, op};

use super::frames::records;
use super::gather::{Gather, Whole};
use super::layout::{Holds, Layout};
use super::loss::Loss;
use super::read::Entry;
use super::unpack::unpack;
use super::{
    BODY_TOPIC, CONTACT_TOPIC, DEVICE_TOPIC, EVENT_TOPIC, Event, LONGEST_RECORD, MESSAGE_ENCODING,
    TICK_TOPIC, schema,
};

#[derive(Clone)]
enum Channel {
    /// Ticks, contacts, bodies or devices, with the layout of their messages.
    Rows(Arc<Layout>),
    Events,
    /// Channel of another program.
    Other,
}

/// State after the chunks read so far: channels, layouts and ticks.
#[derive(Clone)]
pub(super) struct Content {
    /// Layouts of the types of ticks, contacts, bodies and devices, by their numbers.
    layouts: BTreeMap<u16, Arc<Layout>>,
    channels: BTreeMap<u16, Channel>,
    gather: Gather,
    pub loss: Loss,
}

impl Content {
    /// Creates the state at the beginning of a recording, with the channels as this program writes them; a chunk with
    /// other channels overrides them.
    pub fn new() -> Self {
        let rows = |layout| Channel::Rows(Arc::new(layout));
        Self {
            layouts: BTreeMap::new(),
            channels: [
                (1, rows(Layout::of_tick())),
                (2, rows(Layout::of_contact())),
                (3, Channel::Events),
                (4, rows(Layout::of_body())),
                (5, rows(Layout::of_device())),
            ]
            .into(),
            gather: Gather::default(),
            loss: Loss::default(),
        }
    }

    /// Returns the entries of a chunk, or the reason why it is invalid. `may_lack_sum`: a checksum of 0 means that
    /// there is none, as other tools may write it.
    pub fn chunk(&mut self, body: &[u8], may_lack_sum: bool) -> Result<Vec<Entry>, String> {
        let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
            return Err("its header is damaged".into());
        };
        let most = header.uncompressed_size.min(LONGEST_RECORD);
        let unpacked = unpack(&header.compression, &data, most)?;
        if let Some(fault) = unpacked.fault {
            return Err(format!("it cannot be unpacked: {fault}"));
        }
        let data = unpacked.bytes;
        let lacks_sum = may_lack_sum && header.uncompressed_crc == 0;
        if !lacks_sum && crc32fast::hash(&data) != header.uncompressed_crc {
            return Err("its checksum does not match its bytes".into());
        }
        let (records, is_whole) = records(&data);
        if !is_whole {
            return Err("it does not contain records".into());
        }
        let mut entries = Vec::new();
        let mut content = self.clone();
        for (opcode, record) in records {
            entries.extend(content.record(opcode, record)?);
        }
        *self = content;
        Ok(entries)
    }

    /// Returns the entries of a chunk without its end, up to the last complete message. No checksum covers them. The
    /// last message is left out: a system that went down may have replaced its end by zeros.
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

    /// Returns the tick or event of a record, if it contains one, or the reason why it is invalid.
    pub fn record(&mut self, opcode: u8, record: &[u8]) -> Result<Option<Entry>, String> {
        // Other records are ignored; the library does not accept every record everywhere.
        if ![op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(&opcode) {
            return Ok(None);
        }
        match parse_record(opcode, record).map_err(|_| "it does not contain records".to_owned())? {
            Record::Schema { header, data }
                if [schema::TICK, schema::CONTACT, schema::BODY, schema::DEVICE]
                    .contains(&header.name.as_str()) =>
            {
                let layout = std::str::from_utf8(&data)
                    .map_err(|_| "it is not text".to_owned())
                    .and_then(|text| Layout::of_schema(&header.name, text))
                    .map_err(|why| {
                        let of = match header.name.as_str() {
                            schema::TICK => "ticks",
                            schema::BODY => "bodies",
                            schema::DEVICE => "devices",
                            _ => "contacts",
                        };
                        format!("the type of the {of}: {why}")
                    })?;
                self.layouts.insert(header.id, Arc::new(layout));
            }
            Record::Channel(channel) => {
                let messages = || self.layouts.get(&channel.schema_id).map(Arc::clone);
                let known = match channel.topic.as_str() {
                    _ if channel.message_encoding != MESSAGE_ENCODING => Channel::Other,
                    TICK_TOPIC => {
                        Channel::Rows(messages().unwrap_or_else(|| Arc::new(Layout::of_tick())))
                    }
                    CONTACT_TOPIC => {
                        Channel::Rows(messages().unwrap_or_else(|| Arc::new(Layout::of_contact())))
                    }
                    BODY_TOPIC => {
                        Channel::Rows(messages().unwrap_or_else(|| Arc::new(Layout::of_body())))
                    }
                    DEVICE_TOPIC => {
                        Channel::Rows(messages().unwrap_or_else(|| Arc::new(Layout::of_device())))
                    }
                    EVENT_TOPIC => Channel::Events,
                    _ => Channel::Other,
                };
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                Some(Channel::Rows(layout)) => {
                    let layout = Arc::clone(layout);
                    return self.row(&layout, &data);
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

impl Content {
    /// Adds a message; returns the tick that it completes, if any.
    fn row(&mut self, layout: &Layout, message: &[u8]) -> Result<Option<Entry>, String> {
        let row = layout.decode(message).ok_or(match layout.holds {
            Holds::Contact => "a message is not a contact",
            Holds::Body => "a message is not a body",
            Holds::Device => "a message is not a device",
            Holds::Tick => "a message is not a tick",
        })?;
        let whole = match layout.holds {
            Holds::Device => {
                self.gather.device(row.device)?;
                None
            }
            Holds::Tick => self.gather.tick(row.tick)?,
            Holds::Contact => self.gather.contact(row.contact)?,
            Holds::Body => self.gather.body(row.body),
        };
        whole.map(|whole| self.whole(whole)).transpose()
    }

    fn whole(&mut self, (tick, contacts, bodies, devices): Whole) -> Result<Entry, String> {
        if self.loss.tick(tick.sequence) {
            return Ok(Entry::Tick(tick, contacts, bodies, devices));
        }
        Err(format!(
            "tick {} does not come after the previous one",
            tick.sequence
        ))
    }
}

/// Returns the header and the available data of a chunk.
fn head_of(body: &[u8]) -> Option<(ChunkHeader, &[u8])> {
    // The library parses a header only if all of the data follows it: set its length to 0.
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

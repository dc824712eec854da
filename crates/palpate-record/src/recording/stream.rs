//! Ticks and events as an MCAP stream.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions, Writer};

use super::{
    BODY_TOPIC, BodyTick, CONTACT_TOPIC, Column, ContactTick, DEVICE_TOPIC, DeviceTick,
    EVENT_TOPIC, Event, LoopCount, MESSAGE_ENCODING, RecordingMetadata, Row, SCHEMA_ENCODING,
    TICK_TOPIC, Tick, cdr, schema,
};

/// Maximum size of a chunk without a flush, before its compression [bytes]: about three seconds of one contact at 1 kHz.
const CHUNK: usize = 1 << 20;
#[cfg(not(target_family = "wasm"))]
const COMPRESSION: Option<mcap::Compression> = Some(mcap::Compression::Lz4);
#[cfg(target_family = "wasm")]
const COMPRESSION: Option<mcap::Compression> = None;
/// Longest text of an event [bytes].
const LONGEST_TEXT: usize = 1 << 20;

/// Writer of a recording to any output; chunks appear there as a whole.
pub(super) struct Stream<W: Write> {
    /// `None` after the end or a failed write: the library panics if a writer is used after its end could not be
    /// written.
    mcap: Option<Writer<NoSeek<W>>>,
    tick_channel: u16,
    contact_channel: u16,
    event_channel: u16,
    body_channel: u16,
    /// `None` until the first tick with several devices.
    device_channel: Option<u16>,
    /// Size of the current chunk [bytes].
    in_chunk: usize,
    last_sequence: Option<u64>,
    pub ticks: u64,
    pub events: u64,
    message: Vec<u8>,
}

impl<W: Write> Stream<W> {
    /// Starts with the metadata, which `out` has received on return.
    pub fn begin(out: W, metadata: &RecordingMetadata) -> io::Result<Self> {
        let metadata = metadata.to_metadata().map_err(invalid)?;
        let mut mcap = WriteOptions::new()
            .compression(COMPRESSION)
            .library(concat!("palpate ", env!("CARGO_PKG_VERSION")))
            // Automatic chunks could end between a tick and its contacts.
            .chunk_size(None)
            .disable_seeking(true)
            .create(NoSeek::new(out))
            .map_err(plain)?;
        let begin = |mcap: &mut Writer<NoSeek<W>>| {
            mcap.write_metadata(&metadata)?;
            let mut channel = |topic, name, schema: &str| {
                let schema = mcap.add_schema(name, SCHEMA_ENCODING, schema.as_bytes())?;
                mcap.add_channel(schema, topic, MESSAGE_ENCODING, &BTreeMap::new())
            };
            let channels = (
                channel(TICK_TOPIC, schema::TICK, &schema::tick())?,
                channel(CONTACT_TOPIC, schema::CONTACT, &schema::contact())?,
                channel(EVENT_TOPIC, schema::EVENT, &schema::event())?,
                channel(BODY_TOPIC, schema::BODY, &schema::body())?,
            );
            // Write the channels, so that a recording without ticks has them too.
            mcap.flush()?;
            Ok(channels)
        };
        match begin(&mut mcap) {
            Ok((tick_channel, contact_channel, event_channel, body_channel)) => Ok(Self {
                mcap: Some(mcap),
                tick_channel,
                contact_channel,
                event_channel,
                body_channel,
                device_channel: None,
                in_chunk: 0,
                last_sequence: None,
                ticks: 0,
                events: 0,
                message: Vec::new(),
            }),
            Err(error) => {
                // Dropping the writer would write an end.
                drop(mcap.into_inner());
                Err(plain(error))
            }
        }
    }

    /// Appends a tick, preceded by its devices and followed by its contacts and its bodies. All of them are in the
    /// same chunk, so that none exists without the others.
    pub fn append(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
        devices: &[DeviceTick],
    ) -> io::Result<()> {
        if let Some(last) = self.last_sequence.filter(|last| tick.sequence <= *last) {
            return Err(invalid(format!(
                "tick {} does not come after tick {last}; tick numbers must increase",
                tick.sequence
            )));
        }
        if !devices.is_empty() {
            self.append_devices(tick, devices)?;
        }
        self.message.clear();
        encode_tick(&tick.with(contacts, bodies), &mut self.message);
        self.write(self.tick_channel, tick.sequence, tick.time)?;
        for (number, contact) in (0..).zip(contacts) {
            let numbered = ContactTick {
                sequence: tick.sequence,
                contact: number,
                ..*contact
            };
            self.message.clear();
            encode_contact(&numbered, &mut self.message);
            self.write(self.contact_channel, tick.sequence, tick.time)?;
        }
        for body in bodies {
            let numbered = BodyTick {
                sequence: tick.sequence,
                ..*body
            };
            self.message.clear();
            encode_body(&numbered, &mut self.message);
            self.write(self.body_channel, tick.sequence, tick.time)?;
        }
        self.last_sequence = Some(tick.sequence);
        self.ticks += 1;
        self.end_full_chunk()
    }

    fn append_devices(&mut self, tick: &Tick, devices: &[DeviceTick]) -> io::Result<()> {
        let channel = match self.device_channel {
            Some(channel) => channel,
            None => self.begin_devices()?,
        };
        let number = u32::try_from(devices.len()).unwrap_or(u32::MAX);
        for (place, device) in (0..).zip(devices) {
            let numbered = DeviceTick {
                sequence: tick.sequence,
                device: place,
                devices: number,
                ..*device
            };
            self.message.clear();
            encode_device(&numbered, &mut self.message);
            self.write(channel, tick.sequence, tick.time)?;
        }
        Ok(())
    }

    /// Creates the channel of the devices, which a recording of a loop with one device lacks.
    fn begin_devices(&mut self) -> io::Result<u16> {
        let mut channel = 0;
        self.with(|mcap, _| {
            let text = schema::device();
            let schema = mcap.add_schema(schema::DEVICE, SCHEMA_ENCODING, text.as_bytes())?;
            channel = mcap.add_channel(schema, DEVICE_TOPIC, MESSAGE_ENCODING, &BTreeMap::new())?;
            Ok(())
        })?;
        self.device_channel = Some(channel);
        Ok(channel)
    }

    pub fn event(&mut self, event: &Event) -> io::Result<()> {
        let length = event.kind.len() + event.text.len();
        if length > LONGEST_TEXT {
            return Err(invalid(format!(
                "the event has {length} bytes of text; at most {LONGEST_TEXT} fit"
            )));
        }
        self.message.clear();
        event.encode(&mut self.message);
        self.write(self.event_channel, event.sequence, event.time)?;
        self.events += 1;
        self.end_full_chunk()
    }

    /// Ends the chunk: the output has received all of it on return.
    pub fn flush(&mut self) -> io::Result<()> {
        self.in_chunk = 0;
        self.with(|mcap, _| mcap.flush())
    }

    fn end_full_chunk(&mut self) -> io::Result<()> {
        if self.in_chunk < CHUNK {
            return Ok(());
        }
        self.flush()
    }

    /// Writes the counters of the loop.
    pub fn count(&mut self, count: &LoopCount) -> io::Result<()> {
        let record = count.to_metadata();
        self.with(|mcap, _| mcap.write_metadata(&record))
    }

    /// Completes the file and returns the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.with(|mcap, _| mcap.finish().map(drop))?;
        let mcap = self.mcap.take().ok_or_else(failed_before)?;
        Ok(mcap.into_inner().into_inner())
    }

    fn write(&mut self, channel_id: u16, sequence: u64, time: f64) -> io::Result<()> {
        let log_time = nanoseconds(time);
        let header = MessageHeader {
            channel_id,
            // The message itself contains the full number.
            sequence: u32::try_from(sequence & u64::from(u32::MAX)).expect("32 bits"),
            log_time,
            publish_time: log_time,
        };
        self.in_chunk += self.message.len();
        self.with(|mcap, message| mcap.write_to_known_channel(&header, message))
    }

    /// Calls `act` with the writer, which is not used again after a failure.
    fn with(
        &mut self,
        act: impl FnOnce(&mut Writer<NoSeek<W>>, &[u8]) -> McapResult<()>,
    ) -> io::Result<()> {
        let mut mcap = self.mcap.take().ok_or_else(failed_before)?;
        let outcome = act(&mut mcap, &self.message);
        if outcome.is_ok() {
            self.mcap = Some(mcap);
        } else {
            // Dropping the writer would write an end.
            drop(mcap.into_inner());
        }
        outcome.map_err(plain)
    }
}

impl<W: Write> Drop for Stream<W> {
    /// Keeps the appended data without writing an end, because the recording was not finished.
    fn drop(&mut self) {
        if let Some(mut mcap) = self.mcap.take() {
            let _ = mcap.flush();
            drop(mcap.into_inner());
        }
    }
}

/// Appends the message of a tick: its columns in their order, each aligned to its size.
pub(super) fn encode_tick(tick: &Tick, message: &mut Vec<u8>) {
    let row = Row {
        tick: *tick,
        ..Row::UNKNOWN
    };
    encode(Tick::COLUMNS, &row, message);
}

/// Appends the message of a contact in the same way.
pub(super) fn encode_contact(contact: &ContactTick, message: &mut Vec<u8>) {
    let row = Row {
        contact: *contact,
        ..Row::UNKNOWN
    };
    encode(ContactTick::COLUMNS, &row, message);
}

/// Appends the message of a body in the same way.
pub(super) fn encode_body(body: &BodyTick, message: &mut Vec<u8>) {
    let row = Row {
        body: *body,
        ..Row::UNKNOWN
    };
    encode(BodyTick::COLUMNS, &row, message);
}

/// Appends the message of a device in the same way.
pub(super) fn encode_device(device: &DeviceTick, message: &mut Vec<u8>) {
    let row = Row {
        device: *device,
        ..Row::UNKNOWN
    };
    encode(DeviceTick::COLUMNS, &row, message);
}

fn encode(columns: &[Column], row: &Row, message: &mut Vec<u8>) {
    let mut out = cdr::Writer::begin(message);
    for column in columns {
        column.value(row).encode(&mut out);
    }
}

/// Converts a time since the start to that of MCAP; an invalid time becomes 0.
fn nanoseconds(time: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float becomes the nearest number there is"
    )]
    let nanoseconds = (time * 1e9).round() as u64;
    nanoseconds
}

fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

fn failed_before() -> io::Error {
    io::Error::other("an earlier part could not be written")
}

/// Returns the error of the system, if there is one.
fn plain(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::super::samples::row;
    use super::*;

    /// A disk with a capacity of `room` bytes.
    #[derive(Clone)]
    struct Disk {
        room: usize,
        bytes: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut disk = self.bytes.lock().unwrap();
            let fits = bytes.len().min(self.room - disk.len());
            if fits == 0 && !bytes.is_empty() {
                return Err(io::ErrorKind::StorageFull.into());
            }
            disk.extend(&bytes[..fits]);
            Ok(fits)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn append(stream: &mut Stream<Disk>, sequence: u64) -> io::Result<()> {
        let Row { tick, contact, .. } = row(sequence, 0);
        stream.append(&tick, &[contact], &[], &[])
    }

    /// Records until a write fails; returns the number of flushed ticks, or the error of writing the end.
    fn record(disk: &Disk) -> io::Result<u64> {
        let metadata = RecordingMetadata::new("0.1.0").with("scene", "a = 1");
        let mut stream = Stream::begin(disk.clone(), &metadata)?;
        let mut outcome = Ok(());
        for sequence in 0..6 {
            outcome = append(&mut stream, sequence).and_then(|()| stream.flush());
            if let Err(error) = &outcome {
                assert_eq!(error.kind(), io::ErrorKind::StorageFull);
                let again = append(&mut stream, 9).unwrap_err().to_string();
                assert_eq!(again, "an earlier part could not be written");
                assert_eq!(
                    stream.flush().unwrap_err().to_string(),
                    "an earlier part could not be written"
                );
                break;
            }
        }
        let ticks = stream.ticks;
        let finished = stream.finish();
        assert!(outcome.is_ok() || finished.is_err());
        finished.map(|_| ticks)
    }

    #[test]
    fn wherever_the_disk_is_full_an_error_says_so_and_no_end_is_written() {
        let disk = |room| Disk {
            room,
            bytes: Arc::default(),
        };
        let whole = disk(usize::MAX);
        assert_eq!(record(&whole).unwrap(), 6);
        let size = whole.bytes.lock().unwrap().len();
        for room in 0..size {
            let full = disk(room);
            record(&full).unwrap_err();
            let written = full.bytes.lock().unwrap();
            assert!(whole.bytes.lock().unwrap().starts_with(&written), "{room}");
        }
        assert_eq!(record(&disk(size)).unwrap(), 6);
    }

    #[test]
    fn a_time_that_is_none_is_no_fault() {
        assert_eq!(nanoseconds(1.5), 1_500_000_000);
        assert_eq!([nanoseconds(f64::NAN), nanoseconds(-1.0)], [0, 0]);
        assert_eq!(nanoseconds(f64::INFINITY), u64::MAX);
    }
}

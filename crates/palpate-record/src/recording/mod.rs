//! Recordings of a device loop, tick by tick, written while the loop runs.
//!
//! A recording is an [MCAP](https://mcap.dev) file, so Foxglove and PlotJuggler can open it. Its first record is the
//! [`RecordingMetadata`], the metadata: the configuration as text. Then follow in chunks with checksums: [`Tick`]s on
//! the channel `/tick`, the [`ContactTick`]s of each tick on `/contact`, the [`BodyTick`]s of a world on `/body`, the
//! [`DeviceTick`]s of a loop with several devices on `/device`, and [`Event`]s on `/event`.
//! `docs/reference/recording.md` documents every byte. An unfinished recording is called `NAME.part`. Data handed on by
//! [`RecordingWriter::flush`] survive the program. [`RecordingWriter::count`] writes the counters of the loop
//! ([`LoopCount`]), and [`RecordingWriter::finish`] then gives the file its name.
//!
//! [`Recording::open`] reads the available part of a recording and reports missing data: lost ticks by their numbers,
//! a truncated end, and damaged chunks.
//!
//! ```
//! use palpate_record::recording::{ContactTick, RecordingMetadata, Recording, RecordingWriter, Tick};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("tap.mcap");
//!
//! let metadata = RecordingMetadata::new("0.1.0").with("scene", "format = 2");
//! let mut writer = RecordingWriter::create(&path, &metadata)?;
//! // Two contacts; a loop that touches one thing has one.
//! writer.append(&Tick::default(), &[ContactTick::default(), ContactTick::default()])?;
//! writer.finish()?;
//!
//! let recording = Recording::open(&path)?;
//! assert!(recording.is_whole());
//! let mut rows = recording.rows()?;
//! let last = rows.by_ref().last().transpose()?.unwrap_or_default();
//! assert_eq!((last.tick.sequence, last.contact.contact), (0, 1));
//! let _penetration = last.contact.penetration; // [m]
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body;
mod cdr;
mod chunk;
mod column;
mod contact;
mod count;
mod csv;
mod device;
mod event;
mod export;
mod frames;
mod gather;
mod layout;
mod loss;
mod metadata;
#[cfg(feature = "parquet")]
mod parquet;
mod read;
mod row;
#[cfg(test)]
mod samples;
mod schema;
mod state;
mod stream;
mod table;
mod tick;
mod unpack;
mod walk;
mod write;

/// First bytes of every recording, finished or not.
pub const BEGINS: &[u8] = mcap::MAGIC;

/// Start of a message about damage to the file as a whole, which removes no data.
pub const WHOLE: &str = "the file as a whole";
/// Metadata entry with the names of several devices, one per line in the order of their numbers.
pub const DEVICES: &str = "devices";

pub use body::BodyTick;
pub use column::{Column, Kind, Shown, Value};
pub use contact::ContactTick;
pub use count::{LoopCount, LoopTime};
pub use device::DeviceTick;
pub use event::Event;
pub use loss::Gap;
pub use metadata::RecordingMetadata;
pub use read::{Entries, Entry, Recording, RecordingError, Rows};
pub use row::Row;
pub use state::{Flags, Phase};
pub use table::columns;
pub use tick::Tick;
pub use write::{RecordingWriter, Summary};

/// Version of the format.
const VERSION: u32 = 2;
/// Topics of the channels.
const TICK_TOPIC: &str = "/tick";
const CONTACT_TOPIC: &str = "/contact";
const BODY_TOPIC: &str = "/body";
const DEVICE_TOPIC: &str = "/device";
const EVENT_TOPIC: &str = "/event";
/// Encoding of messages and of their types.
const MESSAGE_ENCODING: &str = "cdr";
const SCHEMA_ENCODING: &str = "ros2msg";
/// Largest accepted record [bytes].
const LONGEST_RECORD: u64 = 64 << 20;

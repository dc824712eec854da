//! Recordings: what a loop with a device really did, tick by tick, as it happens.
//!
//! A recording is an [MCAP](https://mcap.dev) file, so Foxglove and PlotJuggler show it as it is.
//! Its first record is the [`Receipt`]: the configuration as text. After it come [`Tick`]s on the
//! channel `/tick`, the [`ContactTick`]s of each tick on `/contact`, the [`BodyTick`]s of a world on `/body`, the
//! [`DeviceTick`]s of a loop with several devices on `/device`, and [`Event`]s on `/event`, in chunks with checksums; `docs/formats.md` has every byte. A live recording is called `NAME.part`. What [`RecordingWriter::flush`] has handed on
//! outlives the program, and [`RecordingWriter::finish`] gives the file its name. Before it,
//! [`RecordingWriter::count`] writes what the loop itself counted ([`LoopCount`]).
//!
//! [`Recording::open`] reads whatever there is of one, and says what is not there: ticks that were
//! lost, by their numbers, an end that was cut off, and chunks that are not what was written.
//!
//! ```
//! use palpate_record::recording::{ContactTick, Receipt, Recording, RecordingWriter, Tick};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("tap.mcap");
//!
//! let receipt = Receipt::new("0.1.0").with("scene", "scene_format = 1");
//! let mut writer = RecordingWriter::create(&path, &receipt)?;
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
#[cfg(feature = "parquet")]
mod parquet;
mod read;
mod receipt;
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

/// The bytes with which every recording begins, finished or not.
pub const BEGINS: &[u8] = mcap::MAGIC;

/// How damage begins that is of the file as a whole: nothing is left out for it.
pub const WHOLE: &str = "the file as a whole";
/// Text of the receipt of a loop with several devices that has their names, a line each, in the order of their numbers.
pub const DEVICES: &str = "devices";

pub use body::BodyTick;
pub use column::{Column, Kind, Shown, Value};
pub use contact::ContactTick;
pub use count::{LoopCount, LoopTime};
pub use device::DeviceTick;
pub use event::Event;
pub use loss::Gap;
pub use read::{Entries, Entry, Recording, RecordingError, Rows};
pub use receipt::Receipt;
pub use row::Row;
pub use state::{Flags, Phase};
pub use table::columns;
pub use tick::Tick;
pub use write::{RecordingWriter, Summary};

/// The version that is written.
const VERSION: u32 = 2;
/// The versions that are read.
const READ: [u32; 2] = [1, VERSION];
/// Topics of the channels.
const TICK_TOPIC: &str = "/tick";
const CONTACT_TOPIC: &str = "/contact";
const BODY_TOPIC: &str = "/body";
const DEVICE_TOPIC: &str = "/device";
const EVENT_TOPIC: &str = "/event";
/// How messages are encoded, and how their types are written down.
const MESSAGE_ENCODING: &str = "cdr";
const SCHEMA_ENCODING: &str = "ros2msg";
/// Longest record that is written or believed [bytes].
const LONGEST_RECORD: u64 = 64 << 20;

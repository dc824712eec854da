//! Recordings: what a loop with a device really did, tick by tick, as it happens.
//!
//! A recording is an [MCAP](https://mcap.dev) file, so Foxglove and PlotJuggler show it as it is.
//! Its first record is the [`Receipt`]: the configuration as text. After it come [`Tick`]s on the
//! channel `/tick` and [`Event`]s on `/event`, in chunks with checksums; `docs/formats.md` has every
//! byte. A live recording is called `NAME.part`. What [`RecordingWriter::flush`] has handed on
//! outlives the program, and [`RecordingWriter::finish`] gives the file its name. Before it,
//! [`RecordingWriter::count`] writes what the loop itself counted ([`LoopCount`]).
//!
//! [`Recording::open`] reads whatever there is of one, and says what is not there: ticks that were
//! lost, by their numbers, an end that was cut off, and chunks that are not what was written.
//!
//! ```
//! use palpate_record::recording::{Entry, Receipt, Recording, RecordingWriter};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("tap.mcap");
//! # let tick = palpate_record::recording::Tick::default();
//!
//! let receipt = Receipt::new("0.1.0").with("scene", "scene_format = 1");
//! let mut writer = RecordingWriter::create(&path, &receipt)?;
//! writer.append(&tick)?;
//! writer.finish()?;
//!
//! let recording = Recording::open(&path)?;
//! assert!(recording.is_whole());
//! for entry in recording.entries()? {
//!     if let Entry::Tick(tick) = entry? {
//!         let _penetration = tick.penetration; // [m]
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cdr;
mod chunk;
mod column;
mod count;
mod csv;
mod event;
mod export;
mod frames;
mod layout;
mod loss;
#[cfg(feature = "parquet")]
mod parquet;
mod read;
mod receipt;
mod schema;
mod state;
mod stream;
mod tick;
mod unpack;
mod walk;
mod write;

/// How damage begins that is of the file as a whole: nothing is left out for it.
pub const WHOLE: &str = "the file as a whole";

pub use column::{Column, Kind, Value};
pub use count::{LoopCount, LoopTime};
pub use event::Event;
pub use loss::Gap;
pub use read::{Entries, Entry, Recording, RecordingError};
pub use receipt::Receipt;
pub use state::{Flags, Phase};
pub use tick::{COLUMNS, Tick};
pub use write::{RecordingWriter, Summary};

/// The version that is written and read.
const VERSION: u32 = 1;
/// Topics of the two channels.
const TICK_TOPIC: &str = "/tick";
const EVENT_TOPIC: &str = "/event";
/// How messages are encoded, and how their types are written down.
const MESSAGE_ENCODING: &str = "cdr";
const SCHEMA_ENCODING: &str = "ros2msg";
/// Longest record that is written or believed [bytes].
const LONGEST_RECORD: u64 = 64 << 20;

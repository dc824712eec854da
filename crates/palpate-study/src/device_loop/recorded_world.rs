//! World and device paths of a recorded loop, for rendering them again.

use crate::recording::{WorldPathError, world_path};
use crate::text::counted;
use palpate_record::recording::Recording;
use palpate_rt::{NoFrame, frames_of_devices};
use palpate_scene::world::WorldFile;
use palpate_scene::{Edit, SceneErrors, Source};
use palpate_testbed::world::LedPath;

/// A world rendered by a recorded loop, with its device paths.
#[derive(Clone, Debug)]
pub struct RecordedWorld {
    /// The world in its initial state. Its devices have the axes of the recorded devices: the motors cannot push
    /// along a missing axis, so that axis is not evaluated.
    pub file: WorldFile,
    /// Positions and orientations of the devices over time.
    pub path: LedPath,
    /// Number of ticks without a position of each device; the path interpolates linearly over them.
    pub without_position: u64,
}

/// Reason why a recorded world cannot be rendered again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordedWorldError {
    /// The recording contains no world.
    #[error("{0}: recording of one contact, not of a world")]
    OneContact(String),
    /// The recorded world is invalid.
    #[error(transparent)]
    World(#[from] SceneErrors),
    /// The recording lacks the frame of a device.
    #[error("{name}: {error}")]
    NoFrame {
        /// Name of the recording.
        name: String,
        /// The missing frame and its device.
        error: NoFrame,
    },
    /// The recorded path is not a valid motion.
    #[error(transparent)]
    Path(#[from] WorldPathError),
}

impl RecordedWorld {
    /// Name of the metadata text that contains the world; a recording of one contact lacks it.
    pub const TEXT: &str = "world";

    /// Reads the world of a recording. Mesh files are searched beside the recording.
    ///
    /// # Errors
    /// The recording is of one contact, or a part of its world is missing or invalid.
    pub fn new(recording: &Recording) -> Result<Self, RecordedWorldError> {
        Self::edited(recording, &[])
    }

    /// Reads the world of a recording with `edits`, as [`new`](Self::new) does.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn edited(recording: &Recording, edits: &[Edit]) -> Result<Self, RecordedWorldError> {
        let name = recording.path().display().to_string();
        let Some(text) = recording.metadata.texts.get(Self::TEXT) else {
            return Err(RecordedWorldError::OneContact(name));
        };
        // The devices follow the recording, without hands. Traces of hands are in the folder of the scene.
        let mut file = WorldFile::parse_led(&Source::new(&name, text).edited(edits))?;
        let tools = file.scene.world.tools.iter();
        let names: Vec<_> = tools.map(|tool| tool.name.as_str()).collect();
        let frames = frames_of_devices(&recording.metadata, &names)
            .map_err(|error| RecordedWorldError::NoFrame { name, error })?;
        for (number, frame) in frames.iter().enumerate() {
            let axes = [0, 1, 2].map(|axis| frame.has(axis));
            file.scene = file.scene.with_axes(number, axes);
        }
        let devices = file.scene.devices.iter();
        let turns: Vec<bool> = devices.map(|device| device.turning.is_some()).collect();
        let in_world = |device: usize, place| frames[device].in_world(place);
        let (path, without_position) = world_path(recording, &turns, in_world)?;
        Ok(Self {
            file,
            path,
            without_position,
        })
    }

    /// Returns a sentence with the number of ticks without a position of each device; `None` if all ticks have one.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        let ticks = counted(self.without_position, "tick");
        (self.without_position > 0)
            .then(|| format!("{ticks} without a position, linearly interpolated"))
    }
}

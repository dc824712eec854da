//! What the recording of a loop that rendered a world holds, to be rendered again.

use palpate_record::recording::Recording;
use palpate_rt::{NoFrame, frames_of_devices};
use palpate_scene::SceneErrors;
use palpate_scene::world::WorldFile;
use palpate_study::recording::{WorldPathError, world_path};
use palpate_study::text::counted;
use palpate_testbed::world::LedPath;

/// A world that a loop rendered, and where its devices went.
#[derive(Clone, Debug)]
pub struct RecordedWorld {
    /// The world, as it begins. Its devices have the axes that the recorded ones had: their motors could not push along an axis
    /// that they lack, so nothing is judged there.
    pub file: WorldFile,
    /// Where the devices went, and how they were turned.
    pub path: LedPath,
    /// How many ticks have no position of each device: straight lines stand there.
    pub without_position: u64,
}

/// Why a recorded world cannot be rendered again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordedWorldError {
    /// The recording is of no world.
    #[error("{0}: it is a recording of one contact")]
    OneContact(String),
    /// The world that it holds is not one.
    #[error(transparent)]
    World(#[from] SceneErrors),
    /// It does not say where a device stood.
    #[error("{name}: {error}")]
    NoFrame {
        /// The recording.
        name: String,
        /// Which device.
        error: NoFrame,
    },
    /// Where the devices went is no motion.
    #[error(transparent)]
    Path(#[from] WorldPathError),
}

impl RecordedWorld {
    /// Text of the receipt that holds the world; a recording without it is of one contact.
    pub const TEXT: &str = "world";

    /// The world of a recording. Files of meshes are looked for beside the recording.
    ///
    /// # Errors
    /// A recording of one contact, or one that lacks something of its world.
    pub fn of(recording: &Recording) -> Result<Self, RecordedWorldError> {
        let name = recording.path().display().to_string();
        let Some(text) = recording.receipt.texts.get(Self::TEXT) else {
            return Err(RecordedWorldError::OneContact(name));
        };
        let mut file = WorldFile::parse(&name, text)?;
        let tools = file.scene.world.tools.iter();
        let names: Vec<_> = tools.map(|tool| tool.name.as_str()).collect();
        let frames = frames_of_devices(&recording.receipt, &names)
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

    /// Says how many ticks have no position of each device; none if all have one.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        let ticks = counted(self.without_position, "tick");
        (self.without_position > 0)
            .then(|| format!("{ticks} without a position; straight lines stand there"))
    }
}

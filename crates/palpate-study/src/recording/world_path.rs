//! Where the device of a recorded world went.

use palpate_record::recording::{Flags, Recording, RecordingError};
use palpate_testbed::world::LedPath;

/// Why the motion of a recorded world cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldPathError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// What is recorded is no motion.
    #[error("{name}: {why}")]
    NoMotion {
        /// The recording.
        name: String,
        /// Why, in words.
        why: String,
    },
}

/// Where the one device of a recorded world went, and if it `turns` how it was turned, with how many ticks have no position:
/// straight lines stand there. `in_world` turns what the device measured `[m]` into a place in the world `[m]`; a device that turns
/// has the axes of the world.
///
/// # Errors
/// What cannot be read; a recording that is no motion.
pub fn world_path(
    recording: &Recording,
    turns: bool,
    in_world: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<(LedPath, u64), WorldPathError> {
    let (mut times, mut positions): (Vec<f64>, Vec<_>) = (Vec::new(), Vec::new());
    let mut orientations = Vec::new();
    let mut start = 0.0;
    let mut without = 0_u64;
    let mut last = None;
    for row in recording.rows()? {
        let tick = row?.tick;
        if last.replace(tick.sequence) == Some(tick.sequence) {
            continue;
        }
        let is_turned = tick.device_orientation.iter().all(|part| part.is_finite());
        if tick.flags.has(Flags::DEVICE_FAULT)
            || tick.device_axes[0].is_nan()
            || (turns && !is_turned)
        {
            without += 1;
            continue;
        }
        if times.is_empty() {
            start = tick.time;
        }
        times.push(tick.time - start);
        // An axis that the device has not is none of the frame's.
        let measured = tick.device_axes.map(|x| if x.is_nan() { 0.0 } else { x });
        positions.push(vec![in_world(measured)]);
        orientations.push(vec![tick.device_orientation]);
    }
    let mut path = LedPath::new(times, positions);
    if turns {
        path = path.and_then(|path| path.turned(orientations));
    }
    let path = path.map_err(|error| WorldPathError::NoMotion {
        name: recording.path().display().to_string(),
        why: error.to_string(),
    })?;
    Ok((path, without))
}

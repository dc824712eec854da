//! Device paths of a recorded world.

use palpate_record::recording::{Entry, Flags, Recording, RecordingError};
use palpate_testbed::world::LedPath;

use crate::text::counted;

/// Reason why the motion of a recorded world cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldPathError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording contains no valid motion.
    #[error("{name}: {why}")]
    NoMotion {
        /// The recording.
        name: String,
        /// Reason in words.
        why: String,
    },
}

/// Returns the paths of the devices of a recorded world, with the orientations of the devices selected by `turns`,
/// and the number of ticks without a position of each device. The path interpolates linearly over these ticks.
/// `in_world` converts the measured position `[m]` of a device, given by its number, to world coordinates `[m]`; a
/// device with orientation uses the axes of the world.
///
/// # Errors
/// The recording cannot be read, or it contains no valid motion.
pub fn world_path(
    recording: &Recording,
    turns: &[bool],
    in_world: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> Result<(LedPath, u64), WorldPathError> {
    let (mut times, mut positions): (Vec<f64>, Vec<_>) = (Vec::new(), Vec::new());
    let mut orientations = Vec::new();
    let mut start = 0.0;
    let mut without = 0_u64;
    for entry in recording.entries()? {
        let Entry::Tick(tick, _, _, several) = entry? else {
            continue;
        };
        let devices: Vec<_> = if several.is_empty() {
            vec![(tick.device_axes, tick.device_orientation)]
        } else {
            let of = several
                .iter()
                .map(|device| (device.axes, device.orientation));
            of.collect()
        };
        let is_known = |((axes, orientation), turns): (&([f64; 3], [f64; 4]), &bool)| {
            let is_turned = orientation.iter().all(|part| part.is_finite());
            !axes[0].is_nan() && (!turns || is_turned)
        };
        let are_known = devices.len() == turns.len() && devices.iter().zip(turns).all(is_known);
        if tick.flags.has(Flags::DEVICE_FAULT) || !are_known {
            without += 1;
            continue;
        }
        if times.is_empty() {
            start = tick.time;
        }
        times.push(tick.time - start);
        let places = devices.iter().enumerate().map(|(number, (axes, _))| {
            // An axis that the device lacks does not contribute to the frame.
            in_world(number, axes.map(|x| if x.is_nan() { 0.0 } else { x }))
        });
        positions.push(places.collect::<Vec<_>>());
        let turned = devices.iter().zip(turns).map(|((_, orientation), turns)| {
            if *turns {
                *orientation
            } else {
                [1.0, 0.0, 0.0, 0.0]
            }
        });
        orientations.push(turned.collect::<Vec<_>>());
    }
    if times.len() < 2 {
        return Err(WorldPathError::NoMotion {
            name: recording.path().display().to_string(),
            why: few(recording, times.len()),
        });
    }
    let mut path = LedPath::new(times, positions);
    if turns.contains(&true) {
        path = path.and_then(|path| path.turned(orientations));
    }
    let path = path.map_err(|error| WorldPathError::NoMotion {
        name: recording.path().display().to_string(),
        why: error.to_string(),
    })?;
    Ok((path, without))
}

/// Explains why a recording has too few positions for a motion.
fn few(recording: &Recording, positions: usize) -> String {
    let lost = match recording.lost() {
        0 => String::new(),
        lost => format!("; {} lost", counted(lost, "tick")),
    };
    let read = counted(recording.ticks, "readable tick");
    format!("{positions} of {read} with a position of every device{lost}; a motion needs 2")
}

//! Adds the scene to the metadata of a recording.

use std::collections::BTreeMap;
use std::path::Path;

use palpate_record::files::bounded::SCENE;
use palpate_record::recording::RecordingMetadata;
use palpate_scene::{ContactFile, Scene, SceneErrors, beside};

/// Reason why metadata cannot contain a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PutSceneError {
    /// The scene file cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// The scene file is no longer valid.
    #[error(transparent)]
    Invalid(#[from] SceneErrors),
    /// The scene names other files and differs from its file.
    #[error(
        "{name}: {why}, so a recording can contain this scene only as in its file; put the changes of the flags into \
         the file"
    )]
    Changed {
        /// The file.
        name: String,
        /// Reason why it cannot be written.
        why: String,
    },
}

/// Metadata entry with the renderer's model values of the device.
const TOLD: &str = "model";

/// Returns the model values of the device in the renderer of `scene`, one line `key = value` each.
fn model(scene: &Scene) -> String {
    let model = scene.model_actuation();
    let mass = scene.model_device_mass.unwrap_or(scene.device.mass());
    let transmission = model.transmission.map(|it| {
        [
            ("resonance_hz", it.resonance),
            ("resonance_damping_ratio", it.damping_ratio),
            ("flexible_mass_fraction", it.flexible_mass_fraction),
        ]
    });
    [
        ("device_mass_kg", mass),
        ("delay_s", model.delay),
        ("lag_s", model.lag),
        ("gain", model.gain),
        ("delay_deviation_s", model.delay_deviation),
        ("lag_deviation_s", model.lag_deviation),
        ("gain_deviation", model.gain_deviation),
    ]
    .into_iter()
    .chain(transmission.into_iter().flatten())
    .map(|(key, value)| format!("{key} = {value}\n"))
    .collect()
}

/// Returns the metadata with the scene as it is run, and with the files that it names. `file` is the scene file at
/// `path`, which `scene` comes from.
///
/// # Errors
/// The file cannot be read, or the scene names other files and was changed.
pub fn put_scene(
    metadata: RecordingMetadata,
    scene: &Scene,
    path: &Path,
) -> Result<RecordingMetadata, PutSceneError> {
    let metadata = metadata.with(TOLD, &model(scene));
    let unwritable = match scene.to_toml() {
        Ok(text) => return Ok(metadata.with("scene", &text)),
        Err(unwritable) => unwritable,
    };
    // A scene that names other files is stored as its file text, together with these files.
    let name = path.display().to_string();
    let text = SCENE
        .text(path)
        .map_err(|error| PutSceneError::Unreadable(format!("{name}: {error}")))?;
    let mut named = BTreeMap::new();
    let mut read = beside(path);
    let mut reads = |file: &str| {
        let text = read(file)?;
        named.insert(file.to_owned(), text.clone());
        Ok(text)
    };
    let as_it_stands = ContactFile::parse_with(&name, &text, &mut reads)?.scene;
    if as_it_stands != *scene {
        let why = unwritable.to_string();
        return Err(PutSceneError::Changed { name, why });
    }
    Ok(named
        .iter()
        .fold(metadata.with("scene", &text), |metadata, (file, text)| {
            metadata.with_file(file, text)
        }))
}

//! The scene of a recording.

use std::io;

use palpate_record::recording::Recording;
use palpate_scene::{ContactFile, Edit, SceneErrors, Source};

/// Metadata entry that contains the scene.
const SCENE: &str = "scene";

/// Reason why a recording has no scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoScene {
    /// The metadata contain no scene.
    #[error("{0}: metadata entry `{SCENE}` is missing, so the contact parameters are unknown")]
    Missing(String),
    /// The scene in the metadata is invalid.
    #[error(transparent)]
    Invalid(#[from] SceneErrors),
}

/// Returns the scene of `recording` and the files that it names.
///
/// # Errors
/// The recording contains no scene, or an invalid one.
pub fn scene_of(recording: &Recording) -> Result<ContactFile, NoScene> {
    scene_edited(recording, &[])
}

/// Returns the scene of `recording` with `edits`, as [`scene_of`] does.
///
/// # Errors
/// Those of [`scene_of`].
pub fn scene_edited(recording: &Recording, edits: &[Edit]) -> Result<ContactFile, NoScene> {
    let name = recording.path().display().to_string();
    let metadata = &recording.metadata;
    let Some(text) = metadata.texts.get(SCENE) else {
        return Err(NoScene::Missing(name));
    };
    let mut files = |file: &str| {
        metadata.file(file).map(str::to_owned).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::NotFound,
                "it is not in the recording's metadata",
            )
        })
    };
    let source = Source::new(&format!("{name} ({SCENE})"), text).edited(edits);
    Ok(ContactFile::parse_edited(&source, &mut files)?)
}

//! The scene of a recording.

use std::io;

use palpate_record::recording::Recording;
use palpate_scene::{SceneErrors, SceneFile};

/// Text of the receipt that holds the scene.
const SCENE: &str = "scene";

/// Why a recording has no scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoScene {
    /// Its receipt does not have one.
    #[error("{0}: its receipt has no text called {SCENE}, so nothing says what the contact was")]
    Missing(String),
    /// The one that it has is no scene.
    #[error(transparent)]
    Invalid(#[from] SceneErrors),
}

/// The scene that `recording` was made with, and what it names.
///
/// # Errors
/// The recording does not have it, or it is none.
pub fn scene_of(recording: &Recording) -> Result<SceneFile, NoScene> {
    let name = recording.path().display().to_string();
    let receipt = &recording.receipt;
    let Some(text) = receipt.texts.get(SCENE) else {
        return Err(NoScene::Missing(name));
    };
    let mut files = |file: &str| {
        receipt.file(file).map(str::to_owned).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::NotFound,
                "it is not in the recording's receipt",
            )
        })
    };
    Ok(SceneFile::parse_with(
        &format!("{name} ({SCENE})"),
        text,
        &mut files,
    )?)
}

//! The committed scenes.

use std::path::{Path, PathBuf};

use palpate_scene::{ContactFile, Scene, beside};

/// Folder of the committed scenes.
pub fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments")
}

/// A scene of `experiments/`.
pub fn scene(name: &str) -> Scene {
    let path = experiments().join(name).with_extension("toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    match ContactFile::parse_with(name, &text, &mut beside(&path)) {
        Ok(file) => file.scene,
        Err(error) => panic!("{error}"),
    }
}

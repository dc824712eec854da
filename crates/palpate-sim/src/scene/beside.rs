//! Files that a scene names.

use std::io;
use std::path::{Path, PathBuf};

/// Gives the text of a file by the name that stands in a scene.
pub(super) type Files<'a> = &'a mut dyn FnMut(&str) -> io::Result<String>;

/// The files beside the scene file at `scene`: names count from the folder it stands in.
pub fn beside(scene: &Path) -> impl FnMut(&str) -> io::Result<String> {
    let folder = scene.parent().map(PathBuf::from).unwrap_or_default();
    move |name| std::fs::read_to_string(folder.join(name))
}

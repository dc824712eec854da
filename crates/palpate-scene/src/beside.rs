//! Files that a scene names.

use std::io;
use std::path::{Path, PathBuf};

use palpate_files::bounded::{SCENE, TABLE};

/// Gives the text of a file by the name that stands in a scene.
pub(super) type Files<'a> = &'a mut dyn FnMut(&str) -> io::Result<String>;

/// What messages call a file that stands as `name` in the scene file called `scene`.
pub(super) fn beside_scene(scene: &str, name: &str) -> String {
    Path::new(scene).with_file_name(name).display().to_string()
}

/// The files beside the scene file at `scene`: names count from the folder it stands in.
pub fn beside(scene: &Path) -> impl FnMut(&str) -> io::Result<String> {
    let folder = scene.parent().map(PathBuf::from).unwrap_or_default();
    move |name| TABLE.text(&folder.join(name))
}

/// The bytes of the scene file at `path`.
///
/// # Errors
/// What the system says; a file that does not end within 16 MiB.
pub fn scene_bytes(path: &Path) -> io::Result<Vec<u8>> {
    SCENE.bytes(path)
}

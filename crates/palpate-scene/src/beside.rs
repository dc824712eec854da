//! Files that a scene names.

use std::io;
use std::path::{Path, PathBuf};

use palpate_record::files::bounded::{SCENE, TABLE};

/// Callback that reads the text of a file by its name in a scene.
pub(super) type Files<'a> = &'a mut dyn FnMut(&str) -> io::Result<String>;

/// Returns the display name of the file `name` that the scene file `scene` refers to.
pub(super) fn beside_scene(scene: &str, name: &str) -> String {
    Path::new(scene).with_file_name(name).display().to_string()
}

/// Returns a reader of the files next to the scene file at `scene`. Names are relative to the scene's folder.
pub fn beside(scene: &Path) -> impl FnMut(&str) -> io::Result<String> {
    let folder = scene.parent().map(PathBuf::from).unwrap_or_default();
    move |name| TABLE.text(&folder.join(name))
}

/// Reads the bytes of the scene file at `path`.
///
/// # Errors
/// An I/O error, or a file of more than 16 MiB.
pub fn scene_bytes(path: &Path) -> io::Result<Vec<u8>> {
    SCENE.bytes(path)
}

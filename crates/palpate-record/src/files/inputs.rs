//! Registry of the files read by this process, which prevents an [output](crate::files::outputs) from overwriting them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Names of the files that were read, by canonical path.
static READ: Mutex<BTreeMap<PathBuf, PathBuf>> = Mutex::new(BTreeMap::new());

fn read() -> MutexGuard<'static, BTreeMap<PathBuf, PathBuf>> {
    READ.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registers the file at `path` as read. [`bounded`](crate::files::bounded) registers the files that it reads.
pub fn note(path: &Path) {
    if let Ok(place) = path.canonicalize()
        && place.is_file()
    {
        read().entry(place).or_insert_with(|| path.to_owned());
    }
}

/// Returns the name under which the file at the canonical path `place` was read, if it was.
pub(crate) fn name_of(place: &Path) -> Option<PathBuf> {
    read().get(place).cloned()
}

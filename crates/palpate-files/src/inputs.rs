//! Which files this process has read, so that none of them becomes an [output](crate::outputs).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The names of the files that were read, by the place where each really is.
static READ: Mutex<BTreeMap<PathBuf, PathBuf>> = Mutex::new(BTreeMap::new());

fn read() -> MutexGuard<'static, BTreeMap<PathBuf, PathBuf>> {
    READ.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The file at `path` is read. Files that [`bounded`](crate::bounded) reads are noted there.
pub fn note(path: &Path) {
    if let Ok(place) = path.canonicalize()
        && place.is_file()
    {
        read().entry(place).or_insert_with(|| path.to_owned());
    }
}

/// The name under which the file at a `place` was read, if it was.
pub(crate) fn name_of(place: &Path) -> Option<PathBuf> {
    read().get(place).cloned()
}

//! The output files of a command: checked together before its work starts, written after it.
//!
//! ```
//! use palpate_record::files::atomic::Existing;
//! use palpate_record::files::outputs::Outputs;
//!
//! let folder = tempfile::tempdir()?;
//! let (table, figure) = (folder.path().join("run.csv"), folder.path().join("run.svg"));
//! let mut outputs = Outputs::new(Existing::Keep);
//! outputs.plan("--out", &table)?;
//! outputs.plan("--plot", &figure)?;
//! // The work is done here.
//! outputs.write(&table, |out| out.write_all(b"t_s,position_m\n"))?;
//! outputs.write(&figure, |out| out.write_all(b"<svg/>"))?;
//! // They are there now, so that a second run of the command is refused before its work.
//! assert!(Outputs::new(Existing::Keep).plan("--out", &table).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::atomic::{self, Existing, WriteError, directory_of, follow_links, is_stream};
use crate::files::inputs;

/// The planned output files of a command.
#[derive(Debug)]
pub struct Outputs {
    existing: Existing,
    kept: Option<Kept>,
    inputs: BTreeMap<PathBuf, PathBuf>,
    /// Flag or other name of each file, by canonical path.
    named: BTreeMap<PathBuf, String>,
    planned: BTreeMap<PathBuf, Existing>,
    /// Directories in which files can be created.
    usable: BTreeSet<PathBuf>,
}

/// Reason why a command cannot write its files.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The file cannot be written, or exists already.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The same command reads the file.
    #[error("{name} would overwrite the input {}", input.display())]
    IsInput {
        /// Flag or other name of the file.
        name: String,
        /// The input file.
        input: PathBuf,
    },
    /// The file exists and is of a kind that is never replaced.
    #[error("{name}: {} is {kind}, which is never replaced; name another file, or remove it first", path.display())]
    IsKept {
        /// Flag or other name of the file.
        name: String,
        /// Path of the file.
        path: PathBuf,
        /// Kind of the file.
        kind: &'static str,
    },
    /// Two outputs name one file.
    #[error("{first} and {second} name the same file; each needs a file of its own")]
    Twice {
        /// First name.
        first: String,
        /// Second name.
        second: String,
    },
}

/// A kind of file that no output replaces, recognised by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kept {
    /// Description of the kind, with an article.
    pub kind: &'static str,
    /// First bytes of every file of this kind.
    pub begins: &'static [u8],
}

impl Kept {
    fn is(self, path: &Path) -> bool {
        let mut begins = Vec::new();
        let source = fs::File::open(path).map(|file| file.take(self.begins.len() as u64));
        source.is_ok_and(|mut source| source.read_to_end(&mut begins).is_ok())
            && begins == self.begins
    }
}

impl Outputs {
    /// Creates an empty plan; `existing` selects the treatment of existing files.
    #[must_use]
    pub fn new(existing: Existing) -> Self {
        Self {
            existing,
            kept: None,
            inputs: BTreeMap::new(),
            named: BTreeMap::new(),
            planned: BTreeMap::new(),
            usable: BTreeSet::new(),
        }
    }

    /// Keeps files of a kind, whatever the treatment of other files.
    #[must_use]
    pub fn keeping(self, kept: Kept) -> Self {
        Self {
            kept: Some(kept),
            ..self
        }
    }

    /// Returns the treatment of existing files.
    #[must_use]
    pub fn existing(&self) -> Existing {
        self.existing
    }

    /// Protects a file that the command reads from being replaced by an output.
    pub fn protect(&mut self, input: &Path) {
        if let Ok(place) = input.canonicalize()
            && place.is_file()
        {
            self.inputs.insert(place, input.to_owned());
        }
    }

    /// Plans to write the file at `path`. `name` identifies it in errors, for example the flag that names it.
    ///
    /// # Errors
    /// The file cannot be written there, exists and must be kept, is an input, or is already planned.
    pub fn plan(&mut self, name: &str, path: &Path) -> Result<(), OutputError> {
        self.plan_over(name, path, self.existing)
    }

    /// Plans a file as [`plan`](Self::plan) does, with its own treatment of an existing file.
    ///
    /// # Errors
    /// Those of `plan`.
    pub fn plan_over(
        &mut self,
        name: &str,
        path: &Path,
        existing: Existing,
    ) -> Result<(), OutputError> {
        let place = place_of(path);
        if let Some(place) = &place {
            self.refuse_input(place, name)?;
            if let Some(Kept { kind, .. }) = self.kept.filter(|kept| kept.is(place)) {
                return Err(OutputError::IsKept {
                    name: name.to_owned(),
                    path: path.to_owned(),
                    kind,
                });
            }
        }
        if !is_stream(path)
            && let Some(place) = place
        {
            if let Some(first) = self.named.get(&place) {
                return Err(OutputError::Twice {
                    first: first.clone(),
                    second: name.to_owned(),
                });
            }
            let directory = directory_of(&place).to_owned();
            let is_new = fs::symlink_metadata(&place).is_err();
            // Check a directory once, even for thousands of new files.
            if !(is_new && self.usable.contains(&directory)) {
                atomic::check(path, existing)?;
            }
            self.usable.insert(directory);
            self.named.insert(place, name.to_owned());
        } else {
            atomic::check(path, existing)?;
        }
        self.planned.insert(path.to_owned(), existing);
        Ok(())
    }

    fn refuse_input(&self, place: &Path, name: &str) -> Result<(), OutputError> {
        let read = || inputs::name_of(place);
        match self.inputs.get(place).cloned().or_else(read) {
            Some(input) => Err(OutputError::IsInput {
                name: name.to_owned(),
                input,
            }),
            None => Ok(()),
        }
    }

    /// Checks the planned files against all files read since.
    ///
    /// # Errors
    /// One of the files was read.
    pub fn spare_inputs(&self) -> Result<(), OutputError> {
        let mut named = self.named.iter();
        named.try_for_each(|(place, name)| self.refuse_input(place, name))
    }

    /// Writes the file at `path` through `write`, completely or not at all.
    ///
    /// # Errors
    /// An error of the system; a file that has appeared since the plan and must be kept; a file that was not planned.
    pub fn write<T>(
        &self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
    ) -> Result<T, WriteError> {
        let Some(existing) = self.planned.get(path) else {
            let unplanned = io::Error::other("it was not checked before the work");
            return Err(WriteError::new(path, unplanned));
        };
        if let Some(place) = place_of(path) {
            let name = self.named.get(&place).map_or("this file", |name| name);
            self.refuse_input(&place, name)
                .map_err(|error| WriteError::new(path, io::Error::other(error)))?;
        }
        atomic::write_over(path, *existing, write)
    }
}

/// Returns the canonical path of a present or future file; `None` if its directory is missing. For a stream, returns
/// the regular file to which the shell redirects it, if any.
fn place_of(path: &Path) -> Option<PathBuf> {
    if is_stream(path) {
        return path.canonicalize().ok().filter(|place| place.is_file());
    }
    let target = follow_links(path).ok()?;
    let name = target.file_name()?;
    let directory = directory_of(&target).canonicalize().ok()?;
    Some(directory.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_is_planned_once_whatever_it_is_called() {
        let folder = tempfile::tempdir().unwrap();
        let (file, again) = (folder.path().join("a.csv"), folder.path().join("./a.csv"));
        let mut outputs = Outputs::new(Existing::Keep);
        outputs.plan("--out", &file).unwrap();
        let error = outputs.plan("--plot", &again).unwrap_err();
        assert_eq!(
            error.to_string(),
            "--out and --plot name the same file; each needs a file of its own"
        );
    }

    #[test]
    fn an_input_is_never_an_output() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("tap.csv");
        fs::write(&input, "t_s").unwrap();
        let mut outputs = Outputs::new(Existing::Replace);
        outputs.protect(&input);
        let error = outputs.plan("--out", &folder.path().join("./tap.csv"));
        let words = format!("--out would overwrite the input {}", input.display());
        assert_eq!(error.unwrap_err().to_string(), words);
    }

    #[test]
    fn what_is_read_is_never_an_output_whenever_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("mesh.stl");
        fs::write(&input, "solid").unwrap();
        let mut outputs = Outputs::new(Existing::Replace);
        outputs.plan("--out", &input).unwrap();
        outputs.spare_inputs().unwrap();
        crate::files::bounded::MESH.bytes(&input).unwrap();
        let words = format!("--out would overwrite the input {}", input.display());
        assert_eq!(outputs.spare_inputs().unwrap_err().to_string(), words);
        let refused = outputs.write(&input, |out| out.write_all(b"t_s"));
        assert!(refused.unwrap_err().to_string().contains(&words));
        assert_eq!(fs::read(&input).unwrap(), b"solid");
        let error = Outputs::new(Existing::Replace).plan("--out", &input);
        assert_eq!(error.unwrap_err().to_string(), words);
    }

    #[test]
    fn a_kind_of_file_is_kept_whatever_becomes_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let [kept, other] = ["kept.bin", "other.bin"].map(|name| folder.path().join(name));
        fs::write(&kept, "MAGIC and more").unwrap();
        fs::write(&other, "MAGI").unwrap();
        let kind = Kept {
            kind: "a treasure",
            begins: b"MAGIC",
        };
        let mut outputs = Outputs::new(Existing::Replace).keeping(kind);
        outputs.plan("--out", &other).unwrap();
        let error = outputs.plan("--plot", &kept).unwrap_err().to_string();
        assert!(
            error.contains("is a treasure, which is never replaced"),
            "{error}"
        );
    }

    /// Covers names that can lead to any file, and an open descriptor.
    #[cfg(target_os = "linux")]
    #[test]
    fn no_other_name_of_an_input_is_an_output() {
        use std::os::fd::AsRawFd;
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("tap.csv");
        fs::write(&input, "t_s").unwrap();
        let open = fs::File::open(folder.path()).unwrap();
        let below = format!("/proc/self/fd/{}/tap.csv", open.as_raw_fd());
        let read = fs::File::open(&input).unwrap();
        let fd = read.as_raw_fd();
        let mut outputs = Outputs::new(Existing::Replace);
        outputs.protect(&input);
        for name in [
            below,
            format!("/dev/fd/{fd}"),
            format!("/proc/self/fd/{fd}"),
        ] {
            let error = outputs.plan("--out", Path::new(&name)).unwrap_err();
            let words = format!("--out would overwrite the input {}", input.display());
            assert_eq!(error.to_string(), words, "{name}");
        }
    }

    #[test]
    fn what_was_not_checked_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let outputs = Outputs::new(Existing::Replace);
        assert!(outputs.write(&path, |_| Ok(())).is_err());
        assert!(!path.exists());
    }

    #[test]
    fn each_of_many_files_in_a_directory_is_looked_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = |number: usize| folder.path().join(format!("plant-{number}.toml"));
        fs::write(path(7), "mine").unwrap();
        let mut outputs = Outputs::new(Existing::Keep);
        let refused: Vec<usize> = (0..10)
            .filter(|number| outputs.plan("--write-scenes", &path(*number)).is_err())
            .collect();
        assert_eq!(refused, [7]);
        outputs
            .plan_over("--write-scenes", &path(7), Existing::Replace)
            .unwrap();
        outputs
            .write(&path(7), |out| out.write_all(b"ours"))
            .unwrap();
        assert_eq!(fs::read(path(7)).unwrap(), b"ours");
    }

    #[cfg(unix)]
    #[test]
    fn streams_may_be_written_by_several() {
        let mut outputs = Outputs::new(Existing::Keep);
        outputs.plan("--out", Path::new("/dev/null")).unwrap();
        outputs.plan("--plot", Path::new("/dev/null")).unwrap();
        outputs
            .write(Path::new("/dev/null"), |out| out.write_all(b"gone"))
            .unwrap();
    }
}

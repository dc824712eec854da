//! List of the files that a demonstration has made in a folder, so that the next one replaces only these.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use palpate_record::files::atomic::Existing;
use palpate_record::files::checksum::Checksum;
use palpate_record::files::outputs::Outputs;

use crate::failure::Failure;

/// The list in the folder: a checksum and a name on each line.
const LIST: &str = "made-by-palpate-demo.txt";
const HEAD: &str =
    "# Files written by palpate demo. The next demo replaces them, unless they were changed.";

/// The files to make in a folder.
pub struct Made {
    folder: PathBuf,
    outputs: Outputs,
    /// The lines of the list.
    known: BTreeSet<String>,
}

impl Made {
    /// Plans files called `names` in `folder`, which is created if it is missing.
    ///
    /// # Errors
    /// One of them exists and is not an unchanged file of a demonstration, or the system fails.
    pub fn plan(folder: &Path, names: &[&str], outputs: Outputs) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| {
            Failure::System(format!(
                "cannot create the folder `{}`: {error}",
                folder.display()
            ))
        })?;
        let list = std::fs::read_to_string(folder.join(LIST)).unwrap_or_default();
        let mut made = Self {
            folder: folder.to_owned(),
            outputs,
            known: list.lines().map(str::to_owned).collect(),
        };
        for name in names {
            let path = made.path(name);
            let ours =
                std::fs::read(&path).is_ok_and(|bytes| made.known.contains(&line(name, &bytes)));
            if !ours
                && made.outputs.existing() == Existing::Keep
                && path.symlink_metadata().is_ok_and(|there| !there.is_dir())
            {
                return Err(Failure::System(format!(
                    "cannot write `{}`: the file exists and is not an unchanged file of palpate demo; name another \
                     folder with --out-dir, or replace it with --overwrite",
                    path.display()
                )));
            }
            made.outputs
                .plan_over("--out-dir", &path, Existing::Replace)?;
        }
        made.outputs
            .plan_over("--out-dir", &made.path(LIST), Existing::Replace)?;
        Ok(made)
    }

    /// Returns the path of a file of that name.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes the files, all of which were planned.
    ///
    /// # Errors
    /// The system fails.
    pub fn write(mut self, files: &[(&str, Vec<u8>)]) -> Result<(), Failure> {
        let lines: BTreeSet<String> = files
            .iter()
            .map(|(name, bytes)| line(name, bytes))
            .collect();
        // Write the list first, so that replaced files are known even if the program is interrupted.
        self.known.extend(lines.iter().cloned());
        self.write_list()?;
        for (name, bytes) in files {
            self.outputs
                .write(&self.path(name), |writer| writer.write_all(bytes))?;
        }
        self.known = lines;
        self.write_list()
    }

    fn write_list(&self) -> Result<(), Failure> {
        Ok(self.outputs.write(&self.path(LIST), |writer| {
            writeln!(writer, "{HEAD}")?;
            self.known
                .iter()
                .filter(|line| !line.starts_with('#'))
                .try_for_each(|line| writeln!(writer, "{line}"))
        })?)
    }
}

fn line(name: &str, bytes: &[u8]) -> String {
    let mut checksum = Checksum::new();
    checksum.add(bytes);
    format!("{}  {name}", checksum.text())
}

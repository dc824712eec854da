//! Scene files: one format, whichever renderer a scene has.

use std::collections::HashSet;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::de::DeTable;

use super::beside::{Files, beside};
use super::contact_file::ContactFile;
use super::fault::SceneErrors;
use super::raw::RawScene;
use super::recover::{self, Fault};
use super::source::Source;
use super::toml_reader;
use crate::world::WorldFile;

/// The version of scene files this crate reads.
const FORMAT: i64 = 2;

/// A scene read from a file. The scene alone decides which renderer it has.
#[derive(Clone, Debug)]
pub enum SceneFile {
    /// One contact along one axis, which the closed form renders: one device with one axis and a point as its tool,
    /// and one body that is fixed or has the same axis, a half-space whose normal is along that axis, with a linear
    /// contact without damping and friction between them.
    Contact(Box<ContactFile>),
    /// Any other scene, which the world renderer renders.
    World(Box<WorldFile>),
}

impl SceneFile {
    /// Reads a scene from the text of a file called `name`. Files that the scene names are read from that file's
    /// folder.
    ///
    /// # Errors
    /// All errors, each with its line, its column and the allowed values.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneErrors> {
        Self::parse_edited(&Source::new(name, source))
    }

    /// Reads a scene with edits, as [`parse`](Self::parse) does.
    ///
    /// # Errors
    /// All errors; those in an edit name its flag.
    pub fn parse_edited(source: &Source) -> Result<Self, SceneErrors> {
        let path = Path::new(&source.name);
        let folder = path.parent().unwrap_or(Path::new(""));
        read(source, folder, &mut beside(path))
    }

    /// Returns whether the world renderer renders the scene of a text, valid values or not. `false` for a text whose
    /// tables cannot be read.
    #[must_use]
    pub fn is_world(source: &str) -> bool {
        Tables::read(&Source::new("", source)).is_ok_and(|tables| tables.raw.one_contact().is_err())
    }
}

/// Reads a scene. Mesh files are read from `folder`; `files` returns the text of other files by their names.
pub(crate) fn read(
    source: &Source,
    folder: &Path,
    files: Files<'_>,
) -> Result<SceneFile, SceneErrors> {
    let tables = Tables::read(source)?;
    match tables.raw.one_contact() {
        Ok(axis) => {
            let file = ContactFile::read(source, tables, axis, files)?;
            Ok(SceneFile::Contact(Box::new(file)))
        }
        Err(_) => {
            let file = WorldFile::read(source, tables, folder)?;
            Ok(SceneFile::World(Box::new(file)))
        }
    }
}

/// The tables of a scene file without the faulty keys.
pub(crate) struct Tables {
    pub raw: RawScene,
    /// Every fault of a key or a type.
    pub faults: Vec<Fault>,
    /// Tables that keys at fault were taken out of.
    pub damaged: HashSet<String>,
    /// Keys that were at fault, with those of their tables.
    pub removed: HashSet<String>,
}

/// The version alone: a file of another version may have keys this one does not know.
#[derive(Deserialize)]
struct RawVersion {
    format: Option<Spanned<i64>>,
    scene_format: Option<Spanned<i64>>,
}

impl Tables {
    /// Reads the tables of a scene.
    ///
    /// # Errors
    /// All faults of keys and types, if the remaining keys are insufficient; every fault of an edit's path.
    pub fn read(source: &Source) -> Result<Self, SceneErrors> {
        let (document, faults) = source.document();
        let faults = if faults.is_empty() {
            Vec::from_iter(other_version(&document))
        } else {
            faults
        };
        if let Some(errors) = source.errors(faults) {
            return Err(errors);
        }
        let mut left = recover::read::<RawScene>(document);
        if let Some(&number) = left.missing.get("format") {
            left.faults[number].1 += "; a scene has format = 2";
        }
        match (left.read, left.faults) {
            (Some(raw), faults) => Ok(Self {
                raw,
                faults,
                damaged: left.damaged,
                removed: left.removed,
            }),
            (None, faults) => match source.errors(faults) {
                Some(errors) => Err(errors),
                None => unreachable!("an unreadable file has a fault"),
            },
        }
    }
}

/// Returns the fault of a file that has another version.
fn other_version(document: &Spanned<DeTable<'_>>) -> Option<Fault> {
    let RawVersion {
        format,
        scene_format,
    } = toml_reader::from_table(document).ok()?;
    if let Some(old) = scene_format {
        let message = "the key scene_format is not read; a scene has format = 2, with [[device]], [[body]] and \
                       [[contact]]";
        return Some((old.span(), message.into()));
    }
    let format = format.filter(|format| *format.get_ref() != FORMAT)?;
    let message = format!("format is {}, but must be {FORMAT}", format.get_ref());
    Some((format.span(), message))
}

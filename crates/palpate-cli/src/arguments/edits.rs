//! Edits of a scene's keys.

use clap::Args;
use palpate_scene::Edit;

use crate::failure::Failure;

/// Edits of a scene file before it is read.
#[derive(Args, Debug, Default, Clone)]
pub struct EditFlags {
    /// Set a key of the scene before it is read, such as body.0.mass_kg=0.2 or contact.stiffness_n_per_m=800;
    /// repeatable. body[ball] chooses by name, and an only entry needs no number. The value is TOML or a word; an empty
    /// one removes the key
    #[arg(long, value_name = "KEY=VALUE", value_parser = edit, allow_hyphen_values = true, help_heading = "Scene")]
    pub set: Vec<Edit>,
}

fn edit(text: &str) -> Result<Edit, String> {
    Edit::parse("--set", text)
}

impl EditFlags {
    /// Rejects edits for a command that has no scene.
    pub fn refuse(&self, why: &str) -> Result<(), Failure> {
        match self.set.first() {
            None => Ok(()),
            Some(edit) => Err(Failure::Arguments(format!("{}: {why}", edit.flag()))),
        }
    }

    /// Adds the edits to the title of a scene, which may name values of the file.
    pub fn retitle(&self, title: &mut String) {
        if self.set.is_empty() {
            return;
        }
        let edits = self
            .set
            .iter()
            .map(|edit| edit.flag().trim_start_matches("--set "));
        let edits: Vec<_> = edits.collect();
        *title = format!("{title} (changed: {})", edits.join(", "));
    }
}

//! Flags present on the command line.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};

use super::setting_flags;

/// Names of the flags and arguments present on the command line.
#[derive(Clone, Debug, Default)]
pub struct Given(Vec<String>);

impl Given {
    /// Returns a flag on the command line that is one of `known` (field names), as written.
    pub fn one_of(&self, known: &[&str]) -> Option<String> {
        let one = self.0.iter().find(|name| known.contains(&name.as_str()))?;
        Some(as_written(one))
    }

    /// Returns a flag on the command line that is not one of `known` (field names), as written.
    pub fn other_than(&self, known: &[&str]) -> Option<String> {
        let other = self.0.iter().find(|name| !known.contains(&name.as_str()))?;
        Some(as_written(other))
    }
}

/// Returns the flag of a field. The flag of a method's setting has no unit, unlike the setting's key.
fn as_written(field: &str) -> String {
    let long = setting_flags::long_of(field).unwrap_or_else(|| field.replace('_', "-"));
    format!("--{long}")
}

/// Adds no flag.
impl Args for Given {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

impl FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = Self::default();
        given.update_from_arg_matches(matches)?;
        Ok(given)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let is_given = |name: &&str| {
            // Groups of flags have the names of their types.
            name.starts_with(char::is_lowercase)
                && matches.value_source(name) == Some(ValueSource::CommandLine)
        };
        let names = matches.ids().map(clap::Id::as_str).filter(is_given);
        self.0 = names.map(str::to_owned).collect();
        Ok(())
    }
}

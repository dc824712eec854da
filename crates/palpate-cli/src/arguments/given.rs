//! Which flags stand on the command line.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};

use super::setting_flags;

/// The flags and arguments that stand on the command line, whatever they say.
#[derive(Clone, Debug, Default)]
pub struct Given(Vec<String>);

impl Given {
    /// A flag that stands on the command line and is one of `known`, by their fields' names; as it is written.
    pub fn one_of(&self, known: &[&str]) -> Option<String> {
        let one = self.0.iter().find(|name| known.contains(&name.as_str()))?;
        Some(as_written(one))
    }

    /// A flag that stands on the command line and is not one of `known`, by their fields' names; as it is
    /// written.
    pub fn other_than(&self, known: &[&str]) -> Option<String> {
        let other = self.0.iter().find(|name| !known.contains(&name.as_str()))?;
        Some(as_written(other))
    }
}

/// The flag of a field. That of a method's setting is shorter than the setting's key, which has its unit.
fn as_written(field: &str) -> String {
    let long = setting_flags::long_of(field).unwrap_or_else(|| field.replace('_', "-"));
    format!("--{long}")
}

/// It adds no flag of its own.
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
            // Groups of flags are called as their types are.
            name.starts_with(char::is_lowercase)
                && matches.value_source(name) == Some(ValueSource::CommandLine)
        };
        let names = matches.ids().map(clap::Id::as_str).filter(is_given);
        self.0 = names.map(str::to_owned).collect();
        Ok(())
    }
}

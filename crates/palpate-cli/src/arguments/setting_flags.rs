//! Flags of the methods' settings, generated from the descriptions in the methods' modules.

use std::fmt::Write as _;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use palpate_core::{ParameterValue, SettingValues, Unit, all_settings};
use palpate_scene::method::{MethodName, Setting, SettingKey, Settings};
use palpate_scene::world::WorldScene;

/// Settings of methods from the command line.
#[derive(Clone, Copy, Debug, Default)]
pub struct SettingFlags(pub Settings);

/// Returns the flag of a setting: its name without the unit, or a negation for a switch.
pub fn flag_of_setting(setting: &Setting) -> String {
    format!("--{}", long(setting))
}

/// Help of `--method`: the names.
pub fn method_help() -> String {
    let names = MethodName::ALL.map(MethodName::name).join(", ");
    let of_worlds = WorldScene::METHODS.join(", ");
    let default = MethodName::default();
    format!(
        "Method: all, or one or more, separated by commas, of {names}; for worlds of {of_worlds} \
         [default: {default}, or the scene's]"
    )
}

fn long(setting: &Setting) -> String {
    let name = setting.name().replace('_', "-");
    match setting.values {
        SettingValues::Switch => format!("no-{name}"),
        _ => name,
    }
}

/// Returns the flag, without its dashes, of the setting with this key, or `None` if no method has it.
pub(super) fn long_of(key: &str) -> Option<String> {
    let mut settings = MethodName::ALL
        .into_iter()
        .flat_map(|method| method.info().settings.iter());
    settings
        .find(|setting| setting.key.as_str() == key)
        .map(long)
}

/// Returns the description of each method for the setting of that key, grouped by equal descriptions.
fn said(key: SettingKey) -> Vec<(Vec<&'static str>, &'static Setting)> {
    let mut said: Vec<(Vec<_>, &Setting)> = Vec::new();
    for method in MethodName::ALL {
        let Some(setting) = method.setting(key) else {
            continue;
        };
        match said.iter_mut().find(|(_, other)| *other == setting) {
            Some((methods, _)) => methods.push(method.name()),
            None => said.push((vec![method.name()], setting)),
        }
    }
    said
}

fn help(setting: &Setting) -> String {
    let mut text = String::new();
    let is_switch = setting.values == SettingValues::Switch;
    for (methods, setting) in said(setting.key) {
        let between = if text.is_empty() { "" } else { "; " };
        let off = if is_switch { "Switch off in " } else { "" };
        let (methods, help) = (methods.join(", "), setting.help);
        // Writing to a string cannot fail.
        let _ = write!(text, "{between}{off}{methods}: {help}");
        if let SettingValues::Words { words, .. } = setting.values {
            let _ = write!(text, ": {}", words.join(", "));
        }
        if !is_switch {
            let _ = write!(text, " [default: {}]", setting.default);
        }
    }
    if let Some(unit) = setting.unit().filter(|unit| *unit != Unit::One) {
        let _ = write!(text, " [{}]", unit.symbol());
    }
    text
}

/// Parses the value of a flag: any value that some method accepts under that key.
fn value(key: SettingKey, text: &str) -> Result<ParameterValue<f64>, String> {
    let settings = || {
        MethodName::ALL
            .into_iter()
            .filter_map(move |m| m.setting(key))
    };
    if let Some(word) = settings().find_map(|setting| setting.word(text)) {
        return Ok(word);
    }
    let words = settings().find_map(|setting| match setting.values {
        SettingValues::Words { words, .. } => words.split_last(),
        _ => None,
    });
    if let Some((last, others)) = words {
        return Err(format!("the choices are {} and {last}", others.join(", ")));
    }
    text.parse().map(ParameterValue::Number).map_err(|_| {
        let unit = settings().find_map(Setting::unit).map_or("", Unit::symbol);
        let words: Vec<_> = settings().flat_map(Setting::words).copied().collect();
        if words.is_empty() {
            "a number is needed, such as 0.01 or 1e-2".into()
        } else {
            format!(
                "a number in {unit} or \"{}\" is needed",
                words.join("\" or \"")
            )
        }
    })
}

fn argument(setting: &'static Setting) -> Arg {
    let argument = Arg::new(setting.key.as_str())
        .long(long(setting))
        .help(help(setting))
        .help_heading("Method");
    let unit = match setting.unit() {
        Some(Unit::One) | None => "NUMBER",
        Some(unit) => unit.symbol(),
    };
    let all = said(setting.key);
    let words: Vec<_> = all
        .iter()
        .flat_map(|(_, own)| own.words())
        .copied()
        .collect();
    let value_name = match setting.values {
        SettingValues::Switch => return argument.action(ArgAction::SetTrue),
        SettingValues::Words { .. } => "NAME".to_owned(),
        _ if words.is_empty() => unit.to_owned(),
        _ => format!("{unit}|{}", words.join("|")),
    };
    let key = setting.key;
    argument
        .value_name(value_name)
        .allow_hyphen_values(true)
        .value_parser(move |text: &str| value(key, text))
}

impl Args for SettingFlags {
    fn augment_args(command: Command) -> Command {
        command.args(all_settings().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SettingFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut flags = Self::default();
        flags.update_from_arg_matches(matches)?;
        Ok(flags)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for setting in all_settings() {
            let name = setting.key.as_str();
            let given = match setting.values {
                SettingValues::Switch => matches
                    .get_flag(name)
                    .then_some(ParameterValue::Switch(false)),
                _ => matches.get_one(name).copied(),
            };
            if given.is_some() {
                self.0.set(setting.key, given);
            }
        }
        Ok(())
    }
}

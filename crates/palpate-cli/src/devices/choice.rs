//! What `--device` takes: a kind of device, or the device of a name with its flags.

use std::ffi::OsStr;

use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error, Parser};

use super::{DeviceArguments, DeviceName};

/// What one `--device` says.
#[derive(Clone, Debug)]
pub enum Choice {
    /// A kind of device.
    Kind(DeviceName),
    /// The device of one tool of a world.
    Of {
        /// Name of the device in the scene.
        name: String,
        /// Which it is, with its flags.
        arguments: Box<DeviceArguments>,
    },
}

/// Reads a [`Choice`]: `KIND`, or `NAME=KIND FLAGS` with the flags of a device.
#[derive(Clone, Copy, Debug)]
pub struct ChoiceParser;

/// A device and its flags, as they stand behind a name.
#[derive(Parser, Debug)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Behind {
    /// They.
    #[command(flatten)]
    arguments: DeviceArguments,
}

impl TypedValueParser for ChoiceParser {
    type Value = Choice;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Choice, Error> {
        let named = value.to_str().and_then(|text| text.split_once('='));
        let Some((name, words)) = named else {
            let kinds = EnumValueParser::<DeviceName>::new();
            return kinds.parse_ref(command, arg, value).map(Choice::Kind);
        };
        let refused = |why: &str| {
            let mut error = Error::new(ErrorKind::ValueValidation).with_cmd(command);
            let text = value.to_string_lossy().into_owned();
            let flag = arg.map_or_else(|| "--device".to_owned(), ToString::to_string);
            error.insert(ContextKind::InvalidArg, ContextValue::String(flag));
            error.insert(ContextKind::InvalidValue, ContextValue::String(text));
            error.insert(
                ContextKind::Suggested,
                ContextValue::StyledStrs(vec![why.to_owned().into()]),
            );
            error
        };
        if name.trim().is_empty() || words.trim().is_empty() {
            return Err(refused(
                "NAME=DEVICE FLAGS is what can stand here, such as \"left=inverse3 --device-id 049D\"",
            ));
        }
        let words = ["--device"].into_iter().chain(words.split_whitespace());
        let behind = Behind::try_parse_from(words).map_err(|error| {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            refused(first.strip_prefix("error: ").unwrap_or(first))
        })?;
        if !matches!(behind.arguments.device[..], [Choice::Kind(_)]) {
            return Err(refused(
                "one device can stand behind a name, without a name of its own",
            ));
        }
        Ok(Choice::Of {
            name: name.trim().to_owned(),
            arguments: Box::new(behind.arguments),
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let kinds = <DeviceName as clap::ValueEnum>::value_variants().iter();
        Some(Box::new(
            kinds.filter_map(clap::ValueEnum::to_possible_value),
        ))
    }
}

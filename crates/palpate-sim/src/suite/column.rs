//! What is compared: methods, or variants of them, each with settings.

use std::collections::HashMap;

use serde::Deserialize;

use crate::method::{MethodName, Settings, SettingsError};
use crate::scene::{RawSettings, in_plain_words};

/// A method with settings, under a name of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in tables.
    pub name: String,
    /// The method.
    pub method: MethodName,
    /// Its settings; what is missing takes its default.
    pub settings: Settings,
}

/// A fault in a file of columns.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ColumnError {
    /// The text is no TOML.
    #[error("{0}")]
    Syntax(String),
    /// A column is wrong.
    #[error("column {name}: {fault}")]
    Column {
        /// Its name.
        name: String,
        /// What is wrong, and what is allowed.
        fault: String,
    },
    /// There is no column.
    #[error("there is no column; one is a table such as [my-variant] with method = \"hfcr\"")]
    None,
}

impl Column {
    /// A method with its defaults, under its own name.
    pub fn of(method: MethodName) -> Self {
        Self {
            name: method.name().into(),
            method,
            settings: Settings::default(),
        }
    }

    /// Reads columns from TOML: a table each, its name that of the column, with a `method` and the
    /// keys that scenes have under `[methods.NAME]`. They keep the order of the file.
    ///
    /// # Errors
    /// Text that is no TOML, no column, a method that is missing or unknown, a key that no method
    /// or not this one has.
    pub fn parse(text: &str) -> Result<Vec<Self>, ColumnError> {
        // By themselves, tables would come sorted by name.
        let tables: HashMap<toml::Spanned<String>, toml::Value> =
            toml::from_str(text).map_err(|error| ColumnError::Syntax(error.to_string()))?;
        let mut tables: Vec<_> = tables.into_iter().collect();
        tables.sort_by_key(|(name, _)| name.span().start);
        if tables.is_empty() {
            return Err(ColumnError::None);
        }
        tables
            .iter()
            .map(|(name, table)| Self::of_table(name.get_ref(), table))
            .collect()
    }

    fn of_table(name: &str, table: &toml::Value) -> Result<Self, ColumnError> {
        let wrong = |fault: String| ColumnError::Column {
            name: name.into(),
            fault,
        };
        let mut keys = table
            .as_table()
            .ok_or_else(|| wrong("a column is a table".into()))?
            .clone();
        let method = keys
            .remove("method")
            .ok_or_else(|| wrong("it needs a method".into()))?
            .as_str()
            .ok_or_else(|| wrong("its method is a name in quotes".into()))?
            .parse::<MethodName>()
            .map_err(|error| wrong(error.to_string()))?;
        let settings: Settings = RawSettings::deserialize(keys)
            .map_err(|error| wrong(in_plain_words(error.message())))?
            .into();
        if let Some(setting) = method.unused(&settings) {
            return Err(wrong(format!(
                "{}: {}; it is for {}",
                setting.key(),
                SettingsError::Unused { method, setting },
                setting.users()
            )));
        }
        Ok(Self {
            name: name.into(),
            method,
            settings,
        })
    }
}

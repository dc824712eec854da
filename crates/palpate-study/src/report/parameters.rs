//! Parameters of a method in a report.

use palpate::ParameterValue;
use serde_json::{Map, Value};

/// Parameters by key, with the unit at the key's end; empty for a method without any.
#[must_use]
pub fn of(parameters: &[(&'static str, ParameterValue<f64>)]) -> Map<String, Value> {
    let named = parameters.iter();
    named
        .map(|&(name, value)| {
            let value = match value {
                ParameterValue::Number(number) => number.into(),
                ParameterValue::Word(word) => word.into(),
                ParameterValue::Switch(on) => on.into(),
                ParameterValue::ToBeDerived => Value::Null,
            };
            (name.to_owned(), value)
        })
        .collect()
}

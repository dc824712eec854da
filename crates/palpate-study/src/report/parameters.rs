//! Parameters of a method in a report.

use palpate_core::ParameterValue;
use serde_json::{Map, Value};

/// Returns the parameters by key, with the unit at the end of the key; empty for a method without parameters.
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

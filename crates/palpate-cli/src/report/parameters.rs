//! Parameters of a method in a report.

use palpate::{AnyParams, ParameterValue};
use palpate_scene::named_parameters::named_parameters;
use serde_json::{Map, Value};

/// Parameters by name, with the unit in the name; empty for a method without any.
pub fn of(params: &AnyParams<f64>) -> Map<String, Value> {
    let named = named_parameters(params).into_iter();
    named
        .map(|(name, value)| {
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

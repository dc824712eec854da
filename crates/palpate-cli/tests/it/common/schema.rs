//! Validation of reports against their schemas in `docs/schema`.
//!
//! The schemas use few keywords of JSON Schema. An unknown keyword fails the test, so that no rule of a schema is
//! skipped.

use std::path::PathBuf;

use serde_json::Value;

/// Checks a report against the committed schema of its format. Returns the name of that schema.
pub fn check(report: &Value) -> String {
    let one = report.get(0).unwrap_or(report);
    let format = one["format"]
        .as_str()
        .unwrap_or_else(|| panic!("no format in {report:#}"));
    let name = name(format);
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../docs/schema")
        .join(&name)
        .with_extension("json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let schema: Value = serde_json::from_str(&text).unwrap();
    if let Err(fault) = fits(report, &schema, &schema, "") {
        panic!("{format}: {fault}\n{report:#}");
    }
    name
}

/// Returns `map-report` for `palpate map report 2`.
fn name(format: &str) -> String {
    let words: Vec<&str> = format.split(' ').collect();
    let ["palpate", name @ .., version] = &words[..] else {
        panic!("no name and version: {format}");
    };
    assert!(version.parse::<u32>().is_ok(), "no version: {format}");
    name.join("-")
}

/// Checks `value`, at the path `at`, against a part of the schema `root`.
pub fn fits(value: &Value, schema: &Value, root: &Value, at: &str) -> Result<(), String> {
    let rules = match schema {
        Value::Bool(true) => return Ok(()),
        Value::Bool(false) => return Err(format!("{at} must not be there")),
        other => other.as_object().expect("a schema is an object or a bool"),
    };
    let numbers = |rule: &Value| rule.as_f64().expect("a number");
    for (word, rule) in rules {
        let holds = match word.as_str() {
            "$schema" | "$defs" | "title" | "description" | "format" => true,
            "$ref" => {
                let pointer = rule.as_str().and_then(|it| it.strip_prefix('#')).unwrap();
                let part = root.pointer(pointer).expect("what is referred to is there");
                fits(value, part, root, at)?;
                true
            }
            "type" => match rule {
                Value::Array(kinds) => kinds.iter().any(|kind| is_a(value, kind)),
                kind => is_a(value, kind),
            },
            "const" => value == rule,
            "enum" => rule.as_array().unwrap().contains(value),
            "minimum" => value.as_f64().is_none_or(|it| it >= numbers(rule)),
            "maximum" => value.as_f64().is_none_or(|it| it <= numbers(rule)),
            "minItems" => value
                .as_array()
                .is_none_or(|it| it.len() as f64 >= numbers(rule)),
            "maxItems" => value
                .as_array()
                .is_none_or(|it| it.len() as f64 <= numbers(rule)),
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    fits(item, rule, root, &format!("{at}[{index}]"))?;
                }
                true
            }
            "required" => {
                let keys = rule.as_array().unwrap().iter();
                let absent = keys
                    .filter_map(Value::as_str)
                    .find(|key| value.as_object().is_some_and(|it| !it.contains_key(*key)));
                if let Some(absent) = absent {
                    return Err(format!("{at} has no {absent}"));
                }
                true
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some(inner) = value.get(key) {
                        fits(inner, rule, root, &format!("{at}.{key}"))?;
                    }
                }
                true
            }
            "additionalProperties" => {
                let named = rules.get("properties").and_then(Value::as_object);
                for (key, inner) in value.as_object().into_iter().flatten() {
                    if named.is_none_or(|named| !named.contains_key(key)) {
                        fits(inner, rule, root, &format!("{at}.{key}"))?;
                    }
                }
                true
            }
            "anyOf" => count(value, rule, root, at) >= 1,
            "oneOf" => count(value, rule, root, at) == 1,
            other => panic!("a word that this test does not know: {other}"),
        };
        if !holds {
            return Err(format!("{at} is {value}, against {word}: {rule}"));
        }
    }
    Ok(())
}

fn count(value: &Value, rule: &Value, root: &Value, at: &str) -> usize {
    let rules = rule.as_array().unwrap().iter();
    rules
        .filter(|rule| fits(value, rule, root, at).is_ok())
        .count()
}

fn is_a(value: &Value, kind: &Value) -> bool {
    match kind.as_str().expect("a name") {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("a kind that this test does not know: {other}"),
    }
}

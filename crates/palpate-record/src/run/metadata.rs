//! Metadata as a JSON object that keeps its order.

use std::fmt;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserializer, Serializer};

/// Returns the JSON object of `entries`, on one line, or the first key that is not allowed.
pub(crate) fn to_json<K: AsRef<str>, V: AsRef<str>>(entries: &[(K, V)]) -> Result<String, &str> {
    for (at, (key, _)) in entries.iter().enumerate() {
        if !is_allowed(key.as_ref(), &entries[..at]) {
            return Err(key.as_ref());
        }
    }
    let mut json = Vec::new();
    serde_json::Serializer::new(&mut json)
        .collect_map(entries.iter().map(|(k, v)| (k.as_ref(), v.as_ref())))
        .expect("memory takes every byte, and every key is a string");
    Ok(String::from_utf8(json).expect("JSON of strings is UTF-8"))
}

/// Returns the entries of the JSON object `json`, in its order.
pub(crate) fn from_json(json: &str) -> serde_json::Result<Vec<(String, String)>> {
    let mut parser = serde_json::Deserializer::from_str(json);
    let entries = parser.deserialize_map(Entries)?;
    parser.end()?;
    Ok(entries)
}

fn is_allowed<K: AsRef<str>, V>(key: &str, before: &[(K, V)]) -> bool {
    !key.is_empty() && before.iter().all(|(other, _)| other.as_ref() != key)
}

struct Entries;

impl<'de> Visitor<'de> for Entries {
    type Value = Vec<(String, String)>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut entries = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            if !is_allowed(&key, &entries) {
                let fault = format!("the key `{key}` is empty or duplicate");
                return Err(A::Error::custom(fault));
            }
            entries.push((key, map.next_value()?));
        }
        Ok(entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_kept() {
        let json = r#"{"b":"1","a":"2"}"#;
        let entries = from_json(json).unwrap();
        assert_eq!((&entries[0].0[..], &entries[1].0[..]), ("b", "a"));
        assert_eq!(to_json(&entries).unwrap(), json);
    }

    #[test]
    fn line_ends_are_escaped() {
        assert_eq!(to_json(&[("a\r", "b\nc")]).unwrap(), r#"{"a\r":"b\nc"}"#);
    }

    #[test]
    fn keys_are_unique_and_not_empty() {
        assert_eq!(to_json(&[("a", "1"), ("", "2")]), Err(""));
        assert_eq!(to_json(&[("a", "1"), ("a", "2")]), Err("a"));
        let message = |json| from_json(json).unwrap_err().to_string();
        assert_eq!(
            message(r#"{"a":"1","a":"2"}"#),
            "the key `a` is empty or duplicate at line 1 column 12"
        );
        assert_eq!(
            message(r#"{"":"1"}"#),
            "the key `` is empty or duplicate at line 1 column 3"
        );
    }
}

//! Reading on after a fault, so that all faults of a file are found at once.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::toml_reader::{Missing, from_table};

/// Byte range of a fault, and its message.
pub(super) type Fault = (Range<usize>, String);

/// Result of reading a file without the faulty keys.
pub(super) struct Recovered<T> {
    /// The value; `None` if the remaining keys are insufficient.
    pub read: Option<T>,
    /// Every fault of its keys and types.
    pub faults: Vec<Fault>,
    /// The fault of each key that is missing, by its place among the faults.
    pub missing: HashMap<&'static str, usize>,
    /// The tables that something was taken out of; the file itself is the empty name.
    pub damaged: HashSet<String>,
    /// The keys that were taken out, with those of their tables.
    pub removed: HashSet<String>,
}

/// Reads a document without the faulty keys.
pub(super) fn read<T: DeserializeOwned>(mut left: Spanned<DeTable<'_>>) -> Recovered<T> {
    let mut faults = Vec::new();
    let (mut damaged, mut removed) = (HashSet::new(), HashSet::new());
    let mut missing = HashMap::new();
    loop {
        let error = match from_table::<T>(&left) {
            Ok(read) => {
                return Recovered {
                    read: Some(read),
                    faults,
                    missing,
                    damaged,
                    removed,
                };
            }
            Err(error) => error,
        };
        let entry = error.span().and_then(|span| {
            let exactly = take_out(left.get_mut(), &|other| other == span);
            let meets = |other: Range<usize>| other.start < span.end && span.start < other.end;
            exactly.or_else(|| take_out(left.get_mut(), &meets))
        });
        // A table lacks what was taken out of it, or what an unknown key was meant to be.
        let is_missing = error.missing().is_some();
        if !(is_missing && damaged.contains(entry.as_deref().unwrap_or_default())) {
            if let Some(Missing::Key(key)) = error.missing() {
                missing.entry(key).or_insert(faults.len());
            }
            faults.push(error.fault());
        }
        let Some(key) = entry else {
            return Recovered {
                read: None,
                faults,
                missing,
                damaged,
                removed,
            };
        };
        let table = key.rsplit_once('.').map_or("", |(table, _)| table);
        damaged.insert(table.to_owned());
        removed.insert(key);
    }
}

/// Removes the innermost entry whose key or value has a span that satisfies `is_it`. Returns its key, with the keys of
/// the enclosing tables.
fn take_out(table: &mut DeTable<'_>, is_it: &dyn Fn(Range<usize>) -> bool) -> Option<String> {
    for (key, value) in table.iter_mut() {
        let found = match value.get_mut() {
            DeValue::Table(inner) => take_out(inner, is_it),
            DeValue::Array(items) => take_out_of_tables(items, is_it),
            _ => None,
        };
        if let Some(found) = found {
            return Some(format!("{}.{found}", key.get_ref()));
        }
    }
    let (key, _) = table
        .iter()
        .find(|(key, value)| is_it(key.span()) || is_it(value.span()))?;
    let key = key.clone();
    table.remove(&key);
    Some(key.into_inner().into_owned())
}

/// Removes an entry from an array of tables, using its index from 0 as the key; returns `None` for an array of values.
fn take_out_of_tables(
    items: &mut DeArray<'_>,
    is_it: &dyn Fn(Range<usize>) -> bool,
) -> Option<String> {
    for (index, item) in items.iter_mut().enumerate() {
        if let DeValue::Table(inner) = item.get_mut()
            && let Some(found) = take_out(inner, is_it)
        {
            return Some(format!("{index}.{found}"));
        }
    }
    // Remove a mixed array as a whole: without the table it would be reported as too short.
    if !items.iter().all(|item| item.get_ref().is_table()) {
        return None;
    }
    let is_one = |item: &Spanned<DeValue<'_>>| is_it(item.span());
    let index = items.iter().position(is_one)?;
    let others = items.clone().into_iter().enumerate();
    *items = others
        .filter_map(|(other, item)| (other != index).then_some(item))
        .collect();
    Some(index.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        a: f64,
        b: Option<bool>,
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Outer {
        one: Inner,
        two: Inner,
        three: Spanned<i64>,
    }

    fn faults(source: &str) -> (bool, Vec<String>) {
        let Recovered { read, faults, .. } = read::<Outer>(DeTable::parse(source).unwrap());
        let mut said: Vec<_> = faults
            .into_iter()
            .map(|(span, message)| format!("{}: {message}", &source[span]))
            .collect();
        said.sort();
        (read.is_some(), said)
    }

    #[test]
    fn what_is_right_is_read_and_has_no_faults() {
        let (is_read, said) = faults("three = 3\n[one]\na = 1\n[two]\na = 2\nb = true\n");
        assert!(is_read && said.is_empty(), "{said:?}");
    }

    #[test]
    fn every_fault_is_found_once_and_what_is_left_is_read_where_it_can_be() {
        let (is_read, said) = faults("three = 3\n[one]\na = 1\nc = 4\n[two]\na = 2\nb = 5\n");
        assert!(is_read);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[0].starts_with("5: invalid type: integer `5`"),
            "{said:?}"
        );
        assert!(said[1].starts_with("c: unknown key c"), "{said:?}");

        // A required value cannot be removed; it is not additionally reported as missing.
        let (is_read, said) = faults("three = \"x\"\n[one]\na = \"y\"\n[two]\nb = true\n");
        assert!(!is_read);
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(said[0].starts_with("\"x\": invalid type"), "{said:?}");
        assert!(said[1].starts_with("\"y\": invalid type"), "{said:?}");
        assert!(said[2].ends_with("the key a is missing"), "{said:?}");
    }

    /// A choice that has lost its value is not a second fault.
    #[test]
    fn a_fault_inside_a_choice_is_the_only_one() {
        #[derive(serde::Deserialize)]
        #[serde(rename_all = "snake_case", deny_unknown_fields)]
        enum Choice {
            Ball { _radius: f64 },
        }
        #[derive(serde::Deserialize)]
        struct File {
            _shape: Spanned<Choice>,
        }
        for (source, said) in [
            (
                "_shape = { ball = { _radius = \"a\" } }",
                "invalid type: string \"a\", expected a number",
            ),
            (
                "_shape = { ball = 3 }",
                "invalid type: integer `3`, expected a table",
            ),
            ("_shape = { ball = {} }", "the key _radius is missing"),
            (
                "_shape = {}",
                "there is no key, and exactly one is expected",
            ),
        ] {
            let Recovered { faults, .. } = read::<File>(DeTable::parse(source).unwrap());
            let found: Vec<_> = faults.into_iter().map(|(_, message)| message).collect();
            assert_eq!(found, [said], "{source}");
        }
    }
}

//! Edits of a scene's document by a path and a value: `body.0.mass_kg=0.2`.

use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};

use crate::fault::Span;
use crate::source::moved;

/// Name of the value in the text of an edit, which is read as a TOML document.
const VALUE: &str = "v = ";

/// An edit of one key of a scene file, applied before the file is read.
///
/// A path has the names of tables and of the key, separated by points. An entry of an array of tables is chosen by its
/// number from 0, `body.0.mass_kg`, or by its name, `body[ball].mass_kg` or `body.ball.mass_kg`; where there is one
/// entry, it need not be chosen: `contact.stiffness_n_per_m`. A number also chooses a component of a vector:
/// `body.0.position_m.0`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    flag: String,
    path: Vec<String>,
    /// [`VALUE`] and the value in TOML; `None` removes the key.
    text: Option<String>,
}

impl Edit {
    /// Reads `KEY=VALUE`. The value is TOML, or a word, which is a string. An empty value removes the key. Errors in
    /// the edit call it `flag` with that text.
    ///
    /// # Errors
    /// The text has no key, or its value is neither.
    pub fn parse(flag: &str, text: &str) -> Result<Self, String> {
        let example = "such as body.0.mass_kg=0.2";
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| format!("a key and its value are needed, {example}"))?;
        let mut edit = Self::new(&format!("{flag} {text}"), key.trim())?;
        let value = value.trim();
        if value.is_empty() {
            return Ok(edit);
        }
        let is_word = value
            .starts_with(|first: char| first.is_alphabetic() || "./_".contains(first))
            && !value.contains(['"', '\'', '\n', '\\']);
        let as_written = format!("{VALUE}{value}");
        let as_word = format!("{VALUE}\"{value}\"");
        edit.text = if is_value(&as_written) {
            Some(as_written)
        } else if is_word && is_value(&as_word) {
            Some(as_word)
        } else {
            return Err(format!(
                "`{value}` is not a value of TOML: a number, true, false, a word or \"text\", [1, 2, 3], {{ key = 1 }}"
            ));
        };
        Ok(edit)
    }

    /// An edit that sets the key at `path` to a number. Errors in it call it `flag`.
    ///
    /// # Errors
    /// The path has an empty part.
    pub fn number(flag: &str, path: &str, value: f64) -> Result<Self, String> {
        let mut edit = Self::new(flag, path)?;
        // Whole numbers as such: a key may need one.
        let written = if value == value.trunc()
            && value.abs() < 1e15
            && (value != 0.0 || value.is_sign_positive())
        {
            format!("{VALUE}{value:.0}")
        } else {
            format!("{VALUE}{value:?}").replace("NaN", "nan")
        };
        edit.text = Some(written);
        Ok(edit)
    }

    fn new(flag: &str, path: &str) -> Result<Self, String> {
        Ok(Self {
            flag: flag.into(),
            path: parts(path)?,
            text: None,
        })
    }

    /// The flag, in messages.
    #[must_use]
    pub fn flag(&self) -> &str {
        &self.flag
    }

    /// Length of its span `[bytes]`.
    pub(crate) fn len(&self) -> usize {
        self.text.as_ref().map_or(VALUE.len(), String::len)
    }

    /// Makes the edit in a document. The new value has `span`.
    pub(crate) fn apply<'a>(
        &'a self,
        document: &mut Spanned<DeTable<'a>>,
        span: Span,
    ) -> Result<(), String> {
        let value = match &self.text {
            None => None,
            Some(text) => {
                let read = DeTable::parse(text).map_err(|error| error.message().to_owned())?;
                let value = read.into_inner().into_iter().next();
                value.map(|(_, value)| moved(value, span.start))
            }
        };
        put(document.get_mut(), "", &self.path, value, &span)
    }
}

fn is_value(text: &str) -> bool {
    DeTable::parse(text).is_ok_and(|read| read.get_ref().len() == 1)
}

/// Returns the names and numbers of a path.
fn parts(path: &str) -> Result<Vec<String>, String> {
    let mut parts = vec![String::new()];
    let mut in_brackets = false;
    for character in path.chars() {
        match character {
            '.' | '[' if !in_brackets => {
                in_brackets = character == '[';
                parts.push(String::new());
            }
            ']' if in_brackets => in_brackets = false,
            _ => parts.last_mut().expect("there is one").push(character),
        }
    }
    if in_brackets || parts.iter().any(|part| part.trim().is_empty()) {
        return Err(format!(
            "`{path}` is not the path of a key, such as body.0.mass_kg or body[ball].mass_kg"
        ));
    }
    Ok(parts)
}

type Value<'a> = Spanned<DeValue<'a>>;

/// Sets or removes the entry of `table`, which is called `at` in messages.
fn put<'a>(
    table: &mut DeTable<'a>,
    at: &str,
    path: &'a [String],
    value: Option<Value<'a>>,
    span: &Span,
) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        return Err(format!("{at} is a table; name a key in it"));
    };
    let here = joined(at, first);
    if rest.is_empty() {
        match value {
            Some(value) => {
                // A new key has the place of the edit, an old one loses its own.
                table.remove(first.as_str());
                let key = Spanned::new(span.clone(), DeString::Borrowed(first));
                table.insert(key, value);
            }
            None => {
                if table.remove(first.as_str()).is_none() {
                    return Err(format!("there is no {here} to remove"));
                }
            }
        }
        return Ok(());
    }
    if !table.contains_key(first.as_str()) {
        if at.is_empty()
            && ["device", "body", "contact", "joint", "field"].contains(&first.as_str())
        {
            return Err(format!("the scene has no [[{first}]]"));
        }
        let key = Spanned::new(span.clone(), DeString::Borrowed(first));
        let inner = Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
        table.insert(key, inner);
    }
    let inner = table.get_mut(first.as_str()).expect("it is there");
    put_inside(inner, &here, rest, value, span)
}

fn put_inside<'a>(
    inner: &mut Value<'a>,
    at: &str,
    path: &'a [String],
    value: Option<Value<'a>>,
    span: &Span,
) -> Result<(), String> {
    match inner.get_mut() {
        DeValue::Table(table) => put(table, at, path, value, span),
        DeValue::Array(items) => put_in_array(items, at, path, value, span),
        _ => Err(format!("{at} is a value and has no key {}", path[0])),
    }
}

fn put_in_array<'a>(
    items: &mut DeArray<'a>,
    at: &str,
    path: &'a [String],
    value: Option<Value<'a>>,
    span: &Span,
) -> Result<(), String> {
    let (index, rest) = chosen(items, at, path)?;
    let here = format!("{at}.{index}");
    let Some(item) = items.get_mut(index) else {
        return Ok(());
    };
    if !rest.is_empty() {
        return put_inside(item, &here, rest, value, span);
    }
    match value {
        Some(value) => *item = value,
        None => {
            return Err(format!(
                "{here} is an entry of a list and cannot be removed"
            ));
        }
    }
    Ok(())
}

/// Returns the index of the entry that the path chooses, and the rest of the path.
fn chosen<'p>(
    items: &DeArray<'_>,
    at: &str,
    path: &'p [String],
) -> Result<(usize, &'p [String]), String> {
    let count = items.len();
    if count == 0 {
        return Err(format!("{at} is empty"));
    }
    let first = path[0].as_str();
    let names: Vec<_> = items.iter().map(|item| name(item)).collect();
    if let Ok(index) = first.parse::<usize>() {
        return if index < count {
            Ok((index, &path[1..]))
        } else {
            Err(format!(
                "{at}.{index} does not exist; the last is {at}.{}",
                count - 1
            ))
        };
    }
    if let Some(index) = names.iter().position(|name| *name == Some(first)) {
        return Ok((index, &path[1..]));
    }
    let are_tables = items.iter().any(|item| item.get_ref().is_table());
    match items.len() {
        1 if are_tables => Ok((0, path)),
        _ if !are_tables => Err(format!(
            "{at} is a list of {count} values; choose one by its number, such as {at}.0"
        )),
        _ => {
            let names: Vec<_> = names
                .iter()
                .enumerate()
                .map(|(index, name)| match name {
                    Some(name) => format!("{at}[{name}]"),
                    None => format!("{at}.{index}"),
                })
                .collect();
            Err(format!(
                "{at} has {count} entries, and none is called {first}; choose one of {}",
                names.join(", ")
            ))
        }
    }
}

fn name<'v>(item: &'v Value<'_>) -> Option<&'v str> {
    item.get_ref().as_table()?.get("name")?.get_ref().as_str()
}

fn joined(table: &str, key: &str) -> String {
    if table.is_empty() {
        key.into()
    } else {
        format!("{table}.{key}")
    }
}

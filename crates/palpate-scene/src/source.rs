//! The text of a scene file, with the edits that flags make in it before it is read.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::fault::{SceneError, SceneErrors, Span};
use super::recover::Fault;
use super::toml_reader::{ReadError, from_table};
use crate::edit::Edit;

/// The text of a scene file and its name in messages, with edits. Errors in an edit name its flag.
#[derive(Clone, Debug)]
pub struct Source {
    pub(crate) name: String,
    pub(crate) text: String,
    edits: Vec<Edit>,
}

impl Source {
    /// A text that is called `name` in messages. Files that the scene names are read from the folder of `name`.
    #[must_use]
    pub fn new(name: &str, text: &str) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
            edits: Vec::new(),
        }
    }

    /// The text with further edits, which apply in their order.
    #[must_use]
    pub fn edited(mut self, edits: &[Edit]) -> Self {
        self.edits.extend_from_slice(edits);
        self
    }

    /// Returns the text with the edits in it. Comments and order of the keys are those of the file only without edits.
    ///
    /// # Errors
    /// The text or an edit cannot be read.
    pub fn edited_text(&self) -> Result<String, SceneErrors> {
        if self.edits.is_empty() {
            return Ok(self.text.clone());
        }
        let (document, faults) = self.document();
        if let Some(errors) = self.errors(faults) {
            return Err(errors);
        }
        let written = from_table::<toml::Table>(&document)
            .map_err(|error| error.to_string())
            .and_then(|table| toml::to_string(&table).map_err(|error| error.to_string()));
        written.map_err(|message| self.error(0..0, message).into())
    }

    /// Returns the tables of the text with its edits, and the faults of both. Spans beyond the text are in an edit.
    pub(crate) fn document(&self) -> (Spanned<DeTable<'_>>, Vec<Fault>) {
        let mut faults = Vec::new();
        let mut document = DeTable::parse(&self.text).unwrap_or_else(|error| {
            let error = ReadError::from(error);
            faults.push(error.fault());
            Spanned::new(0..0, DeTable::new())
        });
        if faults.is_empty() {
            for (number, edit) in self.edits.iter().enumerate() {
                let span = self.span_of(number);
                if let Err(message) = edit.apply(&mut document, span.clone()) {
                    faults.push((span, message));
                }
            }
        }
        (document, faults)
    }

    /// Span of an edit: the edits follow the text and a byte between each.
    fn span_of(&self, number: usize) -> Span {
        let before = self.edits[..number].iter().map(|edit| edit.len() + 1);
        let start = self.text.len() + 1 + before.sum::<usize>();
        start..start + self.edits[number].len()
    }

    /// Returns the error at these bytes.
    pub(crate) fn error(&self, span: Span, message: String) -> SceneError {
        let mut numbers = 0..self.edits.len();
        let edit = numbers.find(|number| self.span_of(*number).contains(&span.start));
        SceneError {
            flag: edit.map(|number| self.edits[number].flag().into()),
            ..SceneError::at(&self.name, &self.text, span, message)
        }
    }

    /// Returns the errors at these faults; `None` if there are none.
    pub(crate) fn errors(&self, faults: Vec<Fault>) -> Option<SceneErrors> {
        let at = |(span, message)| self.error(span, message);
        SceneErrors::new(faults.into_iter().map(at).collect())
    }
}

/// Returns the value with its spans moved by `offset` bytes.
pub(crate) fn moved(value: Spanned<DeValue<'_>>, offset: usize) -> Spanned<DeValue<'_>> {
    let moved_by = |span: Span| span.start + offset..span.end + offset;
    let span = moved_by(value.span());
    let value = match value.into_inner() {
        DeValue::Array(items) => {
            let items = items.into_iter().map(|item| moved(item, offset));
            DeValue::Array(items.collect())
        }
        DeValue::Table(table) => {
            let entries = table.into_iter().map(|(key, value)| {
                let span = moved_by(key.span());
                (Spanned::new(span, key.into_inner()), moved(value, offset))
            });
            DeValue::Table(entries.collect())
        }
        value => value,
    };
    Spanned::new(span, value)
}

//! Spans of a world's parts in its file.

use std::collections::HashMap;
use std::ops::Range;

use palpate_world::{WorldField, WorldPart};
use toml::Spanned;

/// Span of each field of each part of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorldPlaces {
    parts: HashMap<WorldPart, Range<usize>>,
    fields: HashMap<(WorldPart, WorldField), Range<usize>>,
}

impl WorldPlaces {
    /// A part begins here.
    pub fn part(&mut self, place: WorldPart, span: Range<usize>) {
        self.parts.insert(place, span);
    }

    /// Unwraps a value and records its span.
    pub fn take<T>(&mut self, place: WorldPart, field: WorldField, value: Spanned<T>) -> T {
        self.fields.insert((place, field), value.span());
        value.into_inner()
    }

    /// The place of a field, else of its part, else the beginning of the file.
    pub fn of(&self, place: WorldPart, field: WorldField) -> Range<usize> {
        let field = self.fields.get(&(place, field));
        let found = field.or_else(|| self.parts.get(&place));
        found.cloned().unwrap_or(0..0)
    }
}

//! Positions in a text file.

use std::fmt;
use std::ops::Range;

/// A position in a text file, counted as in an editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextPosition {
    file: String,
    line: usize,
    column: usize,
    span: Range<usize>,
    text: String,
}

impl TextPosition {
    /// Creates the position of the bytes `span` of `source`, the whole text of `file`.
    pub(crate) fn new(file: &str, source: &str, span: Range<usize>) -> Self {
        let body = source.strip_prefix('\u{feff}').unwrap_or(source);
        let mark = source.len() - body.len();
        let start = span.start.clamp(mark, source.len());
        let end = span.end.clamp(start, source.len());
        let before = &source[mark..start];
        let line_start = mark + before.rfind(['\n', '\r']).map_or(0, |at| at + 1);
        Self {
            file: file.to_owned(),
            line: 1 + line_ends(before),
            column: 1 + source[line_start..start].chars().count(),
            span: start..end,
            text: source[..end_of_context(source, end)].to_owned(),
        }
    }

    /// Returns the name of the text given by the caller.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Returns the line, counted from 1.
    #[must_use]
    pub fn line(&self) -> usize {
        self.line
    }

    /// Returns the column in characters, counted from 1.
    #[must_use]
    pub fn column(&self) -> usize {
        self.column
    }

    /// Returns the bytes at fault, as offsets both into [`TextPosition::text`] and into the file.
    #[must_use]
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// Returns the file's text from its start to the line after the fault.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for TextPosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Counts the line ends in `text`: `\n`, `\r\n` and a lone `\r` each count once.
fn line_ends(text: &str) -> usize {
    let feeds = text.bytes().filter(|&byte| byte == b'\n').count();
    let returns = text.bytes().filter(|&byte| byte == b'\r').count();
    feeds + returns - text.matches("\r\n").count()
}

/// Returns the end offset of the line that follows the line of `at`.
fn end_of_context(source: &str, at: usize) -> usize {
    source[at..]
        .match_indices('\n')
        .nth(1)
        .map_or(source.len(), |(offset, _)| at + offset)
}

/// Returns the bytes of field `index` of the record at `start`, without surrounding spaces; `delimiter` separates the
/// fields. If the field does not exist, returns the record's last byte.
pub(crate) fn field_span(source: &str, start: usize, index: usize, delimiter: u8) -> Range<usize> {
    let mut quoted = false;
    let mut field = 0;
    let mut from = start;
    let mut to = source.len();
    for (offset, byte) in source[start..].bytes().enumerate() {
        let at = start + offset;
        match byte {
            b'"' => quoted = !quoted,
            _ if byte == delimiter && !quoted => {
                if field == index {
                    to = at;
                    break;
                }
                field += 1;
                from = at + 1;
            }
            b'\n' | b'\r' if !quoted => {
                to = at;
                break;
            }
            _ => {}
        }
    }
    let raw = &source[from..to];
    let lead = raw.len() - raw.trim_start().len();
    from + lead..from + lead + raw.trim().len()
}

/// Returns the bytes of the whole record at `start`.
pub(crate) fn record_span(source: &str, start: usize, delimiter: u8) -> Range<usize> {
    let last = field_span(source, start, usize::MAX, delimiter);
    start..last.end.max(start)
}

/// Returns the offset of a quote in the record at `start` that is not closed before the end of the text; `None` if
/// every quoted field is closed. `delimiter` separates the fields.
pub(crate) fn open_quote(source: &str, start: usize, delimiter: u8) -> Option<usize> {
    enum At {
        FieldStart,
        Plain,
        Quoted(usize),
        /// After a quote within a quoted field: a second quote makes an escaped one.
        QuoteIn(usize),
    }
    let mut state = At::FieldStart;
    for (offset, byte) in source[start..].bytes().enumerate() {
        state = match (state, byte) {
            (At::FieldStart, b'"') => At::Quoted(start + offset),
            (At::QuoteIn(from), b'"') => At::Quoted(from),
            (At::Quoted(from), b'"') => At::QuoteIn(from),
            (At::Quoted(from), _) => At::Quoted(from),
            (_, b'\n' | b'\r') => return None,
            (_, _) if byte == delimiter => At::FieldStart,
            (_, _) => At::Plain,
        };
    }
    match state {
        At::Quoted(from) => Some(from),
        _ => None,
    }
}

/// Returns the offset of the first byte read for a record, including skipped lines.
pub(crate) fn first_byte(record: &csv::StringRecord) -> usize {
    record
        .position()
        .and_then(|position| usize::try_from(position.byte()).ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_are_counted_as_an_editor_does() {
        let source = "\u{feff}t_s,x\r\n0,µ,bad\r\n";
        let at = source.find("bad").unwrap();
        let place = TextPosition::new("a.csv", source, at..at + 3);
        assert_eq!(place.to_string(), "a.csv:2:5");
        assert_eq!(&place.text()[place.span()], "bad");
        assert_eq!(
            (place.file(), place.line(), place.column()),
            ("a.csv", 2, 5)
        );
    }

    #[test]
    fn a_lone_return_ends_a_line() {
        assert_eq!(TextPosition::new("a", "1\r2\r3", 4..5).line(), 3);
    }

    #[test]
    fn the_byte_order_mark_is_no_column() {
        let place = TextPosition::new("a", "\u{feff}time", 3..7);
        assert_eq!((place.line(), place.column()), (1, 1));
    }

    #[test]
    fn the_text_ends_one_line_after_the_fault() {
        let place = TextPosition::new("a", "one\ntwo\nthree\nfour\n", 4..7);
        assert_eq!(place.text(), "one\ntwo\nthree");
    }

    #[test]
    fn fields_are_found_with_quotes_and_spaces() {
        let source = "a,\"b,c\", d \n";
        assert_eq!(&source[field_span(source, 0, 1, b',')], "\"b,c\"");
        assert_eq!(&source[field_span(source, 0, 2, b',')], "d");
        assert_eq!(&source[record_span(source, 0, b',')], "a,\"b,c\", d");
    }
}

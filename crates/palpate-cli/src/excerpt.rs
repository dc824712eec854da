//! The lines of a file with an error, drawn for a terminal.

use std::io::{self, IsTerminal};
use std::ops::Range;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// The erroneous lines with one line before and one after, and the marked bytes.
#[derive(Debug)]
pub struct Excerpt {
    file: String,
    /// The lines, without the rest of the file, which may be long.
    lines: String,
    /// Number of the first of the lines, from 1.
    first: usize,
    /// The marked bytes, within the lines.
    span: Range<usize>,
}

impl Excerpt {
    /// Returns the lines of `text`, the contents of `file`, around the bytes `span`. The span is clipped to the text.
    pub fn new(file: &str, text: &str, span: Range<usize>) -> Self {
        let start = whole_char(text, span.start);
        let end = whole_char(text, span.end).max(start);
        let line_start =
            |before: usize| text[..before].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = |from: usize| text[from..].find('\n').map_or(text.len(), |at| from + at);
        let from = line_start(line_start(start).saturating_sub(1));
        let to = line_end((line_end(end) + 1).min(text.len()));
        let mut lines = text[from..to].to_owned();
        if text[from..start].ends_with('\n') && start == to {
            // An empty last line would be left out, and the error shown at the end of the line before.
            lines.push(' ');
        }
        Self {
            file: file.to_owned(),
            lines,
            first: 1 + text[..from].matches('\n').count(),
            span: start - from..end - from,
        }
    }

    /// Returns the drawing, coloured if standard error is a terminal and `NO_COLOR` is not set.
    pub fn drawing(&self) -> String {
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let renderer = if io::stderr().is_terminal() && !no_color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let fault = AnnotationKind::Primary
            .span(self.span.clone())
            .label("here");
        let snippet = Snippet::source(&self.lines)
            .path(&self.file)
            .line_start(self.first)
            .fold(false)
            .annotation(fault);
        let group = Group::with_level(Level::ERROR).element(snippet);
        renderer.decor_style(DecorStyle::Unicode).render(&[group])
    }
}

/// Returns the start of the character that contains byte `at` of `text`, or the end of the text for a later byte.
fn whole_char(text: &str, at: usize) -> usize {
    let is_start = |at: &usize| text.is_char_boundary(*at);
    (0..=at.min(text.len())).rev().find(is_start).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, span: Range<usize>) -> String {
        Excerpt::new("a.csv", text, span).drawing()
    }

    #[test]
    fn a_line_is_drawn_with_its_neighbours_and_its_number() {
        let text = "one\ntwo\nthree\nfour\nfive\n";
        let drawing = drawn(text, 8..13);
        for part in [
            "a.csv:3:1",
            "2 │ two\n",
            "3 │ three\n",
            "━━━━━ here",
            "4 │ four",
        ] {
            assert!(drawing.contains(part), "{part} in {drawing}");
        }
        assert!(
            !drawing.contains("one") && !drawing.contains("five"),
            "{drawing}"
        );
    }

    /// Every span of a text is drawn with its line.
    #[test]
    fn a_span_may_be_anywhere() {
        for text in [
            "",
            "\n",
            "\n\n\n",
            "aé\r\n—b\n\n",
            "µ",
            "one\n\ttwo\u{1b}[31m\nthree",
        ] {
            for start in 0..=text.len() + 2 {
                for end in start..=text.len() + 2 {
                    let drawing = drawn(text, start..end);
                    let until = whole_char(text, start);
                    let line = 1 + text[..until].matches('\n').count();
                    let place = format!("a.csv:{line}:");
                    assert!(
                        drawing.contains(&place),
                        "{text:?} {start}..{end}: {drawing}"
                    );
                    assert!(
                        drawing.contains("here"),
                        "{text:?} {start}..{end}: {drawing}"
                    );
                    assert!(!drawing.contains('\u{1b}'), "{drawing}");
                }
            }
        }
    }
}

//! Text that comes from files, as text of a page.

/// `text` with what a page would take for markup written so that it is text, in elements and in attributes.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // Not allowed in a page, and nothing to see.
            control if control.is_control() && control != '\n' => safe.push(' '),
            // Characters that turn the direction of writing would turn what follows, too.
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {}
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn markup_is_text() {
        assert_eq!(
            escaped("<script>alert(\"a\" & 'b')</script>\u{7}\u{202e}"),
            "&lt;script&gt;alert(&quot;a&quot; &amp; &#39;b&#39;)&lt;/script&gt; "
        );
        assert_eq!(escaped("Ø 5 µm ± 1"), "Ø 5 µm ± 1");
    }
}

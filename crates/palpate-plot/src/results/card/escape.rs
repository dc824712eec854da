//! Escaping of text from files for HTML.

/// Returns `text` with HTML markup escaped, for elements and attributes.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // Control characters are invalid in HTML and invisible.
            control if control.is_control() && control != '\n' => safe.push(' '),
            // Bidirectional controls would also change the direction of the text after them.
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

//! Words of a command line.

/// Splits a command into words at spaces; single and double quotes keep the spaces of a word.
///
/// # Errors
/// A quote is not closed, or there is no word.
pub fn words(command: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for character in command.chars() {
        match quote {
            Some(open) if character == open => quote = None,
            Some(_) => word.get_or_insert_default().push(character),
            None if character == '"' || character == '\'' => {
                quote = Some(character);
                word.get_or_insert_default();
            }
            None if character.is_whitespace() => words.extend(word.take()),
            None => word.get_or_insert_default().push(character),
        }
    }
    if let Some(open) = quote {
        return Err(format!("{command}: the quote {open} is not closed"));
    }
    words.extend(word);
    if words.is_empty() {
        return Err("no program is named".to_owned());
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn quotes_keep_spaces() {
        let split = |text| words(text).unwrap();
        assert_eq!(split("python  my.py --a=1 "), ["python", "my.py", "--a=1"]);
        assert_eq!(
            split("'my program' \"a 'b'\" ''"),
            ["my program", "a 'b'", ""]
        );
        assert_eq!(split("--name='x y'z"), ["--name=x yz"]);
        assert!(words("a 'b").unwrap_err().contains("not closed"));
        assert!(words("  ").is_err());
    }
}

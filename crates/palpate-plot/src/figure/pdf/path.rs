//! Outlines of a page, converted from SVG path data.

use pdf_writer::Content;

/// Adds an outline to `content`: moves, lines and closings. Other commands are skipped; the figures of this crate do
/// not use them.
pub(super) fn add(content: &mut Content, d: &str) {
    let mut numbers: Vec<f32> = Vec::new();
    let (mut at, mut start, mut command) = ((0.0, 0.0), (0.0, 0.0), 'M');
    for token in Tokens(d) {
        match token {
            Token::Command(letter) => {
                numbers.clear();
                command = letter;
                if letter.eq_ignore_ascii_case(&'z') {
                    content.close_path();
                    at = start;
                }
                continue;
            }
            Token::Number(number) => numbers.push(number),
        }
        match (command, numbers.as_slice()) {
            ('M', &[x, y]) => {
                content.move_to(x, y);
                (at, start, command) = ((x, y), (x, y), 'L');
            }
            ('L', &[x, y]) => {
                content.line_to(x, y);
                at = (x, y);
            }
            ('h', &[dx]) => {
                at.0 += dx;
                content.line_to(at.0, at.1);
            }
            ('v', &[dy]) => {
                at.1 += dy;
                content.line_to(at.0, at.1);
            }
            ('H', &[x]) => {
                content.line_to(x, at.1);
                at.0 = x;
            }
            ('V', &[y]) => {
                content.line_to(at.0, y);
                at.1 = y;
            }
            ('M' | 'L', [_]) => continue,
            _ => return,
        }
        numbers.clear();
    }
}

enum Token {
    Command(char),
    Number(f32),
}

/// Commands and numbers of an outline.
struct Tokens<'a>(&'a str);

impl Iterator for Tokens<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        self.0 = self.0.trim_start_matches([' ', ',', '\n']);
        let first = self.0.chars().next()?;
        if first.is_ascii_alphabetic() {
            self.0 = &self.0[1..];
            return Some(Token::Command(first));
        }
        let is_part = |(at, c): (usize, char)| {
            c.is_ascii_digit() || c == '.' || c == 'e' || (at == 0 && c == '-')
        };
        let length = self
            .0
            .char_indices()
            .find(|&(at, c)| !is_part((at, c)))
            .map_or(self.0.len(), |(at, _)| at);
        let (number, rest) = self.0.split_at(length);
        self.0 = rest;
        number.parse().ok().map(Token::Number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_keeps_its_corners() {
        let mut content = Content::new();
        add(&mut content, "M0 10H20.5V-2L3,4 5 6zM1 1 L2 2h3v-1");
        let text = String::from_utf8(content.finish().to_vec()).unwrap();
        let expected = "0 10 m\n20.5 10 l\n20.5 -2 l\n3 4 l\n5 6 l\nh\n1 1 m\n2 2 l\n5 2 l\n5 1 l";
        assert_eq!(text.trim(), expected);
    }
}

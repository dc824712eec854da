//! Characters in the standard fonts of every PDF reader: Helvetica, Symbol and Zapf Dingbats.

use pdf_writer::Name;

/// One of the standard fonts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Font {
    Plain,
    Bold,
    Symbol,
    Dingbats,
}

impl Font {
    pub const ALL: [Self; 4] = [Self::Plain, Self::Bold, Self::Symbol, Self::Dingbats];

    /// Name of the font.
    pub fn base(self) -> Name<'static> {
        Name(match self {
            Self::Plain => b"Helvetica",
            Self::Bold => b"Helvetica-Bold",
            Self::Symbol => b"Symbol",
            Self::Dingbats => b"ZapfDingbats",
        })
    }

    /// Resource name of the font on the page.
    pub fn short(self) -> Name<'static> {
        Name(match self {
            Self::Plain => b"F0",
            Self::Bold => b"F1",
            Self::Symbol => b"F2",
            Self::Dingbats => b"F3",
        })
    }

    /// Whether its codes are those of WinAnsiEncoding.
    pub fn is_latin(self) -> bool {
        matches!(self, Self::Plain | Self::Bold)
    }
}

/// A character of one of the fonts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Glyph {
    pub font: Font,
    pub code: u8,
    /// Width in thousandths of the font's size.
    pub width: u16,
}

/// Advance widths of Helvetica from the blank to the tilde, as in its font metrics file, in thousandths.
#[rustfmt::skip]
const PLAIN: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
    333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
    556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Advance widths of Helvetica-Bold, in the same format.
#[rustfmt::skip]
const BOLD: [u16; 95] = [
    278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 333, 333, 584, 584, 584, 611,
    975, 722, 722, 722, 722, 667, 611, 778, 722, 278, 556, 722, 611, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 333, 278, 333, 584, 556,
    333, 556, 611, 556, 611, 556, 333, 611, 611, 278, 278, 556, 278, 889, 611, 611,
    611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389, 280, 389, 584,
];

/// Characters that only Symbol contains: code and width.
#[rustfmt::skip]
const SYMBOL: [(char, u8, u16); 42] = [
    ('α', b'a', 631), ('β', b'b', 549), ('γ', b'g', 411), ('δ', b'd', 494), ('ε', b'e', 439),
    ('ζ', b'z', 494), ('η', b'h', 603), ('θ', b'q', 521), ('ι', b'i', 329), ('κ', b'k', 549),
    ('λ', b'l', 549), ('μ', b'm', 576), ('ν', b'n', 521), ('ξ', b'x', 493), ('π', b'p', 549),
    ('ρ', b'r', 549), ('σ', b's', 603), ('τ', b't', 439), ('υ', b'u', 576), ('φ', b'f', 521),
    ('χ', b'c', 549), ('ψ', b'y', 686), ('ω', b'w', 686), ('Γ', b'G', 603), ('Δ', b'D', 612),
    ('Θ', b'Q', 741), ('Λ', b'L', 686), ('Ξ', b'X', 645), ('Π', b'P', 768), ('Σ', b'S', 592),
    ('Φ', b'F', 763), ('Ψ', b'Y', 795), ('Ω', b'W', 768), ('\u{2212}', b'-', 549), ('≤', 0xa3, 549),
    ('≥', 0xb3, 549), ('′', 0xa2, 247), ('″', 0xb2, 411), ('→', 0xae, 987), ('←', 0xac, 987),
    ('∞', 0xa5, 713), ('≈', 0xbb, 549),
];

const DINGBATS: [(char, u8, u16); 3] = [('▲', 0x73, 892), ('▼', 0x74, 892), ('◆', 0x75, 788)];

/// Characters of WinAnsiEncoding outside Latin-1 that figure texts may contain.
const PUNCTUATION: [(char, u8, u16); 8] = [
    ('…', 0x85, 1000),
    ('‘', 0x91, 222),
    ('’', 0x92, 222),
    ('“', 0x93, 333),
    ('”', 0x94, 333),
    ('•', 0x95, 350),
    ('–', 0x96, 556),
    ('—', 0x97, 1000),
];

/// Width of most characters of Latin-1.
const USUAL: u16 = 556;

/// Returns a character in plain or bold letters. A character that no font contains becomes a question mark.
pub(super) fn glyph(character: char, bold: bool) -> Glyph {
    let (letters, widths) = if bold {
        (Font::Bold, &BOLD)
    } else {
        (Font::Plain, &PLAIN)
    };
    let of = |font: Font, table: &[(char, u8, u16)]| {
        let found = table.iter().find(|(known, ..)| *known == character);
        found.map(|&(_, code, width)| Glyph { font, code, width })
    };
    let latin = || {
        let code = u8::try_from(u32::from(character)).ok()?;
        let width = match code {
            b' '..=b'~' => widths[usize::from(code - b' ')],
            // Degree, superscripts, middle dot.
            0xb0 => 400,
            0xb2 | 0xb3 | 0xb9 => 333,
            0xb7 => 278,
            0xb1 | 0xd7 => 584,
            0xa0..=0xff => USUAL,
            _ => return None,
        };
        Some(Glyph {
            font: letters,
            code,
            width,
        })
    };
    latin()
        .or_else(|| of(letters, &PUNCTUATION))
        .or_else(|| of(Font::Symbol, &SYMBOL))
        .or_else(|| of(Font::Dingbats, &DINGBATS))
        .unwrap_or(Glyph {
            font: letters,
            code: b'?',
            width: widths[usize::from(b'?' - b' ')],
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_of_the_figures_is_in_a_font() {
        for sign in "κ = K T²/m ≤ ≥ ± − ″ ξ η θ µ ▲ ▼ · – × °".chars() {
            let glyph = glyph(sign, false);
            assert!(glyph.code != b'?' && glyph.width > 0, "{sign}");
        }
        assert_eq!(glyph('漢', true).code, b'?');
        assert_eq!(glyph('\u{7}', true).code, b'?');
    }
}

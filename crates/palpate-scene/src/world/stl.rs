//! What is checked of an STL file before it is read: readers take a file that was cut off for a smaller part.

use std::borrow::Cow;

/// Bytes before the number of triangles of a binary file.
const HEADER: usize = 80;
/// Bytes of a triangle in a binary file.
const TRIANGLE: u64 = 50;

/// The bytes of a text file, without what is not UTF-8 in its names, or of a binary file that is whole.
pub(super) fn checked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let says = bytes
        .get(HEADER..HEADER + 4)
        .and_then(|count| count.try_into().ok())
        .map(u32::from_le_bytes);
    let has = bytes.len() as u64;
    let whole = says.map(|count| HEADER as u64 + 4 + TRIANGLE * u64::from(count));
    if whole == Some(has) {
        return Ok(Cow::Borrowed(bytes));
    }
    if is_text(bytes) {
        return Ok(match String::from_utf8_lossy(bytes) {
            Cow::Borrowed(text) => Cow::Borrowed(text.as_bytes()),
            Cow::Owned(text) => Cow::Owned(text.into_bytes()),
        });
    }
    Err(match (says, whole) {
        (Some(count), Some(whole)) => format!(
            "a binary STL file of {count} triangles has {whole} bytes, and this one has {has}; text begins with \"solid\""
        ),
        _ => format!(
            "an STL file is text that begins with \"solid\", or has at least {} bytes, and this one has {has}",
            HEADER + 4
        ),
    })
}

/// Whether a file that is no whole binary one is text: binary files may begin with "solid" too, but zeros follow.
fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(says: u32, has: usize) -> Vec<u8> {
        let mut bytes = b"solid, or so it says".to_vec();
        bytes.resize(HEADER, 0);
        bytes.extend(says.to_le_bytes());
        bytes.resize(bytes.len() + 50 * has, 0);
        bytes
    }

    #[test]
    fn a_binary_file_is_whole_or_refused() {
        assert!(checked(&binary(12, 12)).is_ok());
        for (says, has) in [(12, 11), (12, 13), (0, 12), (u32::MAX, 12)] {
            let why = checked(&binary(says, has)).unwrap_err();
            let bytes = 84 + 50 * has;
            assert!(why.contains(&format!("of {says} triangles")), "{why}");
            assert!(why.contains(&format!("this one has {bytes}")), "{why}");
        }
    }

    #[test]
    fn text_may_have_a_name_that_is_not_utf_8() {
        let latin = b"solid Geh\xe4use\nendsolid\n";
        assert!(std::str::from_utf8(&checked(latin).unwrap()).is_ok());
        for short in [&b""[..], b"abc"] {
            assert!(checked(short).unwrap_err().contains("at least 84 bytes"));
        }
    }
}

//! What is checked of an STL file before it is read: readers take a file that was cut off for a smaller part.

use std::borrow::Cow;

/// Bytes before the number of triangles of a binary file.
const HEADER: usize = 80;
/// Bytes of a triangle in a binary file.
const TRIANGLE: u64 = 50;

/// The bytes of a text file, with `?` for what is not ASCII in its names, or of a binary file that is whole.
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
        // Only names can have other characters, and the reader takes ASCII only, its words in small letters.
        let plain = |&byte: &u8| {
            if byte.is_ascii() {
                byte.to_ascii_lowercase()
            } else {
                b'?'
            }
        };
        let is_plain = bytes.iter().all(|byte| *byte == plain(byte));
        return Ok(if is_plain {
            Cow::Borrowed(bytes)
        } else {
            Cow::Owned(bytes.iter().map(plain).collect())
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
    let begins = bytes.trim_ascii_start().get(..b"solid".len());
    begins.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
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
    fn text_may_have_a_name_that_is_not_ascii() {
        let latin = b"solid Geh\xe4use\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n\
                      endloop\n endfacet\nendsolid Geh\xe4use\n";
        let read = mesh_loader::Loader::default()
            .load_stl_from_slice(&checked(latin).unwrap(), "part.stl")
            .unwrap();
        assert_eq!(read.meshes[0].faces.len(), 1);
        let capitals = latin.to_ascii_uppercase();
        let read = mesh_loader::Loader::default()
            .load_stl_from_slice(&checked(&capitals).unwrap(), "part.stl")
            .unwrap();
        assert_eq!(read.meshes[0].faces.len(), 1);
        for short in [&b""[..], b"abc"] {
            assert!(checked(short).unwrap_err().contains("at least 84 bytes"));
        }
    }
}

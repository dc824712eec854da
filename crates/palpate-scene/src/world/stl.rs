//! Triangles of an STL file, as text or binary.

use palpate_world::Vector;

/// Bytes before the number of triangles of a binary file.
const HEADER: usize = 80;
/// Bytes of a triangle in a binary file: a normal, three vertices, and two bytes more.
const TRIANGLE: usize = 50;

/// Corners of triangles in the file's unit, and notes on the file.
#[derive(Debug, PartialEq)]
pub(super) struct ReadStl {
    pub triangles: Vec<[Vector; 3]>,
    pub note: Option<String>,
}

/// Contents of a file. Normals are not read: the order of the corners determines them.
pub(super) fn read(bytes: &[u8]) -> Result<ReadStl, String> {
    let count = bytes
        .get(HEADER..HEADER + 4)
        .and_then(|count| count.try_into().ok())
        .map(u32::from_le_bytes);
    let needed = count.map(|count| HEADER as u64 + 4 + TRIANGLE as u64 * u64::from(count));
    if needed == Some(bytes.len() as u64) {
        return Ok(binary(bytes, None));
    }
    if bytes.starts_with(b"\xff\xfes\0") || bytes.starts_with(b"\xfe\xff\0s") || is_text(bytes) {
        return text(&super::mesh::text_of(bytes)?).map(|triangles| ReadStl {
            triangles,
            note: None,
        });
    }
    let has = bytes.len() as u64;
    let (Some(count), Some(needed)) = (count, needed) else {
        return Err(format!(
            "an STL file is text that begins with \"solid\", or has at least {} bytes, and this one has {has}",
            HEADER + 4
        ));
    };
    // Additional bytes may be triangles beyond the stated number.
    let more = has.saturating_sub(needed);
    if count == 0 || has < needed || more >= TRIANGLE as u64 {
        return Err(format!(
            "a binary STL file of {count} triangles has {needed} bytes, and this one has {has}; text begins with \"solid\""
        ));
    }
    let plural = if more == 1 { "" } else { "s" };
    let note = format!("{more} byte{plural} after the last triangle ignored");
    Ok(binary(bytes, Some(note)))
}

fn binary(bytes: &[u8], note: Option<String>) -> ReadStl {
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    let corner = |at: &[u8]| [0, 4, 8].map(|k| number(&at[k..]));
    let (chunks, _) = bytes[HEADER + 4..].as_chunks::<TRIANGLE>();
    let triangles = chunks
        .iter()
        .map(|chunk| [12, 24, 36].map(|k| corner(&chunk[k..])));
    ReadStl {
        triangles: triangles.collect(),
        note,
    }
}

/// Returns whether a file that is not a complete binary STL is text. Binary files may also begin with "solid", but
/// contain zeros.
fn is_text(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let lines = text.split(|byte| matches!(byte, b'\n' | b'\r'));
    let mut lines = lines.map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && !is_comment(line));
    let begins = first.and_then(|line| line.get(..b"solid".len()));
    begins.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
}

fn is_comment(line: &[u8]) -> bool {
    [&b"#"[..], b";", b"//"]
        .iter()
        .any(|mark| line.starts_with(mark))
}

fn text(text: &str) -> Result<Vec<[Vector; 3]>, String> {
    let mut triangles = Vec::new();
    let mut corners: Vec<Vector> = Vec::new();
    let mut is_in_solid = false;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if is_comment(line.as_bytes()) {
            continue;
        }
        let wrong = |why: String| format!("line {}: {why}", number + 1);
        let mut words = line.split_whitespace();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                // The name of a solid is the rest of the line, or ends before its first facet there.
                "solid" => {
                    is_in_solid = true;
                    let is_facet = |three: &[&str]| {
                        three[0].eq_ignore_ascii_case("facet")
                            && three[1].eq_ignore_ascii_case("normal")
                            && is_number(three[2])
                    };
                    let rest: Vec<&str> = words.clone().collect();
                    match rest.windows(3).position(is_facet) {
                        Some(name) => words.by_ref().take(name).for_each(drop),
                        None => break,
                    }
                }
                "endsolid" => {
                    is_in_solid = false;
                    break;
                }
                "facet" | "outer" | "loop" | "endfacet" => {}
                "normal" => words = skip_numbers(words),
                "vertex" => {
                    let (place, rest) = vertex(words).map_err(wrong)?;
                    corners.push(place);
                    words = rest;
                }
                "endloop" => {
                    let triangle = <[Vector; 3]>::try_from(corners.as_slice());
                    triangles.push(triangle.map_err(|_| {
                        let count = corners.len();
                        wrong(format!("a facet has {count} vertices; it needs 3"))
                    })?);
                    corners.clear();
                }
                _ => {
                    return Err(wrong(format!(
                        "{word:?} is not a word of an STL file; the words are solid, facet normal, outer loop, \
                         vertex, endloop, endfacet and endsolid"
                    )));
                }
            }
        }
    }
    if is_in_solid || !corners.is_empty() {
        return Err(format!(
            "the file ends after {} triangles without \"endsolid\", so it may be cut off; if it is complete, add \
             that line",
            triangles.len()
        ));
    }
    Ok(triangles)
}

type Words<'a> = std::str::SplitWhitespace<'a>;

/// Returns whether a word may be a number of a normal, also an unreadable one.
fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok() || word.contains([',', '#'])
}

fn skip_numbers(words: Words<'_>) -> Words<'_> {
    let mut rest = words.clone();
    for _ in 0..3 {
        let mut next = rest.clone();
        match next.next() {
            Some(word) if is_number(word) => rest = next,
            _ => break,
        }
    }
    rest
}

/// Three numbers, which may have commas between them or in place of the point, and the words that follow.
fn vertex(words: Words<'_>) -> Result<(Vector, Words<'_>), String> {
    let mut rest = words.clone();
    let mut place = [0.0; 3];
    let first = rest.clone().next().unwrap_or_default();
    // "0,5,1": of three numbers with commas between them, or, of two words more, one number with two commas.
    let joined: Vec<&str> = first.split(',').collect();
    let texts: Vec<String> = if joined.len() == 3 && joined.iter().all(|text| !text.is_empty()) {
        rest.next();
        joined.into_iter().map(str::to_owned).collect()
    } else {
        let three = rest.by_ref().take(3);
        three
            .map(|word| word.trim_end_matches(',').replace(',', "."))
            .collect()
    };
    if texts.len() < 3 {
        return Err(format!("a vertex has {} numbers; it needs 3", texts.len()));
    }
    for (own, text) in place.iter_mut().zip(&texts) {
        let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
        *own =
            number.ok_or_else(|| format!("a vertex has {text:?}, which is not a finite number"))?;
    }
    Ok((place, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(says: u32, has: usize, more: usize) -> Vec<u8> {
        let mut bytes = b"solid, or so it says: facet".to_vec();
        bytes.resize(HEADER, b' ');
        bytes.extend(says.to_le_bytes());
        let triangle: Vec<u8> = (0..12_u8)
            .flat_map(|k| f32::from(k).to_le_bytes())
            .chain([0, 0])
            .collect();
        bytes.extend(triangle.repeat(has));
        bytes.resize(bytes.len() + more, 0);
        bytes
    }

    #[test]
    fn a_binary_file_is_whole_or_refused() {
        let whole = read(&binary(12, 12, 0)).unwrap();
        assert_eq!((whole.triangles.len(), whole.note), (12, None));
        assert_eq!(
            whole.triangles[3],
            [[3.0, 4.0, 5.0], [6.0, 7.0, 8.0], [9.0, 10.0, 11.0]]
        );
        for (says, has) in [(12, 11), (12, 13), (0, 12), (u32::MAX, 12)] {
            let why = read(&binary(says, has, 0)).unwrap_err();
            let bytes = 84 + 50 * has;
            assert!(why.contains(&format!("of {says} triangles")), "{why}");
            assert!(why.contains(&format!("this one has {bytes}")), "{why}");
        }
        let padded = read(&binary(12, 12, 2)).unwrap();
        assert_eq!(padded.triangles, whole.triangles);
        assert_eq!(
            padded.note.unwrap(),
            "2 bytes after the last triangle ignored"
        );
        for short in [&b""[..], b"abc"] {
            assert!(read(short).unwrap_err().contains("at least 84 bytes"));
        }
    }

    const FACET: &str = "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1.5 0 0\n vertex 0 1e1 0\n \
                         endloop\nendfacet\n";

    #[test]
    fn text_is_read_as_programs_write_it() {
        let expected = [[[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 10.0, 0.0]]];
        let one_line = FACET.replace('\n', " ");
        for text in [
            format!("solid part\n{FACET}endsolid part\n"),
            format!("\u{feff}solid\n{FACET}endsolid"),
            format!(
                "# by a program\n; of 1999\n\n  solid part // one\n{FACET}  // end\nendsolid\n"
            ),
            format!("solid part\n{one_line}\nendsolid\n"),
            format!("solid part\n{FACET}endsolid part\n").to_ascii_uppercase(),
            format!("solid\r\n{}endsolid\r\n", FACET.replace('\n', "\r\n")),
            format!(
                "# by a program\rsolid part\r{}endsolid part\r",
                FACET.replace('\n', "\r")
            ),
            format!("solid facet normal vertex\n{FACET}endsolid facet normal vertex\n"),
            format!("solid a\nendsolid a\nsolid b\n{FACET}endsolid b\n"),
            format!("solid\n{}endsolid\n", FACET.replace("0 0 1", "nan nan nan")),
            format!(
                "solid\n{}endsolid\n",
                FACET.replace("1.5 0 0", "1,5 0,0 0,0")
            ),
            format!("solid\n{}endsolid\n", FACET.replace("1.5 0 0", "1.5, 0, 0")),
            format!("solid\n{}endsolid\n", FACET.replace("1.5 0 0", "1.5,0,0")),
        ] {
            let file = read(text.as_bytes()).map(|file| file.triangles);
            assert_eq!(file.as_deref(), Ok(&expected[..]), "{text}");
        }
        let latin = [
            b"solid Geh\xe4use\n",
            FACET.as_bytes(),
            b"endsolid Geh\xe4use\n",
        ]
        .concat();
        assert_eq!(read(&latin).unwrap().triangles, expected);
    }

    #[test]
    fn what_is_wrong_with_text_is_said_with_its_line() {
        let whole = format!("solid part\n{FACET}endsolid part\n");
        for (text, words) in [
            (
                whole.replace("endsolid part\n", ""),
                "after 1 triangles without \"endsolid\"",
            ),
            (
                whole.replace("endloop\nendfacet\nendsolid part\n", ""),
                "cut off",
            ),
            (whole.replace("1e1", "nan"), "line 6: a vertex has \"nan\""),
            (
                whole.replace(" vertex 0 1e1 0\n", ""),
                "line 6: a facet has 2 vertices",
            ),
            (
                whole.replace("1.5 0 0", "1.5 0"),
                "line 5: a vertex has 2 numbers",
            ),
            (
                whole.replace("outer loop", "outer lop"),
                "line 3: \"lop\" is not a word",
            ),
        ] {
            let why = read(text.as_bytes()).unwrap_err();
            assert!(why.contains(words), "{why}");
        }
        let units = whole.encode_utf16().flat_map(u16::to_le_bytes);
        let wide: Vec<u8> = b"\xff\xfe".iter().copied().chain(units).collect();
        let why = read(&wide).unwrap_err();
        assert!(why.contains("save it as UTF-8"), "{why}");
    }
}

//! Polygons of a Wavefront OBJ file.

use std::collections::HashMap;

/// Vertices that a polygon uses, by their first use, and triangles by the numbers of their corners.
type Numbers = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// What the `v` and `f` lines of a file say. The weight or the colour that a vertex may have is left out.
pub(super) fn triangles(bytes: &[u8]) -> Result<Numbers, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let mut places: Vec<[f32; 3]> = Vec::new();
    let mut polygons: Vec<(usize, Vec<usize>)> = Vec::new();
    while let Some((number, line)) = lines.next() {
        let mut line = line.trim_end().to_owned();
        while line.ends_with('\\') {
            line.pop();
            let Some((_, more)) = lines.next() else { break };
            line.push(' ');
            line.push_str(more.trim_end());
        }
        let at = |why: String| format!("line {}: {why}", number + 1);
        let said = line.split('#').next().unwrap_or_default();
        let mut words = said.split_whitespace();
        match words.next() {
            Some("v") => places.push(place(words).map_err(at)?),
            Some("f") => {
                let corners = words.map(|word| corner(word, places.len()));
                let corners = corners.collect::<Result<Vec<_>, _>>().map_err(at)?;
                if corners.len() < 3 {
                    let count = corners.len();
                    return Err(at(format!(
                        "a face of {count} corners; it needs at least 3"
                    )));
                }
                polygons.push((number + 1, corners));
            }
            _ => {}
        }
    }
    let mut numbers = HashMap::new();
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (line, polygon) in polygons {
        if let Some(lacking) = polygon.iter().find(|&&corner| corner >= places.len()) {
            return Err(format!(
                "line {line}: a face has vertex {}, and the file has {} of them",
                lacking + 1,
                places.len()
            ));
        }
        let own: Vec<u32> = polygon
            .iter()
            .map(|&corner| {
                *numbers.entry(corner).or_insert_with(|| {
                    vertices.push(places[corner]);
                    (vertices.len() - 1) as u32
                })
            })
            .collect();
        let outline: Vec<_> = polygon
            .iter()
            .map(|&corner| places[corner].map(f64::from))
            .collect();
        faces.extend(cut(&outline).into_iter().map(|cut| cut.map(|k| own[k])));
    }
    Ok((vertices, faces))
}

fn place<'a>(words: impl Iterator<Item = &'a str>) -> Result<[f32; 3], String> {
    let numbers: Vec<&str> = words.collect();
    if numbers.len() < 3 {
        return Err(format!(
            "a vertex of {} numbers; it needs at least 3",
            numbers.len()
        ));
    }
    let mut place = [0.0; 3];
    for (own, word) in place.iter_mut().zip(&numbers) {
        let read = word.parse::<f32>().ok().filter(|x| x.is_finite());
        *own = read.ok_or_else(|| format!("a vertex has {word:?}, which is no finite number"))?;
    }
    Ok(place)
}

/// The index of a corner's vertex from 0: a file counts them from 1, or back from the last by negative numbers.
fn corner(word: &str, so_far: usize) -> Result<usize, String> {
    let vertex = word.split('/').next().unwrap_or_default();
    let wrong = |why: &str| format!("a face has vertex {vertex:?}, {why}");
    let number: i64 = vertex
        .parse()
        .map_err(|_| wrong("which is no whole number"))?;
    let index = match number {
        0 => return Err(wrong("and vertices are counted from 1, or back from -1")),
        1.. => number - 1,
        _ => number.saturating_add(so_far as i64),
    };
    usize::try_from(index).map_err(|_| wrong(&format!("and there are {so_far} before it")))
}

/// Triangles of a polygon: a fan about its first corner where all of them have its sense, and else ear by ear.
fn cut(outline: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let fan = |left: &[usize]| -> Vec<_> {
        left[1..]
            .windows(2)
            .map(|two| [left[0], two[0], two[1]])
            .collect()
    };
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let across = |[a, b, c]: [usize; 3]| {
        let [a, b, c] = [outline[a], outline[b], outline[c]];
        let (p, q) = (
            [0, 1, 2].map(|k| b[k] - a[k]),
            [0, 1, 2].map(|k| c[k] - a[k]),
        );
        [
            p[1] * q[2] - p[2] * q[1],
            p[2] * q[0] - p[0] * q[2],
            p[0] * q[1] - p[1] * q[0],
        ]
    };
    let whole = fan(&left)
        .into_iter()
        .map(across)
        .fold([0.0; 3], |sum: [f64; 3], one| {
            [0, 1, 2].map(|k| sum[k] + one[k])
        });
    let area = |triangle| (0..3).map(|k| across(triangle)[k] * whole[k]).sum::<f64>();
    let mut triangles = Vec::new();
    if fan(&left).into_iter().all(|triangle| area(triangle) >= 0.0) {
        return fan(&left);
    }
    while left.len() > 3 {
        let count = left.len();
        let around = |k: usize| {
            [
                left[(k + count - 1) % count],
                left[k],
                left[(k + 1) % count],
            ]
        };
        let ear = (0..count).find(|&k| {
            let [a, b, c] = around(k);
            let holds = |&p: &usize| {
                ![a, b, c].contains(&p)
                    && ![a, b, c].iter().any(|&own| outline[own] == outline[p])
                    && [[a, b, p], [b, c, p], [c, a, p]]
                        .into_iter()
                        .all(|side| area(side) >= 0.0)
            };
            area([a, b, c]) > 0.0 && !left.iter().any(holds)
        });
        // An outline that crosses itself has none.
        let Some(ear) = ear else { break };
        triangles.push(around(ear));
        left.remove(ear);
    }
    triangles.extend(fan(&left));
    triangles
}

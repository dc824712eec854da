//! Polygons of a Wavefront OBJ file.

use std::collections::{BTreeMap, HashMap};

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use palpate_testbed::world::mesh::gallery::Triangles;
use palpate_world::Vector;

/// First words of the lines that describe no surface, or one that other lines describe too.
const NO_SURFACE: [&str; 20] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "usemap",
    "mtllib",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "p",
    "l",
    "end",
];

/// Contents of the `v` and `f` lines of a file: vertices of polygons, in the order of their first use, and triangles.
/// The weight or the colour that a vertex may have is left out. The note counts lines that are left out though they
/// may describe a surface.
pub(super) fn triangles(bytes: &[u8]) -> Result<(Triangles, Option<String>), String> {
    let text = super::mesh::text_of(bytes)?;
    let mut lines = text.lines().enumerate();
    let mut left_out: BTreeMap<String, usize> = BTreeMap::new();
    let mut places: Vec<Vector> = Vec::new();
    let mut polygons: Vec<(usize, Vec<usize>)> = Vec::new();
    while let Some((number, line)) = lines.next() {
        let mut line = line.trim_end().to_owned();
        // A comment ends with its line, also if it ends with the "\\" of a path.
        while line.ends_with('\\') && !line.contains('#') {
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
                        "a face has {count} corners; it needs at least 3"
                    )));
                }
                polygons.push((number + 1, corners));
            }
            Some(word) if !NO_SURFACE.contains(&word) => {
                *left_out.entry(word.to_owned()).or_default() += 1;
            }
            _ => {}
        }
    }
    let note = left_out_in_words(&left_out);
    if polygons.is_empty() {
        let note = note.map_or(String::new(), |note| format!("; {note}"));
        return Err(format!(
            "no line of the file begins with \"f\", so it has no face{note}"
        ));
    }
    let mut numbers = HashMap::new();
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (line, polygon) in polygons {
        if let Some(lacking) = polygon.iter().find(|&&corner| corner >= places.len()) {
            return Err(format!(
                "line {line}: a face has vertex {}, but the number of vertices is {}",
                lacking + 1,
                places.len()
            ));
        }
        let own: Vec<u32> = polygon
            .iter()
            .map(|&corner| {
                *numbers.entry(corner).or_insert_with(|| {
                    vertices.push(places[corner]);
                    u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
                })
            })
            .collect();
        let outline: Vec<Vector> = polygon.iter().map(|&corner| places[corner]).collect();
        let cut = cut(&outline).map_err(|why| format!("line {line}: {why}"))?;
        faces.extend(cut.into_iter().map(|cut| cut.map(|k| own[k])));
    }
    Ok(((vertices, faces), note))
}

/// Most kinds of lines that a note names.
const MAX_NAMED: usize = 4;

/// Describes the lines that are left out, by their first words and numbers.
fn left_out_in_words(left_out: &BTreeMap<String, usize>) -> Option<String> {
    let named = left_out.iter().take(MAX_NAMED);
    let named = named.map(|(word, count)| {
        let word: String = word.chars().take(12).collect();
        format!("{word:?} ({count})")
    });
    let mut named: Vec<String> = named.collect();
    if left_out.len() > MAX_NAMED {
        named.push(format!("{} other words", left_out.len() - MAX_NAMED));
    }
    (!named.is_empty())
        .then(|| format!("lines left out, by their first word: {}", named.join(", ")))
}

fn place<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vector, String> {
    let numbers: Vec<&str> = words.collect();
    if numbers.len() < 3 {
        return Err(format!(
            "a vertex has {} numbers; it needs at least 3",
            numbers.len()
        ));
    }
    let mut place = [0.0; 3];
    for (own, word) in place.iter_mut().zip(&numbers) {
        let read = word.parse::<f64>().ok().filter(|x| x.is_finite());
        *own =
            read.ok_or_else(|| format!("a vertex has {word:?}, which is not a finite number"))?;
    }
    Ok(place)
}

/// The index of a corner's vertex from 0: a file counts them from 1, or back from the last by negative numbers.
fn corner(word: &str, so_far: usize) -> Result<usize, String> {
    let vertex = word.split('/').next().unwrap_or_default();
    let wrong = |why: &str| format!("a face has vertex {vertex:?}, {why}");
    let number: i64 = vertex
        .parse()
        .map_err(|_| wrong("which is not a whole number"))?;
    let index = match number {
        0 => return Err(wrong("but vertices are counted from 1, or back from -1")),
        1.. => number - 1,
        _ => number.saturating_add(so_far as i64),
    };
    usize::try_from(index).map_err(|_| wrong(&format!("but {so_far} are before it")))
}

/// Most of a polygon's area by which its triangles may differ from it.
const CROSSED: f64 = 1e-6;

/// Triangles of a polygon: a fan about its first corner where all of them have its sense, and else by the ear clipping
/// of a library.
fn cut(outline: &[Vector]) -> Result<Vec<[usize; 3]>, String> {
    let fan = (2..outline.len()).map(|k| [0, k - 1, k]);
    let fan: Vec<[usize; 3]> = fan.collect();
    let whole = fan.iter().map(|&triangle| doubled_area(outline, triangle));
    let whole = whole.fold([0.0; 3], |sum: Vector, one| {
        [0, 1, 2].map(|k| sum[k] + one[k])
    });
    let along = |area: Vector| (0..3).map(|k| area[k] * whole[k]).sum::<f64>();
    let has_its_sense = |triangle: &[usize; 3]| along(doubled_area(outline, *triangle)) >= 0.0;
    if fan.iter().all(has_its_sense) {
        return Ok(fan);
    }
    let mut flat = Vec::new();
    let mut corners: Vec<usize> = Vec::new();
    if project3d_to_2d(outline, outline.len(), &mut flat) {
        Earcut::new().earcut(flat, &[], &mut corners);
    }
    let (triangles, _) = corners.as_chunks::<3>();
    let covered = triangles
        .iter()
        .map(|&triangle| along(doubled_area(outline, triangle)));
    let (covered, own) = (covered.map(f64::abs).sum::<f64>(), along(whole));
    if (covered - own).abs() > CROSSED * own {
        return Err(
            "the outline of a face crosses itself, so its inside is unknown; cut it into triangles"
                .into(),
        );
    }
    Ok(triangles
        .iter()
        .map(|&[a, b, c]| {
            if has_its_sense(&[a, b, c]) {
                [a, b, c]
            } else {
                [a, c, b]
            }
        })
        .collect())
}

/// Along the normal of a triangle, twice its area long.
fn doubled_area(outline: &[Vector], corners: [usize; 3]) -> Vector {
    let [a, b, c] = corners.map(|corner| outline[corner]);
    let (p, q) = (
        [0, 1, 2].map(|k| b[k] - a[k]),
        [0, 1, 2].map(|k| c[k] - a[k]),
    );
    [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ]
}

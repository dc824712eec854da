//! Meshes as a scene file gives them: from a file of a CAD program, by their triangles, or by a formula.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use palpate_record::files::bounded::MESH;
use palpate_testbed::world::mesh::gallery;
use palpate_world::{Hull, HullError, Mesh, Shape, Vector};
use serde::Deserialize;

use super::mesh_contact::{RawDistanceGrid, RawShell};
use super::{obj, stl};

/// Most squares along an edge of the cube of a bumpy sphere: more have more triangles than a mesh may have.
const MAX_CELLS: u32 = 288;

/// Keys of a mesh: one of `file`, `vertices_m` with `faces`, `bumpy_sphere` and `revolved`, and its representation for
/// contacts with shapes other than spheres.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMesh {
    file: Option<String>,
    unit: Option<Unit>,
    scale: Option<Scale>,
    turned: Option<bool>,
    vertices_m: Option<Vec<Vector>>,
    faces: Option<Vec<[u32; 3]>>,
    bumpy_sphere: Option<RawBumpySphere>,
    revolved: Option<RawRevolved>,
    shell: Option<RawShell>,
    distance_grid: Option<RawDistanceGrid>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBumpySphere {
    radius_m: f64,
    height_m: f64,
    waves: f64,
    cells: u32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRevolved {
    profile_m: Vec<[f64; 2]>,
    segments: u32,
    longest_m: Option<f64>,
}

/// Unit of the numbers in a file.
#[derive(Clone, Copy, Debug, Deserialize)]
enum Unit {
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "um")]
    Micrometre,
    #[serde(rename = "in")]
    Inch,
}

impl Unit {
    /// Its length `[m]`.
    fn length(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
            Self::Micrometre => 1e-6,
            Self::Inch => 0.0254,
        }
    }
}

/// Factors beside the unit: one for all axes, or one for each. Below 0 they mirror.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "scale is one number, or three: scale = [1.0, 1.0, -1.0]"
)]
enum Scale {
    All(f64),
    Each(Vector),
}

impl Scale {
    fn factors(scale: Option<Self>) -> Result<Vector, String> {
        let factors = match scale {
            None => [1.0; 3],
            Some(Self::All(scale)) => [scale; 3],
            Some(Self::Each(factors)) => factors,
        };
        if let Some(factor) = factors.iter().find(|x| **x == 0.0 || !x.is_finite()) {
            return Err(format!(
                "scale has {factor}, and each factor has to be finite and not 0; below 0 it mirrors"
            ));
        }
        Ok(factors)
    }
}

/// A mesh, with a note for the user.
pub(crate) struct ReadMesh {
    pub shape: Shape,
    /// For a mesh from a file, its size; for a user-made mesh, its omitted parts and whether it is open.
    pub note: Option<String>,
}

impl RawMesh {
    /// Reads the mesh; file names are relative to `folder`.
    pub fn read(&self, folder: &Path) -> Result<ReadMesh, String> {
        let sources = [
            self.file.is_some(),
            self.vertices_m.is_some() || self.faces.is_some(),
            self.bumpy_sphere.is_some(),
            self.revolved.is_some(),
        ];
        if sources.into_iter().filter(|given| *given).count() != 1 {
            return Err(
                "a mesh needs one of file, vertices_m with faces, bumpy_sphere and revolved".into(),
            );
        }
        if self.file.is_none() && (self.unit.is_some() || self.scale.is_some()) {
            return Err("unit and scale need a mesh file".into());
        }
        let (mut mesh, mut words) = self.surface(folder)?;
        if self.file.is_some() {
            words.insert(0, extent_in_words(&mesh));
        }
        // A formula produces only valid triangles and determines itself whether the mesh is closed.
        if self.file.is_some() || self.vertices_m.is_some() {
            words.extend(unusual(&mesh));
        }
        if let Some(shell) = &self.shell {
            let (with_shell, said) = shell.onto(mesh)?;
            mesh = with_shell;
            words.push(said);
        }
        if let Some(grid) = &self.distance_grid {
            let (with_grid, said) = grid.onto(mesh, folder)?;
            mesh = with_grid;
            words.push(said);
        }
        let name = self.file.as_deref().unwrap_or("its mesh");
        Ok(ReadMesh {
            note: (!words.is_empty()).then(|| format!("{name}: {}", words.join("; "))),
            shape: Shape::Mesh(Arc::new(mesh)),
        })
    }

    /// The triangles alone, and notes on their file.
    fn surface(&self, folder: &Path) -> Result<(Mesh, Vec<String>), String> {
        let mut words = Vec::new();
        let (vertices, mut faces) = if let Some(file) = &self.file {
            let (triangles, note) = in_metres(&folder.join(file), self.unit, self.scale)?;
            words.extend(note);
            triangles
        } else if let Some(bumpy) = &self.bumpy_sphere {
            bumpy.triangles()?
        } else if let Some(revolved) = &self.revolved {
            revolved.triangles()?
        } else {
            match (&self.vertices_m, &self.faces) {
                (Some(vertices), Some(faces)) => (vertices.clone(), faces.clone()),
                _ => return Err("a mesh of triangles needs both vertices_m and faces".into()),
            }
        };
        let is_turned = self.turned.unwrap_or(false);
        if is_turned {
            turn(&mut faces);
        }
        let mesh = Mesh::new(&vertices, &faces).map_err(|error| match &self.file {
            Some(file) => format!("{file}: {error}"),
            None => error.to_string(),
        })?;
        if is_turned && mesh.is_closed() {
            return Err(
                "turned is for an open mesh; the outside of a closed one is found without it"
                    .into(),
            );
        }
        Ok((mesh, words))
    }
}

/// Turns triangles to their other side.
fn turn(faces: &mut [[u32; 3]]) {
    for face in faces {
        face.swap(1, 2);
    }
}

/// Keys of a convex hull: one of `points_m`, `prism` and `file`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawHull {
    points_m: Option<Vec<Vector>>,
    prism: Option<RawPrism>,
    file: Option<String>,
    unit: Option<Unit>,
    scale: Option<Scale>,
    within_m: Option<f64>,
}

impl RawHull {
    /// Reads the hull; file names are relative to `folder`.
    pub fn read(&self, folder: &Path) -> Result<ReadMesh, String> {
        // A simplification by `within_m` needs no note.
        let mut left_out = None;
        let mut around = |points: &[Vector]| match self.within_m {
            Some(within) => Hull::within(points, within),
            None => match Hull::around(points) {
                Err(HullError::TooMany(_)) => {
                    let hull = Hull::simplified(points)?;
                    left_out = Some(hull.left_out());
                    Ok(hull)
                }
                other => other,
            },
        };
        if self.file.is_none() && (self.unit.is_some() || self.scale.is_some()) {
            return Err("unit and scale need a hull file".into());
        }
        let mut of_numbers = |points: &[Vector]| around(points).map_err(|error| error.to_string());
        let (hull, file) = match (&self.points_m, self.prism, &self.file) {
            (Some(points), None, None) => (of_numbers(points)?, None),
            (None, Some(prism), None) => (of_numbers(&prism.corners()?)?, None),
            (None, None, Some(file)) => {
                let ((points, _), note) = in_metres(&folder.join(file), self.unit, self.scale)?;
                let hull = of_numbers(&points).map_err(|why| format!("{file}: {why}"))?;
                (hull, Some((file, note)))
            }
            _ => return Err("a hull needs one of points_m, prism and file".into()),
        };
        let (corners, faces) = (hull.corners().len(), hull.faces().len());
        let size = size_in_words(&hull.corners());
        let mut words = vec![format!(
            "a hull of {corners} corners and {faces} faces, {size}"
        )];
        if let Some(left_out) = left_out {
            words.push(format!(
                "points up to {:.3} mm outside were left out, because the hull needs more than {} corners; set \
                 another tolerance by within_m",
                1e3 * left_out,
                Hull::MAX_CORNERS
            ));
        }
        let note = match file {
            Some((file, note)) => {
                words.extend(note);
                Some(format!("{file}: {}", words.join("; ")))
            }
            None if words.len() > 1 => Some(format!("its hull: {}", words.join("; "))),
            None => None,
        };
        Ok(ReadMesh {
            shape: Shape::Hull(Arc::new(hull)),
            note,
        })
    }
}

/// A right prism whose two ends are regular polygons: nearly a cylinder.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPrism {
    sides: u32,
    radius_m: f64,
    length_m: f64,
}

impl RawPrism {
    /// Its corners, all at the radius from the z axis; the first two have y = 0.
    fn corners(self) -> Result<Vec<Vector>, String> {
        let most = Hull::MAX_CORNERS / 2;
        if self.sides < 3 || self.sides as usize > most {
            return Err(format!(
                "sides is {}, and a prism has 3 to {most}: a hull has at most {} corners",
                self.sides,
                Hull::MAX_CORNERS
            ));
        }
        for (key, length) in [("radius_m", self.radius_m), ("length_m", self.length_m)] {
            if !(length > 0.0 && length.is_finite()) {
                return Err(format!(
                    "{key} is {length} m, and has to be finite and above 0"
                ));
            }
        }
        let around = (0..self.sides).map(|side| {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(self.sides)).sin_cos();
            [self.radius_m * cos, self.radius_m * sin]
        });
        let ends = [-0.5, 0.5].map(|end| end * self.length_m);
        Ok(around.flat_map(|[x, y]| ends.map(|z| [x, y, z])).collect())
    }
}

/// Vertices `[m]` and triangles of a file whose numbers are in `unit`, times a `scale`, and notes on the file.
fn in_metres(
    path: &Path,
    unit: Option<Unit>,
    scale: Option<Scale>,
) -> Result<(gallery::Triangles, Option<String>), String> {
    let unit = unit.ok_or(
        "a mesh file does not contain its unit: give unit = \"mm\", or one of \"m\", \"cm\", \"um\", \"in\"",
    )?;
    let factors = Scale::factors(scale)?;
    let ((mut vertices, mut faces), note) = triangles(path)?;
    for vertex in &mut vertices {
        *vertex = [0, 1, 2].map(|axis| vertex[axis] * unit.length() * factors[axis]);
    }
    if factors.iter().product::<f64>() < 0.0 {
        turn(&mut faces);
    }
    Ok(((vertices, faces), note))
}

impl RawBumpySphere {
    fn triangles(&self) -> Result<gallery::Triangles, String> {
        let Self {
            radius_m,
            height_m,
            waves,
            cells,
        } = *self;
        if !(radius_m > 0.0 && radius_m.is_finite() && waves.is_finite()) {
            return Err("a bumpy sphere needs finite radius_m above 0 and finite waves".into());
        }
        if !(height_m >= 0.0 && height_m < radius_m) {
            return Err(format!(
                "height_m is {height_m}, and has to be at least 0 and below the radius"
            ));
        }
        if !(1..=MAX_CELLS).contains(&cells) {
            return Err(format!("cells is {cells}, and has to be 1 to {MAX_CELLS}"));
        }
        Ok(gallery::bumpy_sphere(radius_m, height_m, waves, cells))
    }
}

impl RawRevolved {
    fn triangles(&self) -> Result<gallery::Triangles, String> {
        let longest = self.longest_m.unwrap_or(f64::INFINITY);
        if longest <= 0.0 || longest.is_nan() {
            return Err(format!("longest_m is {longest}, and has to be above 0"));
        }
        let length: f64 = self
            .profile_m
            .windows(2)
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum();
        let rings = self.profile_m.len() as f64 + length / longest;
        let triangles = 2.0 * rings * f64::from(self.segments);
        if triangles > Mesh::MAX_TRIANGLES as f64 || triangles.is_nan() {
            return Err(format!(
                "the profile makes about {triangles:.0} triangles, and at most {} are allowed; give fewer segments or \
                 a larger longest_m",
                Mesh::MAX_TRIANGLES
            ));
        }
        gallery::revolved(&self.profile_m, self.segments, longest).ok_or_else(|| {
            "profile_m needs at least three points [distance from the axis, z], the first and the last with distance 0 \
             and the others above 0, and segments has to be at least 3"
                .into()
        })
    }
}

/// Vertices in the file's unit, triangles, and notes on an STL or OBJ file. Files that it names, such as of colours,
/// are not read.
fn triangles(path: &Path) -> Result<(gallery::Triangles, Option<String>), String> {
    let at = |why: String| format!("{}: {why}", path.display());
    // In a browser there are no files, and the readers are 3 % of the download.
    if cfg!(target_family = "wasm") {
        return Err(at("a web page reads no files".into()));
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("stl") => {
            let file = stl::read(&bytes_of(path)?).map_err(at)?;
            let corners = file.triangles.len() * 3;
            let count = u32::try_from(corners)
                .map_err(|_| at(format!("{corners} corners are too many")))?;
            let faces = (0..count)
                .step_by(3)
                .map(|first| [first, first + 1, first + 2]);
            Ok(((file.triangles.concat(), faces.collect()), file.note))
        }
        Some("obj") => obj::triangles(&bytes_of(path)?).map_err(at),
        _ => Err(at(
            "a mesh needs a file with the extension .stl or .obj".into()
        )),
    }
}

/// The text of a file, with line ends "\n". Bytes that are not UTF-8, such as those of names, are replaced.
pub(super) fn text_of(bytes: &[u8]) -> Result<String, String> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err("its text is UTF-16; save it as UTF-8".into());
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    Ok(text.replace("\r\n", "\n").replace('\r', "\n"))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, String> {
    MESH.bytes(path)
        .map_err(|error| format!("{}: {error}", path.display()))
}

/// The sides of the box along the axes that just holds some points.
fn size_in_words(points: &[Vector]) -> String {
    let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            least[axis] = least[axis].min(point[axis]);
            most[axis] = most[axis].max(point[axis]);
        }
    }
    let [x, y, z] = [0, 1, 2].map(|axis| 1e3 * (most[axis] - least[axis]));
    format!("{x:.4} x {y:.4} x {z:.4} mm")
}

/// Describes a mesh's number of triangles and its size.
fn extent_in_words(mesh: &Mesh) -> String {
    let size = size_in_words(&mesh.vertices());
    let count = mesh.faces().len();
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} triangle{plural}, {size}")
}

/// Returns notes on unusual properties of a user-made mesh.
fn unusual(mesh: &Mesh) -> Vec<String> {
    let mut words = Vec::new();
    if mesh.dropped() > 0 {
        words.push(format!(
            "triangles left out (no area, duplicate or between touching parts): {}",
            mesh.dropped()
        ));
    }
    if mesh.turned() > 0 {
        let (count, was) = (
            mesh.turned(),
            if mesh.turned() == 1 {
                "part was"
            } else {
                "parts were"
            },
        );
        words.push(format!("{count} {was} inside out, turned"));
    }
    if !mesh.is_closed() {
        words.push(format!(
            "it has open edges, so contacts act on the front of its triangles only, which on average faces {}; \
             turned = true reverses it",
            facing(mesh)
        ));
    }
    words
}

/// Describes the direction that most of a mesh's area faces.
fn facing(mesh: &Mesh) -> String {
    let vertices = mesh.vertices();
    let mut sum = [0.0; 3];
    for face in mesh.faces() {
        let [a, b, c] = face.map(|corner| vertices[corner as usize]);
        let (p, q) = (
            [0, 1, 2].map(|k| b[k] - a[k]),
            [0, 1, 2].map(|k| c[k] - a[k]),
        );
        let area = [0, 1, 2].map(|k| {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            p[next] * q[last] - p[last] * q[next]
        });
        sum = [0, 1, 2].map(|k| sum[k] + area[k]);
    }
    let [x, y, z] = super::shape::unit(sum).map(|part| if part.abs() < 5e-3 { 0.0 } else { part });
    format!("({x:.2}, {y:.2}, {z:.2})")
}

//! Meshes in scene files, and the errors of invalid meshes.
#![allow(missing_docs)]

use std::fs;
use std::path::Path;

use palpate_scene::world::WorldFile;
use palpate_world::{Mesh, Shape};

/// A scene beside the files of a folder, with one body of this shape.
pub fn read(folder: &Path, shape: &str) -> Result<WorldFile, Vec<String>> {
    let source = format!(
        r#"
format = 2
title = "a part"
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.25
tool = {{ sphere = {{ radius_m = 0.01 }} }}
[[body]]
name = "part"
fixed = true
shape = {shape}
[[contact]]
between = "*"
stiffness_n_per_m = 4000.0
"#
    );
    let name = folder.join("scene.toml").display().to_string();
    WorldFile::parse(&name, &source)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect())
}

pub fn mesh(file: &WorldFile) -> &Mesh {
    match &file.scene.world.bodies[0].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

/// A corner of a cube, 10 on each side, outwards.
const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [10.0, 0.0, 0.0],
    [0.0, 10.0, 0.0],
    [0.0, 0.0, 10.0],
];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn ascii_stl() -> String {
    let mut text = "solid part from a CAD program\n".to_owned();
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let [x, y, z] = CORNERS[corner];
            text += &format!("vertex {x} {y} {z:e}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part from a CAD program\n"
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    // Some programs begin a binary file as a text one.
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for x in face.iter().flat_map(|&corner| CORNERS[corner]) {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

pub fn obj() -> String {
    let mut text = "mtllib part.mtl\no part\n".to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in FACES {
        text += &format!("f {}//1 {}//1 {}//1\n", a + 1, b + 1, c + 1);
    }
    text
}

#[test]
fn files_of_cad_programs_are_read_in_the_unit_that_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("text.stl"), ascii_stl()).unwrap();
    fs::write(folder.join("binary.STL"), binary_stl()).unwrap();
    fs::write(folder.join("part.obj"), obj()).unwrap();
    fs::create_dir(folder.join("parts")).unwrap();
    fs::write(folder.join("parts/text.stl"), ascii_stl()).unwrap();
    for name in ["text.stl", "binary.STL", "part.obj", "parts/text.stl"] {
        for (keys, side) in [
            ("unit = \"mm\"", 0.01),
            ("unit = \"m\"", 10.0),
            ("unit = \"in\", scale = 0.1", 0.0254),
        ] {
            let shape = format!("{{ mesh = {{ file = \"{name}\", {keys} }} }}");
            let file = read(folder, &shape).unwrap();
            let mesh = mesh(&file);
            assert_eq!(
                (mesh.faces().len(), mesh.vertices().len()),
                (4, 4),
                "{name}"
            );
            assert!(mesh.is_closed());
            let expected = side * side * side / 6.0;
            assert!(
                (mesh.volume() / expected - 1.0).abs() < 1e-6,
                "{name} {keys}"
            );
            let mm = 1e3 * side;
            assert_eq!(
                file.notes(),
                [format!(
                    "part, {name}: 4 triangles, {mm:.4} x {mm:.4} x {mm:.4} mm"
                )]
            );
        }
    }
}

#[test]
fn what_is_wrong_with_a_mesh_file_is_said_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let bad_number = ascii_stl().replacen("10", "ten", 1);
    let not_a_number = ascii_stl().replacen("1e1", "nan", 1);
    let turned = obj().replacen("f 1//1 3//1 2//1", "f 1//1 2//1 3//1", 1);
    let no_such_corner = obj().replacen("f 1//1", "f 9//1", 1);
    let truncated = &binary_stl()[..150];
    let upper = "V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n";
    let wide: Vec<u8> = "\u{feff}v 0 0 0\n"
        .encode_utf16()
        .flat_map(u16::to_be_bytes)
        .collect();
    for (name, bytes) in [
        ("bad.stl", bad_number.as_bytes()),
        ("nan.stl", not_a_number.as_bytes()),
        ("turned.obj", turned.as_bytes()),
        ("corner.obj", no_such_corner.as_bytes()),
        ("short.stl", truncated),
        ("empty.stl", b"".as_slice()),
        ("none.stl", b"solid none\nendsolid none\n".as_slice()),
        ("none.obj", b"# nothing\n".as_slice()),
        ("upper.obj", upper.as_bytes()),
        ("wide.obj", &wide),
        ("part.step", b"ISO-10303-21;\n".as_slice()),
    ] {
        fs::write(folder.join(name), bytes).unwrap();
    }
    for (name, expected) in [
        ("bad.stl", ""),
        ("nan.stl", "which is not a finite number"),
        ("turned.obj", "triangles 0 and"),
        ("corner.obj", ""),
        ("short.stl", ""),
        ("empty.stl", ""),
        ("none.stl", "no triangle"),
        (
            "none.obj",
            "no line of the file begins with \"f\", so it has no face",
        ),
        (
            "upper.obj",
            "lines left out, by their first word: \"F\" (1), \"V\" (3)",
        ),
        ("wide.obj", "its text is UTF-16; save it as UTF-8"),
        ("part.step", "with the extension .stl or .obj"),
        ("missing.stl", "No such file"),
    ] {
        let shape = format!("{{ mesh = {{ file = \"{name}\", unit = \"mm\" }} }}");
        let said = read(folder, &shape).map(|_| ()).unwrap_err();
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(
            said[0].contains(name) && said[0].contains(expected),
            "{name}: {said:?}"
        );
    }
}

#[test]
fn keys_of_a_mesh_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("part.stl"), ascii_stl()).unwrap();
    for (keys, expected) in [
        (
            "file = \"part.stl\"",
            "a mesh file does not contain its unit",
        ),
        (
            "file = \"part.stl\", unit = \"ft\"",
            "unknown variant `ft`, expected one of `m`, `cm`",
        ),
        (
            "file = \"part.stl\", unit = \"mm\", scale = 0.0",
            "scale has 0, and each factor has to be finite and not 0",
        ),
        (
            "file = \"part.stl\", unit = \"mm\", scale = [1.0, 2.0]",
            "scale is one number, or three: scale = [1.0, 1.0, -1.0]",
        ),
        ("unit = \"mm\"", "a mesh needs one of file"),
        (
            "vertices_m = [[0, 0, 0]]",
            "needs both vertices_m and faces",
        ),
        (
            "vertices_m = [[0, 0, 0]], faces = [[0, 0, 1]]",
            "triangle 0 has corner 1",
        ),
        (
            "bumpy_sphere = { radius_m = 0.04, height_m = 0.05, waves = 3.0, cells = 4 }",
            "height_m is 0.05",
        ),
        (
            "bumpy_sphere = { radius_m = 0.04, height_m = 0.0, waves = 3.0, cells = 400 }",
            "cells is 400, and has to be 1 to 288",
        ),
        (
            "revolved = { profile_m = [[0, 0], [0.01, 0]], segments = 8 }",
            "at least three points",
        ),
        (
            "revolved = { profile_m = [[0, 0], [0.01, 0], [0, 0.01]], segments = 100000, longest_m = 1e-4 }",
            "give fewer segments",
        ),
        ("teapot = 1", "unknown key teapot"),
    ] {
        let said = read(folder, &format!("{{ mesh = {{ {keys} }} }}"));
        let said = said.map(|_| ()).unwrap_err().join("; ");
        assert!(said.contains(expected), "{keys}: {said}");
    }
    let several = "[{ box = { size_m = [1, 1, 1] } }, { sphere = { radius_m = 1 } }]";
    let said = read(folder, several).map(|_| ()).unwrap_err().join("; ");
    let expected = "several shapes of a body are one mesh with a closed part for each";
    assert!(said.contains(expected), "{said}");
}

/// A prism has its corners at the radius, in two rings, and the mass properties of the solid.
#[test]
fn a_prism_stands_in_for_a_cylinder() {
    let folder = tempfile::tempdir().unwrap();
    let prism = |keys: &str| {
        read(
            folder.path(),
            &format!("{{ hull = {{ prism = {{ {keys} }} }} }}"),
        )
    };
    let file = prism("sides = 24, radius_m = 0.02, length_m = 0.01").unwrap();
    let Shape::Hull(hull) = &file.scene.world.bodies[0].shape else {
        panic!("no hull");
    };
    assert_eq!((hull.corners().len(), hull.faces().len()), (48, 26));
    for [x, y, z] in hull.corners() {
        assert!((x.hypot(y) - 0.02).abs() < 1e-15 && z.abs() == 0.005);
    }
    let [_, _, about_axis] = hull.mass_properties(1.0).unwrap().moments;
    // Of a regular polygon: r²/6 (2 + cos(2 π/n)).
    let expected = 0.02_f64.powi(2) / 6.0 * (2.0 + (std::f64::consts::TAU / 24.0).cos());
    assert!(
        (about_axis / expected - 1.0).abs() < 1e-9,
        "{about_axis} {expected}"
    );
    for (keys, expected) in [
        (
            "sides = 2, radius_m = 1.0, length_m = 1.0",
            "sides is 2, and a prism has 3 to 32",
        ),
        (
            "sides = 33, radius_m = 1.0, length_m = 1.0",
            "sides is 33, and a prism has 3 to 32",
        ),
        (
            "sides = 3, radius_m = 0.0, length_m = 1.0",
            "radius_m is 0 m",
        ),
        (
            "sides = 3, radius_m = 1.0, length_m = inf",
            "length_m is inf m",
        ),
        ("sides = 3, radius_m = 1.0", "the key length_m is missing"),
        (
            "sides = 3.5, radius_m = 1.0, length_m = 1.0",
            "expected u32",
        ),
    ] {
        let said = prism(keys).map(|_| ()).unwrap_err().join("; ");
        assert!(said.contains(expected), "{keys}: {said}");
    }
    for (keys, expected) in [
        (
            "prism = { sides = 3, radius_m = 1.0, length_m = 1.0 }, points_m = [[0, 0, 0]]",
            "one of points_m, prism and file",
        ),
        (
            "prism = { sides = 3, radius_m = 1.0, length_m = 1.0 }, unit = \"mm\"",
            "unit and scale need a hull file",
        ),
    ] {
        let said = read(folder.path(), &format!("{{ hull = {{ {keys} }} }}"));
        let said = said.map(|_| ()).unwrap_err().join("; ");
        assert!(said.contains(expected), "{keys}: {said}");
    }
}

/// An open mesh is read with a note; triangles without area are omitted and counted.
#[test]
fn open_meshes_and_flat_triangles_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0 0\nf 1 2 3 4\nf 1 2 5\n";
    fs::write(folder.join("plate.obj"), text).unwrap();
    let file = read(folder, "{ mesh = { file = \"plate.obj\", unit = \"cm\" } }").unwrap();
    assert_eq!(
        file.notes(),
        [
            "part, plate.obj: 2 triangles, 10.0000 x 10.0000 x 0.0000 mm; triangles left out (no area, duplicate \
             or between touching parts): 1; it has open edges, so contacts act on the front of its triangles only, \
             which on average faces (0.00, 0.00, 1.00); turned = true reverses it"
        ]
    );
    let inline = "{ mesh = { vertices_m = [[0, 0, 0], [1, 0, 0], [1, 1, 0]], faces = [[0, 1, 2], [0, 1, 1]] } }";
    let file = read(folder, inline).unwrap();
    assert!(!mesh(&file).is_closed());
    assert_eq!(
        file.notes(),
        [
            "part, its mesh: triangles left out (no area, duplicate or between touching parts): 1; it has open edges, \
             so contacts act on the front of its triangles only, which on average faces (0.00, 0.00, 1.00); turned = \
             true reverses it"
        ]
    );
}

/// A mesh of the part with these keys beside its file's.
fn part_with(keys: &str) -> String {
    format!("{{ mesh = {{ file = \"part.stl\", unit = \"mm\", {keys} }} }}")
}

#[test]
fn a_shell_of_points_is_made_as_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("part.stl"), ascii_stl()).unwrap();
    let file = read(folder, &part_with("shell = { points = 30 }")).unwrap();
    let shell = mesh(&file).shell().unwrap();
    assert_eq!(shell.points().len(), 30);
    assert!(mesh(&file).grid().is_none());
    let [note] = file.notes() else {
        panic!("{:?}", file.notes());
    };
    let sharers = format!(
        "part, part.stl: 4 triangles, 10.0000 x 10.0000 x 10.0000 mm; a shell of 30 points, of which {} share a law",
        shell.sharers()
    );
    assert!(note.starts_with(&sharers), "{note}");
    let file = read(folder, &part_with("shell = { points = 30, shared_by = 5 }"));
    assert_eq!(mesh(&file.unwrap()).shell().unwrap().sharers(), 5);
    for (keys, expected) in [
        (
            "shell = { points = 3 }",
            "the shell has 3 points, and has to have 4 to 2048",
        ),
        ("shell = { points = 2049 }", "the shell has 2049 points"),
        (
            "shell = { points = 400 }",
            "lie in one plane, and at most 64 may touch at a time",
        ),
        (
            "shell = { points = -1 }",
            "expected a whole number from 0 up",
        ),
        (
            "shell = { points = 9, shared_by = 10 }",
            "the law is shared by 10 points, and has to be shared by 1 to 9",
        ),
        ("shell = { point = 9 }", "unknown key point"),
    ] {
        let said = read(folder, &part_with(keys)).map(|_| ()).unwrap_err();
        assert!(said.join("; ").contains(expected), "{keys}: {said:?}");
    }
}

#[test]
fn a_distance_grid_is_kept_in_its_file_and_made_anew_where_that_is_of_another_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("part.stl"), ascii_stl()).unwrap();
    let asked = |spacing: f64| {
        let keys = format!("distance_grid = {{ spacing_m = {spacing}, file = \"part.grid\" }}");
        read(folder, &part_with(&keys))
    };
    let note = |file: &WorldFile| file.notes().join("; ");
    let made = asked(0.001).unwrap();
    assert!(
        note(&made).contains("nodes, saved in part.grid; its surface deviates"),
        "{}",
        note(&made)
    );
    let kept = fs::read(folder.join("part.grid")).unwrap();
    let again = asked(0.001).unwrap();
    assert!(
        note(&again).contains("nodes, from part.grid;"),
        "{}",
        note(&again)
    );
    assert_eq!(mesh(&again).grid(), mesh(&made).grid());
    assert_eq!(fs::read(folder.join("part.grid")).unwrap(), kept);
    let finer = asked(0.0009).unwrap();
    assert!(note(&finer).contains("recomputed because the saved one is of another mesh"));
    assert_ne!(fs::read(folder.join("part.grid")).unwrap(), kept);
    let moved = ascii_stl().replacen("1e1", "1.1e1", 12);
    fs::write(folder.join("part.stl"), moved).unwrap();
    let other = asked(0.0009).unwrap();
    assert!(note(&other).contains("recomputed"), "{}", note(&other));
    // Cut off, and no grid at all: neither is taken, and neither is written over.
    let whole = fs::read(folder.join("part.grid")).unwrap();
    for (bytes, expected) in [
        (&whole[..whole.len() / 2], "truncated or corrupted"),
        (
            b"somebody's notes".as_slice(),
            "not a distance grid of palpate",
        ),
    ] {
        fs::write(folder.join("part.grid"), bytes).unwrap();
        let said = asked(0.0009).map(|_| ()).unwrap_err().join("; ");
        assert!(
            said.contains("part.grid") && said.contains(expected) && said.contains("remove it"),
            "{said}"
        );
        assert_eq!(fs::read(folder.join("part.grid")).unwrap(), bytes);
    }
    // An untrusted scene writes only next to its own file.
    let outside = tempfile::tempdir().unwrap();
    let root = outside.path().join("part.grid").display().to_string();
    for name in [
        "../part.grid",
        "parts/../../part.grid",
        &*root,
        "",
        ".",
        "..",
    ] {
        let keys = format!("distance_grid = {{ spacing_m = 0.001, file = {name:?} }}");
        let said = read(folder, &part_with(&keys)).map(|_| ()).unwrap_err();
        let said = said.join("; ");
        assert!(said.contains("distance_grid.file is"), "{name}: {said}");
        assert!(
            said.contains("in the scene's folder or below"),
            "{name}: {said}"
        );
    }
    assert!(!Path::new(&root).exists());
    fs::create_dir(folder.join("parts")).unwrap();
    let keys = "distance_grid = { spacing_m = 0.001, file = \"./parts/part.grid\" }";
    read(folder, &part_with(keys)).unwrap();
    assert!(folder.join("parts/part.grid").exists());
    // A link would lead elsewhere, be it the file or its folder.
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink(outside.path(), folder.join("away")).unwrap();
        symlink(&root, folder.join("linked.grid")).unwrap();
        for name in ["away/part.grid", "linked.grid"] {
            let keys = format!("distance_grid = {{ spacing_m = 0.001, file = {name:?} }}");
            let said = read(folder, &part_with(&keys)).map(|_| ()).unwrap_err();
            let said = said.join("; ");
            assert!(
                said.contains(name) && said.contains("symbolic link"),
                "{said}"
            );
        }
        assert!(!Path::new(&root).exists());
    }
    // Where nothing can be kept, the scene is whole all the same.
    let keys = "distance_grid = { spacing_m = 0.001, file = \"nowhere/part.grid\" }";
    let file = read(folder, &part_with(keys)).unwrap();
    assert!(mesh(&file).grid().is_some());
    assert!(
        note(&file).contains("nodes, not saved: "),
        "{}",
        note(&file)
    );
}

#[test]
fn a_distance_grid_that_cannot_be_made_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("part.stl"), ascii_stl()).unwrap();
    for (spacing, expected) in [
        ("0.0", "the spacing is 0 m, and has to be above 0 m"),
        ("0.003", "it has to be four spacings or more"),
        ("1e-6", "at most 8388608 are allowed"),
    ] {
        let keys = format!("distance_grid = {{ spacing_m = {spacing} }}");
        let said = read(folder, &part_with(&keys)).map(|_| ()).unwrap_err();
        assert!(said.join("; ").contains(expected), "{spacing}: {said:?}");
    }
    let open = "{ mesh = { vertices_m = [[0, 0, 0], [1, 0, 0], [1, 1, 0]], faces = [[0, 1, 2]], \
                distance_grid = { spacing_m = 0.01 } } }";
    let said = read(folder, open).map(|_| ()).unwrap_err().join("; ");
    assert!(said.contains("the mesh has open edges"), "{said}");
}

#[test]
fn a_mesh_is_scaled_by_axis_mirrored_and_turned() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("part.stl"), ascii_stl()).unwrap();
    let sheet = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.join("sheet.obj"), sheet).unwrap();
    let with = |file: &str, keys: &str| {
        let keys = format!("{{ mesh = {{ file = \"{file}\", unit = \"mm\", {keys} }} }}");
        read(folder, &keys)
    };
    let volume = |keys: &str| mesh(&with("part.stl", keys).unwrap()).volume();
    let whole = volume("scale = 1");
    for keys in ["scale = [-1, 1, 1]", "scale = -1", "scale = [1, -2, 0.5]"] {
        assert!((volume(keys) - whole).abs() < 1e-12 * whole, "{keys}");
    }
    let normal_z = |keys: &str| {
        let file = with("sheet.obj", keys).unwrap();
        let mesh = mesh(&file);
        let [a, b, c] = mesh.faces()[0].map(|corner| mesh.vertices()[corner as usize]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum()
    };
    assert_eq!(normal_z("scale = 1"), 1.0);
    // A mirror keeps the front of a shape, and reverses the order of its corners.
    assert_eq!(normal_z("scale = [-1, 1, 1]"), 1.0);
    assert_eq!(normal_z("turned = true"), -1.0);
    let said = with("part.stl", "turned = true").map(|_| ()).unwrap_err();
    assert!(said[0].contains("turned is for an open mesh"), "{said:?}");
}

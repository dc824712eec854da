//! Polygons and lines of OBJ files.

use std::fs;

use crate::mesh_files::{mesh, obj, read};

#[test]
fn polygons_of_an_obj_file_keep_their_notches_and_ignore_weights() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ell = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]];
    for (first, more) in (0..6).flat_map(|first| ["", " 2", " 0.2 0.4 0.6 1"].map(|m| (first, m))) {
        let mut text = String::new();
        for z in [0, 1] {
            for [x, y] in ell {
                text += &format!("v {x} {y} {z}{more}\n");
            }
        }
        let turn = |k: usize| (first + k) % 6 + 1;
        let top: Vec<_> = (0..6).map(|k| (turn(k) + 6).to_string()).collect();
        let bottom: Vec<_> = (0..6).rev().map(|k| turn(k).to_string()).collect();
        text += &format!("f {} \\\n{}\n", top[..3].join(" "), top[3..].join(" "));
        text += &format!("f {}\n", bottom.join(" "));
        for k in 0..6 {
            let (a, b) = (k + 1, (k + 1) % 6 + 1);
            text += &format!("f {a} {b} {} {}\n", b + 6, a + 6);
        }
        fs::write(folder.join("ell.obj"), text).unwrap();
        let file = read(folder, "{ mesh = { file = \"ell.obj\", unit = \"m\" } }").unwrap();
        let mesh = mesh(&file);
        assert!(mesh.is_closed() && (mesh.volume() - 5.0).abs() < 1e-9);
        // A folded cap has a larger surface than an even one.
        let area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|k| mesh.vertices()[k as usize]);
            let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            (p[0] * q[1] - p[1] * q[0]).abs() / 2.0
        };
        assert!((mesh.faces().iter().map(area).sum::<f64>() - 10.0).abs() < 1e-9);
    }
    let crossed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0.5 2 0\nf 1 2 3 4 5\n";
    fs::write(folder.join("crossed.obj"), crossed).unwrap();
    let said = read(
        folder,
        "{ mesh = { file = \"crossed.obj\", unit = \"m\" } }",
    )
    .map(|_| ());
    assert!(said.unwrap_err()[0].contains("line 6: the outline of a face crosses itself"));
    let zero = obj().replacen("f 1//1", "f 0//1", 1);
    fs::write(folder.join("zero.obj"), zero).unwrap();
    let said = read(folder, "{ mesh = { file = \"zero.obj\", unit = \"m\" } }").map(|_| ());
    assert!(said.unwrap_err()[0].contains("counted from 1"));
}

#[test]
fn lines_of_an_obj_file_end_as_any_system_writes_them_and_none_is_left_out_silently() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The comment does not continue in the next line.
    let text = format!("# C:\\parts\\\n{}", obj());
    for (ends, more, note) in [
        ("\n", "", ""),
        ("\r", "", ""),
        ("\r\n", "", ""),
        (
            "\n",
            "g part\ncall more.obj\nsurf 0 1 0 1 1\nsurf 0 1 0 1 2\n",
            "\"call\" (1), \"surf\" (2)",
        ),
    ] {
        let bytes = (text.clone() + more).replace('\n', ends);
        fs::write(folder.join("part.obj"), bytes).unwrap();
        let file = read(folder, "{ mesh = { file = \"part.obj\", unit = \"mm\" } }").unwrap();
        assert!(mesh(&file).is_closed());
        let said = file.notes().join("; ");
        assert_eq!(said.contains("lines left out"), !note.is_empty(), "{said}");
        assert!(said.contains(note), "{said}");
    }
}

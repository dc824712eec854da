//! Force fields in scene files, and their error messages.
#![allow(missing_docs)]

use palpate_scene::world::WorldFile;
use palpate_world::{Field, FieldKind};

const KNOB: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "knob"
mass_kg = 0.2
[[field]]
on = "knob"
potential = { detents = { at_m = [0.0, 0.0, 0.1], axis = [2.0, 0.0, 0.0], positions = 5, period_m = 0.01, amplitude_j = 1e-3, stiffness_n_per_m = 800.0 } }
[[field]]
on = "knob"
potential = { line = { at_m = [0.0, 0.0, 0.1], axis = [1.0, 0.0, 0.0], stiffness_n_per_m = 500.0, range_m = 0.02 } }
[[field]]
on = "knob"
potential = { point = { at_m = [0.0, 0.1, 0.0], stiffness_n_per_m = 5.0, range_m = 0.1 } }
[[field]]
on = "knob"
potential = { plane = { at_m = [0.0, 0.0, 0.1], normal = [0.0, 0.0, 3.0], stiffness_n_per_m = 50.0, range_m = 0.1 } }
[[field]]
on = "knob"
potential = { constant = { force_n = [0.0, 0.0, -0.5] } }
"#;

#[test]
fn fields_are_read() {
    let file = WorldFile::parse("knob.toml", KNOB).unwrap();
    let (at, axis) = ([0.0, 0.0, 0.1], [1.0, 0.0, 0.0]);
    let kinds = [
        FieldKind::Detents {
            at,
            axis,
            positions: 5,
            period: 0.01,
            amplitude: 1e-3,
            stiffness: 800.0,
        },
        FieldKind::Line {
            at,
            axis,
            stiffness: 500.0,
            range: 0.02,
        },
        FieldKind::Point {
            at: [0.0, 0.1, 0.0],
            stiffness: 5.0,
            range: 0.1,
        },
        FieldKind::Plane {
            at,
            normal: [0.0, 0.0, 1.0],
            stiffness: 50.0,
            range: 0.1,
        },
        FieldKind::Constant {
            force: [0.0, 0.0, -0.5],
        },
    ];
    let expected = kinds.map(|kind| Field {
        tool: "knob".into(),
        kind,
    });
    assert_eq!(file.scene.world.fields, expected);
    // A field is felt without a contact.
    assert!(file.notes().is_empty(), "{:?}", file.notes());
}

#[test]
fn a_detent_without_stops_ends_freely() {
    let without = KNOB.replacen(", stiffness_n_per_m = 800.0", "", 1);
    let fields = WorldFile::parse("knob.toml", &without)
        .unwrap()
        .scene
        .world
        .fields;
    assert!(matches!(
        fields[0].kind,
        FieldKind::Detents { stiffness: 0.0, .. }
    ));
}

#[test]
fn faults_of_fields_have_their_place_and_say_what_is_allowed() {
    for (right, wrong, message) in [
        (
            "on = \"knob\"",
            "on = \"nob\"",
            ":9:6: field 0 on \"nob\": \"nob\" is not a tool of this world",
        ),
        (
            "positions = 5",
            "positions = 0",
            ":10:87: field 0 on \"knob\": positions is 0, and has to be at least 1",
        ),
        (
            "period_m = 0.01",
            "period_m = 0.0",
            "period is 0, and has to be above 0",
        ),
        (
            "amplitude_j = 1e-3",
            "amplitude_j = -1e-3",
            "amplitude is -0.001, and has to be at least 0",
        ),
        (
            "range_m = 0.02",
            "range_m = inf",
            "range is inf, and has to be finite",
        ),
        (
            "axis = [2.0, 0.0, 0.0]",
            "axis = [0.0, 0.0, 0.0]",
            "axis has length 0, so it has no direction; give a finite length above 0",
        ),
        (
            "point = {",
            "magnet = {",
            "unknown variant `magnet`, expected one of `point`, `line`, `plane`, `detents`, `constant`",
        ),
        (", range_m = 0.02", "", "the key range_m is missing"),
        (
            "force_n = [0.0, 0.0, -0.5]",
            "force_n = [0.0, 0.0, -0.5], range_m = 1.0",
            "range_m",
        ),
    ] {
        let errors = WorldFile::parse("knob.toml", &KNOB.replacen(right, wrong, 1)).unwrap_err();
        let said: Vec<_> = errors.iter().map(ToString::to_string).collect();
        assert!(
            said.iter().any(|said| said.contains(message)),
            "{wrong}: {said:?}"
        );
    }
}

#[test]
fn all_methods_leave_out_those_that_render_no_fields() {
    let scene = WorldFile::parse("knob.toml", KNOB).unwrap().scene;
    assert!(scene.method("coupled").is_ok() && scene.method("basic").is_ok());
    for name in ["seh", "hfcr-mod-st"] {
        let error = scene.method(name).unwrap_err().to_string();
        let expected = format!("{name} renders no force fields, and the world has 5");
        assert!(error.contains(&expected), "{error}");
    }
}

//! Edits of a scene before it is read.

use palpate_scene::{Edit, SceneFile, Source};

use crate::common::experiments;

/// Text of a committed scene.
fn committed(name: &str) -> String {
    std::fs::read_to_string(experiments().join(name)).unwrap()
}

/// Reads the text with these edits, or returns the messages.
fn read(text: &str, edits: &[&str]) -> Result<SceneFile, String> {
    let edits: Vec<_> = edits
        .iter()
        .map(|edit| Edit::parse("--set", edit).unwrap())
        .collect();
    let source = Source::new("scene.toml", text).edited(&edits);
    SceneFile::parse_edited(&source).map_err(|errors| errors.to_string())
}

fn contact(edits: &[&str]) -> palpate_scene::Scene {
    match read(&committed("fig2.toml"), edits).unwrap() {
        SceneFile::Contact(file) => file.scene,
        SceneFile::World(_) => panic!("a world"),
    }
}

#[test]
fn an_edit_is_the_same_as_a_change_of_the_text() {
    let text = committed("fig2.toml");
    let changed = text.replace("mass_kg = 0.1\nposition", "mass_kg = 0.2\nposition");
    assert_ne!(text, changed);
    let SceneFile::Contact(expected) = SceneFile::parse("scene.toml", &changed).unwrap() else {
        panic!("a world")
    };
    for path in [
        "body.0.mass_kg",
        "body.mass_kg",
        "body[object].mass_kg",
        "body.object.mass_kg",
    ] {
        assert_eq!(contact(&[&format!("{path}=0.2")]), expected.scene, "{path}");
    }
}

#[test]
fn keys_and_tables_that_the_file_lacks_are_added_and_others_are_removed() {
    let scene = contact(&[
        "loop.delay_s=0.01",
        "device.hand.tremor_n = 0.1",
        "device.hand.tremor_hz=8",
        "render.method=coupled",
        "body.position_m.0=0.11",
        "measure.collisions=",
        "measure.duration_s=0.25",
    ]);
    assert_eq!(scene.method.name(), "coupled");
    assert_eq!(scene.object.position, 0.11);
    assert_eq!(scene.measure, palpate_scene::Measure::Duration(0.25));
    assert_eq!(scene.delay.seconds(), 0.01);
}

#[test]
fn the_edited_text_reads_as_the_edited_scene() {
    let edits = ["loop.period_s=0.004", "body.object.force_n=[-0.5, 0, 0]"];
    let parsed = edits.map(|edit| Edit::parse("--set", edit).unwrap());
    let source = Source::new("scene.toml", &committed("fig2.toml")).edited(&parsed);
    let text = source.edited_text().unwrap();
    let SceneFile::Contact(file) = SceneFile::parse("scene.toml", &text).unwrap() else {
        panic!("a world")
    };
    assert_eq!(file.scene, contact(&edits));
}

/// A fault in an edit names the flag; a fault in the file keeps its line.
#[test]
fn errors_name_the_flag_the_key_the_value_and_what_is_allowed() {
    for (edits, expected) in [
        (
            vec!["body.0.mass_kg=-1"],
            "--set body.0.mass_kg=-1: body.mass_kg is -1 kg, but must be finite and greater than 0",
        ),
        (
            vec!["body.0.mas_kg=1"],
            "--set body.0.mas_kg=1: unknown key mas_kg, did you mean mass_kg? Known here: ",
        ),
        (
            vec!["bdy.0.mass_kg=1"],
            "--set bdy.0.mass_kg=1: unknown key bdy, did you mean body? Known here: ",
        ),
        (
            vec!["loop.period_s=fast"],
            "--set loop.period_s=fast: invalid type: string \"fast\", expected a number",
        ),
        (
            vec!["body.3.mass_kg=1"],
            "--set body.3.mass_kg=1: body.3 does not exist; the last is body.0",
        ),
        (
            vec!["joint.0.name=a"],
            "--set joint.0.name=a: the scene has no [[joint]]",
        ),
        (
            vec!["loop.period_s.x=1"],
            "--set loop.period_s.x=1: loop.period_s is a value and has no key x",
        ),
        (
            vec!["loop.delay_s="],
            "--set loop.delay_s=: there is no loop.delay_s to remove",
        ),
        (
            vec!["body.0.position_m.x=1"],
            "--set body.0.position_m.x=1: body.0.position_m is a list of 3 values; choose one by its number",
        ),
        (vec!["render.method=hfrc"], "--set render.method=hfrc: "),
    ] {
        let error = read(&committed("fig2.toml"), &edits).unwrap_err();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let text = committed("fig2.toml").replace("period_s = 0.01", "period_s = 0");
    let error = read(&text, &["body.0.mass_kg=0.2"]).unwrap_err();
    assert!(error.starts_with("scene.toml:7:12: "), "{error}");
}

#[test]
fn an_entry_of_several_is_chosen() {
    let text = committed("worlds/pushed-block.toml");
    let error = read(&text, &["body.mass_kg=1"]).unwrap_err();
    assert!(
        error.contains("none is called mass_kg; choose one of body["),
        "{error}"
    );
}

#[test]
fn a_text_that_is_no_edit_is_refused() {
    for (text, expected) in [
        ("body.0.mass_kg", "a key and its value are needed"),
        (
            "body..mass_kg=1",
            "`body..mass_kg` is not the path of a key",
        ),
        ("body[0.mass_kg=1", "is not the path of a key"),
        ("title=1 2", "`1 2` is not a value of TOML"),
        ("a=[1", "`[1` is not a value of TOML"),
    ] {
        let error = Edit::parse("--set", text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn numbers_keep_their_bits() {
    for value in [0.1, 1e-7, -0.0, 3.0, 1e20, f64::MIN_POSITIVE] {
        let edit = Edit::number("--key", "body.0.position_m.0", value).unwrap();
        let source = Source::new("scene.toml", &committed("fig2.toml")).edited(&[edit]);
        let text = source.edited_text().unwrap();
        let table: toml::Table = text.parse().unwrap();
        let found = &table["body"][0]["position_m"][0];
        let found = found.as_float().or(found.as_integer().map(|it| it as f64));
        assert_eq!(found.unwrap().to_bits(), value.to_bits(), "{value}");
    }
}

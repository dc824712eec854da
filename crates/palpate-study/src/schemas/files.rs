//! The files of `docs/schema`, compared with the types that they are made from. `palpate-cli` uses
//! this file, too.

use std::collections::BTreeSet;
use std::path::PathBuf;

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};

/// Schema files by the crate of their type.
const FILES: [(&str, &[&str]); 2] = [
    (
        "palpate-cli",
        &[
            "bench-loop",
            "devices",
            "devices-check",
            "doctor",
            "pipe",
            "run",
            "world-pipe",
        ],
    ),
    (
        "palpate-study",
        &[
            "advise",
            "calibrate",
            "card",
            "claims",
            "compare",
            "demo",
            "figure",
            "heights",
            "info",
            "map-report",
            "report",
            "suite",
            "sweep",
            "tune",
            "world",
            "world-suite",
            "world-tune",
        ],
    ),
];

/// A non-finite number, such as the error of a diverged loop, is `null` in JSON.
#[derive(Clone)]
struct NullForNotFinite;

impl Transform for NullForNotFinite {
    fn transform(&mut self, schema: &mut Schema) {
        if schema.get("type").is_some_and(|kind| kind == "number") {
            schema.insert("type".into(), serde_json::json!(["number", "null"]));
        }
        transform_subschemas(self, schema);
    }
}

/// Returns the schema of a report, as in its file.
pub fn schema<R: JsonSchema>() -> String {
    let settings = SchemaSettings::draft2020_12()
        .for_serialize()
        .with_transform(NullForNotFinite);
    let schema = settings.into_generator().into_root_schema_for::<R>();
    serde_json::to_string_pretty(&schema).unwrap() + "\n"
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema")
}

/// Compares the files of this crate with these schemas, or writes them.
pub fn are(schemas: &[(&str, String)]) {
    let writes = std::env::var_os("PALPATE_WRITE_SCHEMAS").is_some();
    for (name, schema) in schemas {
        let path = folder().join(name).with_extension("json");
        if writes {
            std::fs::write(&path, schema).unwrap();
        }
        let committed = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            committed == *schema,
            "{} is not the schema of the report; write it anew as docs/reference/reports.md says",
            path.display()
        );
    }
    let this = env!("CARGO_PKG_NAME");
    let (_, ours) = FILES.iter().find(|(name, _)| *name == this).unwrap();
    let ours: BTreeSet<&str> = ours.iter().copied().collect();
    let names: BTreeSet<&str> = schemas.iter().map(|(name, _)| *name).collect();
    #[cfg(unix)]
    assert_eq!(names, ours);
    #[cfg(not(unix))]
    assert!(ours.is_superset(&names));

    let all: BTreeSet<String> = FILES
        .iter()
        .flat_map(|(_, names)| names.iter().map(|name| format!("{name}.json")))
        .collect();
    let there: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".json"))
        .collect();
    assert_eq!(there, all);
}

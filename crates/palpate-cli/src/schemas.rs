//! The JSON schema of every report, as `docs/schema` has it.
//!
//! `PALPATE_WRITE_SCHEMAS=1 cargo test --release -p palpate-cli --lib schemas` writes these files anew.

use std::collections::BTreeSet;
use std::path::PathBuf;

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};

use crate::commands::demo;
use palpate_pipe as pipe;
use palpate_session as session;
use palpate_study::{
    advise, calibration, card, claims, compare, heights, map, recording, report, suite, sweep,
    tune, world,
};

/// A number that is not finite, such as the error of a loop that ran away, is `null` in JSON.
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

fn schema<R: JsonSchema>() -> String {
    let settings = SchemaSettings::draft2020_12()
        .for_serialize()
        .with_transform(NullForNotFinite);
    let schema = settings.into_generator().into_root_schema_for::<R>();
    serde_json::to_string_pretty(&schema).unwrap() + "\n"
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema")
}

#[test]
fn the_committed_schemas_are_those_of_the_reports() {
    let schemas = [
        ("advise", schema::<advise::Advice>()),
        ("bench-loop", schema::<Vec<session::BenchReport>>()),
        ("calibrate", schema::<calibration::CalibrationReport>()),
        ("card", schema::<card::Card>()),
        ("claims", schema::<claims::report::ClaimsReport>()),
        ("compare", schema::<compare::Comparison>()),
        ("demo", schema::<demo::DemoReport>()),
        ("devices", schema::<session::DeviceList>()),
        #[cfg(unix)]
        ("devices-check", schema::<session::MotorsReport>()),
        ("doctor", schema::<session::MachineReport>()),
        ("figure", schema::<report::DrawingReport>()),
        ("heights", schema::<heights::report::HeightsReport>()),
        ("info", schema::<recording::report::RecordingReport>()),
        ("map-report", schema::<map::report::MapReport>()),
        ("pipe", schema::<pipe::PipeSummary>()),
        ("report", schema::<report::Report>()),
        ("run", schema::<session::RunReport>()),
        ("suite", schema::<suite::report::SuiteReport>()),
        ("sweep", schema::<sweep::report::SweepReport>()),
        ("tune", schema::<tune::report::TuneReport>()),
        ("world", schema::<world::WorldReport>()),
        ("world-compare", schema::<world::compare::WorldComparison>()),
        ("world-suite", schema::<world::suite::WorldSuiteReport>()),
        ("world-tune", schema::<world::tune::WorldTuneReport>()),
        ("world-pipe", schema::<pipe::world::WorldSummary>()),
    ];
    let writes = std::env::var_os("PALPATE_WRITE_SCHEMAS").is_some();
    for (name, schema) in &schemas {
        let path = folder().join(name).with_extension("json");
        if writes {
            std::fs::write(&path, schema).unwrap();
        }
        let committed = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            committed == *schema,
            "{} is not the schema of the report; write it anew as the head of schemas.rs says",
            path.display()
        );
    }
    let names: BTreeSet<String> = schemas
        .iter()
        .map(|(name, _)| format!("{name}.json"))
        .collect();
    let there: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".json"))
        .collect();
    #[cfg(unix)]
    assert_eq!(there, names);
    #[cfg(not(unix))]
    assert!(there.is_superset(&names));
}

//! JSON schemas of the reports of this crate; the files are in `docs/schema`.
//!
//! `docs/reference/reports.md` gives the command that regenerates these files.

mod files;

use crate::{
    advise, calibration, card, claims, compare, heights, map, recording, report, suite, sweep,
    tune, world,
};
use files::schema;

#[test]
fn the_committed_schemas_are_those_of_the_reports() {
    files::are(&[
        ("advise", schema::<advise::Advice>()),
        ("calibrate", schema::<calibration::CalibrationReport>()),
        ("card", schema::<card::Card>()),
        ("claims", schema::<claims::report::ClaimsReport>()),
        ("compare", schema::<compare::Comparison>()),
        ("demo", schema::<report::DemoReport>()),
        ("figure", schema::<report::DrawingReport>()),
        ("heights", schema::<heights::report::HeightsReport>()),
        ("info", schema::<recording::report::RecordingReport>()),
        ("map-report", schema::<map::report::MapReport>()),
        ("report", schema::<report::Report>()),
        ("suite", schema::<suite::report::SuiteReport>()),
        ("sweep", schema::<sweep::report::SweepReport>()),
        ("tune", schema::<tune::report::TuneReport>()),
        ("world", schema::<world::WorldReport>()),
        ("world-suite", schema::<world::suite::WorldSuiteReport>()),
        ("world-tune", schema::<world::tune::WorldTuneReport>()),
    ]);
}

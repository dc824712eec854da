//! The JSON schemas of the reports of this crate, as in `docs/schema`.

#[path = "../../palpate-study/src/schemas/files.rs"]
mod files;

use crate::pipe::{PipeSummary, world};
#[cfg(unix)]
use crate::reports::MotorsReport;
use crate::reports::{BenchReport, DeviceList, MachineReport, RunReport};
use files::schema;

#[test]
fn the_committed_schemas_are_those_of_the_reports() {
    files::are(&[
        ("bench-loop", schema::<Vec<BenchReport>>()),
        ("devices", schema::<DeviceList>()),
        #[cfg(unix)]
        ("devices-check", schema::<MotorsReport>()),
        ("doctor", schema::<MachineReport>()),
        ("pipe", schema::<PipeSummary>()),
        ("run", schema::<RunReport>()),
        ("world-pipe", schema::<world::WorldSummary>()),
    ]);
}

//! JSON schemas of the reports of this crate; the files are in `docs/schema`.

#[path = "../../palpate-study/src/schemas/files.rs"]
mod files;

#[cfg(unix)]
use crate::MotorsReport;
use crate::{BenchReport, DeviceList, MachineReport, RunReport};
use files::schema;

#[test]
fn the_committed_schemas_are_those_of_the_reports() {
    files::are(&[
        ("bench-loop", schema::<Vec<BenchReport>>()),
        ("devices", schema::<DeviceList>()),
        #[cfg(unix)]
        ("devices-check", schema::<MotorsReport>()),
        ("doctor", schema::<MachineReport>()),
        ("run", schema::<RunReport>()),
    ]);
}

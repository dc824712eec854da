//! The JSON schemas of all summaries, as in `docs/schema`.

#[path = "../../../palpate-study/src/schemas/files.rs"]
mod files;

use crate::pipe::{PipeSummary, world};
use files::schema;

#[test]
fn the_committed_schemas_are_those_of_the_summaries() {
    files::are(&[
        ("pipe", schema::<PipeSummary>()),
        ("world-pipe", schema::<world::WorldSummary>()),
    ]);
}

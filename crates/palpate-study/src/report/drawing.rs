//! Report on a figure without runs.

use std::path::Path;

use serde::Serialize;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate figure 1";

/// A written drawing.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DrawingReport {
    /// Files that were written.
    pub files: [String; 1],
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
}

impl DrawingReport {
    /// Creates the report on a drawing in the file at `path`.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self {
            files: [path.display().to_string()],
            format: FORMAT,
        }
    }
}

//! Reports as JSON.

use serde::Serialize;

/// Returns the JSON of a report, on several lines. A non-finite number, such as the error of a diverged loop, is
/// `null`.
pub fn json(report: &impl Serialize) -> String {
    serde_json::to_string_pretty(report).expect("a report has string keys only")
}

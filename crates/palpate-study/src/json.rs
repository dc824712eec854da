//! Reports as JSON.

use serde::Serialize;

/// The JSON of a report, on several lines. A number that is not finite, such as the error of a loop that ran
/// away, is `null`.
pub fn json(report: &impl Serialize) -> String {
    serde_json::to_string_pretty(report).expect("a report has string keys only")
}

//! Results of a sweep as CSV.

use super::report::SweepReport;

/// Columns of the table.
pub const COLUMNS: [&str; 21] = [
    "over",
    "value",
    "and",
    "and_value",
    "column",
    "method",
    "hold_bound_percent",
    "ideal_peak_force_n",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "median_force_rendering_error_percent",
    "worst_force_rendering_error_percent",
    "peak_force_n",
    "absolute_leak_held_j",
    "leak_j",
    "refused_samples",
    "largest_rebound_energy",
    "bounce",
    "left_box_at_s",
    "almost_stable_heights",
    "left_box_heights",
];

impl SweepReport {
    /// Returns a row for each value and column, in the order of [`COLUMNS`]; missing values are empty.
    pub fn rows(&self) -> impl Iterator<Item = [String; COLUMNS.len()]> + '_ {
        self.values.iter().flat_map(move |at| {
            at.columns.iter().map(move |of| {
                [
                    self.over.clone(),
                    at.value.to_string(),
                    text(self.and.as_deref()),
                    text(at.and_value),
                    of.name.clone(),
                    of.method.into(),
                    at.hold_bound_percent.to_string(),
                    at.ideal_peak_force_n.to_string(),
                    of.mean_force_error_percent.to_string(),
                    of.force_rendering_error_percent.to_string(),
                    text(of.median_force_rendering_error_percent),
                    text(of.worst_force_rendering_error_percent),
                    of.peak_force_n.to_string(),
                    text(of.absolute_leak_held_j),
                    text(of.leak_j),
                    text(of.refused_samples),
                    text(of.largest_rebound_energy),
                    text(of.bounce),
                    text(of.left_box_at_s),
                    text(of.almost_stable_heights),
                    text(of.left_box_heights),
                ]
            })
        })
    }
}

/// Returns the value as text, or nothing.
pub(crate) fn text(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

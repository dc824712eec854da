//! One-sentence results of runs for the titles of figures, computed from the runs.

use palpate_study::sim::run::Run;
use palpate_study::text::{digits, percent};

/// Maximum number of names in a sentence; above it the sentence gives their number.
const MAX_NAMES: usize = 3;

/// Returns the result of some runs, each with its name in the figure. Returns `None` if the ideal has no contact,
/// since the error is then undefined.
pub fn of_runs(runs: &[&Run], names: &[&str]) -> Option<String> {
    let errors: Vec<Option<f64>> = runs.iter().map(|run| error(run)).collect();
    let floor = runs.iter().find_map(|run| run.force.fidelity)?.hold_bound;
    let floor = format!("hold bound {} %", percent(floor));
    let broken: Vec<&str> = (runs.iter().zip(names))
        .filter(|(run, _)| end(run).is_some())
        .map(|(_, name)| *name)
        .collect();
    if let ([run], [name]) = (runs, names) {
        let error = percent(errors[0]?);
        let leak = digits(1e3 * run.last().ledger.held_leak.absolute);
        let end = end(run).map_or_else(String::new, |end| format!("; it {end}"));
        return Some(format!(
            "{name}: FRE {error} % ({floor}), leaks of {leak} mJ{end}"
        ));
    }
    let whole = (runs.iter().zip(names).zip(&errors))
        .filter(|((run, _), _)| end(run).is_none())
        .filter_map(|((_, name), error)| Some((*name, (*error)?)));
    let nearest = whole.clone().min_by(|a, b| a.1.total_cmp(&b.1));
    let farthest = whole.max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((near, least)) = nearest else {
        return Some(format!(
            "All {} methods diverged or were stopped",
            runs.len()
        ));
    };
    let mut text = format!(
        "Nearest to the ideal: {near}, FRE {} % ({floor})",
        percent(least)
    );
    if !broken.is_empty() {
        let what = if broken.len() <= MAX_NAMES {
            broken.join(", ")
        } else {
            format!("{} of {}", broken.len(), runs.len())
        };
        text += &format!("; diverged or stopped: {what}");
    }
    // A run that ended early is not the worst of the bounded runs, although its error may be larger.
    if let Some((far, most)) = farthest.filter(|(far, _)| *far != near) {
        let of_whom = if broken.is_empty() {
            ""
        } else {
            " of the others"
        };
        text += &format!("; farthest{of_whom}: {far}, {} %", percent(most));
    }
    Some(text)
}

/// Returns the FRE of a run `[%]`.
pub fn error(run: &Run) -> Option<f64> {
    let error = run.force.fidelity?.force_rendering_error;
    error.is_finite().then_some(error)
}

/// Returns the reason for an early end of a run; `None` for a complete run.
pub fn end(run: &Run) -> Option<&'static str> {
    if run.diverged == Some(true) {
        Some("diverges")
    } else if run.left_box_at.is_some() {
        Some("leaves the safety box")
    } else if run.jammed_at.is_some() {
        Some("jams")
    } else {
        None
    }
}

//! The claims as text or as JSON.

use std::fmt;

use comfy_table::CellAlignment;
use serde::Serialize;

use super::{Claim, Found};
use crate::text::{digits, hanging, number, plain_table, whole, within};

/// Maximum length of the meaning of a number: 80 characters less the number, its unit and `does not fit`.
const FOUND: usize = 50;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate claims 1";

/// The claims of the paper with their computed numbers.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClaimsReport {
    /// One entry for each claim.
    pub claims: Vec<ClaimReport>,
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
}

/// A claim, its computed numbers, and whether it holds here.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClaimReport {
    /// The computed numbers.
    pub found: Vec<FoundReport>,
    /// `holds`, `holds in part` or `does not hold`.
    pub holds: &'static str,
    /// Short name.
    pub name: &'static str,
    /// The paper's statement, paraphrased.
    pub paper: &'static str,
    /// Criterion for the claim to hold here.
    pub takes: String,
}

/// A computed number.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FoundReport {
    /// Whether this number satisfies the claim, if it is decisive.
    pub fits: Option<bool>,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// The number; none if it does not exist, for example the time of an event that did not happen.
    pub value: Option<f64>,
    /// Meaning of the number.
    pub what: String,
}

impl ClaimsReport {
    /// Creates the report of the result of [`check`](super::check).
    pub fn new(claims: Vec<Claim>) -> Self {
        Self {
            claims: claims.into_iter().map(ClaimReport::from).collect(),
            format: FORMAT,
        }
    }
}

impl From<Claim> for ClaimReport {
    fn from(claim: Claim) -> Self {
        Self {
            found: claim.found.into_iter().map(FoundReport::from).collect(),
            holds: claim.holds.name(),
            name: claim.name,
            paper: claim.paper,
            takes: claim.takes,
        }
    }
}

impl From<Found> for FoundReport {
    fn from(found: Found) -> Self {
        Self {
            fits: found.fits,
            unit: found.unit,
            value: found.value,
            what: found.what,
        }
    }
}

impl fmt::Display for ClaimsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, claim) in self.claims.iter().enumerate() {
            if place > 0 {
                writeln!(f)?;
            }
            write!(f, "{claim}")?;
        }
        Ok(())
    }
}

impl fmt::Display for ClaimReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = plain_table(CellAlignment::Left, &["found", "", "", ""]);
        for found in &self.found {
            table.add_row([
                within(&found.what, FOUND).join("\n").into(),
                number(found.value, digits),
                found.unit.into(),
                found.in_words().into(),
            ]);
        }
        writeln!(f, "{}: {}", self.name, self.holds)?;
        for said in [
            format!("  The paper: {}.", self.paper),
            format!("  Criterion: {}.", self.takes),
        ] {
            writeln!(f, "{}", hanging(&said, 4))?;
        }
        writeln!(f, "\n{}", whole(&table))
    }
}

impl FoundReport {
    fn in_words(&self) -> &'static str {
        match self.fits {
            None => "",
            Some(true) => "fits",
            Some(false) => "does not fit",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Holds;

    #[test]
    fn claim_report_states_criterion_and_each_value() {
        let found = |what: &str, value, fits| Found {
            what: what.into(),
            value,
            unit: "s",
            fits,
        };
        let claim = Claim {
            name: "the box",
            paper: "it stays",
            takes: "the same here".into(),
            found: vec![
                found("one", Some(0.34), Some(true)),
                found("other", None, Some(false)),
                found("beside", Some(2.0), None),
            ],
            holds: Holds::InPart,
        };
        let report = ClaimsReport::new(vec![claim]);
        let text = report.to_string();
        assert!(text.starts_with("the box: holds in part\n"), "{text}");
        assert!(text.contains("The paper: it stays."), "{text}");
        assert!(text.contains("Criterion: the same here."), "{text}");
        let line = |what: &str| {
            let mut lines = text.lines();
            let line = lines.find(|line| line.trim_start().starts_with(what));
            line.unwrap_or_else(|| panic!("no {what} in {text}"))
                .to_owned()
        };
        assert!(line("one").contains("0.340") && line("one").ends_with(" fits"));
        assert!(line("other").contains(" - ") && line("other").ends_with("does not fit"));
        assert!(line("beside").ends_with(" s"), "{text}");
        // In a terminal of 80 columns, each number appears once.
        let long = "Fig. 2, hfcr-mod-st: sum of their absolute values, original over remaining";
        let claim = Claim {
            name: "leak",
            paper: "on Fig. 2 the remaining leak is at least ten times smaller than the original leak",
            takes: "the same here".into(),
            found: vec![found(long, Some(481.0), Some(false))],
            holds: Holds::No,
        };
        let text = ClaimsReport::new(vec![claim]).to_string();
        assert!(crate::text::width(&text) <= crate::text::WIDTH, "{text}");
        assert_eq!(text.matches("481").count(), 1, "{text}");
        assert_eq!(text.matches("Fig. 2, hfcr").count(), 1, "{text}");
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(
            json["claims"][0]["found"][1]["value"],
            serde_json::Value::Null
        );
    }
}

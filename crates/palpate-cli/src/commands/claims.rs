//! `palpate claims`: the numbers that the paper claims, computed anew.

use comfy_table::CellAlignment;
use palpate_scene::{Scene, SceneFile};
use palpate_study::claims::{CLAIMS, Claim, Found, PaperScenes, check};
use serde_json::{Value, json};

use crate::arguments::ClaimsArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::{digits, lines, number, plain_table};
use crate::results::print;

/// The committed scenes that the claims are about.
const SCENES: [(&str, &str); 6] = [
    ("fig2", include_str!("../../../../experiments/fig2.toml")),
    (
        "experiment1",
        include_str!("../../../../experiments/experiment1.toml"),
    ),
    (
        "experiment2",
        include_str!("../../../../experiments/experiment2.toml"),
    ),
    ("fig4", include_str!("../../../../experiments/fig4.toml")),
    ("fig5", include_str!("../../../../experiments/fig5.toml")),
    (
        "fig5_box",
        include_str!("../../../../experiments/fig5_box.toml"),
    ),
];

/// Checks the claims and prints them.
pub fn run(arguments: &ClaimsArguments) -> Result<(), Failure> {
    let scenes: Vec<Scene> = SCENES
        .iter()
        .map(|(name, text)| {
            let file = SceneFile::parse(name, text).map_err(Failure::input)?;
            Ok(file.scene)
        })
        .collect::<Result<_, Failure>>()?;
    let [fig2, experiment1, experiment2, fig4, fig5, fig5_box] = &scenes[..] else {
        unreachable!("one scene for each text");
    };
    let progress = Progress::new(CLAIMS);
    progress.begin("claims");
    let claims = check(
        &PaperScenes {
            fig2,
            point_mass: [experiment1, experiment2],
            pantograph: [fig4, fig5],
            fig5_box,
        },
        || progress.advance(),
    )
    .map_err(Failure::input)?;
    drop(progress);
    print(&if arguments.json {
        format!("{:#}\n", report(&claims))
    } else {
        claims.iter().map(in_words).collect::<Vec<_>>().join("\n")
    })
}

fn in_words(claim: &Claim) -> String {
    let mut table = plain_table(CellAlignment::Left, &["found", "", "", ""]);
    for found in &claim.found {
        table.add_row([
            found.what.clone().into(),
            number(found.value, digits),
            found.unit.into(),
            fits(found).into(),
        ]);
    }
    format!(
        "{}: {}\n  The paper: {}.\n  To hold here: {}.\n\n{}\n",
        claim.name,
        claim.holds,
        claim.paper,
        claim.takes,
        lines(&table)
    )
}

fn fits(found: &Found) -> &'static str {
    match found.fits {
        None => "",
        Some(true) => "fits",
        Some(false) => "does not fit",
    }
}

fn report(claims: &[Claim]) -> Value {
    let found = |found: &Found| {
        json!({
            "what": found.what,
            "value": found.value,
            "unit": found.unit,
            "fits": found.fits,
        })
    };
    let claims: Vec<Value> = claims
        .iter()
        .map(|claim| {
            json!({
                "name": claim.name,
                "paper": claim.paper,
                "takes": claim.takes,
                "holds": claim.holds.name(),
                "found": claim.found.iter().map(found).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({ "format": "palpate claims 1", "claims": claims })
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_study::claims::Holds;

    #[test]
    fn a_claim_is_told_in_words_with_every_number() {
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
        let text = in_words(&claim);
        assert!(text.starts_with("the box: holds in part\n"), "{text}");
        assert!(text.contains("The paper: it stays."), "{text}");
        assert!(text.contains("To hold here: the same here."), "{text}");
        let line = |what: &str| {
            let mut lines = text.lines();
            let line = lines.find(|line| line.trim_start().starts_with(what));
            line.unwrap_or_else(|| panic!("no {what} in {text}"))
                .to_owned()
        };
        assert!(line("one").contains("0.340") && line("one").ends_with(" fits"));
        assert!(line("other").contains(" - ") && line("other").ends_with("does not fit"));
        assert!(line("beside").ends_with(" s"), "{text}");
        let report = report(&[claim]);
        assert_eq!(report["claims"][0]["found"][1]["value"], Value::Null);
    }
}

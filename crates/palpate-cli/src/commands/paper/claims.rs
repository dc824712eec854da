//! `palpate paper claims`: recomputes the numbers that the paper claims.

use palpate_scene::{ContactFile, Scene};
use palpate_study::claims::report::ClaimsReport;
use palpate_study::claims::{CLAIMS, PaperScenes, check};

use crate::arguments::ClaimsArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;

/// The committed scenes of the claims.
const SCENES: [(&str, &str); 6] = [
    ("fig2", include_str!("../../../experiments/fig2.toml")),
    (
        "experiment1",
        include_str!("../../../experiments/experiment1.toml"),
    ),
    (
        "experiment2",
        include_str!("../../../experiments/experiment2.toml"),
    ),
    ("fig4", include_str!("../../../experiments/fig4.toml")),
    ("fig5", include_str!("../../../experiments/fig5.toml")),
    (
        "fig5_box",
        include_str!("../../../experiments/fig5_box.toml"),
    ),
];

/// Checks the claims and prints them.
pub fn run(arguments: &ClaimsArguments) -> Result<(), Failure> {
    let scenes: Vec<Scene> = SCENES
        .iter()
        .map(|(name, text)| {
            let file = ContactFile::parse(name, text).map_err(Failure::input)?;
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
    let report = ClaimsReport::new(claims);
    print_report(&report, arguments.json)
}

//! Numeric claims of the paper, computed on its scenes.
//!
//! Each claim has a numeric criterion. A claim about the paper's own device may hold there but not here.

mod experiments;
mod leaks;
pub mod report;

use std::fmt;

use crate::sim::closed_loop::{Bench, LoopError};
use crate::sim::run::Run;
use crate::suite::Column;
use crate::sweep::{ALMOST_STABLE_UP_TO, Quantity, SweepError, sweep};
use palpate_core::SehEstimate;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::{Measure, Scene};

/// The scenes on which the claims are checked.
#[derive(Clone, Copy, Debug)]
pub struct PaperScenes<'a> {
    /// Fig. 2.
    pub fig2: &'a Scene,
    /// Experiments 1 and 2 with a point mass.
    pub point_mass: [&'a Scene; 2],
    /// Experiments 1 and 2 on a virtual pantograph: Figs. 4 and 5.
    pub pantograph: [&'a Scene; 2],
    /// Fig. 5 in the safety box that the paper's text fits best.
    pub fig5_box: &'a Scene,
}

/// A claim, its computed numbers, and whether it holds here.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Short name.
    pub name: &'static str,
    /// The paper's statement, paraphrased.
    pub paper: &'static str,
    /// Criterion for the claim to hold here.
    pub takes: String,
    /// The numbers.
    pub found: Vec<Found>,
    /// Whether it holds here.
    pub holds: Holds,
}

/// A computed number.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Meaning of the number.
    pub what: String,
    /// The number; `None` if it does not exist, for example the time of an event that did not happen.
    pub value: Option<f64>,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// Whether this number satisfies the claim, if it is decisive.
    pub fits: Option<bool>,
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// All decisive numbers satisfy the claim.
    Yes,
    /// Some decisive numbers satisfy the claim.
    InPart,
    /// No decisive number satisfies the claim.
    No,
}

impl Holds {
    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "holds",
            Self::InPart => "holds in part",
            Self::No => "does not hold",
        }
    }
}

impl fmt::Display for Holds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Reason why the claims cannot be checked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClaimError {
    /// A scene cannot be run.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// A scene cannot be varied.
    #[error(transparent)]
    Sweep(#[from] SweepError),
}

/// Period of the paper's reference loop `[s]`.
pub const FINE_PERIOD: f64 = 0.001;

/// Computes one claim.
type Check = fn(&PaperScenes<'_>) -> Result<Claim, ClaimError>;

/// Number of claims that [`check`] checks.
pub const CLAIMS: usize = 10;

/// Checks every claim. Calls `done` after each claim.
///
/// # Errors
/// A scene cannot be run.
pub fn check(scenes: &PaperScenes<'_>, mut done: impl FnMut()) -> Result<Vec<Claim>, ClaimError> {
    let checks: [Check; CLAIMS] = [
        leaks::remaining_leak,
        leaks::leak_at_1_khz,
        truth_at_1_khz,
        sensitivity_to_damping,
        almost_stable,
        experiments::who_stays_in_the_box,
        experiments::when_they_leave,
        experiments::errors,
        experiments::intervals_of_a_collision,
        experiments::as_difficult_at_1_khz,
    ];
    checks
        .into_iter()
        .map(|claim| {
            let checked = claim(scenes);
            done();
            checked
        })
        .collect()
}

impl Found {
    fn of(what: impl Into<String>, value: f64, unit: &'static str) -> Self {
        Self {
            what: what.into(),
            value: Some(value),
            unit,
            fits: None,
        }
    }

    fn decides(self, fits: bool) -> Self {
        Self {
            fits: Some(fits),
            ..self
        }
    }
}

fn claim(name: &'static str, paper: &'static str, takes: String, found: Vec<Found>) -> Claim {
    let decisive = || found.iter().filter_map(|found| found.fits);
    let holds = match (decisive().any(|fits| fits), decisive().all(|fits| fits)) {
        (_, true) => Holds::Yes,
        (true, false) => Holds::InPart,
        (false, false) => Holds::No,
    };
    Claim {
        name,
        paper,
        takes,
        found,
        holds,
    }
}

/// Runs the basic model at 1 kHz over the window of the scene.
fn fine_run(scene: &Scene) -> Result<Run, LoopError> {
    let bench = Bench::new(scene)?;
    let mut fine = scene.clone();
    fine.loop_params.period = FINE_PERIOD;
    let periods = bench.reference().profile.intervals() as f64;
    fine.measure = Measure::Duration(periods * scene.loop_params.period);
    Bench::new(&fine)?.run(MethodName::Basic)
}

fn truth_at_1_khz(scenes: &PaperScenes<'_>) -> Result<Claim, ClaimError> {
    const AT_MOST: f64 = 5.0;
    let mut found = Vec::new();
    for (number, scene) in (1..).zip(scenes.pantograph) {
        let fine = fine_run(scene)?;
        let error = fine
            .force
            .fidelity
            .map_or(f64::NAN, |of| of.force_rendering_error);
        let what =
            format!("experiment {number} on the pantograph: FRE of the basic model at 1 kHz");
        found.push(Found::of(what, error, "%").decides(error <= AT_MOST));
    }
    Ok(claim(
        "truth at 1 kHz",
        "the basic model at 1 kHz is a very good approximation of the true force",
        format!("an FRE to the ideal of at most {AT_MOST} %"),
        found,
    ))
}

fn sensitivity_to_damping(scenes: &PaperScenes<'_>) -> Result<Claim, ClaimError> {
    const AT_MOST: f64 = 1.5;
    /// The estimate of Eq. (11) on Fig. 2, its half and its double `[N s/m]`.
    const DAMPINGS: [f64; 3] = [0.006_25, 0.0125, 0.025];
    let mut found = Vec::new();
    for collisions in [3, 10] {
        let mut scene = scenes.fig2.clone();
        scene.measure = Measure::Collisions(collisions);
        let column = [Column::new(MethodName::Hfcr)];
        let swept = sweep(&scene, Quantity::Damping, &DAMPINGS, &column, false, || {})?;
        let errors: Vec<f64> = swept
            .iter()
            .map(|at| at[0].own.force_rendering_error)
            .collect();
        for (damping, error) in DAMPINGS.iter().zip(&errors) {
            let what = format!("Fig. 2, {collisions} collisions, b = {damping} N s/m: FRE");
            found.push(Found::of(what, *error, "%"));
        }
        let (least, most) = errors
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), error| {
                (a.min(*error), b.max(*error))
            });
        let what = format!("Fig. 2, {collisions} collisions: largest over least FRE");
        found.push(Found::of(what, most / least, "").decides(most / least <= AT_MOST));
    }
    Ok(claim(
        "sensitivity to b",
        "the choice of the damping b of leak dissipation is not very sensitive",
        format!("from half to double the estimate, FRE changes by a factor of at most {AT_MOST}"),
        found,
    ))
}

fn almost_stable(scenes: &PaperScenes<'_>) -> Result<Claim, ClaimError> {
    const FRICTIONS: [f64; 2] = [1.0, 10.0];
    let mut scene = scenes.pantograph[0].clone();
    scene.measure = Measure::Collisions(8);
    let columns: Vec<Column> = [
        ("AB2", SehEstimate::Ab2),
        ("differences", SehEstimate::Differences),
        ("AB3", SehEstimate::Ab3),
    ]
    .map(|(name, estimate)| Column {
        name: name.into(),
        settings: Settings::default().with(SettingKey::ESTIMATE, estimate),
        ..Column::new(MethodName::Seh)
    })
    .into();
    let swept = sweep(
        &scene,
        Quantity::Friction,
        &FRICTIONS,
        &columns,
        false,
        || {},
    )?;
    let mut found = Vec::new();
    for (friction, at) in FRICTIONS.iter().zip(&swept) {
        for (column, swept) in columns.iter().zip(at) {
            let name = &column.name;
            let ratio = swept.outcome.bounce.and_then(|it| it.rebound_energy);
            found.push(Found {
                what: format!("{name}, friction × {friction}: largest rebound energy"),
                value: ratio,
                unit: "",
                fits: Some(ratio.is_some_and(|ratio| ratio <= ALMOST_STABLE_UP_TO)),
            });
            found.push(Found::of(
                format!("{name}, friction × {friction}: peak of the force"),
                swept.outcome.peak_force,
                "N",
            ));
        }
        found.push(Found::of(
            format!("ideal, friction × {friction}: peak of the force"),
            at[0].outcome.ideal_peak_force,
            "N",
        ));
    }
    Ok(claim(
        "SEH almost stable",
        "SEH is almost stable in the first experiment",
        format!(
            "over 8 collisions no rebound has more than {ALMOST_STABLE_UP_TO} times the energy of the ideal's first one"
        ),
        found,
    ))
}

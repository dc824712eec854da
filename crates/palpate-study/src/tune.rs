//! Tuning: dependence of a method's error and leak on its one damping.
//!
//! The best value at one start height may be poor at the next, so every value is evaluated over start heights around
//! the scene's own.

use palpate_core::Unit;
use palpate_scene::Scene;
use palpate_scene::method::{MethodName, Setting, SettingKey, Settings};
use serde::Serialize;

pub mod report;

use crate::sim::closed_loop::{Bench, LoopError};

/// Number of start heights in the evaluation of a value.
pub const HEIGHTS: usize = 21;

/// The outermost start heights, relative to the scene's own gap between device and object.
pub const HEIGHT_RANGE: f64 = 0.05;

/// Quantity to be minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objective {
    /// The median mean-force error.
    Error,
    /// The median sum of absolute leaks.
    Leak,
}

impl Objective {
    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Leak => "leak",
        }
    }
}

/// The distribution of a quantity over the start heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Spread {
    /// At the scene's own height.
    pub own: f64,
    /// Median over the heights.
    pub median: f64,
    /// Largest over the heights.
    pub worst: f64,
}

/// A value and its results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TunedPoint {
    /// The damping or cap `[N s/m]`.
    pub value: f64,
    /// Mean-force error E `[%]`.
    pub mean_force_error: Spread,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub leak: Spread,
    /// Heights at which the loop diverged.
    pub diverged: usize,
}

/// Reason why a method cannot be tuned on a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// The method has nothing to tune.
    #[error("{method} has no damping to tune; {all} have", method = .0, all = with_damping())]
    NothingToTune(MethodName),
    /// The ideal has no contact, so there is no error.
    #[error("the ideal has no contact in the window, so there is no error to minimise")]
    NoContact,
    /// A loop cannot be run.
    #[error(transparent)]
    Loop(#[from] LoopError),
}

/// Returns the names of the methods with a damping.
fn with_damping() -> String {
    let all = MethodName::ALL.into_iter();
    let names = all.filter(|method| tunable(*method).is_some());
    names.map(MethodName::name).collect::<Vec<_>>().join(", ")
}

/// Returns the setting of `method` that is a damping.
#[must_use]
pub fn tunable(method: MethodName) -> Option<&'static Setting> {
    let mut settings = method.info().settings.iter();
    settings.find(|setting| setting.unit() == Some(Unit::NewtonSecondPerMetre))
}

/// Returns the default upper limit of the tried values `[N s/m]`, for a method's setting on a scene. It is above
/// values known to be too large.
#[must_use]
pub fn usual_most(scene: &Scene, method: MethodName, setting: SettingKey) -> f64 {
    let impedance = scene.contact.stiffness * scene.loop_params.period;
    match (setting, method) {
        (SettingKey::DAMPING_CAP, _) => 8.0 * impedance,
        (_, MethodName::Hfcr) => impedance,
        _ => 4.0 * impedance,
    }
}

/// Returns the default lower limit of the tried values `[N s/m]`, for `values` values up to `most`: 0, or one step
/// for a cap, which cannot be 0.
#[must_use]
pub fn usual_least(setting: SettingKey, most: f64, values: u32) -> f64 {
    match setting {
        SettingKey::DAMPING_CAP => most / f64::from(values),
        _ => 0.0,
    }
}

/// Evaluates `method` on `scene` at each of `values` `[N s/m]`. Calls `done` after each start height.
///
/// # Errors
/// The method has no damping, a value is not allowed, or a scene cannot be run.
pub fn tune(
    scene: &Scene,
    method: MethodName,
    values: &[f64],
    mut done: impl FnMut(),
) -> Result<Vec<TunedPoint>, TuneError> {
    let setting = tunable(method).ok_or(TuneError::NothingToTune(method))?;
    let mut trials: Vec<Vec<Trial>> = vec![Vec::with_capacity(HEIGHTS); values.len()];
    for height in 0..HEIGHTS {
        let at_height = at_height(scene, height);
        let mut tuned = at_height.clone();
        let bench = Bench::new(&at_height)?;
        for (value, trials) in values.iter().zip(&mut trials) {
            let given = Settings::default().with(setting.key, *value);
            let others = scene.settings.get(&method).copied().unwrap_or_default();
            tuned.settings.insert(method, given.or(others));
            let run = bench.run_varied(&tuned, method)?;
            let fidelity = run.force.fidelity.ok_or(TuneError::NoContact)?;
            trials.push(Trial {
                error: fidelity.mean_force_error,
                leak: run.last().ledger.held_leak.absolute,
                diverged: run.diverged == Some(true),
            });
        }
        done();
    }
    Ok(values
        .iter()
        .zip(&trials)
        .map(|(value, trials)| TunedPoint {
            value: *value,
            mean_force_error: spread(trials.iter().map(|trial| trial.error)),
            leak: spread(trials.iter().map(|trial| trial.leak)),
            diverged: trials.iter().filter(|trial| trial.diverged).count(),
        })
        .collect())
}

/// Returns the point with the lowest median.
#[must_use]
pub fn best(points: &[TunedPoint], objective: Objective) -> Option<&TunedPoint> {
    let of = |point: &TunedPoint| match objective {
        Objective::Error => point.mean_force_error.median,
        Objective::Leak => point.leak.median,
    };
    points.iter().min_by(|a, b| of(a).total_cmp(&of(b)))
}

#[derive(Clone, Copy)]
struct Trial {
    error: f64,
    leak: f64,
    diverged: bool,
}

/// Returns the change of a start height, relative to the scene's own; 0 for the middle one.
pub(crate) fn height_share(height: usize) -> f64 {
    let middle = (HEIGHTS / 2) as f64;
    HEIGHT_RANGE * (height as f64 - middle) / middle
}

/// Returns the scene with the gap of a start height; the middle height is the scene itself.
pub(crate) fn at_height(scene: &Scene, height: usize) -> Scene {
    let mut scene = scene.clone();
    scene.object.position +=
        height_share(height) * (scene.object.position - scene.device.position());
    scene
}

/// Returns the distribution of a quantity over the heights.
pub(crate) fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let mut values: Vec<f64> = values.collect();
    let own = values[HEIGHTS / 2];
    values.sort_by(f64::total_cmp);
    Spread {
        own,
        median: values[HEIGHTS / 2],
        worst: values[HEIGHTS - 1],
    }
}

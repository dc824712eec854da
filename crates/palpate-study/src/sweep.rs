//! Sweep of one quantity of a scene, with the results of each method at each value.

pub mod report;
pub mod table;
mod world;

use palpate_testbed::metrics::Fidelity;
use palpate_testbed::pantograph::SafetyBox;
use rayon::prelude::*;

use crate::sim::closed_loop::{Bench, LoopError};
use crate::sim::run::Run;
use crate::suite::Column;
use crate::tune::{HEIGHTS, Spread, at_height, spread, tunable};
use palpate_scene::method::{SettingKey, Settings};
use palpate_scene::{Scene, SceneDevice};
pub use world::{SweptWorld, WorldSweepError, sweep_worlds};

/// The varied quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Viscous and Coulomb friction of the device, as a factor on the scene's.
    Friction,
    /// The safety box of a pantograph along y, from minus to plus the value `[m]` about home.
    SafetyBox,
    /// The damping or the cap of the methods `[N s/m]`.
    Damping,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 3] = [Self::Friction, Self::SafetyBox, Self::Damping];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Friction => "friction",
            Self::SafetyBox => "box",
            Self::Damping => "damping",
        }
    }

    /// Returns the unit; empty for a factor.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Friction => "",
            Self::SafetyBox => "m",
            Self::Damping => "N s/m",
        }
    }
}

/// Largest rebound energy of a stable loop, relative to the ideal's first rebound: no rebound is more than 5 % faster
/// than that one. Later rebounds of the ideal are never faster.
pub const STABLE_UP_TO: f64 = 1.1;
/// Largest such ratio of an almost stable loop: no rebound is more than 41 % faster.
pub const ALMOST_STABLE_UP_TO: f64 = 2.0;

/// Class of a bounce, by the largest rebound energy relative to the ideal's first rebound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stability {
    /// At most [`STABLE_UP_TO`].
    Stable,
    /// At most [`ALMOST_STABLE_UP_TO`].
    AlmostStable,
    /// More, or no rebound.
    Unstable,
    /// The loop diverged ([`Run::diverged`]).
    Diverged,
}

impl Stability {
    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::AlmostStable => "almost stable",
            Self::Unstable => "unstable",
            Self::Diverged => "diverged",
        }
    }
}

/// Results of a column at a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swept {
    /// Errors at the scene's own start height.
    pub own: Fidelity,
    /// Results over the start heights, if requested.
    pub over_heights: Option<SweptHeights>,
    /// Strongest held force at the scene's own height `[N]`.
    pub peak_force: f64,
    /// Strongest force of the ideal `[N]`.
    pub ideal_peak_force: f64,
    /// Largest rebound energy relative to the ideal's first rebound; `None` without a rebound.
    pub rebound_energy: Option<f64>,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub leak: f64,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at: Option<f64>,
    /// Class of the bounce.
    pub stability: Stability,
}

/// Results of a column at a value over all start heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptHeights {
    /// Force rendering error FRE `[%]`.
    pub force_rendering_error: Spread,
    /// Heights from which the device left its safety box.
    pub left_box: usize,
    /// Heights from which the bounce was stable or almost stable.
    pub almost_stable: usize,
}

/// Reason why a quantity cannot be varied.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The scene lacks the quantity.
    #[error("{0}")]
    Nothing(&'static str),
    /// A column's method has no damping.
    #[error("column {0}: its method has no damping to vary")]
    NoDamping(String),
    /// A column has several dampings.
    #[error("column {0}: several dampings are not allowed here; name one")]
    Choice(String),
    /// The quantity cannot have this value.
    #[error("{name} {value}: it must be {allowed}")]
    Value {
        /// Name of the quantity.
        name: &'static str,
        /// The value.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The ideal has no contact, so there is no error.
    #[error("the ideal has no contact in the window, so there is no error")]
    NoContact,
    /// The scene cannot be run at a value.
    #[error("at {name} {value}: {error}")]
    Scene {
        /// Name of the quantity, or key of the scene.
        name: String,
        /// The value.
        value: f64,
        /// Cause of the error.
        error: LoopError,
    },
}

/// Runs every column at each of `values` of a quantity of `scene`; returns, per value, the results in the order of
/// `columns`. A column uses the scene's value of every unset setting. `over_heights` adds the 21 start heights. Calls
/// `done` after each value.
///
/// # Errors
/// The scene lacks the quantity, a value is not allowed, or a scene cannot be run or has no contact.
pub fn sweep(
    scene: &Scene,
    quantity: Quantity,
    values: &[f64],
    columns: &[Column],
    over_heights: bool,
    done: impl Fn() + Sync,
) -> Result<Vec<Vec<Swept>>, SweepError> {
    if quantity == Quantity::Damping
        && let Some(column) = columns
            .iter()
            .find(|column| tunable(column.method).is_none())
    {
        return Err(SweepError::NoDamping(column.name.clone()));
    }
    check_choice(scene, columns)?;
    at_each(values, done, |&value| {
        let varied = with(scene, quantity, value)?;
        let columns: Vec<Column> = columns
            .iter()
            .map(|column| match quantity {
                Quantity::Damping => with_damping(column, value),
                _ => column.clone(),
            })
            .collect();
        at_value(&varied, (quantity.name(), value), &columns, over_heights)
    })
}

/// Runs every column on scenes that differ in the value of one key; returns the results as [`sweep`] does.
///
/// # Errors
/// A scene cannot be run or has no contact.
pub fn sweep_scenes(
    key: &str,
    scenes: &[(f64, Scene)],
    columns: &[Column],
    over_heights: bool,
    done: impl Fn() + Sync,
) -> Result<Vec<Vec<Swept>>, SweepError> {
    for (_, scene) in scenes {
        check_choice(scene, columns)?;
    }
    at_each(scenes, done, |(value, scene)| {
        at_value(scene, (key, *value), columns, over_heights)
    })
}

/// Rejects a column with several dampings on the scene.
fn check_choice(scene: &Scene, columns: &[Column]) -> Result<(), SweepError> {
    let mut columns = columns.iter();
    match columns.find(|column| column.candidates(scene).len() > 1) {
        Some(column) => Err(SweepError::Choice(column.name.clone())),
        None => Ok(()),
    }
}

/// Evaluates each of `values` on the threads of rayon.
pub(crate) fn at_each<V: Sync, R: Send, E: Send>(
    values: &[V],
    done: impl Fn() + Sync,
    at: impl Fn(&V) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    values
        .par_iter()
        .map(|value| {
            let found = at(value);
            done();
            found
        })
        // A caller cancels the rest by a panic in `done`.
        .panic_fuse()
        .collect()
}

fn at_value(
    varied: &Scene,
    value: (&str, f64),
    columns: &[Column],
    over_heights: bool,
) -> Result<Vec<Swept>, SweepError> {
    let own = at_height_of(varied, value, columns)?;
    if !over_heights {
        return Ok(own);
    }
    // The heights run sequentially, because the values run in parallel.
    let mut heights: Vec<Vec<Swept>> = vec![Vec::with_capacity(HEIGHTS); columns.len()];
    for height in 0..HEIGHTS {
        let at = at_height_of(&at_height(varied, height), value, columns)?;
        for (column, swept) in heights.iter_mut().zip(at) {
            column.push(swept);
        }
    }
    Ok(own
        .into_iter()
        .zip(&heights)
        .map(|(swept, heights)| Swept {
            over_heights: Some(SweptHeights::new(heights)),
            ..swept
        })
        .collect())
}

fn at_height_of(
    scene: &Scene,
    (name, value): (&str, f64),
    columns: &[Column],
) -> Result<Vec<Swept>, SweepError> {
    let wrong = |error| SweepError::Scene {
        name: name.into(),
        value,
        error,
    };
    let bench = Bench::new(scene).map_err(wrong)?;
    let curve = &bench.reference().curve;
    let ideal_peak_force = curve
        .iter()
        .map(|point| point.force_on_object.abs())
        .fold(0.0, f64::max);
    columns
        .iter()
        .map(|column| {
            let (_, varied) = column.candidates(scene).swap_remove(0);
            let run = bench.run_varied(&varied, column.method).map_err(wrong)?;
            Swept::new(&run, ideal_peak_force)
        })
        .collect()
}

impl Swept {
    fn new(run: &Run, ideal_peak_force: f64) -> Result<Self, SweepError> {
        let rebound_energy = largest_rebound_energy(run);
        Ok(Self {
            own: run.force.fidelity.ok_or(SweepError::NoContact)?,
            over_heights: None,
            peak_force: run.force.peak_force,
            ideal_peak_force,
            rebound_energy,
            leak: run.last().ledger.held_leak.absolute,
            left_box_at: run.left_box_at,
            stability: stability(run.diverged == Some(true), rebound_energy),
        })
    }
}

impl SweptHeights {
    fn new(heights: &[Swept]) -> Self {
        let count = |of: fn(&Swept) -> bool| heights.iter().filter(|swept| of(swept)).count();
        Self {
            force_rendering_error: spread(
                heights.iter().map(|swept| swept.own.force_rendering_error),
            ),
            left_box: count(|swept| swept.left_box_at.is_some()),
            almost_stable: count(|swept| swept.stability <= Stability::AlmostStable),
        }
    }
}

/// Returns the largest rebound energy of `run` relative to the ideal's first rebound: the ratio of the squared
/// separation speeds of device and object.
pub fn largest_rebound_energy(run: &Run) -> Option<f64> {
    let first = run.rebounds.first()?.ideal;
    let speeds = run.rebounds.iter().filter_map(|rebound| rebound.rendered);
    speeds
        .map(|speed| (speed / first) * (speed / first))
        .max_by(f64::total_cmp)
}

fn stability(diverged: bool, rebound_energy: Option<f64>) -> Stability {
    match rebound_energy {
        _ if diverged => Stability::Diverged,
        Some(ratio) if ratio <= STABLE_UP_TO => Stability::Stable,
        Some(ratio) if ratio <= ALMOST_STABLE_UP_TO => Stability::AlmostStable,
        _ => Stability::Unstable,
    }
}

/// Returns the scene at a value of the quantity. A damping changes the columns, not the scene.
fn with(scene: &Scene, quantity: Quantity, value: f64) -> Result<Scene, SweepError> {
    let unless = |ok: bool, allowed| {
        if ok {
            Ok(())
        } else {
            Err(SweepError::Value {
                name: quantity.name(),
                value,
                allowed,
            })
        }
    };
    let mut varied = scene.clone();
    match quantity {
        Quantity::Friction => {
            unless(
                value.is_finite() && value >= 0.0,
                "finite and not below 0, a factor on the scene's",
            )?;
            let none = SweepError::Nothing("the scene's device has no friction to multiply");
            let (viscous, coulomb) = match &mut varied.device {
                SceneDevice::PointMass(device) => {
                    (&mut device.viscous_friction, &mut device.coulomb_friction)
                }
                SceneDevice::Pantograph(device) => {
                    let params = &mut device.linkage.params;
                    (&mut params.viscous_friction, &mut params.coulomb_friction)
                }
                SceneDevice::Recorded { .. } => return Err(none),
            };
            if *viscous == 0.0 && *coulomb == 0.0 {
                return Err(none);
            }
            *viscous *= value;
            *coulomb *= value;
        }
        Quantity::SafetyBox => {
            let device = varied.device.pantograph_mut().ok_or(SweepError::Nothing(
                "only a device of kind pantograph has a safety box",
            ))?;
            let linkage = &mut device.linkage;
            unless(value.is_finite() && value > 0.0, "finite and above 0 m")?;
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            let x = linkage.safety_box.map_or(everywhere, |bounds| bounds.x);
            let bounds = SafetyBox {
                x,
                y: [-value, value],
            };
            *linkage = linkage.clone().in_box(bounds);
        }
        Quantity::Damping => {
            unless(
                value.is_finite() && value >= 0.0,
                "finite and not below 0 N s/m",
            )?;
        }
    }
    Ok(varied)
}

fn with_damping(column: &Column, value: f64) -> Column {
    let damping = tunable(column.method).map_or(SettingKey::DAMPING, |setting| setting.key);
    let given = Settings::default().with(damping, value);
    Column {
        settings: given.or(column.settings),
        dampings: None,
        ..column.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stability_is_a_number() {
        assert_eq!(stability(false, Some(0.2)), Stability::Stable);
        assert_eq!(stability(false, Some(1.1)), Stability::Stable);
        assert_eq!(stability(false, Some(1.11)), Stability::AlmostStable);
        assert_eq!(stability(false, Some(2.0)), Stability::AlmostStable);
        assert_eq!(stability(false, Some(2.01)), Stability::Unstable);
        assert_eq!(stability(false, None), Stability::Unstable);
        assert_eq!(stability(true, Some(1.0)), Stability::Diverged);
    }
}

//! Sweep of one quantity of a scene, with the results of each method at each value.

pub mod report;
pub mod table;

use palpate_core::Mass;
use palpate_testbed::metrics::Fidelity;
use palpate_testbed::pantograph::SafetyBox;
use rayon::prelude::*;

use crate::sim::run::Run;
use crate::studied::{Bounce, Compared, Outcome, Studied, StudyError};
use crate::suite::Column;
use crate::tune::{Spread, spread, tunable};
use palpate_scene::method::{SettingKey, Settings};
use palpate_scene::{Scene, SceneDevice};

/// The varied quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Stiffness of every contact, as a factor on the scene's.
    Stiffness,
    /// Mass and inertia of every body that moves, as a factor on the scene's; forces stay.
    Mass,
    /// Viscous and Coulomb friction of the device, as a factor on the scene's.
    Friction,
    /// The safety box of a pantograph along y, from minus to plus the value `[m]` about home.
    SafetyBox,
    /// The damping or the cap of the methods `[N s/m]`.
    Damping,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 5] = [
        Self::Stiffness,
        Self::Mass,
        Self::Friction,
        Self::SafetyBox,
        Self::Damping,
    ];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiffness => "stiffness",
            Self::Mass => "mass",
            Self::Friction => "friction",
            Self::SafetyBox => "box",
            Self::Damping => "damping",
        }
    }

    /// Returns the unit; empty for a factor.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Stiffness | Self::Mass | Self::Friction => "",
            Self::SafetyBox => "m",
            Self::Damping => "N s/m",
        }
    }

    /// Checks a value.
    pub(crate) fn check(self, value: f64) -> Result<(), SweepError> {
        let (allowed, least) = match self {
            Self::Stiffness | Self::Mass => (
                "finite and above 0, a factor on the scene's",
                f64::MIN_POSITIVE,
            ),
            Self::Friction => ("finite and not below 0, a factor on the scene's", 0.0),
            Self::SafetyBox => ("finite and above 0 m", f64::MIN_POSITIVE),
            Self::Damping => ("finite and not below 0 N s/m", 0.0),
        };
        if value.is_finite() && value >= least {
            return Ok(());
        }
        Err(SweepError::Value {
            name: self.name(),
            value,
            allowed,
        })
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
    pub(crate) fn new(diverged: bool, rebound_energy: Option<f64>) -> Self {
        match rebound_energy {
            _ if diverged => Self::Diverged,
            Some(ratio) if ratio <= STABLE_UP_TO => Self::Stable,
            Some(ratio) if ratio <= ALMOST_STABLE_UP_TO => Self::AlmostStable,
            _ => Self::Unstable,
        }
    }

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
    /// Result at the scene's own start height.
    pub outcome: Outcome,
    /// Results over the start heights, if requested.
    pub over_heights: Option<SweptHeights>,
}

/// Results of a column at a value over all start heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptHeights {
    /// Force rendering error FRE `[%]`.
    pub force_rendering_error: Spread,
    /// Of one contact: numbers of heights from which the device left its safety box, and from which the bounce was
    /// stable or almost stable.
    pub left_box_and_stable: Option<[usize; 2]>,
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
    /// The scene cannot be evaluated at a value.
    #[error("at {at}: {error}")]
    Scene {
        /// The quantities or keys with their values.
        at: String,
        /// Cause of the error.
        error: StudyError,
    },
}

impl SweepError {
    pub(crate) const NO_FRICTION: Self =
        Self::Nothing("the scene's device has no friction to multiply");
    pub(crate) const NO_MASS: Self = Self::Nothing("the scene has no body that moves");
    pub(crate) const NO_BOX: Self =
        Self::Nothing("only a device of kind pantograph has a safety box");
}

/// A scene and columns at one or more values.
#[derive(Clone, Debug)]
pub struct Point<S: Studied> {
    /// The values, in messages: `body.0.mass_kg 0.2`.
    pub at: String,
    /// The scene.
    pub scene: S,
    /// The columns.
    pub columns: Vec<S::Column>,
}

impl<S: Studied> Point<S> {
    /// Returns the point with another value of a quantity.
    ///
    /// # Errors
    /// The scene lacks the quantity, or the value is not allowed.
    pub fn with(self, quantity: Quantity, value: f64) -> Result<Self, SweepError> {
        let (scene, columns) = self.scene.at(&self.columns, quantity, value)?;
        Ok(Self {
            scene,
            columns,
            ..self
        })
    }
}

/// Runs every column at each of `values` of a quantity of `scene`, as [`sweep_points`] does.
///
/// # Errors
/// The scene lacks the quantity, a value is not allowed, or a scene cannot be run or has no contact.
pub fn sweep<S: Studied>(
    scene: &S,
    quantity: Quantity,
    values: &[f64],
    columns: &[S::Column],
    over_heights: bool,
    done: impl Fn() + Sync,
) -> Result<Vec<Vec<Swept>>, SweepError> {
    let point = |&value: &f64| {
        let point = Point {
            at: format!("{} {value}", quantity.name()),
            scene: scene.clone(),
            columns: columns.to_vec(),
        };
        point.with(quantity, value)
    };
    let points: Vec<_> = values.iter().map(point).collect::<Result<_, _>>()?;
    sweep_points(&points, over_heights, done)
}

/// Runs every column at each of `points`; returns, per point, the results in the order of its columns. A column uses
/// the scene's value of every unset setting. `over_heights` adds the 21 start heights. Calls `done` after each point.
///
/// # Errors
/// A scene cannot be run or has no contact, or a column has several dampings.
pub fn sweep_points<S: Studied>(
    points: &[Point<S>],
    over_heights: bool,
    done: impl Fn() + Sync,
) -> Result<Vec<Vec<Swept>>, SweepError> {
    for point in points {
        check_choice(&point.scene, &point.columns)?;
    }
    at_each(points, done, |point| at_point(point, over_heights))
}

/// Rejects a column with several dampings on the scene.
fn check_choice<S: Studied>(scene: &S, columns: &[S::Column]) -> Result<(), SweepError> {
    let mut choices = scene.choices(columns).into_iter().zip(columns);
    match choices.find(|(choice, _)| choice.len() > 1) {
        Some((_, column)) => Err(SweepError::Choice(column.name().into())),
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

fn at_point<S: Studied>(
    Point { at, scene, columns }: &Point<S>,
    over_heights: bool,
) -> Result<Vec<Swept>, SweepError> {
    let evaluated = |scene: &S| -> Result<Vec<(Fidelity, Outcome)>, StudyError> {
        let of = |outcomes: Vec<Outcome>| Ok((outcomes[0].fidelity()?, outcomes[0]));
        scene.evaluate(columns)?.into_iter().map(of).collect()
    };
    let own_and_heights = || {
        let own = evaluated(scene)?;
        // The heights run sequentially, because the points run in parallel.
        let heights: Option<Vec<_>> = if over_heights {
            let scenes = scene.start_heights()?;
            Some(scenes.iter().map(evaluated).collect::<Result<_, _>>()?)
        } else {
            None
        };
        Ok((own, heights))
    };
    let (own, heights) = own_and_heights().map_err(|error| SweepError::Scene {
        at: at.clone(),
        error,
    })?;
    let swept = |(column, (own, outcome))| Swept {
        own,
        outcome,
        over_heights: heights.as_ref().map(|heights| {
            SweptHeights::new(&heights.iter().map(|at| at[column]).collect::<Vec<_>>())
        }),
    };
    Ok(own.into_iter().enumerate().map(swept).collect())
}

impl SweptHeights {
    fn new(heights: &[(Fidelity, Outcome)]) -> Self {
        let errors = heights.iter().map(|(own, _)| own.force_rendering_error);
        let bounces: Option<Vec<Bounce>> = heights.iter().map(|(_, at)| at.bounce).collect();
        let count = |of: &dyn Fn(&Bounce) -> bool, all: &[Bounce]| {
            all.iter().filter(|bounce| of(bounce)).count()
        };
        Self {
            force_rendering_error: spread(errors),
            left_box_and_stable: bounces.map(|all| {
                [
                    count(&|it| it.left_box_at.is_some(), &all),
                    count(&|it| it.stability <= Stability::AlmostStable, &all),
                ]
            }),
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

/// Returns the scene at a value of the quantity. A damping changes the columns, not the scene.
pub(crate) fn with(scene: &Scene, quantity: Quantity, value: f64) -> Result<Scene, SweepError> {
    quantity.check(value)?;
    let mut varied = scene.clone();
    match quantity {
        Quantity::Stiffness => varied.contact.stiffness *= value,
        Quantity::Mass => match &mut varied.contact.object_mass {
            Mass::Finite(mass) => *mass *= value,
            Mass::Infinite => return Err(SweepError::NO_MASS),
        },
        Quantity::Friction => {
            let (viscous, coulomb) = match &mut varied.device {
                SceneDevice::PointMass(device) => {
                    (&mut device.viscous_friction, &mut device.coulomb_friction)
                }
                SceneDevice::Pantograph(device) => {
                    let params = &mut device.linkage.params;
                    (&mut params.viscous_friction, &mut params.coulomb_friction)
                }
                SceneDevice::Recorded { .. } => return Err(SweepError::NO_FRICTION),
            };
            if *viscous == 0.0 && *coulomb == 0.0 {
                return Err(SweepError::NO_FRICTION);
            }
            *viscous *= value;
            *coulomb *= value;
        }
        Quantity::SafetyBox => {
            let device = varied.device.pantograph_mut().ok_or(SweepError::NO_BOX)?;
            let linkage = &mut device.linkage;
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            let x = linkage.safety_box.map_or(everywhere, |bounds| bounds.x);
            let bounds = SafetyBox {
                x,
                y: [-value, value],
            };
            *linkage = linkage.clone().in_box(bounds);
        }
        Quantity::Damping => {}
    }
    Ok(varied)
}

pub(crate) fn with_damping(column: &Column, value: f64) -> Column {
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
        assert_eq!(Stability::new(false, Some(0.2)), Stability::Stable);
        assert_eq!(Stability::new(false, Some(1.1)), Stability::Stable);
        assert_eq!(Stability::new(false, Some(1.11)), Stability::AlmostStable);
        assert_eq!(Stability::new(false, Some(2.0)), Stability::AlmostStable);
        assert_eq!(Stability::new(false, Some(2.01)), Stability::Unstable);
        assert_eq!(Stability::new(false, None), Stability::Unstable);
        assert_eq!(Stability::new(true, Some(1.0)), Stability::Diverged);
    }
}

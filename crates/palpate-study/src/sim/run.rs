//! Result of a run: every tick, and its evaluation.

use std::fmt;

use palpate_core::{Ledger, Output, ParameterValue};
use palpate_testbed::metrics::{EnergyEvaluation, ForceEvaluation, ReboundSpeed};
use palpate_testbed::profile::{ForceProfile, Snapshot};

use palpate_scene::method::MethodName;

/// One sample of a run and the answer to it, in the user's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Time of the sample `[s]`.
    pub time: f64,
    /// Device position as the renderer saw it `[m]`.
    pub device_position: f64,
    /// Device position as it was, before the sensor `[m]`.
    pub true_device_position: f64,
    /// The renderer's answer.
    pub output: Output<f64>,
    /// Force on the object that acts from this sample on `[N]`: with a delay, that of an earlier output; with a lag,
    /// its value at this instant. In a loop of whole periods without a lag it lasts until the next sample; otherwise
    /// [`Run::held`] has its changes.
    pub held_force_on_object: f64,
    /// Arrival of this sample's command at the motor `[s]`; `None` after the window's end.
    pub command_from: Option<f64>,
    /// EnergyLedger of the intervals before this sample.
    pub ledger: Ledger<f64>,
}

/// A force that is held from an instant until the next entry. For an actuator with a lag it is the mean delivered
/// force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Start time `[s]`.
    pub from: f64,
    /// Force on the object `[N]`: of a line its mean.
    pub force_on_object: f64,
    /// Slope of the line that is held `[N/s]`; 0 for a constant.
    pub slope_on_object: f64,
}

/// The method of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RunMethod {
    /// One of the program's methods, as it was chosen.
    BuiltIn(MethodName),
    /// A method of the caller's own, by its name.
    Own(&'static str),
}

impl RunMethod {
    /// The method's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BuiltIn(method) => method.name(),
            Self::Own(name) => name,
        }
    }
}

impl fmt::Display for RunMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl From<MethodName> for RunMethod {
    fn from(method: MethodName) -> Self {
        Self::BuiltIn(method)
    }
}

impl PartialEq<MethodName> for RunMethod {
    fn eq(&self, method: &MethodName) -> bool {
        *self == Self::BuiltIn(*method)
    }
}

/// A run of one method, from the first sample to the end of the last interval.
#[derive(Clone, Debug)]
pub struct Run {
    /// The method.
    pub method: RunMethod,
    /// Its parameters by key, with the unit at the key's end; defaults included.
    pub parameters: Vec<(&'static str, ParameterValue<f64>)>,
    /// Every sample that was taken; the last one closes the window and is not acted on. A perfect loop
    /// has one more than periods.
    pub ticks: Vec<Tick>,
    /// The force that was really held, one for each interval of the reference's profile.
    pub held: Vec<Held>,
    /// Metrics of the held force against the ideal one.
    pub force: ForceEvaluation,
    /// Time at which a linkage jams at the end of its reach `[s]`. The rest of the run shows the end stop of the
    /// mechanism, not the method.
    pub jammed_at: Option<f64>,
    /// Time at which a linkage is first measured outside its safety box, which then disables the motors permanently
    /// `[s]`. No force is held afterwards, and the run shows only the hand.
    pub left_box_at: Option<f64>,
    /// Whether the loop ran away; closed loops only.
    pub diverged: Option<bool>,
    /// Effect of the loop on the energy of device and object; only for closed loops of a point mass without friction
    /// under a constant force.
    pub energy: Option<EnergyEvaluation>,
    /// Separation speed of device and object after each ideal collision that ends within the window; closed loops only.
    pub rebounds: Vec<ReboundSpeed>,
    /// Work through the port as integrated by the bench, independently of the renderer's energy ledger, positive into
    /// the object `[J]`; closed loops only.
    pub bench_port_work: Option<f64>,
    /// Offset of the object's centre from its position, in the user's frame `[m]`; 0 if the scene has no radius. The
    /// run does not depend on it.
    pub centre_offset: f64,
}

/// The ideal of a scene, over the window of a run.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Its force, cut into intervals.
    pub profile: ForceProfile,
    /// Error of any interval's impulse, relative to the largest: 0 where the ideal is exact, an
    /// estimate where it is integrated.
    pub error: f64,
    /// Device, object and force on a fine grid, for figures, in the user's frame.
    pub curve: Vec<IdealPoint>,
    /// Time at which its device leaves the safety box of the scene's linkage `[s]`. The ideal itself has no box; a time
    /// within the window means that the box is too small for the scene.
    pub leaves_box_at: Option<f64>,
}

/// A point of the ideal's motion, in the user's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealPoint {
    /// Time `[s]`.
    pub time: f64,
    /// Device position `[m]`.
    pub device_position: f64,
    /// Object position `[m]`.
    pub object_position: f64,
    /// Force on the object `[N]`.
    pub force_on_object: f64,
    /// Speed of device and object against each other `[m/s]`.
    pub approach_speed: f64,
}

impl Run {
    /// The last tick; its ledger holds the totals of the run.
    #[must_use]
    pub fn last(&self) -> &Tick {
        self.ticks.last().expect("a run has at least one tick")
    }

    /// Number of samples that were refused.
    #[must_use]
    pub fn faults(&self) -> usize {
        self.count(|output| output.fault.is_some())
    }

    /// Number of forces that a limit changed.
    #[must_use]
    pub fn limited(&self) -> usize {
        self.count(|output| output.limited.any())
    }

    /// Number of intervals in which the device accelerated beyond the bound of the guard.
    #[must_use]
    pub fn beyond_guard(&self) -> usize {
        self.count(|output| output.limited.beyond_guard)
    }

    fn count(&self, condition: impl Fn(&Output<f64>) -> bool) -> usize {
        self.ticks
            .iter()
            .filter(|tick| condition(&tick.output))
            .count()
    }

    /// Strongest pull on the object over the run, as a force that is not negative `[N]`.
    pub fn strongest_pull(&self, sign: f64) -> f64 {
        let held = self
            .ticks
            .iter()
            .map(|tick| -sign * tick.held_force_on_object);
        let ends = self.held.iter().skip(1).map(|held| held.from);
        let lines = self.held.iter().zip(ends.chain([self.last().time]));
        let ends_of_lines =
            lines
                .filter(|(held, _)| held.slope_on_object != 0.0)
                .map(|(held, end)| {
                    let rise = 0.5 * (end - held.from) * held.slope_on_object.abs();
                    rise - sign * held.force_on_object
                });
        held.chain(ends_of_lines).fold(0.0, f64::max)
    }
}

impl Reference {
    /// The reference of a profile whose ideal is at `snapshot` of a time, mirrored by `sign` into
    /// the user's frame.
    pub(crate) fn new(
        profile: ForceProfile,
        error: f64,
        sign: f64,
        snapshot: impl Fn(f64) -> Snapshot,
    ) -> Self {
        let duration = profile.grid().end() - profile.start();
        let points = (profile.intervals() * CURVE_POINTS_PER_PERIOD).min(MAX_CURVE_POINTS);
        let curve = (0..=points)
            .map(|i| {
                let at = snapshot(profile.start() + duration * (i as f64 / points as f64));
                IdealPoint {
                    time: at.time,
                    device_position: sign * at.device_position,
                    object_position: sign * at.object_position,
                    force_on_object: sign * at.force_on_object,
                    approach_speed: (at.device_velocity - at.object_velocity).abs(),
                }
            })
            .collect();
        Self {
            profile,
            error,
            curve,
            leaves_box_at: None,
        }
    }
}

/// Longest run `[periods]`. Every tick is kept, about 200 bytes each and for every method.
pub const MAX_PERIODS: usize = 2_000_000;

/// Points of the fine grid of a reference per period, as long as there are not too many.
const CURVE_POINTS_PER_PERIOD: usize = 20;
/// Most points of the fine grid: more than any figure can show.
const MAX_CURVE_POINTS: usize = 1_000_000;

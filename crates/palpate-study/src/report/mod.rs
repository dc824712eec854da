//! Reports of commands: the same facts as a table or as JSON.

mod actuator;
mod demo;
mod drawing;
#[cfg(any(test, feature = "schema"))]
mod in_json;
mod metadata;
mod motion;
mod parameters;
mod recording;
mod replayed;
mod seeds;
mod text;
mod timing;

pub use actuator::{model as actuation_lines, of as actuator_of};
pub use demo::DemoReport;
pub use drawing::DrawingReport;
pub use metadata::{metadata, plant_metadata};
pub use motion::RecordedMotion;
pub use parameters::of as parameters_of;
pub use recording::FromRecording;
pub use replayed::{HandReport, Replayed};
pub use seeds::OverSeeds;
pub(crate) use timing::in_words as timing_in_words;
pub use timing::of as timing_of;

use crate::sim::replay::ReplaySetup;
use crate::sim::run::{Reference, Run};
use palpate_core::{Contact, Difficulty, LoopParams, Mass, Side};
use palpate_scene::{Delay, Scene, Timing};
use palpate_testbed::metrics::Rebound;
use serde::Serialize;
use serde_json::Value;

use crate::seeded::Seeded;
use crate::spread::Spread;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate report 1";

/// Report on runs of several methods.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Report {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Title of the scene or the replay.
    pub title: String,
    /// Stiffness of the contact `[N/m]`.
    pub stiffness_n_per_m: f64,
    /// Mass of the object `[kg]`, `inf` for a wall.
    #[cfg_attr(any(test, feature = "schema"), schemars(with = "in_json::MassInJson"))]
    pub object_mass_kg: Mass<f64>,
    /// On which side of the device the object is.
    #[cfg_attr(any(test, feature = "schema"), schemars(with = "in_json::SideInJson"))]
    pub side: Side,
    /// Whether the contact can only push.
    pub unilateral: bool,
    /// Period of the loop `[s]`.
    pub period_s: f64,
    /// Effective mass of the device `[kg]`, if it is known.
    pub device_mass_kg: Option<f64>,
    /// kappa; 0 for a recorded device, whose motion is prescribed; none if the mass is not known.
    pub kappa: Option<f64>,
    /// Kc = K T²/M; 0 for a wall.
    pub object_kappa: f64,
    /// Delay of the loop `[samples]`.
    pub delay_samples: usize,
    /// The replayed motion or hand, of a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replay: Option<Replayed>,
    /// The recording, if a loop made it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<FromRecording>,
    /// The recorded motion: its samples, gaps, and the interpolated share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<RecordedMotion>,
    /// Further imperfections of the loop.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    pub timing: serde_json::Map<String, Value>,
    /// Seed of the random values of jitter, drops and sensor noise, the first of several; none if nothing is random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Number of consecutive seeds, if there are several. Every value outside `over_seeds` is then of the first seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<usize>,
    /// Lag and gain of the actuator, and the renderer's model values of delay, lag and gain, by key with the unit;
    /// empty if there is only a delay of whole samples.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    pub actuator: serde_json::Map<String, Value>,
    /// Whether the text explains the columns of errors and leaks.
    #[serde(skip)]
    says_what_columns_are: bool,
    /// Fraction of a period by which the delay is longer.
    #[serde(skip)]
    delay_fraction: f64,
    /// The imperfections in words.
    #[serde(skip)]
    timing_in_words: String,
    /// Number of samples, including the last sample of the window.
    pub samples: usize,
    /// Length of the window `[periods]`.
    pub window_periods: usize,
    /// Length of the window `[s]`.
    pub window_s: f64,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`; none without contact.
    pub hold_bound_percent: Option<f64>,
    /// Means over several seeds with their intervals, and differences of the methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeded: Option<Box<Seeded>>,
    /// Spread of the zero-order-hold bound over several seeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_bound_over_seeds: Option<Spread>,
    /// Collisions of the ideal in the window.
    pub ideal_collisions: usize,
    /// Error of the ideal's impulses relative to the largest; 0 if it is exact.
    pub ideal_error: f64,
    /// Time at which the ideal, which has no safety box, leaves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ideal_leaves_box_at_s: Option<f64>,
    /// One entry for each method.
    pub methods: Vec<MethodReport>,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// Results of a method.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodReport {
    /// Name of the method.
    pub method: &'static str,
    /// Parameters by key, with the unit at the end of the key.
    pub parameters: serde_json::Map<String, Value>,
    /// Mean-force error E `[%]`; none without contact.
    pub mean_force_error_percent: Option<f64>,
    /// FRE `[%]`; none without contact.
    pub force_rendering_error_percent: Option<f64>,
    /// FRE over the zero-order-hold bound; none if the bound is 0.
    pub error_over_bound: Option<f64>,
    /// Strongest held force `[N]`.
    pub peak_force_n: f64,
    /// Strongest pull on the object `[N]`.
    pub strongest_pull_n: f64,
    /// Sum of the leaks of the original force, the spring alone `[J]`.
    pub leak_original_j: f64,
    /// Sum of the leaks of the held force `[J]`.
    pub leak_held_j: f64,
    /// Sum of the absolute leaks of the original force `[J]`.
    pub absolute_leak_original_j: f64,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub absolute_leak_held_j: f64,
    /// Energy stored in spring and object at the end `[J]`.
    pub stored_energy_j: f64,
    /// Work through the port into the object, from the energy ledger `[J]`.
    pub port_work_j: f64,
    /// Work of the virtual force `[J]`.
    pub virtual_force_work_j: f64,
    /// Work of external changes of the object `[J]`.
    pub outside_work_j: f64,
    /// Work through the port, integrated by the bench `[J]`; closed loops only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bench_port_work_j: Option<f64>,
    /// Drift of the energy of device and object, relative to the energy of the ideal `[%]`; lossless scenes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_drift_percent: Option<f64>,
    /// Time at which a linkage jammed `[s]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jammed_at_s: Option<f64>,
    /// Time at which the device left its safety box `[s]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_box_at_s: Option<f64>,
    /// Whether the loop diverged; closed loops only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diverged: Option<bool>,
    /// Number of samples that the renderer rejected.
    pub faults: usize,
    /// Number of forces that a limit changed.
    pub limited: usize,
    /// Number of intervals in which the device accelerated beyond the bound of the guard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond_guard: Option<usize>,
    /// Number of rendered collisions.
    pub rendered_collisions: usize,
    /// One entry for each collision of the ideal that ends in the window.
    pub collisions: Vec<CollisionReport>,
    /// Spread of the values over several seeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_seeds: Option<OverSeeds>,
}

/// A collision of the ideal and the corresponding rendered one.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CollisionReport {
    /// Start of the collision `[s]`.
    pub start_s: f64,
    /// Impulse of the ideal `[N s]`.
    pub ideal_impulse_n_s: f64,
    /// Strongest force of the ideal `[N]`.
    pub ideal_peak_force_n: f64,
    /// Whether a corresponding rendered collision exists.
    pub rendered: bool,
    /// Error of the rendered impulse `[%]`.
    pub impulse_error_percent: Option<f64>,
    /// Error of the rendered peak force `[%]`.
    pub peak_force_error_percent: Option<f64>,
    /// Error of the rebound energy `[%]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rebound_energy_error_percent: Option<f64>,
    /// Separation speed of device and object of the ideal `[m/s]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ideal_rebound_speed_m_per_s: Option<f64>,
    /// Error of the separation speed `[%]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rebound_speed_error_percent: Option<f64>,
}

/// Properties of the reported scene or replay.
#[derive(Debug)]
pub struct Subject<'a> {
    /// Title of the scene or replay.
    pub title: String,
    /// The contact.
    pub contact: &'a Contact<f64>,
    /// The loop.
    pub loop_params: &'a LoopParams<f64>,
    /// Effective mass of the device, if known `[kg]`.
    pub device_mass: Option<f64>,
    /// Delay from a sample to its command.
    pub delay: Delay,
    /// Further imperfections of the loop.
    pub timing: Timing,
    /// Standard deviation of the sensor's noise `[m]`.
    pub sensor_noise: f64,
    /// Seed of the random numbers; none if nothing is random.
    pub seed: Option<u64>,
}

impl<'a> Subject<'a> {
    /// Returns the properties of a scene in closed loop.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            title: scene.title.clone(),
            contact: &scene.contact,
            loop_params: &scene.loop_params,
            device_mass: Some(scene.device.mass()),
            delay: scene.delay,
            timing: scene.timing.clone(),
            sensor_noise: scene.device.noise(),
            seed: scene.random_seed(),
        }
    }

    /// Returns the properties of a replay of a recorded motion or hand.
    #[must_use]
    pub fn of_replay(title: String, setup: &'a ReplaySetup) -> Self {
        Self {
            title,
            contact: &setup.contact,
            loop_params: &setup.loop_params,
            device_mass: setup.device_mass,
            delay: setup.delay(),
            timing: Timing::default(),
            sensor_noise: 0.0,
            seed: None,
        }
    }
}

impl Report {
    /// Creates the report on `runs` of a subject.
    #[must_use]
    pub fn new(subject: &Subject, reference: &Reference, runs: &[Run]) -> Self {
        let period = subject.loop_params.period;
        let profile = &reference.profile;
        let window = profile.grid().end() - profile.start();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 1 to MAX_PERIODS"
        )]
        let window_periods = (window / period).round() as usize;
        let object_mass = match subject.contact.object_mass {
            Mass::Finite(mass) => mass,
            Mass::Infinite => f64::INFINITY,
        };
        let difficulty = Difficulty::new(
            subject.contact.stiffness,
            subject.device_mass.unwrap_or(f64::INFINITY),
            object_mass,
            period,
        )
        .ok();
        Self {
            format: FORMAT,
            title: subject.title.clone(),
            stiffness_n_per_m: subject.contact.stiffness,
            object_mass_kg: subject.contact.object_mass,
            side: subject.contact.side,
            unilateral: subject.contact.unilateral,
            period_s: period,
            device_mass_kg: subject.device_mass,
            kappa: difficulty
                .filter(|_| subject.device_mass.is_some())
                .map(|difficulty| difficulty.kappa),
            object_kappa: difficulty.map_or(0.0, |difficulty| difficulty.object_kappa),
            delay_samples: subject.delay.whole_samples(),
            replay: None,
            recording: None,
            motion: None,
            timing: timing::of(subject.delay, &subject.timing),
            seed: subject.seed,
            seeds: None,
            seeded: None,
            actuator: serde_json::Map::new(),
            says_what_columns_are: true,
            delay_fraction: subject.delay.fraction(),
            timing_in_words: timing::of_subject(subject),
            samples: runs.first().map_or(0, |run| run.ticks.len()),
            window_periods,
            window_s: window_periods as f64 * period,
            hold_bound_percent: runs
                .iter()
                .find_map(|run| run.force.fidelity)
                .map(|fidelity| fidelity.hold_bound),
            hold_bound_over_seeds: None,
            ideal_collisions: profile.collisions().len(),
            ideal_error: reference.error,
            ideal_leaves_box_at_s: reference.leaves_box_at,
            methods: runs
                .iter()
                .map(|run| MethodReport::new(run, subject.contact.side.sign()))
                .collect(),
            files: Vec::new(),
        }
    }

    /// Omits the explanation of the columns, which a previous report contains.
    pub fn after_another(&mut self) {
        self.says_what_columns_are = false;
    }

    /// Sets the replayed motion or hand.
    pub fn replayed(&mut self, replayed: Replayed) {
        self.replay = Some(replayed);
    }

    /// Sets the replayed recording.
    pub fn recorded(&mut self, recording: FromRecording) {
        self.recording = Some(recording);
    }

    /// Sets the coverage of the loop's samples by the recorded motion.
    pub fn moved(&mut self, motion: RecordedMotion) {
        self.motion = Some(motion);
    }

    /// Sets the true values of the actuator and the renderer's model values, by key with the unit.
    pub fn actuated(&mut self, values: impl IntoIterator<Item = (&'static str, f64)>) {
        let named = |(key, value): (&str, f64)| (key.to_owned(), value.into());
        self.actuator.extend(values.into_iter().map(named));
    }

    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }

    /// Returns the report as JSON.
    #[must_use]
    pub fn json(&self) -> String {
        crate::json(self)
    }
}

impl MethodReport {
    /// Creates the report on `run`, whose object is on the side of `sign`.
    pub(crate) fn new(run: &Run, sign: f64) -> Self {
        let ledger = &run.last().ledger;
        let fidelity = run.force.fidelity;
        let rebounds = run.energy.as_ref().map(|energy| &energy.rebounds);
        Self {
            method: run.method.name(),
            parameters: parameters::of(&run.parameters),
            mean_force_error_percent: fidelity.map(|f| f.mean_force_error),
            force_rendering_error_percent: fidelity.map(|f| f.force_rendering_error),
            error_over_bound: fidelity.and_then(|f| f.error_over_bound),
            peak_force_n: run.force.peak_force,
            strongest_pull_n: run.strongest_pull(sign),
            leak_original_j: ledger.original_leak.accumulated,
            leak_held_j: ledger.held_leak.accumulated,
            absolute_leak_original_j: ledger.original_leak.absolute,
            absolute_leak_held_j: ledger.held_leak.absolute,
            stored_energy_j: ledger.stored,
            port_work_j: ledger.port_work,
            virtual_force_work_j: ledger.virtual_force_work,
            outside_work_j: ledger.outside_work,
            bench_port_work_j: run.bench_port_work,
            energy_drift_percent: run
                .energy
                .as_ref()
                .and_then(|energy| energy.energy_drift)
                .map(in_percent),
            jammed_at_s: run.jammed_at,
            left_box_at_s: run.left_box_at,
            diverged: run.diverged,
            faults: run.faults(),
            limited: run.limited(),
            beyond_guard: Some(run.beyond_guard()).filter(|&count| count > 0),
            rendered_collisions: run.force.rendered_collisions,
            collisions: run
                .force
                .collisions
                .iter()
                .enumerate()
                .map(|(number, collision)| {
                    let rendered = collision.rendered.as_ref();
                    let rebound = run.rebounds.get(number);
                    CollisionReport {
                        start_s: collision.ideal.start,
                        ideal_impulse_n_s: collision.ideal.impulse,
                        ideal_peak_force_n: collision.ideal.peak_force,
                        rendered: rendered.is_some(),
                        impulse_error_percent: rendered
                            .and_then(|rendered| rendered.impulse_error)
                            .map(in_percent),
                        peak_force_error_percent: rendered
                            .and_then(|rendered| rendered.peak_force_error)
                            .map(in_percent),
                        rebound_energy_error_percent: match rebounds.and_then(|all| all.get(number))
                        {
                            Some(Rebound::EnergyError(error)) => Some(in_percent(*error)),
                            _ => None,
                        },
                        ideal_rebound_speed_m_per_s: rebound.map(|speed| speed.ideal),
                        rebound_speed_error_percent: rebound
                            .and_then(|speed| speed.error)
                            .map(in_percent),
                    }
                })
                .collect(),
            over_seeds: None,
        }
    }
}

fn in_percent(ratio: f64) -> f64 {
    100.0 * ratio
}

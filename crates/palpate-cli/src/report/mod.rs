//! What a command reports: the same facts as a table or as JSON.

pub mod compare;
mod parameters;
mod recording;
mod replayed;
mod text;
mod timing;

pub use parameters::of as parameters_of;
pub use recording::FromRecording;
pub use replayed::Replayed;
pub use text::{counted, digits, exactly, lines, motors_off, number, percent, plain_table, short};
pub use timing::of as timing_of;

use palpate::{Contact, Difficulty, LoopParams, Mass, Side};
use palpate_scene::Timing;
use palpate_sim::run::{Reference, Run};
use palpate_testbed::metrics::Rebound;
use serde::Serialize;
use serde_json::Value;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate report 1";

/// Everything a run of some methods has to say.
#[derive(Debug, Serialize)]
pub struct Report {
    format: &'static str,
    title: String,
    stiffness_n_per_m: f64,
    object_mass_kg: Mass<f64>,
    side: Side,
    unilateral: bool,
    period_s: f64,
    device_mass_kg: Option<f64>,
    /// kappa; 0 for a recorded device, which cannot be moved; none if the mass is not known.
    kappa: Option<f64>,
    object_kappa: f64,
    delay_samples: usize,
    /// Of a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<Replayed>,
    /// Of a recording that a loop has made.
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<FromRecording>,
    /// What else is not perfect about the loop.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    timing: serde_json::Map<String, Value>,
    /// Whether the text says what the columns of errors and leaks are.
    #[serde(skip)]
    says_what_columns_are: bool,
    #[serde(skip)]
    delay_fraction: f64,
    #[serde(skip)]
    timing_in_words: String,
    /// Samples that were taken, the one that closes the window included.
    samples: usize,
    window_periods: usize,
    window_s: f64,
    hold_floor_percent: Option<f64>,
    ideal_collisions: usize,
    /// Error of the ideal's impulses relative to the largest; 0 where it is exact.
    ideal_error: f64,
    /// When the ideal leaves the safety box that it does not have.
    #[serde(skip_serializing_if = "Option::is_none")]
    ideal_leaves_box_at_s: Option<f64>,
    methods: Vec<MethodReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
}

#[derive(Debug, Serialize)]
struct MethodReport {
    method: &'static str,
    parameters: serde_json::Map<String, Value>,
    mean_force_error_percent: Option<f64>,
    force_rendering_error_percent: Option<f64>,
    error_over_floor: Option<f64>,
    peak_force_n: f64,
    strongest_pull_n: f64,
    leak_original_j: f64,
    leak_held_j: f64,
    absolute_leak_original_j: f64,
    absolute_leak_held_j: f64,
    stored_energy_j: f64,
    port_work_j: f64,
    virtual_force_work_j: f64,
    outside_work_j: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    bench_port_work_j: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    energy_drift_percent: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    jammed_at_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    left_box_at_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diverged: Option<bool>,
    faults: usize,
    limited: usize,
    rendered_collisions: usize,
    collisions: Vec<CollisionReport>,
}

#[derive(Debug, Serialize)]
struct CollisionReport {
    start_s: f64,
    ideal_impulse_n_s: f64,
    ideal_peak_force_n: f64,
    rendered: bool,
    impulse_error_percent: Option<f64>,
    peak_force_error_percent: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rebound_energy_error_percent: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ideal_rebound_speed_m_per_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rebound_speed_error_percent: Option<f64>,
}

/// What a report says of the scene or the replay it is about.
#[derive(Debug)]
pub struct Subject<'a> {
    /// A line that names it.
    pub title: String,
    /// The contact.
    pub contact: &'a Contact<f64>,
    /// The loop.
    pub loop_params: &'a LoopParams<f64>,
    /// Effective mass of the device, if known `[kg]`.
    pub device_mass: Option<f64>,
    /// Whole samples between measuring and actuating.
    pub delay: usize,
    /// What else is not perfect about the loop.
    pub timing: Timing,
}

impl Report {
    /// The report on `runs` of a subject.
    pub fn new(subject: &Subject, reference: &Reference, runs: &[Run]) -> Self {
        let period = subject.loop_params.period;
        let profile = &reference.profile;
        let window = profile.grid().end() - profile.start();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 1 to MOST_PERIODS"
        )]
        let window_periods = (window / period).round() as usize;
        let object_mass = match subject.contact.object_mass {
            Mass::Finite(mass) => mass,
            Mass::Infinite => f64::INFINITY,
        };
        let difficulty = Difficulty::of(
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
            delay_samples: subject.delay,
            replay: None,
            recording: None,
            timing: timing::of(&subject.timing),
            says_what_columns_are: true,
            delay_fraction: subject.timing.delay_fraction,
            timing_in_words: timing::in_words(&subject.timing),
            samples: runs.first().map_or(0, |run| run.ticks.len()),
            window_periods,
            window_s: window_periods as f64 * period,
            hold_floor_percent: runs
                .iter()
                .find_map(|run| run.force.fidelity)
                .map(|fidelity| fidelity.hold_floor),
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

    /// Leaves out what the columns are: another report has said so.
    pub fn after_another(&mut self) {
        self.says_what_columns_are = false;
    }

    /// Says what of a recording was replayed.
    pub fn replayed(&mut self, replayed: Replayed) {
        self.replay = Some(replayed);
    }

    /// Says which recording that was.
    pub fn recorded(&mut self, recording: FromRecording) {
        self.recording = Some(recording);
    }

    /// Adds a file that was written.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }

    /// The report as JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a report has string keys only")
    }
}

impl MethodReport {
    fn new(run: &Run, sign: f64) -> Self {
        let ledger = &run.last().ledger;
        let fidelity = run.force.fidelity;
        let rebounds = run.energy.as_ref().map(|energy| &energy.rebounds);
        Self {
            method: run.method.name(),
            parameters: parameters::of(&run.parameters),
            mean_force_error_percent: fidelity.map(|f| f.mean_force_error),
            force_rendering_error_percent: fidelity.map(|f| f.force_rendering_error),
            error_over_floor: fidelity.and_then(|f| f.error_over_floor),
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
        }
    }
}

fn in_percent(ratio: f64) -> f64 {
    100.0 * ratio
}

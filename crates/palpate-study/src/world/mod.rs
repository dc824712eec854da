//! Results of methods on a world: the report of `simulate` for scenes with several bodies.

pub mod candidates;
pub mod forces;
mod setting;
pub mod suite;
mod text;
pub mod tune;

pub use setting::SettingReport;

use crate::sim::world::{Refusal, WorldBench, WorldRun};
use palpate_scene::Delay;
use palpate_scene::world::WorldScene;
use palpate_testbed::metrics::Fidelity;
use palpate_testbed::world::{DeviceEvaluation, Member, WorldIdeal};
use serde::Serialize;

use crate::report::{RecordedMotion, timing_in_words, timing_of};
use crate::seeded::Seeded;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world 1";

/// Results of methods on a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Title of the scene.
    pub title: String,
    /// Sampling period.
    pub period_s: f64,
    /// Delay from a sample to the start of its force.
    pub delay_s: f64,
    /// Time constant of the actuators.
    pub lag_s: f64,
    /// Ratio of delivered to commanded force.
    pub gain: f64,
    /// Order of the hold: 1 if commands are lines. Omitted for constants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_order: Option<u8>,
    /// Further imperfections of the loop.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    pub timing: serde_json::Map<String, serde_json::Value>,
    /// Seed of the random values of jitter, drops and sensor noise; none if nothing is random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The imperfections in words.
    #[serde(skip)]
    timing_in_words: String,
    /// Length of the evaluated window.
    pub window_s: f64,
    /// Number of samples in it.
    pub samples: usize,
    /// Time from which the ideal's motion depends on its integration steps: the window ends there. None if it does
    /// not depend on them.
    pub chaotic_from_s: Option<f64>,
    /// Mean-force error between the ideal and the ideal with coarser steps; none if it was computed only once.
    pub ideal_error_percent: Option<f64>,
    /// The recorded motion from a table: its samples, gaps, and the interpolated share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<RecordedMotion>,
    /// Number of contacts that begin in the ideal's window.
    pub contacts: usize,
    /// Names of pairs that overlap at the start, so that their contact begins with that overlap.
    pub overlapping_at_start: Vec<[String; 2]>,
    /// Largest penetration of the ideal's contacts.
    pub deepest_m: f64,
    /// Influence of sensor and hand on the errors, one entry per device.
    pub decisive: Vec<DecisiveReport>,
    /// One entry for each method.
    pub methods: Vec<WorldMethodReport>,
    /// Means over several seeds with their intervals, and differences of the methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeded: Option<Seeded>,
    /// Methods that were omitted, with the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutReport>,
}

/// An omitted method.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LeftOutReport {
    /// Name of the method.
    pub method: &'static str,
    /// Reason why it cannot be set up.
    pub reason: String,
}

/// Influence of the sensor and the hand of a device on its force error.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DecisiveReport {
    /// Name of the device.
    pub name: String,
    /// Force change per quantum of the position, for the stiffest contact of the ideal with the tool.
    pub quantum_force_n: f64,
    /// That force change over the root mean square of the ideal's force during contact with the tool; none without
    /// contact. Above 0.1 the sensor dominates the error.
    pub quantum_over_force: Option<f64>,
    /// Stiffness of the hand times the square of the period, over the lowest mass along an axis. Above 0.2 the hand
    /// dominates the error if forces are delayed.
    pub hand_over_mass: f64,
}

/// Results of a method on a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldMethodReport {
    /// Name of the method.
    pub method: String,
    /// Errors over all devices and axes; none if the ideal touches no tool.
    pub sum: Option<FidelityReport>,
    /// One entry for each device.
    pub devices: Vec<WorldDeviceReport>,
    /// Generated energy of the held forces: the total energy gain of hands, bodies, contacts and dissipation.
    pub leak_j: f64,
    /// Energy dissipated by friction and damping of contacts and joints.
    pub dissipated_j: f64,
    /// Number of samples that the renderer rejected.
    pub refused_samples: usize,
    /// The first rejected sample, if any.
    pub first_refusal: Option<RefusalReport>,
    /// Number of samples at which a limit changed a force; a guard in report mode changes none.
    pub limited_samples: usize,
    /// Number of samples at which forces exceeded the guard's bound, limited or not.
    pub guarded_samples: usize,
    /// Number of intervals in which a device accelerated beyond the bound of the guard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond_guard: Option<usize>,
    /// Number of samples at which contacts changed their mode more often than the finest sub-steps of the renderer
    /// resolve.
    pub coarse_samples: usize,
    /// Number of samples with more nearby triangles or shell points than the renderer's capacity: it ignored the
    /// farthest.
    pub crowded_samples: usize,
    /// Number of samples at which the fastest contact or joint needed more sub-steps than a tick has: it oscillates
    /// within a few periods.
    pub too_fast_samples: usize,
    /// Number of times that a tool or body went through a solid and left it on the far side.
    pub went_through: usize,
    /// The first such event, if any.
    pub first_through: Option<ThroughReport>,
}

/// A tool or body that went through a solid.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ThroughReport {
    /// Time at which it was found on the far side.
    pub time_s: f64,
    /// Name of the tool or body that went through.
    pub first: String,
    /// Name of the solid.
    pub second: String,
}

/// A rejected sample with the reason.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RefusalReport {
    /// Time of the sample.
    pub time_s: f64,
    /// Name of the fault, for example `overflow`.
    pub fault: &'static str,
    /// Name of the device whose position or orientation is at fault; none if it is not of a device.
    pub device: Option<String>,
    /// Whether a contact or joint is too stiff or too damped for its masses at this period, so that its computed
    /// motion would grow.
    pub too_fast: bool,
    /// The reason in words.
    pub reason: String,
}

/// Results of the force on one device.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldDeviceReport {
    /// Name of the device.
    pub name: String,
    /// Errors over its axes, including the torque; none if the ideal does not touch its tool.
    pub sum: Option<FidelityReport>,
    /// Errors of the force alone.
    pub force: Option<FidelityReport>,
    /// Errors of the torque alone; none for a device without torque.
    pub torque: Option<TorqueReport>,
    /// Errors of the force along x, y and z, or along the device's own axes; none for an axis without force in the
    /// ideal.
    pub axes: [Option<FidelityReport>; 3],
    /// Axes of the device as unit vectors in world axes; none if they are the world's axes.
    pub own_axes: Option<[[f64; 3]; 3]>,
    /// Largest magnitude of the held force.
    pub peak_force_n: f64,
    /// Largest magnitude of the held force over that of the ideal's force; none if the ideal has no force.
    pub peak_over_ideal_peak: Option<f64>,
    /// Number of contacts of the ideal that are long enough to be counted.
    pub touches: usize,
    /// Largest error of a contact's impulse; none if no contact was rendered.
    pub largest_impulse_error_percent: Option<f64>,
}

/// Results of the torque on one device, about its mass centre.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TorqueReport {
    /// Errors over its axes; none if the ideal has no torque.
    pub sum: Option<FidelityReport>,
    /// Errors about x, y and z; none for an axis without torque in the ideal.
    pub axes: [Option<FidelityReport>; 3],
    /// Largest magnitude of the held torque.
    pub peak_torque_n_m: f64,
}

/// Errors of held forces, in percent of the ideal's root mean square. An infinite error is `null`.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FidelityReport {
    /// E, the avoidable part of the error.
    pub mean_force_error_percent: f64,
    /// FRE.
    pub force_rendering_error_percent: f64,
    /// Zero-order-hold bound: minimum FRE of any held force.
    pub hold_bound_percent: f64,
    /// FRE over the zero-order-hold bound.
    pub error_over_bound: Option<f64>,
}

impl From<Fidelity> for FidelityReport {
    fn from(fidelity: Fidelity) -> Self {
        Self {
            mean_force_error_percent: fidelity.mean_force_error,
            force_rendering_error_percent: fidelity.force_rendering_error,
            hold_bound_percent: fidelity.hold_bound,
            error_over_bound: fidelity.error_over_bound,
        }
    }
}

impl WorldReport {
    /// Adds the methods without settings in the scene, which `all` omits.
    pub fn all_methods(&mut self, scene: &WorldScene) {
        let left_out = WorldScene::METHODS.into_iter().filter_map(|method| {
            let reason = scene.method(method).err()?.message.to_string();
            Some(LeftOutReport { method, reason })
        });
        self.left_out.extend(left_out);
    }

    /// Creates the report of these runs on the bench of a scene.
    #[must_use]
    pub fn new(scene: &WorldScene, bench: &WorldBench, runs: &[WorldRun]) -> Self {
        let ideal = bench.ideal();
        let check = bench.self_check();
        let grid = &ideal.grid;
        let peaks = ideal.devices.iter().map(|device| {
            let peaks = device.peaks.iter().copied();
            peaks.fold(0.0, f64::max)
        });
        let names = scene.world.tools.iter().map(|tool| tool.name.as_str());
        let own_axes = scene.devices.iter().map(|device| device.own_axes);
        let of_devices = names.clone().zip(peaks).zip(own_axes);
        let of_devices: Vec<_> = of_devices
            .map(|((name, ideal_peak), own_axes)| OfDevice {
                name,
                ideal_peak,
                own_axes,
            })
            .collect();
        let decisive = names.zip(bench.decisive());
        let imperfections = &scene.timing.imperfections;
        let noises = scene.devices.iter().map(|device| device.drivetrain.noise);
        let noise = noises.fold(0.0, f64::max);
        Self {
            format: FORMAT,
            title: scene.title.clone(),
            period_s: scene.timing.period,
            delay_s: scene.timing.delay.time(scene.timing.period),
            lag_s: scene.timing.actuator.lag,
            gain: scene.timing.actuator.gain,
            hold_order: (!scene.render.actuation.hold.is_constant()).then_some(1),
            timing: timing_of(Delay::NONE, imperfections),
            seed: scene.random_seed(),
            timing_in_words: timing_in_words(Delay::NONE, imperfections, noise).join(", "),
            window_s: grid.edge(grid.intervals()),
            samples: runs.first().map_or(0, |run| run.positions.len()),
            chaotic_from_s: check.and_then(|check| check.chaotic_from),
            ideal_error_percent: check.map(|check| check.error),
            motion: None,
            contacts: ideal.encounters.len(),
            overlapping_at_start: overlapping_at_start(scene, ideal),
            left_out: Vec::new(),
            seeded: None,
            deepest_m: ideal.deepest(),
            decisive: decisive
                .map(|(name, of)| DecisiveReport {
                    name: name.to_owned(),
                    quantum_force_n: of.quantum_force,
                    quantum_over_force: of.quantum_over_force,
                    hand_over_mass: of.hand_over_mass,
                })
                .collect(),
            methods: runs.iter().map(|run| of_run(run, &of_devices)).collect(),
        }
    }
}

impl WorldReport {
    /// Sets the coverage of the loop's samples by the recorded motion.
    pub fn moved(&mut self, motion: RecordedMotion) {
        self.motion = Some(motion);
    }
}

fn overlapping_at_start(scene: &WorldScene, ideal: &WorldIdeal) -> Vec<[String; 2]> {
    let name = |member| match member {
        Member::Device(number) => scene.world.tools[number].name.clone(),
        Member::Body(number) => scene.world.bodies[number].name.clone(),
    };
    let at_start = ideal.encounters.iter().filter(|it| it.start == 0.0);
    let mut pairs: Vec<_> = at_start.map(|it| it.between.map(name)).collect();
    // A box on a plane has several contact points.
    pairs.dedup();
    pairs
}

/// Data of a device common to all methods.
struct OfDevice<'a> {
    name: &'a str,
    ideal_peak: f64,
    own_axes: Option<[[f64; 3]; 3]>,
}

fn of_run(run: &WorldRun, of_devices: &[OfDevice<'_>]) -> WorldMethodReport {
    let devices = run.evaluation.devices.iter().zip(of_devices);
    WorldMethodReport {
        method: run.method.clone(),
        sum: run.evaluation.sum.map(Into::into),
        devices: devices
            .map(|(evaluated, of)| of_device(evaluated, of))
            .collect(),
        leak_j: run.created(),
        dissipated_j: run.ledger.dissipated(),
        refused_samples: run.refused,
        first_refusal: run.first_refusal.map(|it| of_refusal(&it, of_devices)),
        limited_samples: run.limited,
        guarded_samples: run.guarded,
        beyond_guard: Some(run.beyond_guard).filter(|&count| count > 0),
        coarse_samples: run.coarse,
        crowded_samples: run.crowded,
        too_fast_samples: run.too_fast,
        went_through: run.went_through,
        first_through: run.first_through.as_ref().map(|through| {
            let [first, second] = through.names.clone();
            ThroughReport {
                time_s: through.time,
                first,
                second,
            }
        }),
    }
}

fn of_refusal(refusal: &Refusal, of_devices: &[OfDevice<'_>]) -> RefusalReport {
    let fault = refusal.fault.fault;
    let device = refusal.fault.tool.and_then(|tool| of_devices.get(tool));
    let device = device.map(|of| of.name.to_owned());
    let of_whom = device
        .as_ref()
        .map_or_else(String::new, |name| format!("\"{name}\": "));
    let reason = if refusal.too_fast {
        "a contact or joint is too stiff or too damped for its masses at this period: its computed motion would diverge"
            .into()
    } else {
        format!("{of_whom}{fault}")
    };
    RefusalReport {
        time_s: refusal.time,
        fault: fault.name(),
        device,
        too_fast: refusal.too_fast,
        reason,
    }
}

fn of_device(evaluated: &DeviceEvaluation, of: &OfDevice<'_>) -> WorldDeviceReport {
    let ideal_peak = of.ideal_peak;
    let rendered = evaluated
        .touches
        .iter()
        .filter_map(|it| it.rendered.as_ref());
    let errors = rendered.filter_map(|touch| touch.impulse_error);
    WorldDeviceReport {
        name: of.name.to_owned(),
        sum: evaluated.sum.map(Into::into),
        force: evaluated.force.map(Into::into),
        torque: evaluated.torque.as_ref().map(|torque| TorqueReport {
            sum: torque.sum.map(Into::into),
            axes: torque.axes.map(|axis| axis.map(Into::into)),
            peak_torque_n_m: torque.peak_torque,
        }),
        axes: evaluated.axes.map(|axis| axis.map(Into::into)),
        own_axes: of.own_axes,
        peak_force_n: evaluated.peak_force,
        peak_over_ideal_peak: (ideal_peak > 0.0).then(|| evaluated.peak_force / ideal_peak),
        touches: evaluated.touches.len(),
        largest_impulse_error_percent: errors.map(|error| 100.0 * error).reduce(f64::max),
    }
}

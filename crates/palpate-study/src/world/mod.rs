//! What methods made of a world: the report of `simulate` for scenes with several bodies.

pub mod candidates;
pub mod compare;
pub mod forces;
mod setting;
pub mod suite;
mod text;
pub mod tune;

pub use setting::SettingReport;

use palpate_scene::world::WorldScene;
use palpate_sim::world::{Refusal, WorldBench, WorldRun};
use palpate_testbed::metrics::Fidelity;
use palpate_testbed::world::{DeviceJudgement, Member, WorldIdeal};
use serde::Serialize;

use crate::report::RecordedMotion;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate world 1";

/// What methods made of a world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// Title of the scene.
    pub title: String,
    /// Time from sample to sample.
    pub period_s: f64,
    /// Time from a sample to the beginning of its force.
    pub delay_s: f64,
    /// Time constant of the actuators.
    pub lag_s: f64,
    /// Delivered over commanded force.
    pub gain: f64,
    /// Length of the window that was judged.
    pub window_s: f64,
    /// Number of samples in it.
    pub samples: usize,
    /// From when on the ideal's motion depends on the steps by which it is computed: the window ends there. None: for
    /// the whole window it does not.
    pub chaotic_from_s: Option<f64>,
    /// Mean-force error of the ideal, computed again with coarser steps, against itself; none if it was
    /// computed once.
    pub ideal_error_percent: Option<f64>,
    /// Of a recorded motion in a table: its samples, gaps, and the interpolated share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<RecordedMotion>,
    /// Number of contacts that begin in the ideal's window.
    pub contacts: usize,
    /// Names of those that overlap at the start, so that a contact begins with that overlap.
    pub overlapping_at_start: Vec<[String; 2]>,
    /// Largest penetration of the ideal's contacts.
    pub deepest_m: f64,
    /// One entry for each device: how much its sensor and its hand decide about the errors.
    pub decisive: Vec<DecisiveReport>,
    /// One entry for each method.
    pub methods: Vec<WorldMethodReport>,
    /// Methods that were left out of all, with the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutReport>,
}

/// A method that was left out of all.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LeftOutReport {
    /// Name of the method.
    pub method: &'static str,
    /// Why it cannot be set up.
    pub reason: String,
}

/// How much the sensor and the hand of a device decide about the error of its force.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DecisiveReport {
    /// Name of the device.
    pub name: String,
    /// By how much a quantum of the position changes the force of the stiffest contact that the ideal makes with the tool.
    pub quantum_force_n: f64,
    /// The same over the root mean square of the ideal's force while something touches the tool; none if nothing does.
    /// Above 0.1 the sensor decides.
    pub quantum_over_force: Option<f64>,
    /// Stiffness of the hand times the square of the period, over the least mass along an axis. Above 0.2 the hand decides,
    /// where forces come late.
    pub hand_over_mass: f64,
}

/// What a method made of a world.
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
    /// Energy that held forces created: what hands, bodies, contacts and dissipation have gained together.
    pub leak_j: f64,
    /// Energy that friction and damping took, of contacts and joints.
    pub dissipated_j: f64,
    /// Samples that the renderer refused.
    pub refused_samples: usize,
    /// The first of them; none if the renderer refused none.
    pub first_refusal: Option<RefusalReport>,
    /// Samples at which a limit changed a force; a guard that only reports changes none.
    pub limited_samples: usize,
    /// Samples at which forces exceeded the guard's bound, whether it kept them to it or not.
    pub guarded_samples: usize,
    /// Samples at which contacts changed their mode more often than the renderer follows at its finest.
    pub coarse_samples: usize,
    /// Samples at which more triangles, or points of a shell, were near what they may touch than the renderer has room for: it left
    /// out the furthest.
    pub crowded_samples: usize,
    /// Samples at which the fastest contact or joint asked for more sub-steps than a tick has: it swings within a few periods.
    pub too_fast_samples: usize,
    /// How often a tool or body went through a solid and came out of its far side.
    pub went_through: usize,
    /// The first time; none if none did.
    pub first_through: Option<ThroughReport>,
}

/// A tool or body that went through a solid.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ThroughReport {
    /// When it was found on the far side.
    pub time_s: f64,
    /// Name of the tool or body that went through,
    pub first: String,
    /// and of the solid.
    pub second: String,
}

/// A sample that the renderer refused, and why.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RefusalReport {
    /// When it was taken.
    pub time_s: f64,
    /// Name of the fault, as `overflow`.
    pub fault: &'static str,
    /// Name of the device whose position or orientation it is; none where it is no one's.
    pub device: Option<String>,
    /// Whether a contact or joint is too stiff or too damped for its masses at this period: its computed motion would have grown.
    pub too_fast: bool,
    /// The same in words.
    pub reason: String,
}

/// How the force on one device was rendered.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WorldDeviceReport {
    /// Name of the device.
    pub name: String,
    /// Errors over its axes, those of the torque too; none if the ideal does not touch its tool.
    pub sum: Option<FidelityReport>,
    /// Errors of the force alone.
    pub force: Option<FidelityReport>,
    /// Errors of the torque alone; none for a device that gives none.
    pub torque: Option<TorqueReport>,
    /// Errors of the force along x, y and z, or along the device's own axes; none where the ideal has no force.
    pub axes: [Option<FidelityReport>; 3],
    /// The device's axes, unit vectors along the world's; none if they are the world's.
    pub own_axes: Option<[[f64; 3]; 3]>,
    /// Largest length of the held force.
    pub peak_force_n: f64,
    /// The same over the largest length of the ideal's force; none if the ideal has none.
    pub peak_over_ideal_peak: Option<f64>,
    /// Touches of the ideal that are long enough to be told apart.
    pub touches: usize,
    /// Largest error of a touch's impulse; none if no touch was rendered.
    pub largest_impulse_error_percent: Option<f64>,
}

/// How the torque on one device, about its mass centre, was rendered.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TorqueReport {
    /// Errors over its axes; none if the ideal has no torque.
    pub sum: Option<FidelityReport>,
    /// Errors about x, y and z; none where the ideal has no torque.
    pub axes: [Option<FidelityReport>; 3],
    /// Largest length of the held torque.
    pub peak_torque_n_m: f64,
}

/// Errors of held forces, in percent of the ideal's root mean square. An infinite one is `null`.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FidelityReport {
    /// E, the part that a renderer can avoid.
    pub mean_force_error_percent: f64,
    /// FRE.
    pub force_rendering_error_percent: f64,
    /// The least FRE that held forces can have here.
    pub hold_floor_percent: f64,
    /// FRE over the floor.
    pub error_over_floor: Option<f64>,
}

impl From<Fidelity> for FidelityReport {
    fn from(fidelity: Fidelity) -> Self {
        Self {
            mean_force_error_percent: fidelity.mean_force_error,
            force_rendering_error_percent: fidelity.force_rendering_error,
            hold_floor_percent: fidelity.hold_floor,
            error_over_floor: fidelity.error_over_floor,
        }
    }
}

impl WorldReport {
    /// Adds the methods that the scene has no settings for, which `all` leaves out.
    pub fn all_methods(&mut self, scene: &WorldScene) {
        let left_out = WorldScene::METHODS.into_iter().filter_map(|method| {
            let reason = scene.method(method).err()?.message.to_string();
            Some(LeftOutReport { method, reason })
        });
        self.left_out.extend(left_out);
    }

    /// The report of these runs on the bench of a scene.
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
        Self {
            format: FORMAT,
            title: scene.title.clone(),
            period_s: scene.timing.period,
            delay_s: scene.timing.actuator.delay,
            lag_s: scene.timing.actuator.lag,
            gain: scene.timing.actuator.gain,
            window_s: grid.edge(grid.intervals()),
            samples: runs.first().map_or(0, |run| run.positions.len()),
            chaotic_from_s: check.and_then(|check| check.chaotic_from),
            ideal_error_percent: check.map(|check| check.error),
            motion: None,
            contacts: ideal.encounters.len(),
            overlapping_at_start: overlapping_at_start(scene, ideal),
            left_out: Vec::new(),
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
    /// Says how the recorded motion covers the loop's samples.
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
    // A box on a plane touches it at several corners.
    pairs.dedup();
    pairs
}

/// What all methods have in common of a device.
struct OfDevice<'a> {
    name: &'a str,
    ideal_peak: f64,
    own_axes: Option<[[f64; 3]; 3]>,
}

fn of_run(run: &WorldRun, of_devices: &[OfDevice<'_>]) -> WorldMethodReport {
    let devices = run.judgement.devices.iter().zip(of_devices);
    WorldMethodReport {
        method: run.method.clone(),
        sum: run.judgement.sum.map(Into::into),
        devices: devices.map(|(judged, of)| of_device(judged, of)).collect(),
        leak_j: run.created(),
        dissipated_j: run.books.dissipated(),
        refused_samples: run.refused,
        first_refusal: run.first_refusal.map(|it| of_refusal(&it, of_devices)),
        limited_samples: run.limited,
        guarded_samples: run.guarded,
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
        "a contact or joint is too stiff or too damped for its masses at this period: its computed motion would have \
         grown"
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

fn of_device(judged: &DeviceJudgement, of: &OfDevice<'_>) -> WorldDeviceReport {
    let ideal_peak = of.ideal_peak;
    let rendered = judged.touches.iter().filter_map(|it| it.rendered.as_ref());
    let errors = rendered.filter_map(|touch| touch.impulse_error);
    WorldDeviceReport {
        name: of.name.to_owned(),
        sum: judged.sum.map(Into::into),
        force: judged.force.map(Into::into),
        torque: judged.torque.as_ref().map(|torque| TorqueReport {
            sum: torque.sum.map(Into::into),
            axes: torque.axes.map(|axis| axis.map(Into::into)),
            peak_torque_n_m: torque.peak_torque,
        }),
        axes: judged.axes.map(|axis| axis.map(Into::into)),
        own_axes: of.own_axes,
        peak_force_n: judged.peak_force,
        peak_over_ideal_peak: (ideal_peak > 0.0).then(|| judged.peak_force / ideal_peak),
        touches: judged.touches.len(),
        largest_impulse_error_percent: errors.map(|error| 100.0 * error).reduce(f64::max),
    }
}

//! The sampled-data loop: renderer and device, coupled by a held force.

use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::measure::{Sampler, SensorNoise};
use palpate_testbed::metrics::{EnergyEvaluation, ForceEvaluation, ReboundSpeed};
use palpate_testbed::profile::{ForceProfile, Snapshot};
use palpate_testbed::reference::{self, ReferenceScene, Stop};
use palpate_testbed::timeline::Timeline;

use palpate_core::{Hold, Mass, Method, MethodParams, ParameterValue, Renderer};

use crate::sim::loop_record::LoopRecord;
use crate::sim::own_device::{OwnDevice, Seen};
use crate::sim::plant::{Plant, is_free};
use crate::sim::run::{IdealPoint, MAX_PERIODS, Reference, Run, RunMethod};
use crate::sim::sampled_loop::SampledLoop;
use palpate_scene::method::MethodName;
use palpate_scene::named_parameters::named_parameters;
use palpate_scene::{Delay, Measure, Scene, SetupError};

pub use crate::sim::loop_error::LoopError;

/// A scene on the testbed. Its ideal is computed once and is the reference solution for every method.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    scene: &'a Scene,
    sign: f64,
    plant: Plant,
    motion: IdealMotion,
    timeline: Timeline,
    reference: Reference,
}

/// The ideal of a scene: in closed form where there is one.
#[derive(Clone, Debug)]
enum IdealMotion {
    Exact(Ideal),
    Integrated(reference::Reference),
}

/// Longest step of an integrated ideal `[s]`.
const LONGEST_STEP: f64 = 1e-5;
/// Most steps of an integrated ideal in a period, however long that is.
const MAX_STEPS: f64 = 10_000.0;

impl<'a> Bench<'a> {
    /// Sets up `scene` and its ideal.
    ///
    /// # Errors
    /// A value the bench refuses; a window that the ideal cannot fill or that is too long.
    pub fn new(scene: &'a Scene) -> Result<Self, LoopError> {
        scene.check().map_err(SetupError::from)?;
        let sign: f64 = scene.contact.side.sign();
        Self::on(scene, Plant::of(scene, sign)?, is_free(scene))
    }

    /// Like [`new`](Self::new), but `device` replaces the scene's device and hand. It starts in its present state, on
    /// the scene's side of the object, in the user's frame. The scene's device then determines only the model values of
    /// the renderer (effective mass and encoder quantum) and the encoder itself. The ideal is integrated on a copy of
    /// `device`, so [`DevicePlant::advance`](palpate_testbed::device::DevicePlant::advance) should be exact, or much
    /// more accurate than the effects to be measured.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn with_device(
        scene: &'a Scene,
        device: impl OwnDevice + 'static,
    ) -> Result<Self, LoopError> {
        scene.check().map_err(SetupError::from)?;
        let sign: f64 = scene.contact.side.sign();
        let plant = Plant::Own(Seen::new(Box::new(device), sign));
        Self::on(scene, plant, false)
    }

    /// The bench of a scene that was checked, whose ideal is known in closed form where `is_free`.
    fn on(scene: &'a Scene, plant: Plant, is_free: bool) -> Result<Self, LoopError> {
        // Checks contact and loop, whatever the method.
        scene.renderer(match scene.hold() {
            Hold::Constant => scene.method,
            Hold::Line => MethodName::Coupled,
        })?;
        let sign: f64 = scene.contact.side.sign();
        let period = scene.loop_params.period;
        let too_long = |periods: f64| {
            if periods > MAX_PERIODS as f64 {
                Err(LoopError::TooLong(periods))
            } else {
                Ok(())
            }
        };
        if let Measure::Collisions(asked) = scene.measure {
            too_long(asked as f64)?;
        }
        // In the user's periods the window is the ideal's; how it is cut is the loop's.
        let timeline = |periods: usize| {
            let shortest = scene.timing.shortest_period(period);
            too_long((periods as f64 * period / shortest).floor())?;
            Ok::<_, LoopError>(scene.timeline(periods)?)
        };
        let (timeline, profile, error, motion) = if is_free {
            let ideal = exact_ideal(scene, sign)?;
            let intervals = match scene.measure {
                Measure::Collisions(asked) => {
                    ideal
                        .window(asked, period)
                        .ok_or_else(|| LoopError::TooFewCollisions {
                            asked,
                            found: (1..asked)
                                .take_while(|&n| ideal.end_of_collision(n).is_some())
                                .count(),
                        })?
                }
                Measure::Duration(duration) => whole_periods(duration, period)?,
            };
            too_long(intervals as f64)?;
            let timeline = timeline(intervals)?;
            let profile = ideal.profile_on(timeline.grid().clone())?;
            (timeline, profile, 0.0, IdealMotion::Exact(ideal))
        } else {
            let ideal = integrated_ideal(scene, sign, &plant, timeline)?;
            (
                ideal.timeline,
                ideal.profile,
                ideal.error,
                IdealMotion::Integrated(ideal.reference),
            )
        };
        let mut reference = match &motion {
            IdealMotion::Exact(ideal) => Reference::new(profile, 0.0, sign, |time| ideal.at(time)),
            IdealMotion::Integrated(integrated) => {
                let points = reference::POINTS_PER_PERIOD as f64 / period;
                Reference::new(profile, error, sign, |time| {
                    let last = integrated.record.len() - 1;
                    integrated.record[nearest_point(time * points, last)]
                })
            }
        };
        reference.leaves_box_at = leaves_box_at(scene, &reference);
        Ok(Self {
            scene,
            sign,
            plant,
            motion,
            timeline,
            reference,
        })
    }

    /// The scene's ideal over the window.
    #[must_use]
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Runs the loop by `method` over the window and evaluates it.
    ///
    /// At each sample instant the renderer receives the measured position and the measured time since the previous
    /// sample. Each of its forces is held from its arrival at the motor until the next one arrives, while the device
    /// moves under the actuator's output. The renderer receives the commanded force after the motor's limit, as a
    /// driver would report it.
    ///
    /// # Errors
    /// The settings are invalid for this method.
    pub fn run(&self, method: MethodName) -> Result<Run, LoopError> {
        self.run_built_in(&self.timeline, self.scene, method)
    }

    /// Runs each of `methods`, in their order.
    ///
    /// # Errors
    /// The error of the first method that cannot run; see [`run`](Self::run).
    pub fn run_all(&self, methods: &[MethodName]) -> Result<Vec<Run>, LoopError> {
        methods.iter().map(|&method| self.run(method)).collect()
    }

    /// Runs the loop by a caller-defined method and evaluates it, as [`run`](Self::run) does.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn run_own(&self, params: impl MethodParams<f64>) -> Result<Run, LoopError> {
        let mut parameters = Vec::new();
        params.describe(&mut |key, value| parameters.push((key, value)));
        let method = RunMethod::Own(params.name());
        let loop_params = self.scene.loop_params_with_delay();
        let renderer =
            Renderer::new(self.scene.contact, loop_params, params).map_err(SetupError::from)?;
        self.run_along(&self.timeline, self.scene, &renderer, method, parameters)
    }

    /// Like [`run`](Self::run), for a variant of this bench's scene: a copy with other settings of its methods, another
    /// guard or hold, another model mass or model actuator, or, if the loop is perfect otherwise, another delay. The
    /// ideal depends on none of them, so one bench serves all such scenes.
    ///
    /// # Errors
    /// Those of [`run`](Self::run), or `scene` differs in anything else.
    pub fn run_varied(&self, scene: &Scene, method: MethodName) -> Result<Run, LoopError> {
        if !self.evaluates(scene) {
            return Err(LoopError::AnotherScene);
        }
        if scene.hold() != self.scene.hold() {
            scene.check().map_err(SetupError::from)?;
        }
        if scene.delay == self.scene.delay {
            return self.run_built_in(&self.timeline, scene, method);
        }
        let delayed = scene.timeline(self.timeline.samples().len() - 1)?;
        if delayed.grid() != self.timeline.grid() {
            return Err(LoopError::AnotherScene);
        }
        self.run_built_in(&delayed, scene, method)
    }

    /// Whether this bench can [run](Self::run_varied) `scene`, if the loop is perfect or the delay is its own:
    /// whether its ideal is that of `scene`.
    #[must_use]
    pub fn evaluates(&self, scene: &Scene) -> bool {
        let mut own = self.scene.clone();
        own.settings.clone_from(&scene.settings);
        own.loop_params.guard = scene.loop_params.guard;
        own.loop_params.actuation.hold = scene.loop_params.actuation.hold;
        // Whole samples: another fraction or time cuts the grid of the ideal elsewhere.
        if let (
            Delay::Periods { samples, .. },
            Delay::Periods {
                samples: others, ..
            },
        ) = (&mut own.delay, scene.delay)
        {
            *samples = others;
        }
        own.model = scene.model;
        own.model_device_mass = scene.model_device_mass;
        own == *scene
    }

    fn run_built_in(
        &self,
        timeline: &Timeline,
        scene: &Scene,
        method: MethodName,
    ) -> Result<Run, LoopError> {
        let renderer = scene.renderer(method)?;
        let params = scene.params(method).map_err(SetupError::from)?;
        let parameters = named_parameters(&params.derived(renderer.method()));
        let method = RunMethod::BuiltIn(method);
        self.run_along(timeline, scene, &renderer, method, parameters)
    }

    fn run_along<M: Method<f64>>(
        &self,
        timeline: &Timeline,
        scene: &Scene,
        renderer: &Renderer<f64, M>,
        method: RunMethod,
        parameters: Vec<(&'static str, ParameterValue<f64>)>,
    ) -> Result<Run, LoopError> {
        let mut in_progress = self.loop_in_progress(scene, renderer)?;
        let record = LoopRecord::of(&mut in_progress, timeline);
        Ok(self.evaluated_run(scene, record, method, parameters))
    }

    /// Returns the loop of `scene` before its first sample.
    fn loop_in_progress<'r, M: Method<f64>>(
        &self,
        scene: &Scene,
        renderer: &'r Renderer<f64, M>,
    ) -> Result<SampledLoop<'r, M, Plant>, LoopError> {
        Ok(SampledLoop {
            sampler: if scene.device.encoder_quantum() > 0.0 {
                Sampler::quantum(scene.device.encoder_quantum())?
            } else {
                Sampler::Ideal
            },
            noise: SensorNoise::normal(scene.device.noise(), scene.timing.seed)?,
            actuator: Actuator::new(scene.actuator)?,
            sign: self.sign,
            virtual_force: scene.virtual_force,
            ..SampledLoop::new(renderer, scene.object, self.plant.clone())
                .map_err(SetupError::from)?
        })
    }

    /// Evaluates the record of a loop against the ideal.
    fn evaluated_run(
        &self,
        scene: &Scene,
        record: LoopRecord,
        method: RunMethod,
        parameters: Vec<(&'static str, ParameterValue<f64>)>,
    ) -> Run {
        let LoopRecord {
            ticks,
            snapshots,
            held,
            port_work,
            jammed_at,
            left_box_at,
            ..
        } = record;
        let forces: Vec<f64> = held
            .iter()
            .map(|held| self.sign * held.force_on_object)
            .collect();
        let slopes: Vec<f64> = held
            .iter()
            .map(|held| self.sign * held.slope_on_object)
            .collect();
        let profile = &self.reference.profile;
        let energy = self.energy_evaluation(&forces, &snapshots);
        Run {
            method,
            parameters,
            ticks,
            held,
            force: match scene.hold() {
                Hold::Constant => ForceEvaluation::new(&forces, profile),
                Hold::Line => ForceEvaluation::of_lines(&forces, &slopes, profile),
            }
            .expect("one force per interval"),
            jammed_at,
            left_box_at,
            diverged: Some(self.has_diverged(
                energy.as_ref(),
                record_until(&snapshots, left_box_at.or(jammed_at)),
            )),
            rebounds: ReboundSpeed::sampled(profile, &forces, &snapshots)
                .expect("one force per interval, and a sample"),
            energy,
            bench_port_work: Some(port_work),
            centre_offset: scene.centre_offset(),
        }
    }

    /// Returns the effect of a lossless loop on its energy. With friction or a passive hand, energy is not conserved
    /// and cannot be compared.
    fn energy_evaluation(&self, held: &[f64], record: &[Snapshot]) -> Option<EnergyEvaluation> {
        match (&self.motion, &self.plant) {
            (IdealMotion::Exact(ideal), Plant::Free(_)) => Some(
                EnergyEvaluation::sampled(ideal, &self.reference.profile, held, record)
                    .expect("one force per interval, and a sample"),
            ),
            _ => None,
        }
    }

    fn has_diverged(&self, energy: Option<&EnergyEvaluation>, record: &[Snapshot]) -> bool {
        match energy {
            Some(energy) => energy.diverged,
            None => {
                let speeds = self
                    .reference
                    .curve
                    .iter()
                    .map(|point| point.approach_speed);
                ran_away(record, speeds.fold(0.0, f64::max))
            }
        }
    }
}

/// The record up to `time` `[s]`, after which the loop is no longer what moves the device.
fn record_until(record: &[Snapshot], time: Option<f64>) -> &[Snapshot] {
    let end = record.partition_point(|at| time.is_none_or(|time| at.time <= time));
    &record[..end]
}

/// Returns whether device and object ever move relative to each other with ten times the energy of the ideal's
/// `fastest` relative speed `[m/s]`, or any value is not finite.
fn ran_away(record: &[Snapshot], fastest: f64) -> bool {
    record.iter().any(|at| {
        let approach = at.device_velocity - at.object_velocity;
        !at.is_finite() || approach * approach > 10.0 * fastest * fastest
    })
}

/// The nearest whole number from 0 to `last`.
fn nearest_point(position: f64, last: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "limited to 0 and above; a float becomes the nearest index"
    )]
    let index = position.round().max(0.0) as usize;
    index.min(last)
}

/// Returns the time `[s]` at which the ideal, which has no safety box, leaves the scene's safety box.
fn leaves_box_at(scene: &Scene, reference: &Reference) -> Option<f64> {
    let [low, high] = scene.device.pantograph()?.linkage.safety_box?.y;
    let outside = |point: &&IdealPoint| !(low..=high).contains(&point.device_position);
    reference.curve.iter().find(outside).map(|point| point.time)
}

/// Mass of the object `[kg]`, infinite for a wall.
#[must_use]
pub fn object_mass(scene: &Scene) -> f64 {
    match scene.contact.object_mass {
        Mass::Finite(mass) => mass,
        Mass::Infinite => f64::INFINITY,
    }
}

fn exact_ideal(scene: &Scene, sign: f64) -> Result<Ideal, InvalidParameter> {
    Ideal::new(PointMassScene {
        stiffness: scene.contact.stiffness,
        device_mass: scene.device.mass(),
        object_mass: object_mass(scene),
        user_force: sign * scene.device.hand_force(),
        virtual_force: sign * scene.virtual_force,
        device_position: sign * scene.device.position(),
        device_velocity: sign * scene.device.velocity(),
        object_position: sign * scene.object.position,
        object_velocity: sign * scene.object.velocity,
    })
}

/// An integrated ideal, and the timeline of the loop that it is the reference for.
struct Integrated {
    timeline: Timeline,
    /// The ideal force, cut where the loop changes its own.
    profile: ForceProfile,
    reference: reference::Reference,
    error: f64,
}

/// The ideal of a plant without a closed form, and its error: how much the impulse of any period
/// changes when the step is halved, relative to the largest impulse, over 3 because the error of a
/// second-order step falls to a quarter.
fn integrated_ideal(
    scene: &Scene,
    sign: f64,
    plant: &Plant,
    timeline: impl Fn(usize) -> Result<Timeline, LoopError>,
) -> Result<Integrated, LoopError> {
    let period = scene.loop_params.period;
    let stop = match scene.measure {
        Measure::Collisions(asked) => Stop::AfterCollisions(asked),
        Measure::Duration(duration) => Stop::AfterPeriods(whole_periods(duration, period)?),
    };
    // The ideal has no motor limit.
    let plant = plant.without_motor_limits(scene, sign)?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1 to MAX_STEPS / 20"
    )]
    let twenties = (period / LONGEST_STEP)
        .clamp(20.0, MAX_STEPS)
        .div_euclid(20.0) as usize;
    let object = |steps_per_period| ReferenceScene {
        stiffness: scene.contact.stiffness,
        object_mass: object_mass(scene),
        virtual_force: sign * scene.virtual_force,
        object_position: sign * scene.object.position,
        object_velocity: sign * scene.object.velocity,
        period,
        steps_per_period,
    };
    let coarse = reference::integrate(&plant, &object(20 * twenties), stop)?;
    let timeline = timeline(coarse.profile.intervals())?;
    let (fine, profile) = reference::integrate_on(&plant, &object(40 * twenties), timeline.grid())?;
    let largest = |impulses: &[f64]| impulses.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let (a, b) = (coarse.profile.impulses(), fine.profile.impulses());
    let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let error = largest(&change) / (3.0 * largest(b).max(f64::MIN_POSITIVE));
    Ok(Integrated {
        timeline,
        profile,
        reference: fine,
        error,
    })
}

/// Force rendering error of `run` `[%]` against the force that another loop held, `fine`, whose
/// period is a whole fraction of the run's: what the paper, which had no ideal, measures against.
/// None if `fine` held no force within the run's window or ends before it.
#[must_use]
pub fn error_against(run: &Run, fine: &Run) -> Option<f64> {
    let window = run.last().time;
    let mut coarse = run.held.iter().peekable();
    let (mut error, mut force, mut current) = (0.0, 0.0, 0.0);
    let ends = fine.held.iter().skip(1).map(|held| held.from);
    for (held, end) in fine.held.iter().zip(ends.chain([fine.last().time])) {
        let middle = 0.5 * (held.from + end);
        if middle > window {
            break;
        }
        while let Some(held) = coarse.next_if(|held| held.from <= middle) {
            current = held.force_on_object;
        }
        let (step, held) = (end - held.from, held.force_on_object);
        error += step * (current - held) * (current - held);
        force += step * held * held;
    }
    let reaches = fine.last().time >= window - 1e-9;
    (reaches && force > 0.0).then(|| 100.0 * (error / force).sqrt())
}

/// Number of periods that cover `duration` `[s]`; an excess of a millionth of a period is
/// rounding.
fn whole_periods(duration: f64, period: f64) -> Result<usize, LoopError> {
    let periods = (duration / period - 1e-6).ceil().max(1.0);
    if periods > MAX_PERIODS as f64 {
        return Err(LoopError::TooLong(periods));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number from 1 to MAX_PERIODS"
    )]
    Ok(periods as usize)
}

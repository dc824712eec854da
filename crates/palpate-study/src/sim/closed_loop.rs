//! The sampled-data loop: renderer and device, coupled by a held force.

use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::DevicePlant;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::measure::{Sampler, SensorNoise};
use palpate_testbed::metrics::{EnergyEvaluation, ForceEvaluation, ReboundSpeed};
use palpate_testbed::profile::{ForceProfile, Snapshot};
use palpate_testbed::reference::{self, ReferenceScene, Stop};
use palpate_testbed::timeline::Timeline;

use palpate_core::{Mass, Method, MethodParams, ParameterValue, Renderer};

use crate::sim::own_device::{OwnDevice, Seen};
use crate::sim::plant::{Plant, is_free};
use crate::sim::run::{Held, IdealPoint, MAX_PERIODS, Reference, Run, RunMethod, Tick};
use crate::sim::sampled_loop::{Sampled, SampledLoop};
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
    /// `device`, so [`DevicePlant::advance`] should be exact, or much more accurate than the effects to be measured.
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
        scene.renderer(scene.method)?;
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
    /// guard, another model mass or model actuator, or, if the loop is perfect otherwise, another delay. The ideal
    /// depends on none of them, so one bench serves all such scenes.
    ///
    /// # Errors
    /// Those of [`run`](Self::run), or `scene` differs in anything else.
    pub fn run_varied(&self, scene: &Scene, method: MethodName) -> Result<Run, LoopError> {
        if !self.evaluates(scene) {
            return Err(LoopError::AnotherScene);
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
        let sign = self.sign;
        let mut in_progress = SampledLoop {
            sampler: if scene.device.encoder_quantum() > 0.0 {
                Sampler::quantum(scene.device.encoder_quantum())?
            } else {
                Sampler::Ideal
            },
            noise: SensorNoise::normal(scene.device.noise(), scene.timing.seed)?,
            actuator: Actuator::new(scene.actuator)?,
            sign,
            virtual_force: scene.virtual_force,
            ..SampledLoop::new(renderer, scene.object, self.plant.clone())
                .map_err(SetupError::from)?
        };

        let samples = timeline.samples();
        let grid = timeline.grid();
        let mut ticks: Vec<Tick> = Vec::with_capacity(samples.len());
        let mut record = Vec::with_capacity(samples.len());
        let mut held = Vec::with_capacity(grid.intervals());
        let mut delivered = HeldSince::default();
        let mut port_work = 0.0;
        let (mut jammed_at, mut left_box_at) = (None, None);
        let mut time = 0.0;
        for stretch in timeline.stretches() {
            let answer = if let Some(index) = stretch.sample {
                let sample = samples[index];
                time = sample.time;
                // Nothing was measured before the first sample.
                let measured_time = (index > 0).then_some(sample.elapsed);
                let sampled = in_progress.sample(sample.elapsed, measured_time);
                let sent = in_progress.given_force(sampled.output.force_on_object);
                in_progress.report_sent(sent);
                if left_box_at.is_none() && in_progress.device.has_left_box() {
                    left_box_at = Some(time);
                }
                Some((index, sampled))
            } else {
                None
            };
            let command = match (stretch.command, &answer) {
                (None, _) => 0.0,
                (Some(own), Some((index, sampled))) if own == *index => {
                    sampled.output.force_on_object
                }
                (Some(earlier), _) => ticks[earlier].output.force_on_object,
            };
            let sent = in_progress.given_force(command);
            let force = in_progress.acting_force(sent);
            let device = &in_progress.device;
            if let Some((index, Sampled { measured, output })) = answer {
                ticks.push(Tick {
                    time,
                    device_position: measured,
                    true_device_position: sign * device.position(),
                    output,
                    held_force_on_object: force,
                    command_from: samples[index].command_from,
                    ledger: *in_progress.state.ledger(),
                });
                record.push(Snapshot {
                    time,
                    device_position: device.position(),
                    device_velocity: device.velocity(),
                    object_position: sign * output.object_position,
                    object_velocity: sign * output.object_velocity,
                    force_on_object: sign * force,
                });
            }
            if stretch.begins_hold && held.len() < grid.intervals() {
                delivered = HeldSince::default();
                held.push(Held {
                    from: grid.edge(held.len()),
                    force_on_object: force,
                });
            }
            if stretch.duration > 0.0 {
                let driven = in_progress.drive(sent, stretch.duration);
                port_work += driven.work;
                delivered.add(driven.mean_force, stretch.duration);
                if let (Some(held), Some(mean)) = (held.last_mut(), delivered.mean()) {
                    held.force_on_object = mean;
                }
                time += stretch.duration;
                if jammed_at.is_none() && in_progress.device.is_jammed() {
                    jammed_at = Some(time);
                }
            }
        }
        let forces: Vec<f64> = held
            .iter()
            .map(|held| sign * held.force_on_object)
            .collect();
        let profile = &self.reference.profile;
        let energy = self.energy_evaluation(&forces, &record);
        Ok(Run {
            method,
            parameters,
            ticks,
            held,
            force: ForceEvaluation::new(&forces, profile).expect("one force per interval"),
            jammed_at,
            left_box_at,
            diverged: Some(self.has_diverged(
                energy.as_ref(),
                record_until(&record, left_box_at.or(jammed_at)),
            )),
            rebounds: ReboundSpeed::sampled(profile, &forces, &record)
                .expect("one force per interval, and a sample"),
            energy,
            bench_port_work: Some(port_work),
            centre_offset: scene.centre_offset(),
        })
    }
}

/// Delivered force since a command began to act.
#[derive(Default)]
struct HeldSince {
    first: Option<f64>,
    changed: bool,
    impulse: f64,
    duration: f64,
}

impl HeldSince {
    fn add(&mut self, force: f64, duration: f64) {
        self.changed |= self.first.is_some_and(|first| first != force);
        self.first = self.first.or(Some(force));
        self.impulse += force * duration;
        self.duration += duration;
    }

    /// The force, or where it changed its mean over time; none before anything was.
    fn mean(&self) -> Option<f64> {
        if self.changed {
            Some(self.impulse / self.duration)
        } else {
            self.first
        }
    }
}

impl Bench<'_> {
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

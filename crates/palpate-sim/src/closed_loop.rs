//! The sampled-data loop: renderer and device, coupled by a held force.

use palpate_testbed::InvalidParameter;
use palpate_testbed::device::Device;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::measure::Sampler;
use palpate_testbed::metrics::{EnergyJudgement, ForceJudgement};
use palpate_testbed::profile::Snapshot;
use palpate_testbed::reference::{self, ReferenceScene, Stop};

use palpate::Mass;

use crate::method::{MethodName, with_derived_values};
use crate::plant::{Plant, is_free};
use crate::run::{MOST_PERIODS, Reference, Run, Tick};
use crate::sampled_loop::SampledLoop;
use crate::scene::{Measure, Scene, SetupError};

/// Why a scene cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LoopError {
    /// The method cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The bench refuses a value.
    #[error(transparent)]
    Bench(#[from] InvalidParameter),
    /// The ideal does not collide as often as the window asks.
    #[error(
        "the window asks for {asked} collisions, but the ideal has only {found}; \
         state a duration instead"
    )]
    TooFewCollisions {
        /// Collisions asked for.
        asked: usize,
        /// Collisions of the ideal.
        found: usize,
    },
    /// The window is too long.
    #[error("the window has {0} periods; at most {MOST_PERIODS} fit")]
    TooLong(f64),
}

/// A scene on the bench: its ideal is computed once and judges every method.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    scene: &'a Scene,
    sign: f64,
    plant: Plant,
    motion: IdealMotion,
    intervals: usize,
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
const MOST_STEPS: f64 = 10_000.0;

impl<'a> Bench<'a> {
    /// Sets up `scene` and its ideal.
    ///
    /// # Errors
    /// A value the bench refuses; a window that the ideal cannot fill or that is too long.
    pub fn new(scene: &'a Scene) -> Result<Self, LoopError> {
        scene.check().map_err(SetupError::from)?;
        // Checks contact and loop, whatever the method.
        scene.renderer(scene.method)?;
        let sign: f64 = scene.contact.side.sign();
        let period = scene.loop_params.period;
        let plant = Plant::of(scene, sign)?;
        let too_long = |periods: f64| {
            if periods > MOST_PERIODS as f64 {
                Err(LoopError::TooLong(periods))
            } else {
                Ok(())
            }
        };
        if let Measure::Collisions(asked) = scene.measure {
            too_long(asked as f64)?;
        }
        let (profile, error, motion) = if is_free(scene) {
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
            let profile = ideal.profile(period, intervals)?;
            (profile, 0.0, IdealMotion::Exact(ideal))
        } else {
            let (integrated, error) = integrated_ideal(scene, sign, &plant)?;
            let profile = integrated.profile.clone();
            (profile, error, IdealMotion::Integrated(integrated))
        };
        let intervals = profile.intervals();
        let reference = match &motion {
            IdealMotion::Exact(ideal) => Reference::new(profile, 0.0, sign, |time| ideal.at(time)),
            IdealMotion::Integrated(integrated) => {
                let points = reference::POINTS_PER_PERIOD as f64 / period;
                Reference::new(profile, error, sign, |time| {
                    let last = integrated.record.len() - 1;
                    integrated.record[nearest_point(time * points, last)]
                })
            }
        };
        Ok(Self {
            scene,
            sign,
            plant,
            motion,
            intervals,
            reference,
        })
    }

    /// The scene's ideal over the window.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Runs the loop by `method` over the window and judges it.
    ///
    /// Sample, render, hold: at each sample instant the renderer sees the measured position, and
    /// its force, or with a delay an earlier one, is held until the next while the device moves.
    ///
    /// # Errors
    /// Settings that do not make this method.
    pub fn run(&self, method: MethodName) -> Result<Run, LoopError> {
        self.run_as(self.scene, method)
    }

    /// Runs `scene`, which is this bench's own but for the settings of its methods.
    pub(crate) fn run_as(&self, scene: &Scene, method: MethodName) -> Result<Run, LoopError> {
        let sign = self.sign;
        let period = scene.loop_params.period;
        let renderer = scene.renderer(method)?;
        let mut in_progress = SampledLoop {
            sampler: if scene.device.encoder_quantum > 0.0 {
                Sampler::quantum(scene.device.encoder_quantum)?
            } else {
                Sampler::Ideal
            },
            sign,
            virtual_force: scene.virtual_force,
            ..SampledLoop::new(
                &renderer,
                scene.object,
                self.plant.clone(),
                DelayedHold::new(scene.delay)?,
                period,
            )
            .map_err(SetupError::from)?
        };

        let mut ticks = Vec::with_capacity(self.intervals + 1);
        let mut record = Vec::with_capacity(self.intervals + 1);
        let mut port_work = 0.0;
        let mut jammed_at = None;
        for i in 0..=self.intervals {
            let time = i as f64 * period;
            let sampled = in_progress.sample();
            let device = &in_progress.device;
            ticks.push(Tick {
                time,
                device_position: sampled.measured,
                true_device_position: sign * device.position(),
                output: sampled.output,
                held_force_on_object: sampled.held,
                ledger: *in_progress.state.ledger(),
            });
            record.push(Snapshot {
                time,
                device_position: device.position(),
                device_velocity: device.velocity(),
                object_position: sign * sampled.output.object_position,
                object_velocity: sign * sampled.output.object_velocity,
                force_on_object: sign * sampled.held,
            });
            if i < self.intervals {
                port_work += in_progress.advance(&sampled);
                if jammed_at.is_none() && in_progress.device.is_jammed() {
                    jammed_at = Some(time + period);
                }
            }
        }
        let held: Vec<f64> = record[..self.intervals]
            .iter()
            .map(|snapshot| snapshot.force_on_object)
            .collect();
        let profile = &self.reference.profile;
        Ok(Run {
            method,
            params: with_derived_values(scene.params(method).map_err(SetupError::from)?, &renderer),
            ticks,
            force: ForceJudgement::of(&held, profile).expect("one force per interval"),
            jammed_at,
            diverged: Some(self.has_diverged(&record)),
            energy: self.energy_judgement(&record),
            bench_port_work: Some(port_work),
        })
    }
}

impl Bench<'_> {
    /// What a lossless loop did to its energy. With friction or a hand of its own there is no such
    /// energy to compare with.
    fn energy_judgement(&self, record: &[Snapshot]) -> Option<EnergyJudgement> {
        match (&self.motion, &self.plant) {
            (IdealMotion::Exact(ideal), Plant::Free(_)) => Some(
                EnergyJudgement::of(ideal, &self.reference.profile, record)
                    .expect("one state per sample"),
            ),
            _ => None,
        }
    }

    fn has_diverged(&self, record: &[Snapshot]) -> bool {
        match self.energy_judgement(record) {
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

/// Whether device and object ever move ten times as energetically against each other as the ideal's
/// `fastest` relative speed `[m/s]`, or anything is no number.
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

fn object_mass(scene: &Scene) -> f64 {
    match scene.contact.object_mass {
        Mass::Finite(mass) => mass,
        Mass::Infinite => f64::INFINITY,
    }
}

fn exact_ideal(scene: &Scene, sign: f64) -> Result<Ideal, InvalidParameter> {
    Ideal::new(PointMassScene {
        stiffness: scene.contact.stiffness,
        device_mass: scene.device.mass,
        object_mass: object_mass(scene),
        user_force: sign * scene.user_force,
        virtual_force: sign * scene.virtual_force,
        device_position: sign * scene.device.position,
        device_velocity: sign * scene.device.velocity,
        object_position: sign * scene.object.position,
        object_velocity: sign * scene.object.velocity,
    })
}

/// The ideal of a plant without a closed form, and its error: how much the impulse of any interval
/// changes when the step is halved, relative to the largest impulse, over 3 because the error of a
/// second-order step falls to a quarter.
fn integrated_ideal(
    scene: &Scene,
    sign: f64,
    plant: &Plant,
) -> Result<(reference::Reference, f64), LoopError> {
    let period = scene.loop_params.period;
    let stop = match scene.measure {
        Measure::Collisions(asked) => Stop::AfterCollisions(asked),
        Measure::Duration(duration) => Stop::AfterPeriods(whole_periods(duration, period)?),
    };
    // A motor's limit is no part of the ideal.
    let plant = plant.without_motor_limits(scene, sign)?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1 to MOST_STEPS / 20"
    )]
    let twenties = (period / LONGEST_STEP)
        .clamp(20.0, MOST_STEPS)
        .div_euclid(20.0) as usize;
    let with_steps = |steps_per_period| {
        let object = ReferenceScene {
            stiffness: scene.contact.stiffness,
            object_mass: object_mass(scene),
            virtual_force: sign * scene.virtual_force,
            object_position: sign * scene.object.position,
            object_velocity: sign * scene.object.velocity,
            period,
            steps_per_period,
        };
        reference::integrate(&plant, &object, stop)
    };
    let (coarse, fine) = (with_steps(20 * twenties)?, with_steps(40 * twenties)?);
    let largest = |impulses: &[f64]| impulses.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let (a, b) = (coarse.profile.impulses(), fine.profile.impulses());
    let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let error = largest(&change) / (3.0 * largest(b).max(f64::MIN_POSITIVE));
    Ok((fine, error))
}

/// Force rendering error of `run` `[%]` against the force that another loop held, `fine`, whose
/// period is a whole fraction of the run's: what the paper, which had no ideal, measures against.
/// None if `fine` held no force within the run's window or ends before it.
pub fn error_against(run: &Run, fine: &Run) -> Option<f64> {
    let window = run.last().time;
    let mut coarse = run.ticks.iter().peekable();
    let (mut error, mut force, mut current) = (0.0, 0.0, 0.0);
    for pair in fine.ticks.windows(2) {
        let middle = 0.5 * (pair[0].time + pair[1].time);
        if middle > window {
            break;
        }
        while let Some(tick) = coarse.next_if(|tick| tick.time <= middle) {
            current = tick.held_force_on_object;
        }
        let step = pair[1].time - pair[0].time;
        let held = pair[0].held_force_on_object;
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
    if periods > MOST_PERIODS as f64 {
        return Err(LoopError::TooLong(periods));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number from 1 to MOST_PERIODS"
    )]
    Ok(periods as usize)
}

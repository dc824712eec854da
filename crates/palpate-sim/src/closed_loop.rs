//! The sampled-data loop: renderer and device, coupled by a held force.

use palpate_testbed::InvalidParameter;
use palpate_testbed::device::{Device, PointMass};
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::measure::Sampler;
use palpate_testbed::metrics::{EnergyJudgement, ForceJudgement};
use palpate_testbed::profile::Snapshot;

use palpate::{Mass, Sample};

use crate::method::{MethodName, with_derived_values};
use crate::run::{MOST_PERIODS, Reference, Run, Tick};
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
    ideal: Ideal,
    intervals: usize,
    reference: Reference,
}

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
        let ideal = Ideal::new(PointMassScene {
            stiffness: scene.contact.stiffness,
            device_mass: scene.device.mass,
            object_mass: match scene.contact.object_mass {
                Mass::Finite(mass) => mass,
                Mass::Infinite => f64::INFINITY,
            },
            user_force: sign * scene.user_force,
            virtual_force: sign * scene.virtual_force,
            device_position: sign * scene.device.position,
            device_velocity: sign * scene.device.velocity,
            object_position: sign * scene.object.position,
            object_velocity: sign * scene.object.velocity,
        })?;
        let intervals = match scene.measure {
            Measure::Collisions(asked) if asked > MOST_PERIODS => {
                return Err(LoopError::TooLong(asked as f64));
            }
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
        if intervals > MOST_PERIODS {
            return Err(LoopError::TooLong(intervals as f64));
        }
        let profile = ideal.profile(period, intervals)?;
        Ok(Self {
            scene,
            sign,
            intervals,
            reference: Reference::new(profile, sign, |time| ideal.at(time)),
            ideal,
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
        let mut state = renderer.start(scene.object).map_err(SetupError::from)?;
        let mut device = PointMass::new(scene.device.mass, sign * scene.user_force)?
            .starting_at(sign * scene.device.position, sign * scene.device.velocity)?;
        let mut hold = DelayedHold::new(scene.delay)?;
        let sampler = if scene.device.encoder_quantum > 0.0 {
            Sampler::quantum(scene.device.encoder_quantum)?
        } else {
            Sampler::Ideal
        };

        let mut ticks = Vec::with_capacity(self.intervals + 1);
        let mut record = Vec::with_capacity(self.intervals + 1);
        let mut port_work = 0.0;
        for i in 0..=self.intervals {
            let time = i as f64 * period;
            let measured = sign * sampler.sample(device.position());
            let output = renderer.step(
                &mut state,
                Sample::at(measured).with_virtual_force(scene.virtual_force),
            );
            let held = hold.exchange(output.force_on_object);
            renderer.report_held(&mut state, held);
            ticks.push(Tick {
                time,
                device_position: measured,
                true_device_position: sign * device.position(),
                output,
                held_force_on_object: held,
                ledger: *state.ledger(),
            });
            record.push(Snapshot {
                time,
                device_position: device.position(),
                device_velocity: device.velocity(),
                object_position: sign * output.object_position,
                object_velocity: sign * output.object_velocity,
                force_on_object: sign * held,
            });
            if i < self.intervals {
                port_work += device.advance(sign * held, period);
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
            energy: Some(
                EnergyJudgement::of(&self.ideal, profile, &record).expect("one state per sample"),
            ),
            bench_port_work: Some(port_work),
        })
    }
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

//! Drawing of one random plant.

use palpate_core::{Contact, LoopParams, ObjectState};
use palpate_testbed::reference::{self, POINTS_PER_PERIOD, ReferenceScene, Stop};

use super::COLLISIONS;
use super::chance::Chance;
use super::steps::Step;
use crate::sim::closed_loop::{LoopError, object_mass};
use crate::sim::sampled_loop::device_of;
use palpate_scene::method::MethodName;
use palpate_scene::{
    ActuatorParams, Delay, Grip, Hand, Intention, Measure, Model, PointMassDevice, Scene,
    SceneDevice, Timing, Wave,
};

/// Gravity on the object `[m/s²]`.
pub(super) const GRAVITY: f64 = 9.81;

/// Durations of the search for the collisions `[s]`. Most plants collide often enough within the first; a plant that
/// does not within the last is drawn again.
const SEARCHES: [f64; 2] = [0.4, 2.0];
/// Minimum distance of object and device after the last collision `[m]`; below it the end of the collision is
/// ambiguous.
const MIN_PARTING: f64 = 1e-5;
/// Step of the search for collisions `[s]`; the reference solution of a plant is finer.
const SEARCH_STEP: f64 = 1e-4;
/// Maximum number of draws for one plant. One in six is drawn again.
const MAX_DRAWS: u32 = 1000;

/// A plant drawn at random.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomPlant {
    /// Seed of the draws.
    pub seed: u64,
    /// Number of the plant, from 0.
    pub index: usize,
    /// Number of rejected draws, in which object and device did not part three times.
    pub redrawn: u32,
    /// K T²/m, with the mass of the device alone.
    pub kappa: f64,
    /// Kc = K T²/M.
    pub object_kappa: f64,
    /// Speed of the first impact without the hand's spring and damper and without friction `[m/s]`.
    pub impact_speed: f64,
    /// The plant as a scene: without delay in the paper's set, with a calibrated model in the sets with real
    /// actuators.
    pub scene: Scene,
}

/// Reason why a plant cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DrawError {
    /// None of the draws collides often enough.
    #[error("plant {0}: none of {MAX_DRAWS} draws collides {COLLISIONS} times")]
    NeverCollides(usize),
    /// The bench cannot run a draw.
    #[error("plant {0}: {1}")]
    Bench(usize, LoopError),
    /// No excitation force calibrates the device.
    #[error("plant {0} cannot be calibrated: {1}")]
    Calibration(usize, String),
}

impl RandomPlant {
    /// Draws plant number `index` of `seed` of the paper's set; it is always the same.
    ///
    /// # Errors
    /// No failing plant is known. Possible errors: too few collisions, or an error of the bench.
    pub fn draw(seed: u64, index: usize) -> Result<Self, DrawError> {
        colliding(seed, index, "Random plant", draw, &[])
    }
}

/// Returns the first plant that collides often enough, unchanged and with each of the `steps`, among the draws of
/// `draw` for number `index` of `seed`. Its title begins with `kind`.
pub(super) fn colliding(
    seed: u64,
    index: usize,
    kind: &str,
    draw: fn(&mut Chance) -> RandomPlant,
    steps: &[Step],
) -> Result<RandomPlant, DrawError> {
    let mut chance = Chance::new(seed, index as u64);
    for redrawn in 0..MAX_DRAWS {
        let mut plant = draw(&mut chance);
        let mut all = collides(&plant.scene).map_err(|error| DrawError::Bench(index, error))?;
        for step in steps {
            let mut scene = plant.scene.clone();
            step.change(&mut scene);
            all = all && collides(&scene).map_err(|error| DrawError::Bench(index, error))?;
        }
        if all {
            plant.seed = seed;
            plant.index = index;
            plant.redrawn = redrawn;
            plant.scene.title = format!("{kind} {index} of seed {seed}");
            return Ok(plant);
        }
    }
    Err(DrawError::NeverCollides(index))
}

/// Draws a hand on a device of `mass` `[kg]`.
pub(super) fn grip(chance: &mut Chance, mass: f64) -> Grip {
    Grip {
        mass: mass * chance.between(0.0, 1.0),
        stiffness: chance.log_between(10.0, 300.0),
        damping: chance.between(0.5, 5.0),
        // Start of the device: the spring is relaxed, and the user's force is added.
        intention: Intention::at(0.0),
    }
}

/// Draws a tremor of a user who pushes with `user_force` `[N]`, with a probability of one half.
pub(super) fn tremor(chance: &mut Chance, user_force: f64) -> Option<Wave> {
    let trembles = chance.happens(0.5);
    let tremor = Wave {
        amplitude: 0.2 * user_force,
        frequency_hz: chance.between(4.0, 12.0),
    };
    trembles.then_some(tremor)
}

/// Returns the next draw. Every number is drawn even if it is unused, so that one choice does not shift the numbers
/// after it.
fn draw(chance: &mut Chance) -> RandomPlant {
    let mass = chance.log_between(0.05, 0.5);
    let period = chance.log_between(0.001, 0.02);
    let kappa = chance.log_between(0.01, 2.0);
    let object_kappa = chance.log_between(0.01, 3.0);
    let push = chance.between(2.0, 10.0);
    let impact_speed = chance.between(0.2, 1.0);
    let viscous_friction = mass * chance.between(0.0, 1.0);
    let user_force = mass * push;
    let rubs = chance.happens(0.5);
    let encoder_quantum = chance.one_of([0.0, 1e-6, 1e-5]);
    let model_device_mass = mass * chance.log_between(0.5, 2.0);
    let is_held = !chance.happens(0.4);
    let grip = grip(chance, mass);
    let tremor = tremor(chance, user_force);

    let stiffness = kappa * mass / (period * period);
    let object_mass = stiffness * period * period / object_kappa;
    RandomPlant {
        seed: 0,
        index: 0,
        redrawn: 0,
        kappa,
        object_kappa,
        impact_speed,
        scene: Scene {
            title: String::new(),
            contact: Contact::object(stiffness, object_mass),
            loop_params: LoopParams {
                // No speed limit: a diverging loop shall be visible, as in scene files.
                speed_limit: None,
                ..LoopParams::new(period)
            },
            object: ObjectState::at_rest(impact_speed * impact_speed / (2.0 * (push + GRAVITY))),
            virtual_force: -GRAVITY * object_mass,
            device: SceneDevice::PointMass(PointMassDevice {
                mass,
                encoder_quantum,
                viscous_friction,
                coulomb_friction: if rubs { 0.02 * user_force } else { 0.0 },
                hand: Hand {
                    force: user_force,
                    tremor,
                    grip: is_held.then_some(grip),
                    release: None,
                },
                ..PointMassDevice::default()
            }),
            model_device_mass: Some(model_device_mass),
            object_radius: 0.0,
            delay: Delay::NONE,
            timing: Timing::default(),
            actuator: ActuatorParams::default(),
            model: Model::default(),
            measure: Measure::Collisions(COLLISIONS),
            method: MethodName::default(),
            settings: std::collections::HashMap::new(),
        },
    }
}

/// Whether device and object part often enough within the search time.
fn collides(scene: &Scene) -> Result<bool, LoopError> {
    for duration in SEARCHES {
        if collides_within(scene, duration)? {
            return Ok(true);
        }
    }
    Ok(false)
}

fn collides_within(scene: &Scene, duration: f64) -> Result<bool, LoopError> {
    let period = scene.loop_params.period;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 2000 periods and 200 steps in each"
    )]
    let (periods, steps_per_point) = (
        (duration / period).ceil() as usize,
        (period / SEARCH_STEP / POINTS_PER_PERIOD as f64).ceil() as usize,
    );
    let search = ReferenceScene {
        stiffness: scene.contact.stiffness,
        object_mass: object_mass(scene),
        virtual_force: scene.virtual_force,
        object_position: scene.object.position,
        object_velocity: scene.object.velocity,
        period,
        steps_per_period: POINTS_PER_PERIOD * steps_per_point,
    };
    let plant = device_of(scene, 1.0)?;
    let found = reference::integrate(&plant, &search, Stop::AfterPeriods(periods))?;
    let collisions = found.profile.collisions();
    let Some(end) = collisions.get(COLLISIONS - 1).and_then(|last| last.end) else {
        return Ok(false);
    };
    let next = collisions
        .get(COLLISIONS)
        .map_or(f64::INFINITY, |next| next.start);
    Ok(found
        .record
        .iter()
        .filter(|at| at.time > end && at.time < next)
        .any(|at| at.object_position - at.device_position > MIN_PARTING))
}

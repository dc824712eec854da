//! Contact that stays: whether an object that lies on a held device, or is pressed, comes to rest.

use palpate::ObjectState;
use palpate_testbed::device::Device;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::measure::Sampler;

use super::bounce::{Bounce, BounceError};
use crate::closed_loop::LoopError;
use crate::plant::Plant;
use crate::sampled_loop::SampledLoop;
use palpate_scene::Grip;
use palpate_scene::method::{MethodName, Settings};

/// Largest standard deviation of the force, over its mean, of a contact that has come to rest.
pub const RESTS_BELOW: f64 = 0.1;

/// Force with which a contact is pressed `[N]`.
pub const PRESSED_WITH: f64 = 3.0;

/// Hands that hold the device, light and firm: mass `[kg]`, stiffness `[N/m]`, damping `[N s/m]`.
const HANDS: [(f64, f64, f64); 2] = [(0.05, 300.0, 3.0), (0.1, 400.0, 20.0)];

/// Gravity on the object `[m/s²]`.
const GRAVITY: f64 = 9.81;

/// How far from its place of rest the contact begins, over the spring's deflection there. An ideal
/// contact keeps, or loses, what this gives it: 7 % of standard deviation.
const BEGINS_OFF: f64 = 0.1;

/// How long a contact is followed `[s]`, and with how many samples.
const FOLLOWED: f64 = 20.0;
const SAMPLES: (f64, f64) = (2000.0, 20_000.0);

/// The part of the samples, at the end, that is looked at.
const LOOKED_AT: f64 = 0.2;

/// How a contact stays: the standard deviation of its force over what presses it, from the worse hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stay {
    /// Of an object that lies on the device by its weight; none for a wall.
    pub resting: Option<f64>,
    /// Of an object or a wall that is pressed.
    pub pressed: f64,
}

impl Stay {
    /// Whether the object rests, or is a wall.
    pub fn rests(&self) -> bool {
        self.resting.is_none_or(|swing| swing < RESTS_BELOW)
    }

    /// Whether the pressed contact is steady.
    pub fn is_steady_pressed(&self) -> bool {
        self.pressed < RESTS_BELOW
    }
}

impl Bounce {
    /// How the contact stays where it begins near its place of rest, in a light hand and in a firm one.
    ///
    /// # Errors
    /// A parameter that the bench or the method refuses.
    pub fn stay(&self, method: MethodName, settings: Settings) -> Result<Stay, BounceError> {
        let worse = |force: f64| {
            HANDS.into_iter().try_fold(0.0, |worst: f64, hand| {
                Ok::<_, BounceError>(self.swing(method, settings, force, hand)?.max(worst))
            })
        };
        Ok(Stay {
            resting: if self.is_wall() {
                None
            } else {
                Some(worse(GRAVITY * self.object_mass)?)
            },
            pressed: worse(PRESSED_WITH)?,
        })
    }

    /// Standard deviation of the force over `force` `[N]`, which presses device and object together;
    /// infinite where the loop diverged.
    fn swing(
        &self,
        method: MethodName,
        settings: Settings,
        force: f64,
        (mass, stiffness, damping): (f64, f64, f64),
    ) -> Result<f64, BounceError> {
        let mut scene = self.scene(0.0, 1);
        scene.user_force = force;
        scene.virtual_force = if self.is_wall() { 0.0 } else { -force };
        scene.grip = Some(Grip {
            mass,
            stiffness,
            damping,
            position: 0.0,
            swing: None,
            intention: None,
        });
        let renderer = self.renderer(method, settings)?;
        let quantum = self.device.encoder_quantum;
        let place = ObjectState::at_rest(-(1.0 + BEGINS_OFF) * force / self.stiffness);
        let mut in_progress = SampledLoop {
            sampler: if quantum > 0.0 {
                Sampler::quantum(quantum)?
            } else {
                Sampler::Ideal
            },
            virtual_force: scene.virtual_force,
            ..SampledLoop::new(&renderer, place, Plant::of(&scene, 1.0)?)
                .map_err(|error| LoopError::Setup(error.into()))?
        };
        let mut hold = DelayedHold::new(self.delay)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "2000 to 20 000"
        )]
        let samples = (FOLLOWED / self.period).clamp(SAMPLES.0, SAMPLES.1) as usize;
        let first = (1.0 - LOOKED_AT) * samples as f64;
        let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
        for i in 0..samples {
            let output = in_progress.sample(self.period, None).output;
            let held = in_progress.given_force(hold.exchange(output.force_on_object));
            in_progress.report_held(held);
            if !held.is_finite() || !in_progress.device.position().is_finite() {
                return Ok(f64::INFINITY);
            }
            if i as f64 >= first {
                sum += held;
                square += held * held;
                count += 1.0;
            }
            in_progress.advance(held, self.period);
        }
        let mean = sum / count;
        let deviation = (square / count - mean * mean).max(0.0).sqrt() / force;
        Ok(if deviation.is_nan() {
            f64::INFINITY
        } else {
            deviation
        })
    }
}

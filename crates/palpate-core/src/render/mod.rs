//! Renderer: one tick from sample to force, common to all methods.
//!
//! Data flows one way through a tick. The sample closes the ledger entry of the interval that it ends, the method plans
//! the next interval, the limits act on the planned force, and the state stores the held force. A method is a file of
//! this folder; it receives a [`Situation`] and returns a [`Plan`].

mod any;
mod basic;
mod coupled;
mod energy_corrected;
mod energy_tank;
mod extrapolated;
mod force_bounding;
mod hfcr;
mod list;
mod method;
mod named;
mod pmi;
mod popc;
mod popc_ref;
mod predict;
mod seh;
mod setting;
mod state;
mod tick;
mod virtual_coupling;
mod virtual_damper;

pub use any::*;
pub use basic::{Basic, BasicParams};
pub use method::{Ended, Method, MethodParams, Plan, Situation};
pub use named::{MethodInfo, MethodName, all_settings};
pub use predict::{
    LONGEST_WINDOW, Prediction, PredictionMemory, PredictionName, SensorInterval, SensorNoise,
};
pub use setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
pub use state::State;

use crate::Scalar;
use crate::actuation::Hold;
use crate::actuator::Actuator;
use crate::contact::{Contact, LoopParams};
use crate::motion::{ObjectMotion, ObjectState, Start};
use crate::parameter::{Allowed, Parameter, ParameterError};
use crate::sample::Limited;
use state::DeviceTrack;

/// A contact rendered by one method at one nominal period. Immutable: one renderer serves any number of [`State`]s, and
/// a tick cannot change a parameter.
#[derive(Clone, Copy, Debug)]
pub struct Renderer<S, M> {
    contact: Contact<S>,
    loop_params: LoopParams<S>,
    method: M,
    motion: ObjectMotion<S>,
    actuator: Actuator<S>,
    sign: S,
    per_period: S,
    largest_gap: S,
    speed_limit: S,
    force_limit: S,
    slew_limit: S,
    holds_lines: bool,
    /// Penetration above which the contact yields with the largest force; infinite if it does not yield `[m]`.
    yields_at: S,
}

/// A renderer whose method is selected by a value, for example from a file.
pub type AnyRenderer<S> = Renderer<S, AnyMethod<S>>;

impl<S: Scalar, M: Method<S>> Renderer<S, M> {
    /// Checks every parameter and computes the quantities that depend on parameters only.
    ///
    /// # Errors
    /// The first parameter outside its range, with its name, value and allowed range.
    pub fn new<P: MethodParams<S, Method = M>>(
        contact: Contact<S>,
        loop_params: LoopParams<S>,
        method: P,
    ) -> Result<Self, ParameterError> {
        contact.check()?;
        loop_params.check()?;
        let method = method.check(&contact, &loop_params)?;
        let holds_lines = loop_params.actuation.hold == Hold::Line;
        Parameter::HoldOrder.unless(
            method.plans_lines() || !holds_lines,
            S::ONE,
            Allowed::Words("0, a constant: of the methods, only coupled plans a line"),
        )?;
        let unlimited = S::INFINITY;
        let gain = loop_params.actuation.limit_gain();
        // The limits apply to the command and to the force that the modelled gain makes of it.
        let force_limit = loop_params.force_limit.unwrap_or(unlimited) / gain;
        let motion = ObjectMotion::new(&contact, method.contact_damping(), loop_params.period);
        // A wall does not move: its potential is that of the force that can be held.
        let yields_at = if motion.is_wall() || method.yields_to_limit() {
            loop_params.actuation.gain * force_limit / contact.stiffness
        } else {
            unlimited
        };
        Ok(Self {
            contact,
            loop_params,
            method,
            motion,
            actuator: Actuator::new(&loop_params.actuation, loop_params.period),
            sign: contact.side.sign(),
            per_period: S::ONE / loop_params.period,
            largest_gap: loop_params.bridged_gap(),
            speed_limit: loop_params.speed_limit.unwrap_or(unlimited),
            force_limit,
            slew_limit: loop_params.slew_limit.unwrap_or(unlimited) / gain,
            holds_lines,
            yields_at,
        })
    }

    /// Returns the kinetic energy of the object plus the elastic energy of the contact, `K p^2/2` up to the penetration
    /// at which it yields to the force limit `[J]`.
    #[inline]
    fn stored_energy(&self, penetration: S, object_velocity: S) -> S {
        let stored = self.motion.stored_energy(penetration, object_velocity);
        let beyond = penetration - self.yields_at;
        if beyond > S::ZERO {
            stored - S::HALF * self.contact.stiffness * beyond * beyond
        } else {
            stored
        }
    }

    /// Returns the rendered contact.
    pub fn contact(&self) -> &Contact<S> {
        &self.contact
    }

    /// Returns the loop parameters.
    pub fn loop_params(&self) -> &LoopParams<S> {
        &self.loop_params
    }

    /// Returns the method with its checked parameters.
    pub fn method(&self) -> &M {
        &self.method
    }

    /// Creates a state: the object is at `object`, without samples and with an empty energy ledger. The first sample
    /// finds the device at rest; the velocity of a wall is set to 0. Replacing a state by a new one is a reset;
    /// [`teleport`](Self::teleport) moves the object and keeps the ledger.
    ///
    /// # Errors
    /// A position or velocity is not finite.
    pub fn start(&self, object: ObjectState<S>) -> Result<State<S, M::Memory>, ParameterError> {
        Ok(State::new(self.canonical(object)?))
    }

    /// Moves the object to `object` at the next sample. The change of energy is recorded as outside work; methods with
    /// a memory of past forces restart.
    ///
    /// # Errors
    /// A position or velocity is not finite; the state is then unchanged.
    pub fn teleport(
        &self,
        state: &mut State<S, M::Memory>,
        object: ObjectState<S>,
    ) -> Result<(), ParameterError> {
        state.teleport = Some(self.canonical(object)?);
        Ok(())
    }

    /// Returns the estimated actuation delay minus its model value `[s]`. Only coupled rendering with a delay standard
    /// deviation estimates it; otherwise the result is 0.
    pub fn learned_lateness(&self, state: &State<S, M::Memory>) -> S {
        self.method.lateness(&state.memory)
    }

    /// Replaces the last output by the force on the object that was actually sent `[N]`, a constant, for example after
    /// saturation. Its delay and lag are those of the output. Non-finite values are ignored.
    pub fn report_sent(&self, state: &mut State<S, M::Memory>, force_on_object: S) {
        self.report_sent_line(state, force_on_object, S::ZERO);
    }

    /// Replaces the last output by the line of the force on the object that was actually sent: its mean `[N]` and its
    /// slope `[N/s]`. Non-finite values are ignored.
    pub fn report_sent_line(&self, state: &mut State<S, M::Memory>, mean: S, slope: S) {
        if mean.is_finite() && slope.is_finite() {
            state.under_way.correct(self.sign * mean, self.sign * slope);
        }
    }

    /// Sets the measured mean force on the object since the last sample `[N]`, independent of the actuation model. The
    /// ledger, and the methods that observe energy, then use this force for the interval in progress. The call has no
    /// effect if the force is not finite or the state waits.
    pub fn report_held(&self, state: &mut State<S, M::Memory>, force_on_object: S) {
        if let DeviceTrack::Tracked(interval) = &mut state.device
            && force_on_object.is_finite()
        {
            interval.reported = Some(self.sign * force_on_object);
        }
    }

    /// Continues a state of another renderer with other parameters. The change of the stored energy by the new
    /// stiffness and mass at the last sample is recorded as outside work. The interval in progress ends under the new
    /// parameters.
    pub fn adopt(&self, state: &mut State<S, M::Memory>) {
        // The slew limit continues from a force within the new limits.
        (state.commanded, _) = self.bounded(state.commanded, Limited::default());
        if self.motion.is_wall() {
            state.object.velocity = S::ZERO;
            if let Some(object) = &mut state.teleport {
                object.velocity = S::ZERO;
            }
        }
        if let DeviceTrack::Tracked(interval) = &mut state.device {
            let start = Start {
                object_velocity: state.object.velocity,
                ..interval.start
            };
            let stored = self.stored_energy(start.penetration, start.object_velocity);
            let moved = self
                .motion
                .advance(interval.rule, &start, self.motion.period());
            let finite = stored.is_finite() && moved.by.is_finite() && moved.velocity.is_finite();
            if finite && state.ledger.change_from_outside(stored) {
                interval.start = start;
                interval.planned = moved;
            } else {
                state.lose_track(&self.motion, None);
            }
        }
    }

    /// Sets an object at rest at `position` `[m]`, as if it had been there since the last sample. For a renderer of a
    /// wall that is about to [`adopt`](Self::adopt) the state.
    pub(crate) fn stand(&self, state: &mut State<S, M::Memory>, position: S) {
        state.object = ObjectState::at_rest(self.sign * position);
        if let DeviceTrack::Tracked(interval) = &mut state.device {
            interval.start.penetration = interval.device - state.object.position;
        }
    }

    fn canonical(&self, object: ObjectState<S>) -> Result<ObjectState<S>, ParameterError> {
        let position = Parameter::ObjectPosition.finite(object.position)?;
        let velocity = Parameter::ObjectVelocity.finite(object.velocity)?;
        Ok(ObjectState {
            position: self.sign * position,
            velocity: if self.motion.is_wall() {
                S::ZERO
            } else {
                self.sign * velocity
            },
        })
    }
}

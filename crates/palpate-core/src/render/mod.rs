//! Renderer: one tick from sample to force, common to all methods.
//!
//! Data flows one way through a tick. The sample closes the ledger entry of the interval that it ends, the method plans
//! the next interval, the limits act on the planned force, and the state stores the held force. A method is a file of
//! this folder; it receives a [`Situation`] and returns a [`Plan`].

mod any;
mod basic;
mod coupled;
mod hfcr;
mod list;
mod method;
mod named;
mod popc;
mod popc_ref;
mod predict;
mod seh;
mod setting;
mod state;
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
use crate::actuator::{Actuator, Ahead, Command, Held, Piece};
use crate::contact::{Contact, LoopParams};
use crate::energy::Closing;
use crate::guard::Guard;
use crate::motion::{ObjectMotion, ObjectState, Rule, Start};
use crate::parameter::{Parameter, ParameterError};
use crate::sample::{Fault, Limited, Output, Phase, Sample};
use state::{DeviceTrack, Interval, Traces};

/// Relative tolerance within which a measured period counts as nominal: differences of decimal time stamps are never
/// exactly T.
const NOMINAL_WITHIN: f64 = 1e-6;

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
    /// Penetration above which the contact yields with the largest force; infinite if it does not yield `[m]`.
    yields_at: S,
}

/// Force on the device over an interval that has ended.
struct Passed<S> {
    /// Mean force by the actuation model, as recorded in the ledger `[N]`.
    recorded: S,
    /// Force by the estimated actuation.
    passed: Piece<S>,
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

    /// Replaces the last output by the force on the object that was actually sent `[N]`, for example after saturation.
    /// Its delay and lag are those of the output. Non-finite values are ignored.
    pub fn report_sent(&self, state: &mut State<S, M::Memory>, force_on_object: S) {
        if force_on_object.is_finite() {
            state.under_way.correct(self.sign * force_on_object);
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

    /// Computes one tick: takes a sample and returns the force to hold until the next one. It never panics, allocates,
    /// blocks or loops without bound, and its output is finite for any input.
    #[inline]
    pub fn step(&self, state: &mut State<S, M::Memory>, sample: Sample<S>) -> Output<S> {
        self.step_adding(state, sample, |_| None)
    }

    /// Computes one tick with an additional force on the object `[N]`. `adds` receives the method's force after the
    /// pull and force limits. All limits, and the guard, apply to the sum.
    #[inline(always)]
    pub(crate) fn step_adding(
        &self,
        state: &mut State<S, M::Memory>,
        sample: Sample<S>,
        adds: impl FnOnce(S) -> Option<S>,
    ) -> Output<S> {
        let elapsed = self.elapsed(&sample);
        let h = elapsed.map_or(self.motion.period(), |(elapsed, _)| elapsed);
        // The ledger uses the actuation model, the method its estimate.
        let passed = match self.learned_actuator(&state.memory) {
            None => {
                let passed = state.under_way.pass(&self.actuator, h);
                Passed {
                    recorded: passed.held.mean,
                    passed,
                }
            }
            Some(learned) => {
                let (recorded, passed) = state.under_way.pass_learned(&self.actuator, &learned, h);
                Passed { recorded, passed }
            }
        };
        match self.try_step(state, &sample, elapsed, &passed, adds) {
            Ok(output) => output,
            Err(fault) => self.wait(state, &sample, fault),
        }
    }

    // Always inline: as a separate function the large result goes through memory, which made coupled rendering 10 ns
    // slower in a library with worlds.
    #[inline(always)]
    fn try_step(
        &self,
        state: &mut State<S, M::Memory>,
        sample: &Sample<S>,
        elapsed: Result<(S, bool), Fault>,
        Passed { recorded, passed }: &Passed<S>,
        adds: impl FnOnce(S) -> Option<S>,
    ) -> Result<Output<S>, Fault> {
        let device = self.sign * sample.device_position;
        let virtual_force = self.sign * sample.virtual_force;
        if !device.is_finite() {
            return Err(Fault::PositionNotFinite);
        }
        if !virtual_force.is_finite() {
            return Err(Fault::VirtualForceNotFinite);
        }
        let (elapsed, nominal) = elapsed?;

        // State of the object at the end of the interval.
        let mut object = state.object;
        let mut device_velocity = S::ZERO;
        let mut previous_penetration = None;
        match &state.device {
            DeviceTrack::Unknown => {}
            DeviceTrack::Lost(traces) => {
                if !traces.lead_to(device, elapsed, self.speed_limit) {
                    return Err(Fault::JumpTooFast);
                }
            }
            DeviceTrack::Tracked(interval) => {
                let device_moved = device - interval.device;
                if device_moved.abs() > self.speed_limit * elapsed {
                    return Err(Fault::JumpTooFast);
                }
                let held = match interval.reported {
                    // The time course is that of the actuator. The mean and the begin of the commands are measured.
                    Some(mean) => Held {
                        mean,
                        step: S::ZERO,
                        step_moment: S::ZERO,
                        ..passed.held
                    },
                    None => passed.held,
                };
                let moved = self.method.conclude(
                    &self.motion,
                    &Ended {
                        start: interval.start,
                        rule: interval.rule,
                        planned: interval.planned,
                        device_moved,
                        elapsed,
                        nominal,
                        intended_force: passed.intended,
                        held,
                    },
                    &mut state.memory,
                );
                device_velocity = if nominal {
                    device_moved * self.per_period
                } else {
                    device_moved / elapsed
                };
                object = ObjectState {
                    position: object.position + moved.by,
                    velocity: moved.velocity,
                };
                // A wall does not move, although a method may shift it.
                let virtual_force = if self.motion.is_wall() {
                    S::ZERO
                } else {
                    interval.start.virtual_force
                };
                let held_force = interval.reported.unwrap_or(*recorded);
                let closed = state.ledger.close(&Closing {
                    stored: self.stored_energy(device - object.position, object.velocity),
                    port_work: held_force * device_moved,
                    virtual_force_work: virtual_force * moved.by,
                    original_work: interval.original_force * device_moved,
                });
                if !closed {
                    return Err(Fault::Overflow);
                }
                previous_penetration = Some(interval.start.penetration);
            }
        }

        // The interval is closed. If a later check fails, the object keeps its state at the end of the interval, and
        // the next interval is lost.
        state.object = object;
        state.device = DeviceTrack::Lost(Traces {
            seen: Some(device),
            trusted: Some(device),
            since: S::ZERO,
        });

        // Restart, or change from outside.
        let teleported = state.teleport.is_some();
        object = state.teleport.take().unwrap_or(object);
        state.object = object;
        let penetration = device - object.position;
        let previous_penetration = match previous_penetration {
            Some(previous) if !teleported => previous,
            _ => {
                let stored = self.stored_energy(penetration, object.velocity);
                if !state.account_for(stored) {
                    return Err(Fault::Overflow);
                }
                let device_known = previous_penetration.is_some();
                self.method
                    .begin_anew(&mut state.memory, device_known, !teleported);
                penetration
            }
        };

        let learned = self.learned_actuator(&state.memory);
        let situation = Situation {
            start: Start {
                penetration,
                object_velocity: object.velocity,
                device_velocity,
                virtual_force,
            },
            previous_penetration,
            elapsed,
            port_work: state.ledger.port_work,
            held_leak: state.ledger.held_leak.accumulated,
            ahead: Ahead::new(learned.as_ref().unwrap_or(&self.actuator), &state.under_way),
        };
        let plan = self
            .method
            .plan(&self.motion, &situation, &mut state.memory);
        let finite = plan.force.is_finite()
            && plan.moved.by.is_finite()
            && plan.moved.velocity.is_finite()
            && penetration.is_finite();
        if !finite {
            return Err(Fault::Overflow);
        }
        let gain = self.actuator.gain();
        let intended = plan.force / gain;
        let planned = Limited {
            force: self.method.is_limited(&state.memory),
            ..Limited::default()
        };
        let (mut wanted, mut limited) = self.bounded(intended, planned);
        if let Some(added) = adds(self.sign * wanted)
            && let sum = wanted + self.sign * added
            && sum.is_finite()
        {
            (wanted, limited) = self.bounded(sum, limited);
        }
        let mut commanded = self.slewed(wanted, state.commanded, elapsed, &mut limited);
        // With the actuation of the loop, as in the ledger.
        let claims = || Ahead::new(&self.actuator, &state.under_way).impulse_to_come();
        let balance = state.ledger.balance();
        if let Some((bound, kept)) = self.guard_bound(balance, claims)
            && let bound = bound / gain
            && commanded.abs() > bound
        {
            limited.guard = true;
            if kept {
                commanded = commanded.within(bound);
            }
        }

        let original_force = situation
            .spring_force(&self.motion)
            .min(self.contact.stiffness * self.yields_at);
        let start = situation.start;
        state.commanded = commanded;
        state.under_way.send(Command {
            intended,
            sent: commanded,
        });
        state.device = DeviceTrack::Tracked(Interval {
            start,
            device,
            rule: plan.rule,
            planned: plan.moved,
            original_force,
            reported: None,
        });
        let (phase, transition_after) = match plan.rule {
            Rule::Free => (Phase::Free, S::ZERO),
            Rule::Contact => (Phase::Contact, S::ZERO),
            Rule::Enters { after, .. } => (Phase::Enters, after),
            Rule::Leaves(after) => (Phase::Leaves, after),
        };
        // Adding 0 normalises a mirrored -0.
        let force = self.sign * commanded + S::ZERO;
        Ok(Output {
            force_on_device: S::ZERO - force,
            force_on_object: force,
            object_position: self.sign * object.position,
            object_velocity: self.sign * object.velocity,
            penetration,
            phase,
            transition_after,
            proxy_shift: self.sign * self.method.proxy_shift(&state.memory) + S::ZERO,
            limited,
            fault: None,
        })
    }

    /// Returns the actuator with the estimated delay, if it differs from the model.
    #[inline]
    fn learned_actuator(&self, memory: &M::Memory) -> Option<Actuator<S>> {
        let later = self.method.lateness(memory);
        (later != S::ZERO).then(|| self.actuator.later(later))
    }

    /// Returns the time since the previous sample `[s]`, and whether it counts as the nominal period.
    #[inline]
    fn elapsed(&self, sample: &Sample<S>) -> Result<(S, bool), Fault> {
        let period = self.motion.period();
        let Some(elapsed) = sample.elapsed else {
            return Ok((period, true));
        };
        if !(elapsed.is_finite() && elapsed > S::ZERO) {
            return Err(Fault::ElapsedNotPositive);
        }
        if elapsed > self.largest_gap {
            return Err(Fault::GapTooLong);
        }
        if (elapsed * self.per_period - S::ONE).abs() < S::from_f64(NOMINAL_WITHIN) {
            Ok((period, true))
        } else {
            Ok((elapsed, false))
        }
    }

    /// Applies the pull limit of the contact and the force limit to a force.
    #[inline(always)]
    fn bounded(&self, planned: S, mut limited: Limited) -> (S, Limited) {
        let mut force = planned;
        if self.contact.unilateral && force < S::ZERO {
            force = S::ZERO;
            limited.pull = true;
        }
        if force.abs() > self.force_limit {
            force = force.within(self.force_limit);
            limited.force = true;
        }
        (force, limited)
    }

    /// Applies the slew limit to a force within the other limits, `elapsed` `[s]` after the command `previous`.
    #[inline(always)]
    fn slewed(&self, force: S, previous: S, elapsed: S, limited: &mut Limited) -> S {
        let largest_change = self.slew_limit * elapsed;
        if (force - previous).abs() > largest_change {
            limited.slew = true;
            previous + (force - previous).within(largest_change)
        } else {
            force
        }
    }

    /// Returns the largest force that the guard permits, and whether the guard keeps the bound.
    #[inline(always)]
    fn guard_bound(&self, balance: S, claims: impl FnOnce() -> S) -> Option<(S, bool)> {
        if self.loop_params.guard == Guard::Off {
            return None;
        }
        let period = self.motion.period();
        self.loop_params.guard.bound(balance, claims(), period)
    }

    /// Handles an unusable sample: zero force, and the object waits at its position.
    #[cold]
    fn wait(&self, state: &mut State<S, M::Memory>, sample: &Sample<S>, fault: Fault) -> Output<S> {
        let device = self.sign * sample.device_position;
        state.under_way.send(Command::default());
        state.lose_track(&self.motion, device.is_finite().then_some(device));
        Output {
            force_on_device: S::ZERO,
            force_on_object: S::ZERO,
            object_position: self.sign * state.object.position,
            object_velocity: self.sign * state.object.velocity,
            penetration: S::ZERO,
            phase: Phase::Waiting,
            transition_after: S::ZERO,
            proxy_shift: S::ZERO,
            limited: Limited::default(),
            fault: Some(fault),
        }
    }
}

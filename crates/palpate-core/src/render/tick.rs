//! One tick: the interval that the sample ends is concluded, the next one begins, and its force is planned and limited.

use crate::Scalar;
use crate::actuator::{Actuator, Ahead, Command, Held, Piece, Uneven};
use crate::energy::Closing;
use crate::guard::Guard;
use crate::motion::{ObjectState, Rule, Start};
use crate::sample::{Fault, Limited, Output, Phase, Sample};

use super::state::{DeviceTrack, Interval, State, Traces};
use super::{Ended, Method, Renderer, Situation};

/// Relative tolerance within which a measured period counts as nominal: differences of decimal time stamps are never
/// exactly T.
const NOMINAL_WITHIN: f64 = 1e-6;

/// Force on the device over an interval that has ended.
struct Passed<S> {
    /// Force by the actuation model, as recorded in the ledger.
    recorded: Held<S>,
    /// Force by the estimated actuation.
    passed: Piece<S>,
    /// Bounds on the recorded force; 0 without a guard.
    uneven: Uneven<S>,
}

/// A concluded interval.
struct Concluded<S> {
    /// Mean velocity of the device over it `[m/s]`.
    device_velocity: S,
    /// Penetration at its start `[m]`; `None` if the device was not tracked.
    previous_penetration: Option<S>,
}

impl<S: Scalar, M: Method<S>> Renderer<S, M> {
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
        let uneven = match self.loop_params.guard {
            Guard::Off => Uneven::default(),
            Guard::Report(_) | Guard::Limit(_) => state.under_way.uneven(&self.actuator, h),
        };
        // The ledger uses the actuation model, the method its estimate.
        let passed = match self.learned_actuator(&state.memory) {
            None => {
                let passed = state.under_way.pass(&self.actuator, h);
                Passed {
                    recorded: passed.held,
                    passed,
                    uneven,
                }
            }
            Some(learned) => {
                let (recorded, passed) = state.under_way.pass_learned(&self.actuator, &learned, h);
                Passed {
                    recorded,
                    passed,
                    uneven,
                }
            }
        };
        match self.try_step(state, &sample, elapsed, &passed, adds) {
            Ok(output) => output,
            Err(fault) => {
                self.lose_interval(state, &passed.uneven);
                self.wait(state, &sample, fault)
            }
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
        passed: &Passed<S>,
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
        let elapsed = elapsed?;
        let concluded = self.conclude(state, device, elapsed, passed)?;
        let (start, previous_penetration) = self.begin(state, device, virtual_force, concluded)?;

        let learned = self.learned_actuator(&state.memory);
        let situation = Situation {
            start,
            previous_penetration,
            elapsed: elapsed.0,
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
            && start.penetration.is_finite();
        if !finite {
            return Err(Fault::Overflow);
        }
        let original_force = situation
            .spring_force(&self.motion)
            .min(self.contact.stiffness * self.yields_at);
        let limited = self.command(state, plan.force, elapsed.0, adds);
        state.device = DeviceTrack::Tracked(Interval {
            start,
            device,
            rule: plan.rule,
            planned: plan.moved,
            original_force,
            reported: None,
        });
        Ok(self.output(state, plan.rule, start.penetration, limited))
    }

    /// Concludes the interval that the sample at `device` ends, and closes its ledger entry. The object has then its
    /// state at the end of the interval, and keeps it if a later check fails.
    #[inline(always)]
    fn conclude(
        &self,
        state: &mut State<S, M::Memory>,
        device: S,
        (elapsed, nominal): (S, bool),
        Passed {
            recorded,
            passed,
            uneven,
        }: &Passed<S>,
    ) -> Result<Concluded<S>, Fault> {
        let mut object = state.object;
        let mut device_velocity = S::ZERO;
        let mut previous_penetration = None;
        match &state.device {
            DeviceTrack::Unknown => {}
            DeviceTrack::Lost(traces) => {
                if !traces.lead_to(device, elapsed, self.speed_limit) {
                    return Err(Fault::JumpTooFast);
                }
                self.lose_interval(state, uneven);
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
                let recorded = Held {
                    mean: interval.reported.unwrap_or(recorded.mean),
                    ..*recorded
                };
                let mut port_work = recorded.mean * device_moved;
                if self.holds_lines {
                    // The device's velocity follows a constant acceleration and the force. The integral of f times the
                    // latter part vanishes for f minus its mean.
                    port_work -= recorded.lead * self.method.device_acceleration(&state.memory);
                }
                let closed = state.ledger.close(&Closing {
                    stored: self.stored_energy(device - object.position, object.velocity),
                    port_work,
                    virtual_force_work: virtual_force * moved.by,
                    original_work: interval.original_force * device_moved,
                    part_sent: self.part_sent(passed),
                });
                if !closed {
                    return Err(Fault::Overflow);
                }
                if let Some(params) = self.loop_params.guard.params() {
                    state
                        .guard
                        .pass(params, &recorded, uneven, device_moved, elapsed);
                }
                previous_penetration = Some(interval.start.penetration);
            }
        }
        state.object = object;
        // Until the next interval is planned, it counts as lost.
        state.device = DeviceTrack::Lost(Traces {
            seen: Some(device),
            trusted: Some(device),
            since: S::ZERO,
        });
        Ok(Concluded {
            device_velocity,
            previous_penetration,
        })
    }

    /// Returns the fraction of a planned push that limits left over an interval, 0 to 1. A contact that yields to the
    /// force limit stores no energy beyond it, so that only a lower limit counts.
    #[inline(always)]
    fn part_sent(&self, passed: &Piece<S>) -> S {
        let yields_at_force = self.contact.stiffness * self.yields_at;
        let (stored_push, sent) = (passed.intended.min(yields_at_force), passed.held.mean);
        if stored_push <= sent || stored_push <= S::ZERO {
            S::ONE
        } else {
            (sent / stored_push).max(S::ZERO)
        }
    }

    /// Applies a restart or a change from outside to the object. Returns the start of the next interval and the
    /// penetration before it `[m]`.
    #[inline(always)]
    fn begin(
        &self,
        state: &mut State<S, M::Memory>,
        device: S,
        virtual_force: S,
        concluded: Concluded<S>,
    ) -> Result<(Start<S>, S), Fault> {
        let teleported = state.teleport.is_some();
        let object = state.teleport.take().unwrap_or(state.object);
        state.object = object;
        let penetration = device - object.position;
        let previous_penetration = match concluded.previous_penetration {
            Some(previous) if !teleported => previous,
            previous => {
                let stored = self.stored_energy(penetration, object.velocity);
                if !state.account_for(stored) {
                    return Err(Fault::Overflow);
                }
                self.method
                    .begin_anew(&mut state.memory, previous.is_some(), !teleported);
                penetration
            }
        };
        let start = Start {
            penetration,
            object_velocity: object.velocity,
            device_velocity: concluded.device_velocity,
            virtual_force,
        };
        Ok((start, previous_penetration))
    }

    /// Applies all limits and the guard to the `planned` force, and sends the command. Returns the limits that applied.
    #[inline(always)]
    fn command(
        &self,
        state: &mut State<S, M::Memory>,
        planned: S,
        elapsed: S,
        adds: impl FnOnce(S) -> Option<S>,
    ) -> Limited {
        let gain = self.actuator.gain();
        let intended = planned / gain;
        let by_method = Limited {
            force: self.method.is_limited(&state.memory),
            ..Limited::default()
        };
        let (mut wanted, mut limited) = self.bounded(intended, by_method);
        if let Some(added) = adds(self.sign * wanted)
            && let sum = wanted + self.sign * added
            && sum.is_finite()
        {
            (wanted, limited) = self.bounded(sum, limited);
        }
        let mut commanded = self.slewed(wanted, state.commanded, elapsed, &mut limited);
        limited.beyond_guard = state.guard.is_exceeded();
        if let Some([push, pull]) = self.guard_bounds(state)
            && !(-pull <= commanded && commanded <= push)
        {
            limited.guard = true;
            if self.loop_params.guard.limits() {
                commanded = commanded.min(push).max(-pull);
            }
        }
        state.commanded = commanded;
        if self.holds_lines {
            let slope = self.method.slope(&state.memory) / gain;
            state.commanded_slope = self.bounded_slope(slope, commanded, &mut limited);
        }
        state.under_way.send(Command {
            intended,
            sent: commanded,
            slope: state.commanded_slope,
        });
        limited
    }

    /// Returns the slope `[N/s]` with which the ends of a line of mean `commanded` `[N]` stay within the pull and force
    /// limits: 0 if it is not finite.
    #[inline(never)]
    fn bounded_slope(&self, slope: S, commanded: S, limited: &mut Limited) -> S {
        if !slope.is_finite() {
            return S::ZERO;
        }
        let half = S::HALF * self.motion.period();
        let (mut slope, room) = (slope, (self.force_limit - commanded.abs()).max(S::ZERO));
        if self.contact.unilateral && slope.abs() * half > commanded {
            slope = slope.within(commanded.max(S::ZERO) / half);
            limited.pull = true;
        }
        if slope.abs() * half > room {
            slope = slope.within(room / half);
            limited.force = true;
        }
        slope
    }

    /// Returns the output of a tick with the contact `rule` of its interval.
    #[inline(always)]
    fn output(
        &self,
        state: &State<S, M::Memory>,
        rule: Rule<S>,
        penetration: S,
        limited: Limited,
    ) -> Output<S> {
        let (phase, transition_after) = match rule {
            Rule::Free => (Phase::Free, S::ZERO),
            Rule::Contact => (Phase::Contact, S::ZERO),
            Rule::Enters { after, .. } => (Phase::Enters, after),
            Rule::Leaves(after) => (Phase::Leaves, after),
        };
        // Adding 0 normalises a mirrored -0.
        let force = self.sign * state.commanded + S::ZERO;
        Output {
            force_on_device: S::ZERO - force,
            force_on_object: force,
            slope_on_device: S::ZERO - self.sign * state.commanded_slope,
            object_position: self.sign * state.object.position,
            object_velocity: self.sign * state.object.velocity,
            penetration,
            phase,
            transition_after,
            proxy_shift: self.sign * self.method.proxy_shift(&state.memory) + S::ZERO,
            limited,
            fault: None,
        }
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
    pub(super) fn bounded(&self, planned: S, mut limited: Limited) -> (S, Limited) {
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

    /// Returns the largest push and pull that the guard permits, as commands `[N]`.
    #[inline(always)]
    fn guard_bounds(&self, state: &State<S, M::Memory>) -> Option<[S; 2]> {
        let params = self.loop_params.guard.params()?;
        let period = self.motion.period();
        // With the actuation of the loop, as in the ledger.
        let pending = Ahead::new(&self.actuator, &state.under_way).pending(period);
        let balance = state.ledger.balance();
        let bounds = state.guard.bounds(params, balance, &pending, period);
        Some(bounds.map(|bound| bound / self.actuator.gain()))
    }

    /// Charges the guard for an interval without a position at both ends, in which a force with these bounds acted.
    #[inline]
    fn lose_interval(&self, state: &mut State<S, M::Memory>, uneven: &Uneven<S>) {
        if let Some(params) = self.loop_params.guard.params() {
            state.guard.lose(params, uneven);
        }
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
            slope_on_device: S::ZERO,
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

//! Actuator model of a loop: effect of the pending commands on the device.

mod ahead;
mod schedule;

pub use ahead::{Ahead, Governed, Impulse, Pending};
use schedule::{Begun, Part, Schedule};

use crate::Scalar;
use crate::actuation::{Actuation, LARGEST_DELAY, WHOLE_WITHIN};

/// Force on the object that reached the device over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held<S> {
    /// Mean `[N]`.
    pub mean: S,
    /// Lead of its impulse over that of a constant force: the integral of (h - s) f(s) over the interval of h, minus
    /// that of the mean `[N s^2]`. 0 for a force that was held throughout.
    pub lead: S,
    /// Change of the force by the commands that begin in the interval `[N]`.
    pub step: S,
    /// Sum of these changes, each times the remaining duration of the interval when it begins `[N s]`.
    pub step_moment: S,
    /// Standard deviation of its impulse by the uncertainty of the actuation `[N s]`.
    pub impulse_deviation: S,
}

impl<S: Scalar> Held<S> {
    /// Creates a constant force `[N]` without uncertainty.
    pub fn constant(force: S) -> Self {
        Self {
            mean: force,
            lead: S::ZERO,
            step: S::ZERO,
            step_moment: S::ZERO,
            impulse_deviation: S::ZERO,
        }
    }

    /// Returns the force over one nominal `period` `[s]` by a line of this mean `[N]` and `slope` `[N/s]`.
    pub(crate) fn line(mean: S, slope: S, period: S) -> Self {
        Self {
            lead: -slope * period * period * period * S::from_f64(1.0 / 12.0),
            ..Self::constant(mean)
        }
    }

    /// Adds the changes of a force that changes by `risen` `[N]` at a constant rate from `begins` to `ends`, in an
    /// interval of `h` `[s]`.
    fn rises(&mut self, risen: S, [begins, ends, h]: [S; 3]) {
        self.step += risen;
        self.step_moment += risen * (h - S::HALF * (begins + ends));
    }
}

/// Deviation of a line from the mean of its command.
struct Deviation<S> {
    /// Mean `[N]`.
    mean: S,
    /// As [`Held::lead`] `[N s^2]`.
    lead: S,
    /// Time for which the line rises or falls `[s]`.
    rising: S,
}

/// Bounds on the force on a device over an interval, for the work that its mean does not show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Uneven<S> {
    /// Largest change of its work by a unit acceleration of the device that leaves the device's displacement as it is
    /// `[N s^2]`: the integral of |G|, where G(s) is the impulse of f - mean over the rest of the interval. 0 for a
    /// force that was held throughout.
    pub course: S,
    /// Integral of |f| `[N s]`.
    pub size: S,
}

/// A command that may not have reached the device yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command<S> {
    /// Force planned by the method `[N]`.
    pub intended: S,
    /// Force sent after the limits and the driver `[N]`.
    pub sent: S,
    /// Slope of the line that has this force as its mean over one nominal period `[N/s]`; 0 for a constant.
    pub slope: S,
}

/// A command, and the time from its sample to the next one `[s]`.
#[derive(Clone, Copy, Debug, Default)]
struct Sent<S> {
    command: Command<S>,
    span: S,
}

impl<S: Scalar> Sent<S> {
    /// Returns the change of the sent force from `earlier`, the command before, to this one when it begins `[N]`.
    #[inline]
    fn step_from(&self, earlier: &Self, period: S) -> S {
        let step = self.command.sent - earlier.command.sent;
        let [slope, earlier_slope] = [self, earlier].map(|sent| sent.command.slope);
        if slope == S::ZERO && earlier_slope == S::ZERO {
            return step;
        }
        let half = S::HALF * period;
        step - slope * half - earlier_slope * (earlier.span.min(period) - half)
    }
}

/// Commands that still act or have yet to act, and the state of the lag.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay<S> {
    /// Ring buffer, from the newest command to the oldest.
    commands: [Sent<S>; MAX_COMMANDS],
    newest: u8,
    /// Force on the device at the last sample `[N]`; used with a lag.
    felt: Command<S>,
    /// Its sent part by the loop's own actuation model, if a method estimates another one `[N]`.
    felt_by_model: S,
}

/// Changes of the force over an interval up to this fraction of its mean count as a contact at rest, whose timing is
/// certain.
const AT_REST: f64 = 0.3;
/// Largest timing deviation without effect at rest `[periods]`. A larger one can make a contact at rest oscillate.
const TIMING_AT_REST: f64 = 0.1;

/// Maximum number of commands that act in one interval or have yet to act.
const MAX_COMMANDS: usize = LARGEST_DELAY + 2;

#[expect(clippy::cast_possible_truncation, reason = "9")]
const LAST_COMMAND: u8 = (MAX_COMMANDS - 1) as u8;

/// A time interval, and the force on the device in it.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S> {
    /// Duration `[s]`.
    pub duration: S,
    /// Mean of the planned force, through the actuator `[N]`.
    pub intended: S,
    /// Sent force, through the actuator.
    pub held: Held<S>,
}

/// The checked actuation of a loop.
#[derive(Clone, Copy, Debug)]
pub struct Actuator<S> {
    /// Time from a sample to the beginning of its command `[s]`.
    delay: S,
    /// Whether a command is held unchanged from its sample to the next, without uncertainty.
    is_at_once: bool,
    /// Whether the delay is a whole number of periods.
    is_whole: bool,
    period: S,
    lag: S,
    gain: S,
    timing_deviation: S,
    /// Part of the timing deviation without effect at rest `[s]`.
    timing_at_rest: S,
    gain_deviation: S,
}

impl<S: Scalar> Actuator<S> {
    /// Creates the actuator of a valid actuation, in a loop of `period` `[s]`.
    pub fn new(actuation: &Actuation<S>, period: S) -> Self {
        let is_known =
            actuation.timing_deviation() <= S::ZERO && actuation.gain_deviation <= S::ZERO;
        let is_certain = actuation.lag <= S::ZERO && is_known;
        Self {
            delay: actuation.delay,
            is_at_once: actuation.delay <= S::ZERO && is_certain,
            is_whole: is_whole(actuation.delay, period),
            period,
            lag: actuation.lag,
            gain: actuation.gain,
            timing_deviation: actuation.timing_deviation(),
            timing_at_rest: S::from_f64(TIMING_AT_REST) * period,
            gain_deviation: actuation.gain_deviation,
        }
    }

    /// Returns the actuator with `by` `[s]` added to its delay, which stays between 0 and the largest delay.
    #[must_use]
    pub fn later(&self, by: S) -> Self {
        let most = S::from_f64(LARGEST_DELAY as f64) * self.period;
        let delay = (self.delay + by).max(S::ZERO).min(most);
        Self {
            delay,
            is_at_once: false,
            is_whole: is_whole(delay, self.period),
            ..*self
        }
    }

    /// Returns the ratio of delivered to commanded force.
    pub fn gain(&self) -> S {
        self.gain
    }

    /// Returns the response to a command over `h` `[s]`: mean, lead and final state of the lag `[N]`.
    fn respond(&self, felt: S, sent: S, h: S) -> (S, S, S) {
        let aim = self.gain * sent;
        if self.lag <= S::ZERO {
            return (aim, S::ZERO, aim);
        }
        let [decayed, carried] = decay(self.lag, h);
        let off = felt - aim;
        let mean = aim + off * carried / h;
        // The integral of (h - s) e^(-s/lag) is lag (h - carried).
        let lead = off * (self.lag * (h - carried) - S::HALF * h * carried);
        (mean, lead, aim + off * decayed)
    }

    /// Returns the deviation of a line from the mean of its command, from `age` to `age + length` after it began `[s]`.
    #[inline(never)]
    fn line(&self, slope: S, age: S, length: S) -> Deviation<S> {
        let slope = self.gain * slope;
        // After one period the line keeps its last value.
        let rising = (self.period - age).max(S::ZERO).min(length);
        let rest = length - rising;
        let cube = rising * rising * rising * S::from_f64(1.0 / 12.0);
        let half = S::HALF * self.period;
        let middle = slope * (age + S::HALF * rising - half);
        if rest <= S::ZERO || length <= S::ZERO {
            return Deviation {
                mean: middle,
                lead: -slope * cube,
                rising,
            };
        }
        let last = slope * half;
        let mean = (middle * rising + last * rest) / length;
        let moment = middle * rising * (length - S::HALF * rising) - slope * cube
            + S::HALF * last * rest * rest;
        Deviation {
            mean,
            lead: moment - S::HALF * mean * length * length,
            rising,
        }
    }

    /// Returns the part of [`Uneven::course`] in an interval of `h` `[s]` by a response from `begins` to `ends` `[s]`
    /// that starts at a distance of `off` from its final value `[N]`, after a step of `jump` `[N]`.
    fn course(&self, [begins, ends, h]: [S; 3], off: S, jump: S) -> S {
        // A change df at s contributes |df| s (h - s)/2.
        let at_begin = begins * (h - begins);
        if self.lag <= S::ZERO {
            return S::HALF * jump.abs() * at_begin;
        }
        let length = ends - begins;
        let [decayed, carried] = decay(self.lag, length);
        let first = carried - length * decayed;
        let second = S::TWO * self.lag * first - length * length * decayed;
        let weighted = at_begin * (S::ONE - decayed) + (h - begins - begins) * first - second;
        S::HALF * off.abs() * weighted.max(S::ZERO)
    }

    /// Computes the force by the commands of a schedule over an interval of `h` `[s]`.
    fn pass(&self, felt: &mut Command<S>, schedule: &Schedule<S>, h: S) -> Piece<S> {
        let mut sum = Piece {
            duration: h,
            intended: S::ZERO,
            held: Held::default(),
        };
        let (mut moment, mut variation, mut is_as_intended) = (S::ZERO, S::ZERO, true);
        let mut before = *felt;
        for part in schedule.parts(h) {
            let Part {
                begins,
                ends,
                age,
                command,
                step,
            } = part;
            let length = ends - begins;
            if length <= S::ZERO {
                // Commands before the first sample are all 0.
                continue;
            }
            let (mut mean, mut lead, end) = self.respond(before.sent, command.sent, length);
            let as_intended = command.sent == command.intended && before.sent == before.intended;
            let (mut intended, intended_end) = if as_intended {
                (mean, end)
            } else {
                is_as_intended = false;
                let (mean, _, end) = self.respond(before.intended, command.intended, length);
                (mean, end)
            };
            before = Command {
                intended: intended_end,
                sent: end,
                slope: S::ZERO,
            };
            let step = self.gain * step;
            sum.held.step += step;
            sum.held.step_moment += step * (h - begins);
            variation += step.abs();
            if command.slope != S::ZERO {
                let line = self.line(command.slope, age, length);
                mean += line.mean;
                intended += line.mean;
                lead += line.lead;
                let risen = self.gain * command.slope * line.rising;
                sum.held.rises(risen, [begins, begins + line.rising, h]);
                variation += risen.abs();
            }
            if length >= h {
                // The whole interval.
                (sum.intended, sum.held.mean, sum.held.lead) = (intended, mean, lead);
                continue;
            }
            sum.intended += intended * length / h;
            sum.held.mean += mean * length / h;
            moment += mean * length * (h - S::HALF * (begins + ends)) + lead;
            sum.held.lead = moment - S::HALF * sum.held.mean * h * h;
        }
        *felt = before;
        if is_as_intended {
            sum.intended = sum.held.mean;
        }
        // The changes of a force at rest are small against the force. Noise in proportion to them would slow down the
        // observer, and a delayed estimate of the hand drives the oscillation.
        let at_rest = S::from_f64(AT_REST) * sum.held.mean.abs();
        let certain = self.timing_deviation.min(self.timing_at_rest) * at_rest;
        let timing = (self.timing_deviation * variation - certain).max(S::ZERO);
        let gain = self.gain_deviation * (variation - at_rest).max(S::ZERO) * h;
        if timing > S::ZERO || gain > S::ZERO {
            sum.held.impulse_deviation = (timing * timing + gain * gain).sqrt();
        }
        sum
    }

    /// Computes the bounds on the force by the commands of a schedule over an interval of `h` `[s]`, from the force
    /// `felt` at its begin `[N]`.
    fn uneven(&self, mut felt: S, schedule: &Schedule<S>, h: S) -> Uneven<S> {
        let mut sum = Uneven::default();
        for part in schedule.parts(h) {
            let length = part.ends - part.begins;
            if length <= S::ZERO {
                continue;
            }
            let aim = self.gain * part.command.sent;
            let off = felt - aim;
            sum.course += self.course([part.begins, part.ends, h], off, self.gain * part.step);
            if self.lag > S::ZERO {
                let [decayed, carried] = decay(self.lag, length);
                sum.size += felt.abs() * carried + aim.abs() * (length - carried);
                felt = aim + off * decayed;
            } else {
                sum.size += aim.abs() * length;
                felt = aim;
            }
        }
        sum
    }

    /// Returns the impulse that the lag carries into an interval of `h` `[s]`, and the part of a command's impulse that
    /// arrives in it `[s]`.
    fn shares(&self, felt: S, h: S) -> (S, S) {
        if self.lag <= S::ZERO {
            return (S::ZERO, h);
        }
        // The inverse of a slow actuator amplifies every estimation error: limit it to that of a lag of half the
        // interval.
        let [_, carried] = decay(self.lag.min(S::HALF * h), h);
        (felt * carried, h - carried)
    }
}

/// Returns whether a delay is a whole number of periods.
fn is_whole<S: Scalar>(delay: S, period: S) -> bool {
    let within = S::from_f64(WHOLE_WITHIN);
    let periods = delay / period;
    periods - (periods + within).floor() <= within
}

/// Returns the remaining fraction of a lag's deviation after `h` `[s]`, and its integral `[s]`.
fn decay<S: Scalar>(lag: S, h: S) -> [S; 2] {
    let decayed = (-h / lag).exp();
    [decayed, lag * (S::ONE - decayed)]
}

impl<S: Scalar> UnderWay<S> {
    /// Creates the state before the first sample: zero force.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            commands: [Sent::default(); MAX_COMMANDS],
            newest: 0,
            felt: Command::default(),
            felt_by_model: S::ZERO,
        }
    }

    /// Ends an interval of `h` `[s]` between two samples and returns the force on the device in it.
    #[inline]
    pub fn pass(&mut self, actuator: &Actuator<S>, h: S) -> Piece<S> {
        let piece = if actuator.is_at_once {
            self.held_at_once(actuator, h)
        } else {
            let mut felt = self.felt;
            let piece = actuator.pass(&mut felt, &self.schedule(actuator, S::ZERO, h), h);
            self.felt = felt;
            self.felt_by_model = felt.sent;
            piece
        };
        if let Some(newest) = self.commands.get_mut(usize::from(self.newest)) {
            newest.span = h;
        }
        piece
    }

    /// Returns the bounds on the force in an interval of `h` `[s]` that is about to [`pass`](Self::pass).
    #[must_use]
    pub fn uneven(&self, actuator: &Actuator<S>, h: S) -> Uneven<S> {
        if actuator.is_at_once {
            let held = actuator.gain * self.aged(0).command.sent;
            return Uneven {
                course: S::ZERO,
                size: held.abs() * h,
            };
        }
        actuator.uneven(self.felt_by_model, &self.schedule(actuator, S::ZERO, h), h)
    }

    /// Ends an interval for a method with another actuator estimate than the `model` of the loop. Returns the force on
    /// the device by the model, and by the estimate.
    #[inline]
    pub fn pass_learned(
        &mut self,
        model: &Actuator<S>,
        learned: &Actuator<S>,
        h: S,
    ) -> (Held<S>, Piece<S>) {
        let (by_model, felt) = if model.is_at_once {
            (self.held_at_once(model, h), S::ZERO)
        } else {
            let mut felt = Command {
                intended: self.felt_by_model,
                sent: self.felt_by_model,
                slope: S::ZERO,
            };
            let schedule = self.schedule(model, S::ZERO, h);
            let piece = model.pass(&mut felt, &schedule, h);
            (piece, felt.sent)
        };
        let piece = self.pass(learned, h);
        self.felt_by_model = felt;
        (by_model.held, piece)
    }

    /// Returns the newest command, exactly as sent.
    #[inline]
    fn held_at_once(&self, actuator: &Actuator<S>, h: S) -> Piece<S> {
        let [later, earlier] = [0, 1].map(|age| self.aged(age));
        let step = actuator.gain * later.step_from(&earlier, actuator.period);
        let later = later.command;
        let mut piece = Piece {
            duration: h,
            intended: actuator.gain * later.intended,
            held: Held {
                step,
                step_moment: step * h,
                ..Held::constant(actuator.gain * later.sent)
            },
        };
        if later.slope != S::ZERO {
            let line = actuator.line(later.slope, S::ZERO, h);
            piece.intended += line.mean;
            piece.held.mean += line.mean;
            piece.held.lead += line.lead;
            let risen = actuator.gain * later.slope * line.rising;
            piece.held.rises(risen, [S::ZERO, line.rising, h]);
        }
        piece
    }

    /// Returns the commands that act in the `h` `[s]` that begin `since` `[s]` after the newest command's sample.
    fn schedule(&self, actuator: &Actuator<S>, since: S, h: S) -> Schedule<S> {
        let mut schedule = Schedule::empty();
        let within = S::from_f64(WHOLE_WITHIN) * actuator.period;
        let mut age = since;
        for place in 0..MAX_COMMANDS {
            let command = self.aged(place).command;
            let begins = actuator.delay - age;
            let step = || {
                let earlier = self.aged(place + 1);
                self.aged(place).step_from(&earlier, actuator.period)
            };
            if begins <= within {
                let step = if begins >= S::ZERO - within {
                    step()
                } else {
                    S::ZERO
                };
                schedule.add(Begun {
                    begins: begins.min(S::ZERO),
                    command,
                    step,
                });
                break;
            }
            if begins < h - within {
                schedule.add(Begun {
                    begins,
                    command,
                    step: step(),
                });
            }
            age += self.aged(place + 1).span;
        }
        schedule
    }

    /// Sends the command of a sample.
    #[inline]
    pub fn send(&mut self, command: Command<S>) {
        self.newest = match self.newest.checked_sub(1) {
            Some(before) => before,
            None => LAST_COMMAND,
        };
        if let Some(newest) = self.commands.get_mut(usize::from(self.newest)) {
            *newest = Sent {
                command,
                span: S::ZERO,
            };
        }
    }

    /// Replaces the command of the last sample by the force that the driver sent: its mean over one period `[N]`, and
    /// its slope `[N/s]`.
    pub fn correct(&mut self, sent: S, slope: S) {
        if let Some(newest) = self.commands.get_mut(usize::from(self.newest)) {
            newest.command.sent = sent;
            newest.command.slope = slope;
        }
    }

    /// Returns the command that is `age` samples older than the newest.
    #[inline]
    fn aged(&self, age: usize) -> Sent<S> {
        let place = usize::from(self.newest) + age.min(MAX_COMMANDS - 1);
        let place = place.checked_sub(MAX_COMMANDS).unwrap_or(place);
        self.commands.get(place).copied().unwrap_or_default()
    }
}

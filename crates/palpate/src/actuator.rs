//! The actuator of a loop: what the commands on their way do to the device, by what is known of it.

use crate::Scalar;
use crate::actuation::{Actuation, LARGEST_DELAY, WHOLE_WITHIN};

/// Force on the object that reached the device over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held<S> {
    /// Its mean `[N]`.
    pub mean: S,
    /// By how much its impulse came earlier than a constant force's: the integral of (h - s) f(s) over the
    /// interval of h, less that of the mean `[N s^2]`. 0 for a force that was held all along.
    pub lead: S,
    /// By how much the commands that begin in the interval change the force `[N]`,
    pub step: S,
    /// and the sum of these changes, each times what is left of the interval when it begins `[N s]`.
    pub step_moment: S,
    /// Standard deviation of its impulse, as far as the actuation is not known exactly `[N s]`.
    pub impulse_deviation: S,
}

impl<S: Scalar> Held<S> {
    /// A constant force `[N]` that is certain.
    pub fn constant(force: S) -> Self {
        Self {
            mean: force,
            lead: S::ZERO,
            step: S::ZERO,
            step_moment: S::ZERO,
            impulse_deviation: S::ZERO,
        }
    }
}

/// A command that may not have reached the device yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command<S> {
    /// What the method asked for `[N]`.
    pub intended: S,
    /// What was sent: what the limits, and the driver, left of it `[N]`.
    pub sent: S,
}

/// A command and how long its sample came before the next `[s]`.
#[derive(Clone, Copy, Debug, Default)]
struct Sent<S> {
    command: Command<S>,
    span: S,
}

/// The commands that still act or have yet to act, and where the lag is.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay<S> {
    /// A ring: those after the newest are older, up to it.
    commands: [Sent<S>; MOST_COMMANDS],
    newest: u8,
    /// What the device felt at the last sample `[N]`: used where there is a lag.
    felt: Command<S>,
    /// What of it was sent, by the loop's own actuation where a method has learned another `[N]`.
    felt_by_model: S,
}

/// Changes of the force over an interval up to this part of its mean are those of a contact at rest, whose timing is not in
/// doubt.
const AT_REST: f64 = 0.3;
/// Largest timing deviation that does not count at rest `[periods]`. A larger one can make a contact at rest swing.
const TIMING_AT_REST: f64 = 0.1;

/// Most commands that can act in one interval or have yet to.
const MOST_COMMANDS: usize = LARGEST_DELAY + 2;

#[expect(clippy::cast_possible_truncation, reason = "9")]
const LAST_COMMAND: u8 = (MOST_COMMANDS - 1) as u8;

/// A stretch of time, and what reaches the device in it.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S> {
    /// Its duration `[s]`.
    pub duration: S,
    /// Mean of what the method asked for, through the actuator `[N]`.
    pub intended: S,
    /// What was sent, through the actuator.
    pub held: Held<S>,
}

/// The checked actuation of a loop.
#[derive(Clone, Copy, Debug)]
pub struct Actuator<S> {
    /// From a sample to the beginning of its command `[s]`.
    delay: S,
    /// Whether a command is held as it was sent from its sample to the next, and that is certain.
    is_at_once: bool,
    /// Whether the delay is a whole number of periods.
    is_whole: bool,
    period: S,
    lag: S,
    gain: S,
    timing_deviation: S,
    /// Part of it that does not count at rest `[s]`.
    timing_at_rest: S,
    gain_deviation: S,
}

impl<S: Scalar> Actuator<S> {
    /// Of an actuation without faults, in a loop of `period` `[s]`.
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

    /// The same with every command `by` `[s]` later, or earlier, but not before its sample.
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

    /// Delivered over commanded force.
    pub fn gain(&self) -> S {
        self.gain
    }

    /// What a command does over `h` `[s]`, and where it leaves the lag: mean, lead and end `[N]`.
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

    /// What the commands of a schedule do over an interval of `h` `[s]`.
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
                command,
                step,
            } = part;
            let length = ends - begins;
            if length <= S::ZERO {
                // Of commands before the first sample, all of which are 0.
                continue;
            }
            let (mean, lead, end) = self.respond(before.sent, command.sent, length);
            let as_intended = command.sent == command.intended && before.sent == before.intended;
            let (intended, intended_end) = if as_intended {
                (mean, end)
            } else {
                is_as_intended = false;
                let (mean, _, end) = self.respond(before.intended, command.intended, length);
                (mean, end)
            };
            before = Command {
                intended: intended_end,
                sent: end,
            };
            let step = self.gain * step;
            sum.held.step += step;
            sum.held.step_moment += step * (h - begins);
            variation += step.abs();
            if length >= h {
                // All of the interval.
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
        // The changes of a force at rest are small against the force. Noise in proportion to them would slow the observer
        // down, and a hand that is followed late drives the swing.
        let at_rest = S::from_f64(AT_REST) * sum.held.mean.abs();
        let certain = self.timing_deviation.min(self.timing_at_rest) * at_rest;
        let timing = (self.timing_deviation * variation - certain).max(S::ZERO);
        let gain = self.gain_deviation * (variation - at_rest).max(S::ZERO) * h;
        if timing > S::ZERO || gain > S::ZERO {
            sum.held.impulse_deviation = (timing * timing + gain * gain).sqrt();
        }
        sum
    }

    /// Impulse that the lag carries into an interval of `h` `[s]`, and what of a command's impulse
    /// arrives in it `[s]`.
    fn shares(&self, felt: S, h: S) -> (S, S) {
        if self.lag <= S::ZERO {
            return (S::ZERO, h);
        }
        // The inverse of a slow actuator amplifies every error of what is known: no further than that
        // of one with a lag of half the interval.
        let [_, carried] = decay(self.lag.min(S::HALF * h), h);
        (felt * carried, h - carried)
    }
}

/// Whether a delay is a whole number of periods.
fn is_whole<S: Scalar>(delay: S, period: S) -> bool {
    let within = S::from_f64(WHOLE_WITHIN);
    let periods = delay / period;
    periods - (periods + within).floor() <= within
}

/// The commands that act in an interval.
struct Schedule<S> {
    /// When each begins, counted from the interval's beginning `[s]`, and by how much it changes the
    /// command; the last to begin first.
    begun: [(S, Command<S>, S); MOST_COMMANDS],
    count: usize,
}

/// A part of an interval in which one command acts.
struct Part<S> {
    begins: S,
    ends: S,
    command: Command<S>,
    /// By how much the command changes with it, if it begins with it `[N]`.
    step: S,
}

impl<S: Scalar> Schedule<S> {
    fn add(&mut self, begins: S, command: Command<S>, step: S) {
        if let Some(place) = self.begun.get_mut(self.count) {
            *place = (begins, command, step);
            self.count += 1;
        }
    }

    /// In the order of time, to the interval's end at `h` `[s]`.
    fn parts(&self, h: S) -> impl Iterator<Item = Part<S>> {
        let begun = self.begun.get(..self.count).unwrap_or_default();
        let ends = move |place: usize| match place.checked_sub(1).and_then(|next| begun.get(next)) {
            Some((begins, ..)) => *begins,
            None => h,
        };
        begun
            .iter()
            .enumerate()
            .rev()
            .map(move |(place, (begins, command, step))| Part {
                begins: *begins,
                ends: ends(place),
                command: *command,
                step: *step,
            })
    }
}

/// What is left of a lag's deviation after `h` `[s]`, and the integral of it `[s]`.
fn decay<S: Scalar>(lag: S, h: S) -> [S; 2] {
    let decayed = (-h / lag).exp();
    [decayed, lag * (S::ONE - decayed)]
}

impl<S: Scalar> UnderWay<S> {
    /// Before the first sample: no force.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            commands: [Sent::default(); MOST_COMMANDS],
            newest: 0,
            felt: Command::default(),
            felt_by_model: S::ZERO,
        }
    }

    /// An interval of `h` `[s]` between two samples is over: what reached the device in it.
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

    /// The same where a method has learned another actuator than the `model` of the loop: the mean force by the
    /// model `[N]`, and the force that reached the device by the learned model.
    #[inline]
    pub fn pass_learned(
        &mut self,
        model: &Actuator<S>,
        learned: &Actuator<S>,
        h: S,
    ) -> (S, Piece<S>) {
        let (by_model, felt) = if model.is_at_once {
            (self.held_at_once(model, h), S::ZERO)
        } else {
            let mut felt = Command {
                intended: self.felt_by_model,
                sent: self.felt_by_model,
            };
            let schedule = self.schedule(model, S::ZERO, h);
            let piece = model.pass(&mut felt, &schedule, h);
            (piece, felt.sent)
        };
        let piece = self.pass(learned, h);
        self.felt_by_model = felt;
        (by_model.held.mean, piece)
    }

    /// The newest command, exactly as it was sent.
    #[inline]
    fn held_at_once(&self, actuator: &Actuator<S>, h: S) -> Piece<S> {
        let [later, earlier] = [0, 1].map(|age| self.aged(age).command);
        let step = actuator.gain * (later.sent - earlier.sent);
        Piece {
            duration: h,
            intended: actuator.gain * later.intended,
            held: Held {
                step,
                step_moment: step * h,
                ..Held::constant(actuator.gain * later.sent)
            },
        }
    }

    /// What acts in the `h` `[s]` that begin `since` `[s]` after the newest command's sample.
    fn schedule(&self, actuator: &Actuator<S>, since: S, h: S) -> Schedule<S> {
        let mut schedule = Schedule {
            begun: [(S::ZERO, Command::default(), S::ZERO); MOST_COMMANDS],
            count: 0,
        };
        let within = S::from_f64(WHOLE_WITHIN) * actuator.period;
        let mut age = since;
        for place in 0..MOST_COMMANDS {
            let command = self.aged(place).command;
            let begins = actuator.delay - age;
            let step = || command.sent - self.aged(place + 1).command.sent;
            if begins <= within {
                let step = if begins >= S::ZERO - within {
                    step()
                } else {
                    S::ZERO
                };
                schedule.add(S::ZERO, command, step);
                break;
            }
            if begins < h - within {
                schedule.add(begins, command, step());
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

    /// The driver has sent another force than the command of the last sample `[N]`.
    pub fn correct(&mut self, sent: S) {
        if let Some(newest) = self.commands.get_mut(usize::from(self.newest)) {
            newest.command.sent = sent;
        }
    }

    /// The command that is older than the newest by so many samples.
    #[inline]
    fn aged(&self, age: usize) -> Sent<S> {
        let place = usize::from(self.newest) + age.min(MOST_COMMANDS - 1);
        let place = place.checked_sub(MOST_COMMANDS).unwrap_or(place);
        self.commands.get(place).copied().unwrap_or_default()
    }
}

/// The commands on their way at a sample, before its own.
#[derive(Clone, Copy, Debug)]
pub struct Ahead<'a, S> {
    actuator: &'a Actuator<S>,
    under_way: &'a UnderWay<S>,
}

impl<'a, S: Scalar> Ahead<'a, S> {
    /// Of a loop's actuator and what is under way in it.
    pub fn new(actuator: &'a Actuator<S>, under_way: &'a UnderWay<S>) -> Self {
        Self {
            actuator,
            under_way,
        }
    }

    /// Whether a command that is not 0 is still to act before the command of this sample does.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        let delay = self.actuator.delay;
        let parts = (!self.actuator.is_at_once && delay > S::ZERO).then(|| self.schedule(delay));
        parts.is_some_and(|parts| parts.parts(delay).any(|part| part.command.sent != S::ZERO))
    }

    /// Bound on the impulse that the commands before this sample's can still give, whatever follows `[N s]`:
    /// the integral of the force's magnitude. A lag spreads an impulse over time and adds none, so each command
    /// counts with the time that it has left to act, and the force that decays in the lag with its whole rest.
    #[must_use]
    pub fn impulse_to_come(&self) -> S {
        let actuator = self.actuator;
        let mut sum = S::ZERO;
        if !actuator.is_at_once && actuator.delay > S::ZERO {
            for part in self.schedule(actuator.delay).parts(actuator.delay) {
                sum += (part.ends - part.begins).max(S::ZERO) * part.command.sent.abs();
            }
        }
        actuator.gain * sum + actuator.lag * self.under_way.felt_by_model.abs()
    }

    /// What acts before the command of this sample begins, in order, and what then follows it over
    /// `period` `[s]`.
    #[inline]
    pub fn until_own(&self, period: S, mut each: impl FnMut(Piece<S>)) -> Governed<S> {
        let actuator = self.actuator;
        let mut felt = self.under_way.felt;
        if actuator.delay > S::ZERO {
            for part in self.schedule(actuator.delay).parts(actuator.delay) {
                let h = part.ends - part.begins;
                if h <= S::ZERO {
                    continue;
                }
                let mut alone = Schedule {
                    begun: [(S::ZERO, Command::default(), S::ZERO); MOST_COMMANDS],
                    count: 0,
                };
                alone.add(S::ZERO, part.command, part.step);
                each(actuator.pass(&mut felt, &alone, h));
            }
        }
        let (carried, share) = actuator.shares(felt.sent, period);
        Governed { carried, share }
    }

    /// Whether the command of this sample begins with a sample.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.actuator.is_whole
    }

    /// What reaches the device in the next `h` `[s]`, if `own` `[N]` is what the command of this sample
    /// is to deliver.
    pub fn over_next(&self, own: S, h: S) -> Held<S> {
        let actuator = self.actuator;
        let mut schedule = self.schedule(h);
        if actuator.delay < h {
            let own = own / actuator.gain;
            let command = Command {
                intended: own,
                sent: own,
            };
            // It is the last to begin.
            let mut with_own = Schedule {
                begun: [(S::ZERO, Command::default(), S::ZERO); MOST_COMMANDS],
                count: 0,
            };
            with_own.add(actuator.delay, command, S::ZERO);
            for place in 0..schedule.count {
                if let Some((begins, command, step)) = schedule.begun.get(place).copied() {
                    with_own.add(begins, command, step);
                }
            }
            schedule = with_own;
        }
        let mut felt = self.under_way.felt;
        actuator.pass(&mut felt, &schedule, h).held
    }

    fn schedule(&self, h: S) -> Schedule<S> {
        let since = self.under_way.aged(0).span;
        self.under_way.schedule(self.actuator, since, h)
    }
}

/// The interval in which a command acts.
#[derive(Clone, Copy, Debug)]
pub struct Governed<S> {
    /// Impulse that the lag carries into it `[N s]`.
    carried: S,
    /// Part of it that a command's own impulse has `[s]`.
    share: S,
}

impl<S: Scalar> Governed<S> {
    /// The delivered force, constant but for the lag, whose impulse over the interval of `h` `[s]` is
    /// that of `mean` `[N]`.
    pub fn with_mean(&self, mean: S, h: S) -> S {
        if self.share == h {
            return mean;
        }
        (mean * h - self.carried) / self.share
    }
}

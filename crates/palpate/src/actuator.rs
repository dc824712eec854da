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
    /// Change of the delivered command within the interval `[N]`,
    pub step: S,
    /// and the time from it to the interval's end `[s]`.
    pub step_age: S,
    /// Standard deviation of its impulse, as far as the actuation is not known exactly `[N s]`.
    pub doubt: S,
}

impl<S: Scalar> Held<S> {
    /// A constant force `[N]` that is certain.
    pub fn constant(force: S) -> Self {
        Self {
            mean: force,
            lead: S::ZERO,
            step: S::ZERO,
            step_age: S::ZERO,
            doubt: S::ZERO,
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

/// The commands that still act or have yet to act, and where the lag is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnderWay<S> {
    /// The newest first.
    commands: [Command<S>; LARGEST_DELAY + 2],
    /// What the device felt at the last sample `[N]`: used where there is a lag.
    felt: Command<S>,
}

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
pub(crate) struct Actuator<S> {
    /// Whole periods of the delay.
    samples: usize,
    /// The rest of it `[s]`: 0, or less than a period.
    rest: S,
    period: S,
    lag: S,
    gain: S,
    timing_deviation: S,
    gain_deviation: S,
}

impl<S: Scalar> Actuator<S> {
    /// Of an actuation without faults, in a loop of `period` `[s]`.
    pub fn new(actuation: &Actuation<S>, period: S) -> Self {
        let (samples, rest) = parts(actuation.delay, period);
        Self {
            samples,
            rest,
            period,
            lag: actuation.lag,
            gain: actuation.gain,
            timing_deviation: actuation.timing_deviation(),
            gain_deviation: actuation.gain_deviation,
        }
    }

    /// The same with every command `by` `[s]` later, or earlier, but not before its sample.
    pub fn later(&self, by: S) -> Self {
        let delay = S::from_f64(self.samples as f64) * self.period + self.rest;
        let (samples, rest) = parts(delay + by, self.period);
        Self {
            samples,
            rest,
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

    /// What the commands `earlier` and then `later` do over an interval of `h` `[s]`.
    fn pass(
        &self,
        felt: &mut Command<S>,
        earlier: Command<S>,
        later: Command<S>,
        h: S,
    ) -> Piece<S> {
        let first = self.rest.min(h);
        let through = |felt: &mut S, earlier: S, later: S| {
            if first <= S::ZERO {
                let (mean, lead, end) = self.respond(*felt, later, h);
                *felt = end;
                return (mean, lead);
            }
            let (a, lead_a, between) = self.respond(*felt, earlier, first);
            let second = h - first;
            if second <= S::ZERO {
                *felt = between;
                return (a, lead_a);
            }
            let (b, lead_b, end) = self.respond(between, later, second);
            *felt = end;
            let mean = (a * first + b * second) / h;
            // Each part's own, and that of the step between them.
            let step = S::HALF * (a - b) * first * second;
            (mean, lead_a + lead_b + step)
        };
        let (mean, lead) = through(&mut felt.sent, earlier.sent, later.sent);
        let intended = if earlier.intended == earlier.sent
            && later.intended == later.sent
            && felt.intended == felt.sent
        {
            mean
        } else {
            through(&mut felt.intended, earlier.intended, later.intended).0
        };
        let step = self.gain * (later.sent - earlier.sent);
        let timing = self.timing_deviation * step.abs();
        let gain = self.gain_deviation * mean.abs() * h;
        Piece {
            duration: h,
            intended,
            held: Held {
                mean,
                lead,
                step,
                step_age: h - first,
                doubt: if timing > S::ZERO || gain > S::ZERO {
                    (timing * timing + gain * gain).sqrt()
                } else {
                    S::ZERO
                },
            },
        }
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

/// Whole periods of a delay, and the rest of it `[s]`.
fn parts<S: Scalar>(delay: S, period: S) -> (usize, S) {
    let within = S::from_f64(WHOLE_WITHIN);
    let most = S::from_f64(LARGEST_DELAY as f64);
    let periods = (delay / period).max(S::ZERO).min(most);
    let whole = (periods + within).floor();
    let rest = periods - whole;
    let mut samples = 0;
    while samples < LARGEST_DELAY && S::from_f64(samples as f64) < whole {
        samples += 1;
    }
    let rest = if rest > within {
        rest * period
    } else {
        S::ZERO
    };
    (samples, rest)
}

/// What is left of a lag's deviation after `h` `[s]`, and the integral of it `[s]`.
fn decay<S: Scalar>(lag: S, h: S) -> [S; 2] {
    let decayed = (-h / lag).exp();
    [decayed, lag * (S::ONE - decayed)]
}

impl<S: Scalar> UnderWay<S> {
    pub fn nothing() -> Self {
        Self {
            commands: [Command::default(); LARGEST_DELAY + 2],
            felt: Command::default(),
        }
    }

    /// An interval of `h` `[s]` between two samples is over: what reached the device in it.
    #[inline]
    pub fn pass(&mut self, actuator: &Actuator<S>, h: S) -> Piece<S> {
        let [earlier, later] = [actuator.samples + 1, actuator.samples].map(|age| self.aged(age));
        actuator.pass(&mut self.felt, earlier, later, h)
    }

    /// Sends the command of a sample.
    #[inline]
    pub fn send(&mut self, command: Command<S>) {
        self.commands.copy_within(..LARGEST_DELAY + 1, 1);
        self.commands[0] = command;
    }

    /// The driver has sent another force than the command of the last sample `[N]`.
    pub fn correct(&mut self, sent: S) {
        self.commands[0].sent = sent;
    }

    fn aged(&self, age: usize) -> Command<S> {
        self.commands[age.min(LARGEST_DELAY + 1)]
    }
}

/// The commands on their way at a sample, before its own.
#[derive(Clone, Copy, Debug)]
pub struct Ahead<'a, S> {
    actuator: &'a Actuator<S>,
    under_way: &'a UnderWay<S>,
}

impl<'a, S: Scalar> Ahead<'a, S> {
    pub(crate) fn new(actuator: &'a Actuator<S>, under_way: &'a UnderWay<S>) -> Self {
        Self {
            actuator,
            under_way,
        }
    }

    /// Sum of the magnitudes of what is still to act `[N]`.
    pub fn magnitude(&self) -> S {
        let mut sum = S::ZERO;
        for age in (0..self.actuator.samples).rev() {
            sum += self.under_way.aged(age).sent.abs();
        }
        if self.actuator.rest > S::ZERO {
            sum += self.under_way.aged(self.actuator.samples).sent.abs();
        }
        sum
    }

    /// What acts before the command of this sample begins, in order, in periods of `period` `[s]`, and
    /// what then follows it.
    #[inline]
    pub fn until_own(&self, period: S, mut each: impl FnMut(Piece<S>)) -> Governed<S> {
        let actuator = self.actuator;
        // A window begins where a command does, so that each of them acts all along.
        let whole = Actuator {
            rest: S::ZERO,
            ..*actuator
        };
        let mut felt = self.under_way.felt;
        let mut follow = |age: usize, h: S| {
            let now = self.under_way.aged(age);
            let before = self.under_way.aged(age + 1);
            each(whole.pass(&mut felt, before, now, h));
        };
        if actuator.rest > S::ZERO {
            follow(actuator.samples, actuator.rest.min(period));
        }
        for age in (0..actuator.samples).rev() {
            follow(age, period);
        }
        let (carried, share) = actuator.shares(felt.sent, period);
        Governed { carried, share }
    }

    /// Whether every command begins with a sample.
    pub fn is_whole(&self) -> bool {
        self.actuator.rest <= S::ZERO
    }

    /// What reaches the device in the next `h` `[s]`, if `own` `[N]` is what the command of this sample
    /// is to deliver.
    pub fn over_next(&self, own: S, h: S) -> Held<S> {
        let actuator = self.actuator;
        let own = own / actuator.gain;
        let later = match actuator.samples.checked_sub(1) {
            Some(age) => self.under_way.aged(age),
            None => Command {
                intended: own,
                sent: own,
            },
        };
        let earlier = self.under_way.aged(actuator.samples);
        let mut felt = self.under_way.felt;
        actuator.pass(&mut felt, earlier, later, h).held
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

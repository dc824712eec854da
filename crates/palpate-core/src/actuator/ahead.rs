//! Commands before that of a sample: the forces that act before it, and the interval that it governs.

use super::{Actuator, Begun, Command, Held, Piece, Schedule, UnderWay};
use crate::Scalar;

/// Pending commands at a sample, before its own.
#[derive(Clone, Copy, Debug)]
pub struct Ahead<'a, S> {
    actuator: &'a Actuator<S>,
    under_way: &'a UnderWay<S>,
}

impl<'a, S: Scalar> Ahead<'a, S> {
    /// Creates a view of a loop's actuator and its pending commands.
    pub fn new(actuator: &'a Actuator<S>, under_way: &'a UnderWay<S>) -> Self {
        Self {
            actuator,
            under_way,
        }
    }

    /// Returns whether a non-zero command acts before the command of this sample does.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        let delay = self.actuator.delay;
        let parts = (!self.actuator.is_at_once && delay > S::ZERO).then(|| self.schedule(delay));
        parts.is_some_and(|parts| {
            let mut parts = parts.parts(delay);
            parts.any(|part| part.command.sent != S::ZERO || part.command.slope != S::ZERO)
        })
    }

    /// Returns a bound on the impulse that the commands before this sample's can still give `[N s]`: the integral of
    /// the force's magnitude. A lag spreads an impulse over time and adds none, so each command counts with its
    /// remaining time, and the decaying force in the lag with its whole remainder.
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

    /// Returns the impulses that earlier commands still give, and the place of this sample's command after them.
    #[must_use]
    pub fn pending(&self, period: S) -> Pending<S> {
        let actuator = self.actuator;
        let mut pending = Pending {
            push: Impulse::default(),
            pull: Impulse::default(),
            own_at: actuator.delay + S::HALF * period + actuator.lag,
            overlaps: actuator.lag > S::ZERO,
        };
        // A first-order lag delays the centroid of an impulse by its time constant.
        pending.add(actuator.lag * self.under_way.felt_by_model, actuator.lag);
        if !actuator.is_at_once && actuator.delay > S::ZERO {
            for part in self.schedule(actuator.delay).parts(actuator.delay) {
                let length = (part.ends - part.begins).max(S::ZERO);
                let at = part.begins + S::HALF * length + actuator.lag;
                pending.add(actuator.gain * part.command.sent * length, at);
            }
        }
        pending
    }

    /// Passes the forces before the command of this sample to `each` in temporal order, and returns the interval of
    /// `period` `[s]` that the command governs.
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
                each(actuator.pass(&mut felt, &Schedule::of(&part), h));
            }
        }
        let (carried, share) = actuator.shares(felt.sent, period);
        Governed { carried, share }
    }

    /// Returns the time from the sample to the begin of its command `[s]`.
    #[must_use]
    pub(crate) fn delay(&self) -> S {
        self.actuator.delay
    }

    /// Returns the mean over the `h` `[s]` after its begin by which a line of `slope` `[N/s]`, delivered, differs from
    /// the mean of its command `[N]`: 0 if h is the nominal period.
    #[must_use]
    pub(crate) fn line_off(&self, slope: S, h: S) -> S {
        let actuator = self.actuator;
        actuator.line(slope / actuator.gain, S::ZERO, h).mean
    }

    /// Returns whether the command of this sample begins at a sample.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.actuator.is_whole
    }

    /// Returns the force on the device in the next `h` `[s]`, if the command of this sample delivers `own` `[N]` with
    /// `slope` `[N/s]`.
    pub fn over_next(&self, own: S, slope: S, h: S) -> Held<S> {
        let actuator = self.actuator;
        let mut schedule = self.schedule(h);
        if actuator.delay < h {
            let own = own / actuator.gain;
            // It is the last to begin.
            let mut with_own = Schedule::empty();
            with_own.add(Begun {
                begins: actuator.delay,
                command: Command {
                    intended: own,
                    sent: own,
                    slope: slope / actuator.gain,
                },
                step: S::ZERO,
            });
            for begun in schedule.begun() {
                with_own.add(*begun);
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

/// Interval in which a command acts.
#[derive(Clone, Copy, Debug)]
pub struct Governed<S> {
    /// Impulse that the lag carries into it `[N s]`.
    carried: S,
    /// Part of it for a command's own impulse `[s]`.
    share: S,
}

impl<S: Scalar> Governed<S> {
    /// Returns the delivered force, constant except for the lag, whose impulse over the interval of `h` `[s]` is that
    /// of `mean` `[N]`.
    pub fn with_mean(&self, mean: S, h: S) -> S {
        if self.share == h {
            return mean;
        }
        (mean * h - self.carried) / self.share
    }
}

/// Impulse of forces of one sign `[N s]`, and its first moment about the sample `[N s^2]`; both as magnitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse<S> {
    /// Impulse `[N s]`.
    pub impulse: S,
    /// First moment `[N s^2]`.
    pub moment: S,
}

/// Impulses of the commands before that of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Pending<S> {
    /// Impulse of the forces into the object.
    pub push: Impulse<S>,
    /// Impulse of the forces out of it.
    pub pull: Impulse<S>,
    /// Centroid of the impulse of the sample's own command, after the sample `[s]`.
    pub own_at: S,
    /// Whether earlier forces still act when the own command begins: the actuator has a lag.
    pub overlaps: bool,
}

impl<S: Scalar> Pending<S> {
    fn add(&mut self, impulse: S, at: S) {
        let side = if impulse < S::ZERO {
            &mut self.pull
        } else {
            &mut self.push
        };
        side.impulse += impulse.abs();
        side.moment += impulse.abs() * at;
    }
}

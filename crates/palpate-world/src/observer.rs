//! The observer of a device along one axis: a Kalman filter of the device's motion under the forces it has felt.
//!
//! Over an interval the device is pushed by the force f that is held and by an acceleration a of everything else: the
//! hand, gravity, friction. The hand is a spring and a damper as well, whose force follows the device's motion:
//!
//! ```text
//! x' = u    u' = a + theta f    a' = -lambda u' - kappa u + w    w white: the jerk of the hand
//! ```
//!
//! theta = 1/m, lambda (damping over mass) and kappa (stiffness over mass) are parts of the state, which an interval
//! of contact tells. f counts by its mean over the interval, and by how much of it comes early, so the interval's end follows in closed form; a series in h of six terms is
//! within rounding of it where lambda h and kappa h^2 are small.

use nalgebra::{SMatrix, SVector};
use palpate::{SensorInterval, SensorNoise};

/// What is estimated: x, u, a, theta, lambda, kappa.
const STATES: usize = 6;
type Row = SVector<f64, STATES>;
type Covariance = SMatrix<f64, STATES, STATES>;

/// A device along one axis at a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisMotion {
    /// Position, counted from the measured one `[m]`.
    pub offset: f64,
    /// u `[m/s]`.
    pub velocity: f64,
    /// a: acceleration by everything but the contacts `[m/s^2]`.
    pub external: f64,
    /// theta `[1/kg]`.
    pub mobility: f64,
    /// lambda `[1/s]`.
    pub damping_rate: f64,
    /// kappa `[1/s^2]`.
    pub spring_rate: f64,
}

/// What an interval does to a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// Displacement `[m]`.
    pub travel: f64,
    /// Change of u `[m/s]`.
    pub gained: f64,
    /// Change of a `[m/s^2]`.
    pub external: f64,
}

/// A force on a device along an axis, over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisForce {
    /// Its mean `[N]`.
    pub mean: f64,
    /// By how much its impulse comes earlier than a constant force's `[N s^2]`.
    pub lead: f64,
    /// Standard deviation of its impulse `[N s]`.
    pub impulse_deviation: f64,
    /// Mean of a known acceleration beside it `[m/s^2]`,
    pub bias: f64,
    /// and the way that it adds by not being constant `[m]`.
    pub bias_lead: f64,
    /// Acceleration that it has of each unit of the external one: 1 but for a linkage that is not at its reference.
    pub share: f64,
}

/// Derivatives of a velocity by time, from the velocity itself on.
type Series = [f64; STATES];

/// By the derivatives of a velocity at the start: what an interval of `h` does to place, velocity and acceleration.
fn over(series: &Series, h: f64) -> Change {
    let mut change = Change {
        travel: 0.0,
        gained: 0.0,
        external: 0.0,
    };
    // h^k / k!
    let (mut before, mut power) = (0.0, 1.0);
    for (k, derivative) in (1_u32..).zip(series) {
        let next = power * h / f64::from(k);
        change.travel += derivative * next;
        if k > 1 {
            change.gained += derivative * power;
        }
        if k > 2 {
            change.external += derivative * before;
        }
        (before, power) = (power, next);
    }
    change
}

impl AxisMotion {
    /// From where it was measured with this velocity `[m/s]`, whatever pushes.
    fn led(velocity: f64) -> Self {
        Self {
            offset: 0.0,
            velocity,
            external: 0.0,
            mobility: 0.0,
            damping_rate: 0.0,
            spring_rate: 0.0,
        }
    }

    /// Derivatives of the velocity that begins with these two, with what enters each further one, where so much of each unit of the
    /// external acceleration is felt.
    fn series(&self, first: [f64; 2], share: f64, enters: impl Fn(usize) -> f64) -> Series {
        let mut series = [first[0], first[1], 0.0, 0.0, 0.0, 0.0];
        let (damping_rate, spring_rate) = (self.damping_rate * share, self.spring_rate * share);
        for k in 2..STATES {
            series[k] = enters(k) - damping_rate * series[k - 1] - spring_rate * series[k - 2];
        }
        series
    }

    fn own_series(&self, force: &AxisForce) -> Series {
        let pushed = self.external * force.share + force.bias + self.mobility * force.mean;
        self.series([self.velocity, pushed], force.share, |_| 0.0)
    }

    /// What an interval of `h` `[s]` does to it under a `force` on it.
    pub fn under(&self, force: &AxisForce, h: f64) -> Change {
        let mut change = over(&self.own_series(force), h);
        change.travel += self.mobility * force.lead + force.bias_lead;
        change.external /= force.share;
        change
    }

    /// How place, velocity and acceleration at the end come from the state at the start.
    fn transition(&self, force: &AxisForce, h: f64) -> [Row; 3] {
        let AxisForce {
            mean, lead, share, ..
        } = *force;
        let own = self.own_series(force);
        let none = |_| 0.0;
        let by_velocity = over(&self.series([1.0, 0.0], share, none), h);
        let by_push = over(&self.series([0.0, 1.0], share, none), h);
        let by_damping = over(&self.series([0.0; 2], share, |k| -own[k - 1] * share), h);
        let by_spring = over(&self.series([0.0; 2], share, |k| -own[k - 2] * share), h);
        let row = |own: f64, u: f64, a: f64, theta: f64, l: f64, k: f64| {
            Row::from([own, u, a, theta, l, k])
        };
        let (u, a, l, k) = (by_velocity, by_push, by_damping, by_spring);
        [
            row(
                1.0,
                u.travel,
                a.travel * share,
                mean * a.travel + lead,
                l.travel,
                k.travel,
            ),
            row(
                0.0,
                1.0 + u.gained,
                a.gained * share,
                mean * a.gained,
                l.gained,
                k.gained,
            ),
            row(
                0.0,
                u.external / share,
                1.0 + a.external,
                mean * a.external / share,
                l.external / share,
                k.external / share,
            ),
        ]
    }
}

/// What is known of a device and its hand before the first sample, each as a standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Of the velocity `[m/s]`.
    pub velocity: f64,
    /// Of the acceleration by the hand `[m/s^2]`.
    pub acceleration: f64,
    /// Of 1/m, and of one over the moments of inertia, as a part of what was told.
    pub mobility: f64,
    /// Of the hand's damping over the mass, and over the moments of inertia `[1/s]`.
    pub damping_rate: f64,
    /// Of the hand's stiffness over the mass `[1/s^2]`.
    pub spring_rate: f64,
    /// Of the hand's jerk, from sample to sample; less is reckoned with while the hand rests `[m/s^3]`.
    pub jerk: f64,
    /// Of the angular velocity of a device that turns `[rad/s]`.
    pub angular_velocity: f64,
    /// Of the angular acceleration by the hand `[rad/s^2]`.
    pub angular_acceleration: f64,
    /// Of its change, from sample to sample `[rad/s^3]`.
    pub angular_jerk: f64,
}

impl Default for Prior {
    fn default() -> Self {
        Self {
            velocity: 0.1,
            acceleration: 20.0,
            mobility: 0.5,
            damping_rate: 15.0,
            spring_rate: 1000.0,
            jerk: 100.0,
            angular_velocity: 3.0,
            angular_acceleration: 300.0,
            angular_jerk: 5000.0,
        }
    }
}

impl Prior {
    /// Of a device whose mass is known exactly, on which a force acts that does not depend on its motion.
    #[must_use]
    pub fn of_a_known_mass() -> Self {
        Self {
            mobility: 0.0,
            damping_rate: 0.0,
            spring_rate: 0.0,
            ..Self::default()
        }
    }
}

/// The place of the velocity in the state.
const VELOCITY: usize = 1;
/// Innovations whose square is beyond this multiple of what is expected are no jerk, but a kick. With 25, as along an axis alone, first
/// contacts of masses told wrong count as kicks at 10 ms; with 100, a tool that goes over an edge may.
pub(crate) const SURPRISE: f64 = 900.0;
/// Square of the standard deviations that are left of a surprise when a kick has been reckoned with.
pub(crate) const EXPLAINED: f64 = 4.0;
/// By which part the variance of the jerk falls from a sample to the next while the device is where it is expected.
const CALMING: f64 = 0.2;
/// Quantum of a sensor that is not known to have one, or a finer one `[m]`. Finer positions would tell more than a filter can use that
/// takes its equations for straight: it would trust what the first samples say of the hand's spring and damper far too much.
const FINEST_QUANTUM: f64 = 5e-7;
/// The device is taken for no lighter than this part of what was told,
const LIGHTEST: f64 = 0.05;
/// and for no heavier than this multiple of it.
const HEAVIEST: f64 = 20.0;
/// Largest hand damping and stiffness over mass that are believed, times the period and its square: beyond them the
/// series ends too early.
const MOST_RATE: f64 = 0.5;

/// The observer of a device along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisObserver {
    pub motion: AxisMotion,
    covariance: Covariance,
    /// Variance of the hand's jerk, as far as innovations show one `[m^2/s^6]`.
    jerk_variance: f64,
    sensor_noise: SensorNoise<f64>,
}

/// What an observer starts from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisPrior {
    /// 1/m as told `[1/kg]`; 0 for what no force moves.
    pub mobility: f64,
    /// Variance of a measured position `[m^2]`.
    pub measurement_variance: f64,
    pub prior: Prior,
    /// The jerk that is reckoned with while the device is where it is expected, at least `[m/s^3]`.
    least_jerk: f64,
    /// Whether the device has this axis. If not, the tool is where it is measured, and nothing is estimated.
    is_there: bool,
}

impl AxisPrior {
    pub fn new(mass: f64, quantum: f64, prior: Prior) -> Self {
        let quantum = quantum.max(FINEST_QUANTUM);
        Self {
            mobility: 1.0 / mass,
            // A position is anywhere within its quantum.
            measurement_variance: quantum * quantum / 12.0,
            prior,
            least_jerk: 0.0,
            is_there: true,
        }
    }

    /// Of a device whose mass is another at each place. One mobility for each axis is only nearly right there, and what is left over
    /// has to be put down to a jerk: with less of it E of the arm of `palpate-sim --test it linkages::` is 24 % at 4 ms in place of 9 %.
    pub fn of_a_linkage(self) -> Self {
        Self {
            least_jerk: self.prior.jerk,
            ..self
        }
    }

    /// Of an axis that the device lacks.
    pub fn of_no_axis(self) -> Self {
        Self {
            mobility: 0.0,
            is_there: false,
            ..self
        }
    }
}

/// Covariance of the state at the start of an interval with that at its end, and that of the state at its end without the jerk.
fn carried(at_start: &Covariance, transition: &[Row; 3]) -> (Covariance, Covariance) {
    let mut cross = *at_start;
    for (column, row) in transition.iter().enumerate() {
        cross.set_column(column, &(at_start * row));
    }
    let mut at_end = cross;
    for (number, row) in transition.iter().enumerate() {
        at_end.set_row(number, &(row.transpose() * cross));
    }
    (cross, at_end)
}

impl AxisObserver {
    pub fn new(from: &AxisPrior) -> Self {
        let prior = &from.prior;
        let variances = [
            from.measurement_variance,
            prior.velocity * prior.velocity,
            prior.acceleration * prior.acceleration,
            (prior.mobility * from.mobility).powi(2),
            prior.damping_rate * prior.damping_rate,
            prior.spring_rate * prior.spring_rate,
        ];
        Self {
            motion: AxisMotion {
                offset: 0.0,
                velocity: 0.0,
                external: 0.0,
                mobility: from.mobility,
                damping_rate: 0.0,
                spring_rate: 0.0,
            },
            covariance: Covariance::from_diagonal(&Row::from(variances)),
            jerk_variance: prior.jerk * prior.jerk,
            sensor_noise: SensorNoise::default(),
        }
    }

    /// Takes the sample at the end of an interval of `h` `[s]` over which the device has moved by `moved` `[m]` under
    /// a held `force` `[N]`. Returns the device at the interval's beginning as the sample makes it look now: smoothed by
    /// one step, but for theta, lambda and kappa, which are the same at both ends.
    pub fn see(&mut self, from: &AxisPrior, moved: f64, force: &AxisForce, h: f64) -> AxisMotion {
        if !from.is_there {
            // Straight from the one measured place to the next, and on.
            self.motion = AxisMotion::led(moved / h);
            return self.motion;
        }
        let measurement_variance = self.sensor_variance(from, moved, force, h);
        let before = self.motion;
        let change = before.under(force, h);
        let transition = before.transition(force, h);
        let jerk = Row::from([h * h * h / 6.0, h * h / 2.0, h, 0.0, 0.0, 0.0]);
        // What is not known of the force: a kick that is not there, or is there twice.
        let kicked = before.mobility * force.impulse_deviation * h;
        let innovation = moved - (before.offset + change.travel);
        let expects = |at_start: &Covariance, jerk_variance: f64| {
            let (cross, mut at_end) = carried(at_start, &transition);
            at_end += jerk * jerk.transpose() * jerk_variance;
            let variance = at_end[(0, 0)] + measurement_variance + kicked * kicked;
            (cross, at_end, variance)
        };
        let mut at_start = self.covariance;
        let mut jerk_variance = self.jerk_variance;
        let (mut cross, mut covariance, mut variance) = expects(&at_start, jerk_variance);
        let square = innovation * innovation;
        // By a unit of jerk, in an interval.
        let travel_variance = jerk[0] * jerk[0];
        let most = from.prior.jerk * from.prior.jerk;
        if square > EXPLAINED * variance && jerk_variance < most {
            // The hand moves again.
            let missing = (square / EXPLAINED - variance) / travel_variance;
            jerk_variance = (jerk_variance + missing).min(most);
            (cross, covariance, variance) = expects(&at_start, jerk_variance);
        }
        let calm = CALMING * (1.0 - square / variance).max(0.0);
        // One whose way in an interval the sensor cannot tell from none costs nothing.
        let least = measurement_variance / travel_variance;
        let least = least.max(from.least_jerk * from.least_jerk).min(most);
        let calmed = (jerk_variance * (1.0 - calm)).max(least);
        if square > SURPRISE * variance {
            // Nothing the filter reckons with: something kicked the device. Let the kick come first in the interval, which makes the
            // velocity that of the last step.
            at_start[(VELOCITY, VELOCITY)] += (square / EXPLAINED - variance) / (h * h);
            (cross, covariance, variance) = expects(&at_start, jerk_variance);
        }
        let seen: Row = covariance.column(0).into();
        let gain = seen / variance;
        let update = gain * innovation;
        let smoothing: Row = cross.column(0) * (innovation / variance);
        covariance -= gain * seen.transpose();

        let told = from.mobility;
        let mobility = (before.mobility + update[3]).clamp(told / HEAVIEST, told / LIGHTEST);
        let damping_rate = (before.damping_rate + update[4]).clamp(0.0, MOST_RATE / h);
        let spring_rate = (before.spring_rate + update[5]).clamp(0.0, MOST_RATE / (h * h));
        let mut covariance = (covariance + covariance.transpose()) * 0.5;
        for state in 0..STATES {
            // By rounding only.
            covariance[(state, state)] = covariance[(state, state)].max(0.0);
        }
        let adapted = Self {
            motion: AxisMotion {
                offset: innovation * (gain[0] - 1.0),
                velocity: before.velocity + change.gained + update[1],
                external: before.external + change.external + update[2],
                mobility,
                damping_rate,
                spring_rate,
            },
            covariance,
            jerk_variance: calmed,
            sensor_noise: self.sensor_noise,
        };
        if !adapted.is_sound() {
            *self = Self::new(from);
            return self.motion;
        }
        *self = adapted;
        AxisMotion {
            offset: before.offset + smoothing[0],
            velocity: before.velocity + smoothing[1],
            external: before.external + smoothing[2],
            mobility,
            damping_rate,
            spring_rate,
        }
    }

    /// Variance of the sample that ends an interval `[m^2]`, by what free motion has shown.
    fn sensor_variance(&mut self, from: &AxisPrior, moved: f64, force: &AxisForce, h: f64) -> f64 {
        let known = self.motion;
        let interval = SensorInterval {
            moved,
            elapsed: h,
            pushed: known.mobility * force.mean * h * h,
            expected: known.under(force, h).travel,
        };
        let mut sensor_noise = self.sensor_noise;
        let misjudged = sensor_noise.take(&interval, from.measurement_variance);
        let variance = sensor_noise.variance(from.measurement_variance);
        if misjudged {
            *self = Self::new(from);
            self.motion.velocity = known.velocity;
            self.covariance[(0, 0)] = variance;
        }
        self.sensor_noise = sensor_noise;
        variance
    }

    fn is_sound(&self) -> bool {
        let AxisMotion {
            offset,
            velocity,
            external,
            mobility,
            damping_rate,
            spring_rate,
        } = self.motion;
        let sum = offset + velocity + external + mobility + damping_rate + spring_rate;
        (sum + self.covariance.sum()).is_finite()
    }
}

#[cfg(test)]
mod tests;

//! Observer of a device along one axis: a Kalman filter of the device's motion under the applied forces.
//!
//! Over an interval the held force f and an acceleration a due to everything else (hand, gravity, friction) act on
//! the device. The hand is also a spring and a damper, whose force depends on the device's motion:
//!
//! ```text
//! x' = u    u' = a + theta f    a' = -lambda u' - kappa u + w    w white: the jerk of the hand
//! ```
//!
//! theta = 1/m, lambda (damping over mass) and kappa (stiffness over mass) are part of the state and become
//! observable in contact. f is represented by its mean over the interval and its lead, so the state at the end has a
//! closed form. A series in h with six terms equals it to rounding if lambda h and kappa h^2 are small.

use nalgebra::{SMatrix, SVector};
use palpate_core::{SensorInterval, SensorNoise};

/// Number of estimated states: x, u, a, theta, lambda, kappa.
const STATES: usize = 6;
type Row = SVector<f64, STATES>;
type Covariance = SMatrix<f64, STATES, STATES>;

/// State of a device along one axis at a sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisMotion {
    /// Position relative to the measured one `[m]`.
    pub offset: f64,
    /// u `[m/s]`.
    pub velocity: f64,
    /// a: acceleration without contacts `[m/s^2]`.
    pub external: f64,
    /// theta `[1/kg]`.
    pub mobility: f64,
    /// lambda `[1/s]`.
    pub damping_rate: f64,
    /// kappa `[1/s^2]`.
    pub spring_rate: f64,
}

/// Change of a device's state over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// Displacement `[m]`.
    pub travel: f64,
    /// Change of u `[m/s]`.
    pub gained: f64,
    /// Change of a `[m/s^2]`.
    pub external: f64,
}

/// Force on a device along an axis over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisForce {
    /// Mean `[N]`.
    pub mean: f64,
    /// Moment by which its impulse comes earlier than that of a constant force `[N s^2]`.
    pub lead: f64,
    /// Standard deviation of the impulse `[N s]`.
    pub impulse_deviation: f64,
    /// Mean of an additional known acceleration `[m/s^2]`.
    pub bias: f64,
    /// Displacement due to the variation of that acceleration `[m]`.
    pub bias_lead: f64,
    /// Effective fraction of the external acceleration: 1, except for a linkage away from its reference.
    pub share: f64,
}

/// Time derivatives of a velocity, from the velocity itself on.
type Series = [f64; STATES];

/// Returns the change of position, velocity and acceleration over `h` from the derivatives of a velocity at the
/// start.
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
    /// Returns a device at its measured position with this velocity `[m/s]`, independent of forces.
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

    /// Returns the derivatives of a velocity that begin with `first`. `enters` is the input to each further one;
    /// `share` is the effective fraction of the external acceleration.
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

    /// Returns the change over an interval of `h` `[s]` under a `force`.
    pub fn under(&self, force: &AxisForce, h: f64) -> Change {
        let mut change = over(&self.own_series(force), h);
        change.travel += self.mobility * force.lead + force.bias_lead;
        change.external /= force.share;
        change
    }

    /// Returns the derivatives of position, velocity and acceleration at the end with respect to the state at the
    /// start.
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

/// Prior standard deviations of device and hand parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Velocity `[m/s]`.
    pub velocity: f64,
    /// Acceleration by the hand `[m/s^2]`.
    pub acceleration: f64,
    /// 1/m and inverse moments of inertia, relative to their model values.
    pub mobility: f64,
    /// Hand damping over mass, and over moments of inertia `[1/s]`.
    pub damping_rate: f64,
    /// Hand stiffness over mass `[1/s^2]`.
    pub spring_rate: f64,
    /// Hand jerk between samples; a smaller value is used while the hand rests `[m/s^3]`.
    pub jerk: f64,
    /// Angular velocity of a device that turns `[rad/s]`.
    pub angular_velocity: f64,
    /// Angular acceleration by the hand `[rad/s^2]`.
    pub angular_acceleration: f64,
    /// Angular jerk by the hand between samples `[rad/s^3]`.
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
    /// Returns the prior of a device with exactly known mass and an external force that does not depend on its
    /// motion.
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

/// Index of the velocity in the state.
const VELOCITY: usize = 1;
/// Squared innovation, relative to its variance, above which it is attributed to a kick instead of jerk. With 25, as
/// for a single axis, first contacts with wrong model masses count as kicks at 10 ms. With 100, a tool that crosses
/// an edge may.
pub(crate) const SURPRISE: f64 = 900.0;
/// Squared normalised innovation that remains after a kick has been included.
pub(crate) const EXPLAINED: f64 = 4.0;
/// Relative decrease of the jerk variance per sample while the device is where it is expected.
const CALMING: f64 = 0.2;
/// Quantum assumed for a sensor with unknown or finer quantum `[m]`. With a smaller value the filter, which
/// linearises its equations, would rely too much on the first samples for the hand's spring and damper.
const FINEST_QUANTUM: f64 = 5e-7;
/// Minimum of the estimated mass, relative to its model value.
const LIGHTEST: f64 = 0.05;
/// Maximum of the estimated mass, relative to its model value.
const HEAVIEST: f64 = 20.0;
/// Maximum of the hand damping over mass times the period, and of the stiffness over mass times its square: beyond it
/// the truncated series is inaccurate.
const MAX_RATE: f64 = 0.5;

/// Observer of a device along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisObserver {
    pub motion: AxisMotion,
    covariance: Covariance,
    /// Variance of the hand's jerk as shown by the innovations `[m^2/s^6]`.
    jerk_variance: f64,
    sensor_noise: SensorNoise<f64>,
}

/// Initial values of an observer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisPrior {
    /// 1/m from the model mass `[1/kg]`; 0 if no force moves the device.
    pub mobility: f64,
    /// Variance of a measured position `[m^2]`.
    pub measurement_variance: f64,
    pub prior: Prior,
    /// Minimum jerk assumed while the device is where it is expected `[m/s^3]`.
    least_jerk: f64,
    /// Whether the device has this axis. Otherwise the tool is at the measured position and nothing is estimated.
    is_there: bool,
}

impl AxisPrior {
    pub fn new(mass: f64, quantum: f64, prior: Prior) -> Self {
        let quantum = quantum.max(FINEST_QUANTUM);
        Self {
            mobility: 1.0 / mass,
            // Uniform distribution within the quantum.
            measurement_variance: quantum * quantum / 12.0,
            prior,
            least_jerk: 0.0,
            is_there: true,
        }
    }

    /// Returns the prior for a position-dependent mass. One mobility per axis is an approximation, and the remainder
    /// must be attributed to jerk. With less jerk, E of the arm in `palpate-study --test it linkages::` is 24 % at 4 ms
    /// instead of 9 %.
    pub fn of_a_linkage(self) -> Self {
        Self {
            least_jerk: self.prior.jerk,
            ..self
        }
    }

    /// Returns the prior for an axis that the device lacks.
    pub fn of_no_axis(self) -> Self {
        Self {
            mobility: 0.0,
            is_there: false,
            ..self
        }
    }
}

/// Uncertainty expected at the end of an interval.
struct Expected {
    /// Covariance of the state at the start with that at the end.
    cross: Covariance,
    /// Covariance of the state at the end.
    covariance: Covariance,
    /// Variance of the measured displacement `[m^2]`.
    variance: f64,
    /// Variance of the hand's jerk for the next interval `[m^2/s^6]`.
    jerk_variance: f64,
}

/// Returns the covariance of the state at the start of an interval with that at its end, and the covariance at the
/// end without jerk.
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

    /// Updates the estimate with the sample at the end of an interval of `h` `[s]`, in which the device moved by
    /// `moved` `[m]` under a held `force` `[N]`. Returns the smoothed state at the beginning of the interval
    /// (one-step smoothing). theta, lambda and kappa are equal at both ends.
    pub fn see(&mut self, from: &AxisPrior, moved: f64, force: &AxisForce, h: f64) -> AxisMotion {
        if !from.is_there {
            // Linear motion between measured positions, extrapolated.
            self.motion = AxisMotion::led(moved / h);
            return self.motion;
        }
        let measurement_variance = self.sensor_variance(from, moved, force, h);
        let before = self.motion;
        let change = before.under(force, h);
        let transition = before.transition(force, h);
        let jerk = Row::from([h * h * h / 6.0, h * h / 2.0, h, 0.0, 0.0, 0.0]);
        // Uncertain force: the kick may be missing or doubled.
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
        // Variance of the displacement per unit jerk variance.
        let travel_variance = jerk[0] * jerk[0];
        let most = from.prior.jerk * from.prior.jerk;
        if square > EXPLAINED * variance && jerk_variance < most {
            // The hand moves again.
            let missing = (square / EXPLAINED - variance) / travel_variance;
            jerk_variance = (jerk_variance + missing).min(most);
            (cross, covariance, variance) = expects(&at_start, jerk_variance);
        }
        let calm = CALMING * (1.0 - square / variance).max(0.0);
        // Jerk whose displacement per interval is below the sensor resolution has no cost.
        let least = measurement_variance / travel_variance;
        let least = least.max(from.least_jerk * from.least_jerk).min(most);
        let calmed = (jerk_variance * (1.0 - calm)).max(least);
        if square > SURPRISE * variance {
            // The filter model cannot explain this innovation: something kicked the device. Assume the kick at the
            // start of the interval, which makes the velocity that of the last step.
            at_start[(VELOCITY, VELOCITY)] += (square / EXPLAINED - variance) / (h * h);
            (cross, covariance, variance) = expects(&at_start, jerk_variance);
        }
        let expected = Expected {
            cross,
            covariance,
            variance,
            jerk_variance: calmed,
        };
        self.adapt(from, innovation, &change, expected, h)
    }

    /// Corrects the estimate by an `innovation` `[m]`. Returns the smoothed state at the beginning of the interval.
    #[inline(always)]
    fn adapt(
        &mut self,
        from: &AxisPrior,
        innovation: f64,
        change: &Change,
        expected: Expected,
        h: f64,
    ) -> AxisMotion {
        let before = self.motion;
        let Expected {
            cross,
            mut covariance,
            variance,
            jerk_variance,
        } = expected;
        let seen: Row = covariance.column(0).into();
        let gain = seen / variance;
        let update = gain * innovation;
        let smoothing: Row = cross.column(0) * (innovation / variance);
        covariance -= gain * seen.transpose();

        let model = from.mobility;
        let mobility = (before.mobility + update[3]).clamp(model / HEAVIEST, model / LIGHTEST);
        let damping_rate = (before.damping_rate + update[4]).clamp(0.0, MAX_RATE / h);
        let spring_rate = (before.spring_rate + update[5]).clamp(0.0, MAX_RATE / (h * h));
        let mut covariance = (covariance + covariance.transpose()) * 0.5;
        for state in 0..STATES {
            // Negative only by rounding.
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
            jerk_variance,
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

    /// Returns the variance of the sample that ends an interval, from the noise observed in free motion `[m^2]`.
    fn sensor_variance(&mut self, from: &AxisPrior, moved: f64, force: &AxisForce, h: f64) -> f64 {
        let known = self.motion;
        let interval = SensorInterval {
            moved,
            elapsed: h,
            pushed: known.mobility * force.mean * h * h,
            expected: known.under(force, h).travel,
        };
        let mut sensor_noise = self.sensor_noise;
        let misclassified = sensor_noise.take(&interval, from.measurement_variance);
        let variance = sensor_noise.variance(from.measurement_variance);
        if misclassified {
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

//! A mass with friction, held by a hand.
//!
//! ```text
//! (m + m_h) x″ = u(t, x, x′) − B x′ − F_c sgn(x′) − f
//! ```
//!
//! with the force u of the [`Hand`], and f the force held on the object. At rest the friction takes any value up to F_c
//! that keeps the mass at rest: static and sliding friction have the same level.
//!
//! # Exact between events
//!
//! Between two events the equation is linear, with an excitation of a constant, a ramp and sinusoids. Its solution is
//! summed as a power series in time, over spans of at most one radian of the fastest rate, D/M + √(K/M) or the fastest
//! sinusoid, until the terms are below round-off. This equals the closed form in exponentials without its special
//! cases: weak and strong damping, k_h → 0, B + b_h → 0 and resonance with a tremor, where the terms of the closed form
//! are differences of nearly equal or infinite numbers, are the same few additions.
//!
//! Coming to rest, reversing, breaking away and a bend of a recorded intention are events. The first zero of the series
//! is bracketed and located to round-off, and the next span begins there. An advance may therefore have any length, and
//! dividing it into pieces changes only round-off.

use crate::InvalidParameter;
use crate::arc::GAUSS_LEGENDRE;
use crate::device::DevicePlant;
use crate::error::{finite, not_negative, positive};
use crate::hand::Hand;
use crate::power_series::{MAX_TERMS, first_fall, integral, terms, value};

/// Most spans and events of one advance.
///
/// A million radians of the fastest rate: a device of 1 g in 100 N s/m would have to be left alone
/// for ten seconds. See [`HeldMass::gave_up`].
const MAX_SPANS: usize = 1_000_000;

/// Fastest rate `[rad/s]` of a mass, and of the hand's motion: a second has this many spans.
const MAX_RATE: f64 = 1e6;

/// A slide from rest that ends within this fraction of its span is the round-off of a force that
/// touches the friction's level, and no slide.
const BRIEFEST_SLIDE: f64 = 1e-12;

/// After such a touch the friction holds this fraction more, or the same touch would be found again.
const MARGIN_AFTER_TOUCH: f64 = 1e-12;

/// A point mass with viscous and dry friction, held by a hand.
///
/// # Accounts
///
/// From the start, and over any number of advances,
///
/// ```text
/// kinetic energy gained = hand work − friction loss − port work
/// ```
///
/// Each account is integrated from the motion separately; none is the difference of the others. The kinetic energy is
/// that of m + m_h. The hand's work is therefore the work of u alone, and energy stored in the hand's mass appears as
/// kinetic energy.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldMass {
    mass: f64,
    hand: Hand,
    viscous_friction: f64,
    coulomb_friction: f64,
    largest_force: f64,
    position: f64,
    velocity: f64,
    clock: Clock,
    /// Time at which the hand releases the device `[s]`; infinite if it never does or already has.
    release: f64,
    accounts: Accounts,
    gave_up: bool,
}

/// Energy flows of a [`HeldMass`] since its start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Accounts {
    /// ∫ u x′ dt `[J]`, positive while the hand drives the mass.
    pub hand_work: f64,
    /// ∫ (B x′² + F_c |x′|) dt `[J]`, never falling.
    pub friction_loss: f64,
    /// ∫ f x′ dt `[J]`, what the advances have returned.
    pub port_work: f64,
}

impl HeldMass {
    /// A mass `[kg]` without friction in a hand, at rest at the origin at time 0.
    ///
    /// # Errors
    ///
    /// `mass` is not finite and positive, or too light for 1e6 rad/s, or a parameter of the hand is not finite, is
    /// negative where it may not be, or faster.
    pub fn new(mass: f64, hand: Hand) -> Result<Self, InvalidParameter> {
        positive("mass", mass, "finite and above 0 kg")?;
        hand.check()?;
        Self {
            mass,
            hand,
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            largest_force: f64::INFINITY,
            position: 0.0,
            velocity: 0.0,
            clock: Clock::default(),
            release: f64::INFINITY,
            accounts: Accounts::default(),
            gave_up: false,
        }
        .with_bounded_rates()
    }

    /// Returns the same device with viscous friction B `[N s/m]` and Coulomb friction F_c `[N]`.
    ///
    /// # Errors
    ///
    /// One of them is not finite and at least 0, or the mass is too light for 1e6 rad/s.
    pub fn with_friction(self, viscous: f64, coulomb: f64) -> Result<Self, InvalidParameter> {
        Self {
            viscous_friction: not_negative(
                "viscous_friction",
                viscous,
                "finite and at least 0 N s/m",
            )?,
            coulomb_friction: not_negative("coulomb_friction", coulomb, "finite and at least 0 N")?,
            ..self
        }
        .with_bounded_rates()
    }

    /// Returns the same device with a motor that gives at most this force `[N]`; infinite is no limit.
    ///
    /// # Errors
    ///
    /// `largest_force` is not positive.
    pub fn with_largest_force(self, largest_force: f64) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(
            largest_force > 0.0,
            "largest_force",
            largest_force,
            "above 0 N",
        )?;
        Ok(Self {
            largest_force,
            ..self
        })
    }

    /// Returns the device with a hand that releases it permanently at `time` `[s]`. The hand's force then ends, and its
    /// mass no longer moves with the device. The kinetic energy of the hand's mass is recorded as work of the hand.
    ///
    /// # Errors
    ///
    /// `time` is not finite and at least 0.
    pub fn released_at(self, time: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            release: not_negative("release", time, "finite and at least 0 s")?,
            ..self
        })
    }

    /// Returns the same device at another position `[m]` and velocity `[m/s]`.
    ///
    /// # Errors
    ///
    /// `position` or `velocity` is not finite.
    pub fn starting_at(self, position: f64, velocity: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            position: finite("position", position, "finite [m]")?,
            velocity: finite("velocity", velocity, "finite [m/s]")?,
            ..self
        })
    }

    fn with_bounded_rates(self) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(
            self.sliding_rate() <= MAX_RATE,
            "mass",
            self.mass,
            "heavy enough for stiffness and damping: no faster than 1e6 rad/s together",
        )?;
        let rate = self.hand.fastest_rate();
        InvalidParameter::unless(rate <= MAX_RATE, "hand.rate", rate, "at most 1e6 rad/s")?;
        Ok(self)
    }

    /// The hand.
    #[must_use]
    pub fn hand(&self) -> &Hand {
        &self.hand
    }

    /// Time of the hand's clock `[s]`, 0 at the start.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Moved mass m + m_h `[kg]`.
    #[must_use]
    pub fn moved_mass(&self) -> f64 {
        self.mass + self.hand.mass()
    }

    /// (m + m_h) x′²/2 `[J]`.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * self.moved_mass() * self.velocity * self.velocity
    }

    /// The accounts since the start.
    #[must_use]
    pub fn accounts(&self) -> Accounts {
        self.accounts
    }

    /// Returns the motor's force for a commanded force on the object `[N]`, limited to the largest force.
    #[must_use]
    pub fn given_force(&self, force_on_object: f64) -> f64 {
        force_on_object.clamp(-self.largest_force, self.largest_force)
    }

    /// Whether an advance ever met a million spans and events, and left the mass where it was for
    /// the rest of its duration. Only parameters far from any device do that.
    #[must_use]
    pub fn gave_up(&self) -> bool {
        self.gave_up
    }

    /// Bound of the rates `[rad/s]` of the sliding mass by itself.
    fn sliding_rate(&self) -> f64 {
        let mass = self.moved_mass();
        (self.viscous_friction + self.hand.damping()) / mass + (self.hand.stiffness() / mass).sqrt()
    }

    /// The motion over a span that begins now, were there no event in it.
    fn motion(&self, force: f64, span: f64, state: State, rate: f64) -> MotionSeries {
        let count = terms(rate * span);
        let mut intended_velocity = [0.0; MAX_TERMS];
        let mut hand_force = [0.0; MAX_TERMS];
        self.hand.write_series(
            self.time(),
            span,
            &mut intended_velocity[..count],
            &mut hand_force[..count],
        );
        let mass = self.moved_mass();
        let (stiffness, damping) = (self.hand.stiffness(), self.hand.damping());
        let mut velocity = [0.0; MAX_TERMS];
        velocity[0] = self.velocity;
        // Coefficient of x_int − x; its rate is x_int′ − x′.
        let mut distance = self.hand.intended_position(self.time()) - self.position;
        for n in 0..count {
            let order = (n + 1) as f64;
            let closing = intended_velocity[n] - velocity[n];
            hand_force[n] += stiffness * distance + damping * closing;
            distance = span * closing / order;
            let State::Sliding { direction } = state else {
                continue;
            };
            if n + 1 == count {
                break;
            }
            let mut push = hand_force[n] - self.viscous_friction * velocity[n];
            if n == 0 {
                push = push - force - direction * self.coulomb_friction;
                if self.velocity == 0.0 && push * direction < 0.0 {
                    // A mass breaks away where this is 0, up to the round-off of the instant.
                    push = 0.0;
                }
            }
            velocity[n + 1] = push / mass * span / order;
        }
        MotionSeries {
            span,
            count,
            velocity,
            hand_force,
        }
    }

    /// Moves along `motion` up to a fraction of its span, records the energies in the accounts, and returns the travel
    /// `[m]`.
    fn follow(&mut self, motion: &MotionSeries, fraction: f64, force: f64) -> f64 {
        let travel = motion.travel(fraction);
        let (hand_work, squared_speed) = motion.work_and_squared_speed(fraction);
        self.position += travel;
        self.velocity = value(motion.velocity(), fraction);
        self.accounts.hand_work += hand_work;
        self.accounts.friction_loss +=
            self.viscous_friction * squared_speed + self.coulomb_friction * travel.abs();
        self.accounts.port_work += force * travel;
        travel
    }

    fn disable_output(&mut self) {
        let before = self.kinetic_energy();
        self.hand = Hand::pushing(0.0);
        self.release = f64::INFINITY;
        self.accounts.hand_work += self.kinetic_energy() - before;
    }

    /// Moves on in the same hand for a `duration` `[s]` above 0.
    fn move_on(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let force = self.given_force(force_on_object);
        let hand_rate = self.hand.fastest_rate();
        let sliding_rate = hand_rate.max(self.sliding_rate());
        let mut end = self.clock;
        end.forward(duration);
        let mut remaining = duration;
        let mut travel = 0.0;
        let mut decided = None;
        for _ in 0..MAX_SPANS {
            let state = decided.take().unwrap_or_else(|| self.state(force));
            let rate = match state {
                State::Sliding { .. } => sliding_rate,
                State::Stuck { .. } => hand_rate,
            };
            let bend = self.hand.next_bend(self.time());
            let to_bend = self.clock.until(bend);
            let span = remaining.min(to_bend).min(1.0 / rate);
            let motion = self.motion(force, span, state, rate);
            let event = match state {
                State::Sliding { direction } => {
                    let standstill = motion.standstill(direction);
                    if self.velocity == 0.0 && standstill.is_some_and(|s| s < BRIEFEST_SLIDE) {
                        let margin = MARGIN_AFTER_TOUCH * self.coulomb_friction;
                        decided = Some(State::Stuck { margin });
                        continue;
                    }
                    travel += self.follow(&motion, standstill.unwrap_or(1.0), force);
                    if standstill.is_some() || self.velocity * direction < 0.0 {
                        self.velocity = 0.0;
                    }
                    standstill
                }
                State::Stuck { margin } => {
                    let broken = self.break_away(&motion, force, margin);
                    decided = broken.map(|(_, direction)| State::Sliding { direction });
                    broken.map(|(instant, _)| instant)
                }
            };
            match event {
                Some(fraction) => self.clock.forward(fraction * span),
                None if span == remaining => {
                    self.clock = end;
                    return force * travel;
                }
                // On the bend itself, not a rounding before it.
                None if span == to_bend => self.clock = Clock::at(bend),
                None => self.clock.forward(span),
            }
            remaining = end.since(self.clock);
            if remaining <= 0.0 {
                self.clock = end;
                return force * travel;
            }
        }
        self.gave_up = true;
        self.clock = end;
        force * travel
    }

    /// Returns the state of motion if no event has just determined it.
    fn state(&self, force: f64) -> State {
        if self.coulomb_friction == 0.0 {
            return State::Sliding { direction: 0.0 };
        }
        if self.velocity != 0.0 {
            let direction = self.velocity.signum();
            return State::Sliding { direction };
        }
        let net = self.hand.force(self.time(), self.position, 0.0) - force;
        if net.abs() > self.coulomb_friction {
            let direction = net.signum();
            return State::Sliding { direction };
        }
        State::Stuck { margin: 0.0 }
    }

    /// The first break-away of a stuck mass: fraction of the span, and direction.
    fn break_away(&self, motion: &MotionSeries, force: f64, margin: f64) -> Option<(f64, f64)> {
        let mut first: Option<(f64, f64)> = None;
        for direction in [1.0, -1.0] {
            let mut reserve = motion.hand_force;
            for coefficient in &mut reserve[..motion.count] {
                *coefficient *= -direction;
            }
            reserve[0] = (self.coulomb_friction + direction * force + reserve[0]).max(margin);
            if let Some(fraction) = first_fall(&reserve[..motion.count])
                && first.is_none_or(|(earlier, _)| fraction < earlier)
            {
                first = Some((fraction, direction));
            }
        }
        first
    }
}

impl DevicePlant for HeldMass {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Implements [`DevicePlant::advance`]. The motor applies [`given_force`](Self::given_force), and the returned work
    /// is that of this force.
    ///
    /// A duration that is not finite and above 0 has no effect.
    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        if !(duration.is_finite() && duration > 0.0) {
            return 0.0;
        }
        let held = self.clock.until(self.release);
        if held >= duration {
            return self.move_on(force_on_object, duration);
        }
        let mut work = 0.0;
        if held > 0.0 {
            work += self.move_on(force_on_object, held);
        }
        self.disable_output();
        work + self.move_on(force_on_object, duration - held.max(0.0))
    }

    /// Returns (m + m_h) x′²/2 + k_h (x_int − x)²/2 − F x `[J]`: the kinetic energy, the energy of the hand's spring at
    /// this instant, and that of the hand's constant force.
    ///
    /// Without friction, damping and tremor, and with a constant intention, it decreases by exactly the work that an
    /// advance returns. A moving intention also changes it; the [accounts](Self::accounts) then have the complete
    /// balance.
    fn stored_energy(&self) -> f64 {
        let distance = self.hand.intended_position(self.time()) - self.position;
        self.kinetic_energy() + 0.5 * self.hand.stiffness() * distance * distance
            - self.hand.constant_force() * self.position
    }
}

/// Whether the mass moves, and which way its friction looks.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Direction +1, −1, or 0 without Coulomb friction.
    Sliding { direction: f64 },
    /// At rest, with a reserve of at least this force `[N]` before breaking away.
    Stuck { margin: f64 },
}

/// Power series in time over `span`, which is 1 in their variable.
struct MotionSeries {
    /// `[s]`
    span: f64,
    count: usize,
    /// x′ `[m/s]`
    velocity: [f64; MAX_TERMS],
    /// u `[N]`
    hand_force: [f64; MAX_TERMS],
}

impl MotionSeries {
    fn velocity(&self) -> &[f64] {
        &self.velocity[..self.count]
    }

    /// Returns the fraction of the span at which a mass sliding in `direction` comes to rest, if it does.
    fn standstill(&self, direction: f64) -> Option<f64> {
        let mut speed = self.velocity;
        for coefficient in &mut speed[..self.count] {
            *coefficient *= direction;
        }
        first_fall(&speed[..self.count])
    }

    /// `[m]`
    fn travel(&self, fraction: f64) -> f64 {
        self.span * integral(self.velocity(), fraction)
    }

    /// (∫ u x′ dt `[J]`, ∫ x′² dt `[m²/s]`), by a rule that is exact to round-off over a radian.
    fn work_and_squared_speed(&self, fraction: f64) -> (f64, f64) {
        let half = 0.5 * fraction;
        let (mut work, mut squared_speed) = (0.0, 0.0);
        for (abscissa, weight) in GAUSS_LEGENDRE {
            for s in [half - half * abscissa, half + half * abscissa] {
                let velocity = value(self.velocity(), s);
                work += weight * velocity * value(&self.hand_force[..self.count], s);
                squared_speed += weight * velocity * velocity;
            }
        }
        (half * self.span * work, half * self.span * squared_speed)
    }
}

/// Time with the part that a sum of many short durations would lose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Clock {
    sum: f64,
    lost: f64,
}

impl Clock {
    fn time(self) -> f64 {
        self.sum
    }

    fn at(time: f64) -> Self {
        Self {
            sum: time,
            lost: 0.0,
        }
    }

    fn until(self, instant: f64) -> f64 {
        Self::at(instant).since(self)
    }

    fn since(self, earlier: Self) -> f64 {
        (self.sum - earlier.sum) + (self.lost - earlier.lost)
    }

    fn forward(&mut self, duration: f64) {
        let duration = duration + self.lost;
        let sum = self.sum + duration;
        let kept = sum - self.sum;
        self.lost = (self.sum - (sum - kept)) + (duration - kept);
        self.sum = sum;
    }
}

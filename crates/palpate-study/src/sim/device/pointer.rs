//! A device in a hand that follows a pointer: a mouse, a finger on a screen, a test.
//!
//! ```text
//! a″ = ω² (target − a) − 2 ω a′                          where the hand aims
//! (m + m_h) x″ = k_h (a − x) + b_h (a′ − x′) − b x′ + f   while it holds the device
//! m x″ = − b x′ − F_c sgn(x′) + f                         after its release
//! ```
//!
//! A mouse reports its position sixty times a second, in steps. The hand therefore follows the target through a
//! critically damped filter, whose position and speed are continuous, as is the force of spring and damper between the
//! aim and the device. At the default ω of 100 rad/s a hand that moves at 0.3 m/s, in steps of 5 mm, shakes the device
//! by some 0.02 mm at 60 Hz, and lags by 2/ω = 20 ms.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use palpate_scene::Scene;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};
use palpate_testbed::device::DevicePlant as Moved;
use palpate_testbed::hand::Hand;
use palpate_testbed::held_mass::HeldMass;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::measure::{Sampler, SensorNoise};

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Cut, Device, DeviceError, Line, Pose, Wrench, ZeroWriter};

use crate::sim::plant::noisy;

/// Parameters of a pointer's device and its hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointerParams {
    /// Mass m of the device `[kg]`.
    pub device_mass: f64,
    /// Viscous friction b of the device `[N s/m]`.
    pub viscous_friction: f64,
    /// Dry friction F_c of the free device `[N]`. It stops the device and carries an object that lies on it; it does
    /// not act while a hand holds the device.
    pub dry_friction: f64,
    /// Quantum of the position `[m]`; 0 for a sensor without one.
    pub encoder_quantum: f64,
    /// Standard deviation of the sensor's white noise, before quantisation `[m]`.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Mass m_h of the hand, which moves with the device while it holds it `[kg]`.
    pub hand_mass: f64,
    /// Stiffness k_h of the hand `[N/m]`.
    pub hand_stiffness: f64,
    /// Damping b_h of the hand `[N s/m]`.
    pub hand_damping: f64,
    /// Rate ω of the filter through which the hand follows its target `[rad/s]`.
    pub aim_rate: f64,
    /// Initial position of the device, at rest `[m]`.
    pub position: f64,
    /// Largest force of the motor `[N]`; `None`: unlimited.
    pub largest_force: Option<f64>,
    /// Periods after which a command acts: what is written is held after as many further writes.
    pub delay: usize,
    /// Time from a write to the beginning of its force, in place of `delay` `[s]`.
    pub delay_seconds: f64,
    /// Gain and lag of the motor.
    pub actuator: ActuatorParams,
}

/// Most forces that begin later: those of the longest delay that a scene can state.
const MAX_LATER: usize = DelayedHold::LONGEST_DELAY + 1;

impl Default for PointerParams {
    /// A light desktop device in a relaxed hand.
    fn default() -> Self {
        Self {
            device_mass: 0.25,
            viscous_friction: 1.0,
            dry_friction: 1.5,
            encoder_quantum: 0.0,
            noise: 0.0,
            seed: 0,
            hand_mass: 0.1,
            hand_stiffness: 400.0,
            hand_damping: 20.0,
            aim_rate: 100.0,
            position: 0.0,
            largest_force: None,
            delay: 0,
            delay_seconds: 0.0,
            actuator: ActuatorParams::default(),
        }
    }
}

impl PointerParams {
    /// Returns the device of `scene` in a pointer's hand, with its mass, sensor, noise, motor, delay, lag, gain and
    /// initial position. A fraction of a period and the jitter of commands are omitted. Its friction is that of the
    /// scene, but at least that of [`default`](Self::default), so that a free device comes to rest.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let default = Self::default();
        Self {
            device_mass: scene.device.mass(),
            encoder_quantum: scene.device.encoder_quantum(),
            noise: scene.device.noise(),
            seed: scene.timing.seed,
            position: scene.device.position(),
            viscous_friction: scene
                .device
                .viscous_friction()
                .max(default.viscous_friction),
            dry_friction: scene.device.coulomb_friction().max(default.dry_friction),
            largest_force: scene.device.largest_force(),
            delay: scene.delay.whole_samples(),
            delay_seconds: scene.delay.seconds(),
            actuator: scene.actuator,
            ..default
        }
    }

    fn check(&self) -> Result<(), InvalidParameter> {
        let named = |name, value: f64, holds: bool, allowed| {
            if value.is_finite() && holds {
                Ok(())
            } else {
                Err(InvalidParameter {
                    name,
                    value,
                    allowed,
                })
            }
        };
        for (name, value, allowed) in [
            ("device_mass", self.device_mass, "finite and above 0 kg"),
            (
                "hand_stiffness",
                self.hand_stiffness,
                "finite and above 0 N/m",
            ),
            (
                "hand_damping",
                self.hand_damping,
                "finite and above 0 N s/m",
            ),
            ("aim_rate", self.aim_rate, "finite and above 0 rad/s"),
        ] {
            named(name, value, value > 0.0, allowed)?;
        }
        for (name, value, allowed) in [
            (
                "viscous_friction",
                self.viscous_friction,
                "finite and at least 0 N s/m",
            ),
            ("dry_friction", self.dry_friction, "finite and at least 0 N"),
            (
                "encoder_quantum",
                self.encoder_quantum,
                "finite and at least 0 m",
            ),
            ("hand_mass", self.hand_mass, "finite and at least 0 kg"),
        ] {
            named(name, value, value >= 0.0, allowed)?;
        }
        // Longest wait times this is how many spans one call may have to sum.
        named(
            "device_mass",
            self.device_mass,
            self.rate() <= 1e5,
            "heavy enough for stiffness and damping of the hand: no faster than 1e5 rad/s together",
        )?;
        if let Some(force) = self.largest_force {
            named("largest_force", force, force > 0.0, "finite and above 0 N")?;
        }
        let is_time = Duration::try_from_secs_f64(self.delay_seconds).is_ok();
        let allowed = "finite and at least 0 s";
        named("delay_seconds", self.delay_seconds, is_time, allowed)?;
        Actuator::new(self.actuator)?;
        named("position", self.position, true, "finite [m]")
    }

    /// Bound of the rates of the held device and of the hand's aim `[rad/s]`.
    fn rate(&self) -> f64 {
        let mass = self.device_mass + self.hand_mass;
        let damping = self.hand_damping + self.viscous_friction;
        (damping / mass + (self.hand_stiffness / mass).sqrt()).max(2.0 * self.aim_rate)
    }
}

/// Target position of a pointer's hand. Any thread may set it at any time without blocking. Clones share one hand, so
/// it can hold several devices.
#[derive(Clone, Debug)]
pub struct PointerHand(Arc<AtomicU64>);

/// A hand that holds nothing. No target has these bits: they are those of a NaN.
const LETS_GO: u64 = u64::MAX;

impl PointerHand {
    /// Creates a hand that holds its device at a target `[m]`.
    #[must_use]
    pub fn at(target: f64) -> Self {
        let hand = Self::free();
        hand.move_to(target);
        hand
    }

    /// A hand that holds nothing.
    #[must_use]
    pub fn free() -> Self {
        Self(Arc::new(AtomicU64::new(LETS_GO)))
    }

    /// Sets the target `[m]`, and grips the device again if the hand had released it. Non-finite targets are ignored.
    pub fn move_to(&self, target: f64) {
        if target.is_finite() {
            self.0.store(target.to_bits(), Ordering::Release);
        }
    }

    /// Lets go of the device.
    pub fn disable_output(&self) {
        self.0.store(LETS_GO, Ordering::Release);
    }

    /// Returns the target `[m]`; `None` if the hand has released the device.
    #[must_use]
    pub fn target(&self) -> Option<f64> {
        let bits = self.0.load(Ordering::Acquire);
        (bits != LETS_GO).then(|| f64::from_bits(bits))
    }
}

/// State of the device, with or without a hand.
#[derive(Clone, Debug)]
enum HeldOrFree {
    Held { target: f64, state: Held },
    Free(HeldMass),
}

/// Aim and device, each with its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    aim: f64,
    aim_velocity: f64,
    position: f64,
    velocity: f64,
}

/// A device in a [`PointerHand`]. Between two calls it moves exactly by the equations above, under the last written
/// force and towards the last target. A grip is smooth: the hand starts with the position and speed of the device.
#[derive(Clone, Debug)]
pub struct PointerDevice<C> {
    clock: C,
    capabilities: Capabilities,
    params: PointerParams,
    sampler: Sampler,
    noise: SensorNoise,
    hand: PointerHand,
    /// The device by itself.
    alone: HeldMass,
    motion: HeldOrFree,
    moved_until: Option<Duration>,
    /// Force on the device that the motor holds `[N]`.
    held: f64,
    /// Commands that do not act yet, the oldest first `[N]`.
    on_their_way: Vec<f64>,
    /// Time from a write to the beginning of its force, where that is not counted in writes.
    late: Duration,
    /// Forces that begin later, with the instant of each, oldest first.
    later: VecDeque<(Duration, f64)>,
    motor: Actuator,
    /// Force on the device that was sent last `[N]`.
    sent: f64,
    cut: Cut,
}

/// Largest simulated time between two calls; a longer pause is cut to it.
pub(super) const LONGEST: f64 = 10.0;

/// Terms of the series over a span of one radian: 1/24! is far below round-off.
const TERMS: usize = 24;

impl<C: Clock> PointerDevice<C> {
    /// A device in `hand`, on `clock`.
    ///
    /// # Errors
    /// A quantity outside its range.
    pub fn new(
        params: PointerParams,
        hand: &PointerHand,
        clock: C,
    ) -> Result<Self, InvalidParameter> {
        params.check()?;
        let alone = HeldMass::new(params.device_mass, Hand::pushing(0.0))?
            .with_friction(params.viscous_friction, params.dry_friction)?
            .starting_at(params.position, 0.0)?;
        Ok(Self {
            clock,
            capabilities: Capabilities {
                largest_force: params.largest_force,
                effective_mass: Some(params.device_mass),
                encoder_quantum: Some(params.encoder_quantum),
                ..Capabilities::unknown("pointer", 1)
            },
            sampler: if params.encoder_quantum > 0.0 {
                Sampler::quantum(params.encoder_quantum)?
            } else {
                Sampler::Ideal
            },
            noise: SensorNoise::normal(params.noise, params.seed)?,
            on_their_way: vec![0.0; params.delay],
            late: Duration::try_from_secs_f64(params.delay_seconds).unwrap_or_default(),
            later: VecDeque::with_capacity(MAX_LATER),
            motor: Actuator::new(params.actuator)?,
            params,
            hand: hand.clone(),
            motion: HeldOrFree::Free(alone.clone()),
            alone,
            moved_until: None,
            held: 0.0,
            sent: 0.0,
            cut: Cut::none(),
        })
    }

    /// True position `[m]`, at the last call.
    #[must_use]
    pub fn position(&self) -> f64 {
        match &self.motion {
            HeldOrFree::Held { state, .. } => state.position,
            HeldOrFree::Free(device) => device.position(),
        }
    }

    /// True velocity `[m/s]`, at the last call.
    #[must_use]
    pub fn velocity(&self) -> f64 {
        match &self.motion {
            HeldOrFree::Held { state, .. } => state.velocity,
            HeldOrFree::Free(device) => device.velocity(),
        }
    }

    /// Moves on to now, and returns that.
    fn move_on(&mut self) -> Duration {
        let now = self.clock.now();
        let mut from = *self.moved_until.get_or_insert(now);
        if let Some(cut) = self.cut.between(from, now) {
            self.hold(from, cut);
            self.held = 0.0;
            self.on_their_way.fill(0.0);
            self.later.clear();
            from = cut;
        }
        self.hold(from, now);
        self.moved_until = Some(now);
        self.look_at_hand();
        now
    }

    /// Moves under what is held, and under what begins on the way.
    fn hold(&mut self, mut from: Duration, until: Duration) {
        while let Some(&(begins, force)) = self.later.front()
            && begins <= until
        {
            self.advance(begins.saturating_sub(from));
            from = from.max(begins);
            self.held = force;
            self.later.pop_front();
        }
        self.advance(until.saturating_sub(from));
    }

    fn advance(&mut self, duration: Duration) {
        let duration = duration.as_secs_f64().min(LONGEST);
        // The testbed has the force on the object, which is the other one.
        match &mut self.motion {
            HeldOrFree::Held { target, state } => {
                let mut led = Led {
                    params: &self.params,
                    target: *target,
                    state,
                };
                self.motor.drive(&mut led, -self.held, duration);
            }
            HeldOrFree::Free(device) => {
                self.motor.drive(device, -self.held, duration);
            }
        }
    }

    /// Reads the hand's target.
    fn look_at_hand(&mut self) {
        let (position, velocity) = (self.position(), self.velocity());
        match (&mut self.motion, self.hand.target()) {
            (HeldOrFree::Held { target, .. }, Some(new)) => *target = new,
            (HeldOrFree::Free(_), Some(target)) => {
                self.motion = HeldOrFree::Held {
                    target,
                    state: Held {
                        aim: position,
                        aim_velocity: velocity,
                        position,
                        velocity,
                    },
                };
            }
            (HeldOrFree::Held { .. }, None) => {
                // A non-finite force has produced an invalid state: restart the device at its initial position.
                let alone = self.alone.clone().starting_at(position, velocity);
                self.motion = HeldOrFree::Free(alone.unwrap_or_else(|_| self.alone.clone()));
            }
            (HeldOrFree::Free(_), None) => {}
        }
    }
}

/// A held device that moves under its motor.
struct Led<'a> {
    params: &'a PointerParams,
    target: f64,
    state: &'a mut Held,
}

impl Moved for Led<'_> {
    fn position(&self) -> f64 {
        self.state.position
    }

    fn velocity(&self) -> f64 {
        self.state.velocity
    }

    /// The returned work is unused, so it is not computed.
    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        self.state
            .advance(self.params, self.target, -force_on_object, duration);
        0.0
    }

    fn stored_energy(&self) -> f64 {
        0.0
    }
}

impl Held {
    /// Moves on for `duration` `[s]` under `force` on the device `[N]`: the equations are linear, so
    /// their power series in time is summed, over spans of a radian of the fastest rate at most.
    fn advance(&mut self, params: &PointerParams, target: f64, force: f64, duration: f64) {
        let longest = 1.0 / params.rate();
        let mut remaining = duration;
        while remaining > 0.0 {
            let span = remaining.min(longest);
            self.follow(params, target, force, span);
            remaining -= span;
        }
    }

    fn follow(&mut self, params: &PointerParams, target: f64, force: f64, span: f64) {
        let rate = params.aim_rate;
        let mass = params.device_mass + params.hand_mass;
        // The excitation is constant, so it appears in the second term only.
        let (mut pull, mut push) = (rate * rate * target, force);
        let mut term = *self;
        for order in 1..TERMS {
            let step = span / order as f64;
            let aim_acceleration = pull - rate * (rate * term.aim + 2.0 * term.aim_velocity);
            let by_hand = params.hand_stiffness * (term.aim - term.position)
                + params.hand_damping * (term.aim_velocity - term.velocity);
            let by_friction = -params.viscous_friction * term.velocity;
            term = Self {
                aim: step * term.aim_velocity,
                aim_velocity: step * aim_acceleration,
                position: step * term.velocity,
                velocity: step * (by_hand + by_friction + push) / mass,
            };
            (pull, push) = (0.0, 0.0);
            self.aim += term.aim;
            self.aim_velocity += term.aim_velocity;
            self.position += term.position;
            self.velocity += term.velocity;
        }
    }
}

impl<C: Clock> Device for PointerDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let time = self.move_on();
        let position = noisy(self.position(), self.noise.draw());
        Ok(Pose {
            orientation: None,
            position: [self.sampler.sample(position), 0.0, 0.0],
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let now = self.move_on();
        self.cut.is_over();
        let [mut force, ..] = wrench.force;
        if let Some(limit) = self.params.largest_force {
            force = force.clamp(-limit, limit);
        }
        self.sent = force;
        if self.late > Duration::ZERO {
            if self.later.len() == MAX_LATER {
                self.later.pop_front();
            }
            self.later.push_back((now + self.late, force));
            return Ok([self.held, 0.0, 0.0].into());
        }
        if let Some(oldest) = self.on_their_way.first().copied() {
            self.on_their_way.rotate_left(1);
            if let Some(newest) = self.on_their_way.last_mut() {
                *newest = force;
            }
            force = oldest;
        }
        self.held = force;
        Ok([force, 0.0, 0.0].into())
    }

    fn last_sent(&self) -> Option<Line> {
        Some(Wrench::of_force([self.sent, 0.0, 0.0]).into())
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        Some(self.cut.writer(&self.clock))
    }
}

#[cfg(test)]
#[path = "pointer_tests.rs"]
mod tests;

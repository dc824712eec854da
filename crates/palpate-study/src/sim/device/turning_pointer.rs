//! Rotation of a six-axis device in a pointer's hand.
//!
//! L' = tau - k phi - b omega about the mass centre: phi is the rotation vector from the hand's aim to the tool. The
//! aim follows the hand's target at a finite rate, because a pointer's target jumps. For a free device only b remains.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{Cut, Vector, ZeroWriter};
use palpate_scene::world::{DeviceTurning, WorldTiming};
use palpate_testbed::InvalidParameter;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::world::{HeldTurning, TurningHand};

use super::pointer::LONGEST;
use crate::sim::world::reference_turning;

/// An orientation, `[w, x, y, z]`.
type Quaternion = [f64; 4];

/// Most torques that begin later: those of the longest delay that a scene can state.
const MAX_LATER: usize = DelayedHold::LONGEST_DELAY + 1;
/// Rate at which the aim follows the hand's wish `[1/s]`.
const AIM_RATE: f64 = 50.0;
/// Stiffness of a hand that the scene gives none `[N m/rad]`.
const STIFFNESS: f64 = 0.3;
/// Damping of a hand that the scene gives none, over that of the aperiodic limit.
const DAMPING: f64 = 0.7;
/// Rate of a default hand, relative to the fastest that is allowed: a slender tool is held more softly.
const OWN_RATE: f64 = 0.25;

/// Target orientation of a pointer's hand; any thread may set it at any time.
#[derive(Clone, Debug)]
pub(super) struct TurningWish(Arc<[AtomicU64; 4]>);

impl TurningWish {
    /// The initial orientation of the device.
    pub fn none() -> Self {
        let unknown = || AtomicU64::new(f64::NAN.to_bits());
        Self(Arc::new([unknown(), unknown(), unknown(), unknown()]))
    }

    /// Sets the target orientation. Quaternions without a direction are ignored.
    pub fn turn_to(&self, orientation: Quaternion) {
        let length = orientation
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt();
        if length > 0.0 && length.is_finite() {
            for (own, part) in self.0.iter().zip(orientation) {
                own.store((part / length).to_bits(), Ordering::Release);
            }
        }
    }

    /// Wants it as it begins.
    pub fn forget(&self) {
        for own in &*self.0 {
            own.store(f64::NAN.to_bits(), Ordering::Release);
        }
    }

    /// `None`: as the device begins. Read while it is written, parts may be of two wishes, which follow each other
    /// within a sixtieth of a second: a quaternion between the two, or of a device that is as it was.
    pub fn get(&self) -> Option<Quaternion> {
        let parts = [0, 1, 2, 3].map(|k: usize| f64::from_bits(self.0[k].load(Ordering::Acquire)));
        let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        (length > 0.5).then(|| parts.map(|part| part / length))
    }
}

/// The rotation of a device in a hand, moved by the time that passes on the loop's clock.
#[derive(Clone, Debug)]
pub(super) struct TurningPointer<C> {
    clock: C,
    turning: HeldTurning,
    /// Initial orientation.
    start: Quaternion,
    wish: TurningWish,
    /// Filtered orientation that the hand pulls towards.
    aim: Quaternion,
    /// Whether the hand held it at the last call.
    is_held: bool,
    moved_until: Option<Duration>,
    /// Torque that the motors hold `[N m]`.
    held: Vector,
    /// Last written torque `[N m]`.
    written: Vector,
    late: Duration,
    /// Torques that begin later, with the instant of each, oldest first.
    later: VecDeque<(Duration, Vector)>,
    cut: Cut,
}

impl<C: Clock> TurningPointer<C> {
    /// Creates the device of a world, with its sensor, motors and initial state. A hand without a stiffness in the
    /// scene gets a default one.
    pub fn new(
        device: &DeviceTurning,
        timing: &WorldTiming,
        wish: &TurningWish,
        clock: C,
    ) -> Result<Self, InvalidParameter> {
        let mut turning = reference_turning(device);
        let hand = &mut turning.hand;
        // The wish is in place of the scene's torque, tremor and rest.
        *hand = TurningHand {
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: turning.orientation,
            ..TurningHand::none()
        };
        if hand.stiffness == 0.0 {
            (hand.stiffness, hand.damping) = own_hand(turning.inertia);
        }
        Ok(Self {
            clock,
            start: turning.orientation,
            aim: turning.orientation,
            is_held: false,
            wish: wish.clone(),
            turning: HeldTurning::checked(&turning, timing.actuator)?,
            moved_until: None,
            held: [0.0; 3],
            written: [0.0; 3],
            late: Duration::try_from_secs_f64(timing.device_delay()).unwrap_or_default(),
            later: VecDeque::with_capacity(MAX_LATER),
            cut: Cut::none(),
        })
    }

    /// Advances to the present time, in the hand or as a free device, and returns the measured orientation.
    pub fn read(&mut self, is_held: bool) -> Quaternion {
        self.move_on(is_held);
        self.turning.measured()
    }

    /// Holds a torque `[N m]`; what is held from now on.
    pub fn write(&mut self, torque: Vector, is_held: bool) -> Vector {
        let now = self.move_on(is_held);
        self.cut.is_over();
        self.written = torque;
        if self.late > Duration::ZERO {
            if self.later.len() == MAX_LATER {
                self.later.pop_front();
            }
            self.later.push_back((now + self.late, torque));
        } else {
            self.held = torque;
        }
        self.held
    }

    pub fn last_sent(&self) -> Vector {
        self.written
    }

    pub fn zero_writer(&mut self) -> Box<dyn ZeroWriter> {
        self.cut.writer(&self.clock)
    }

    fn move_on(&mut self, is_held: bool) -> Duration {
        let now = self.clock.now();
        let mut from = *self.moved_until.get_or_insert(now);
        self.follow(now.saturating_sub(from).as_secs_f64(), is_held);
        if let Some(cut) = self.cut.between(from, now) {
            self.hold(from, cut);
            self.held = [0.0; 3];
            self.later.clear();
            from = cut;
        }
        self.hold(from, now);
        self.moved_until = Some(now);
        now
    }

    /// The hand aims nearer to its wish. It takes hold of the device as it finds it: without a jolt.
    fn follow(&mut self, passed: f64, is_held: bool) {
        if is_held && !self.is_held {
            self.aim = self.turning.orientation();
        }
        self.is_held = is_held;
        if is_held {
            let wish = self.wish.get().unwrap_or(self.start);
            let share = 1.0 - (-AIM_RATE * passed).exp();
            self.aim = between(self.aim, wish, share);
            self.turning.aim_at(self.aim);
        }
        self.turning.hold(is_held);
    }

    fn hold(&mut self, mut from: Duration, until: Duration) {
        while let Some(&(begins, torque)) = self.later.front()
            && begins <= until
        {
            self.advance(begins.saturating_sub(from));
            from = from.max(begins);
            self.held = torque;
            self.later.pop_front();
        }
        self.advance(until.saturating_sub(from));
    }

    fn advance(&mut self, duration: Duration) {
        let duration = duration.as_secs_f64().min(LONGEST);
        if duration > 0.0 {
            let _ = self.turning.advance(self.held, duration);
        }
    }
}

/// Stiffness `[N m/rad]` and damping `[N m s/rad]` of a hand for a device that the scene gives none.
fn own_hand(inertia: Vector) -> (f64, f64) {
    let least = inertia.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let most = inertia.iter().fold(0.0_f64, |a, b| a.max(*b));
    let fastest = OWN_RATE * HeldTurning::FASTEST;
    let stiffness = STIFFNESS.min(fastest * fastest * least);
    let aperiodic = 2.0 * (stiffness * most).sqrt();
    (stiffness, (DAMPING * aperiodic).min(fastest * least))
}

/// An orientation on the way from one to the other, by the shorter way round.
fn between(from: Quaternion, to: Quaternion, share: f64) -> Quaternion {
    let cosine: f64 = from.iter().zip(to).map(|(one, other)| one * other).sum();
    let side = if cosine < 0.0 { -1.0 } else { 1.0 };
    let mut mixed = [0.0; 4];
    for (mixed, (from, to)) in mixed.iter_mut().zip(from.iter().zip(to)) {
        *mixed = from + share * (side * to - from);
    }
    let length = mixed.iter().map(|part| part * part).sum::<f64>().sqrt();
    mixed.map(|part| part / length)
}

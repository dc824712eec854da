//! State of a renderer between ticks.

use crate::Scalar;
use crate::actuator::UnderWay;
use crate::energy::Ledger;
use crate::guard::GuardMemory;
use crate::motion::{Displacement, ObjectMotion, ObjectState, Rule, Start};

/// State of one rendered contact. It is small and `Copy`, so a program can save, restore and move it between threads.
/// [`Renderer::start`](super::Renderer::start) creates it, and only that renderer changes it.
#[derive(Clone, Copy, Debug)]
pub struct State<S, Memory> {
    /// The object at the last sample, in canonical coordinates.
    pub(super) object: ObjectState<S>,
    pub(super) device: DeviceTrack<S>,
    /// Object state to set at the next sample.
    pub(super) teleport: Option<ObjectState<S>>,
    /// Force commanded at the last sample `[N]`.
    pub(super) commanded: S,
    /// Slope commanded at the last sample `[N/s]`.
    pub(super) commanded_slope: S,
    pub(super) under_way: UnderWay<S>,
    pub(super) memory: Memory,
    pub(super) ledger: Ledger<S>,
    pub(super) guard: GuardMemory<S>,
    /// Whether a first sample has opened the energy ledger.
    opened: bool,
}

/// Information on the device.
#[derive(Clone, Copy, Debug)]
pub(super) enum DeviceTrack<S> {
    /// No sample yet.
    Unknown,
    /// The last sample began this interval.
    Tracked(Interval<S>),
    /// A sample was rejected.
    Lost(Traces<S>),
}

/// Last positions of a device that is not tracked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traces<S> {
    /// Position of the last sample `[m]`, if it was finite.
    pub seen: Option<S>,
    /// Position of the last accepted sample `[m]`, if there was one.
    pub trusted: Option<S>,
    /// Time from that sample to the last one `[s]`; each rejected sample counts as one period.
    pub since: S,
}

impl<S: Scalar> Traces<S> {
    /// Returns whether a device found at `device` `[m]`, `elapsed` `[s]` after the last sample, can have moved there at
    /// most at `speed` `[m/s]`: from its last position, or from the last accepted one in case the last position was a
    /// glitch.
    pub fn lead_to(&self, device: S, elapsed: S, speed: S) -> bool {
        let near = |from: S, time: S| (device - from).abs() <= speed * time;
        match (self.seen, self.trusted) {
            (None, None) => true,
            (seen, trusted) => {
                seen.is_some_and(|from| near(from, elapsed))
                    || trusted.is_some_and(|from| near(from, self.since + elapsed))
            }
        }
    }
}

/// Interval in progress, as planned at its first sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval<S> {
    pub start: Start<S>,
    /// Device position xi_i `[m]`.
    pub device: S,
    pub rule: Rule<S>,
    /// Displacement by the rule over a nominal period.
    pub planned: Displacement<S>,
    /// K p_i, or 0 `[N]`.
    pub original_force: S,
    /// Reported mean force over the interval `[N]`.
    pub reported: Option<S>,
}

impl<S: Scalar, Memory: Default> State<S, Memory> {
    pub(super) fn new(object: ObjectState<S>) -> Self {
        Self {
            object,
            device: DeviceTrack::Unknown,
            teleport: None,
            commanded: S::ZERO,
            commanded_slope: S::ZERO,
            under_way: UnderWay::nothing(),
            memory: Memory::default(),
            ledger: Ledger::default(),
            guard: GuardMemory::new(),
            opened: false,
        }
    }

    /// Clears the method's memory of past forces and of the device, for a state that another method is to
    /// [`adopt`](super::Renderer::adopt): the memory of the old method does not describe the interval in progress. The
    /// object, its plan and the ledger are unchanged.
    pub fn forget_past(&mut self) {
        self.memory = Memory::default();
    }

    /// Returns the method's memory.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Returns the energy ledger of the object up to the last sample.
    pub fn ledger(&self) -> &Ledger<S> {
        &self.ledger
    }

    /// Records the stored energy of a contact that restarts: opens the ledger, or records the change while the contact
    /// was not tracked. Returns false, without effect, if the energy or a ledger entry would not be finite.
    #[must_use]
    pub(super) fn account_for(&mut self, stored: S) -> bool {
        if !stored.is_finite() {
            return false;
        }
        if !self.opened {
            self.ledger = Ledger::open(stored);
            self.opened = true;
        } else if !self.ledger.change_from_outside(stored) {
            return false;
        }
        true
    }

    /// Records a device position `[m]`, or none, from an unusable sample. The object completes its interval as planned,
    /// then waits. It stays at the beginning of the interval if it is a wall or the plan's energy is not finite. A
    /// position that is not trusted moves no energy, so nothing is recorded; the next contact accounts for the whole
    /// change.
    pub(super) fn lose_track(&mut self, motion: &ObjectMotion<S>, position: Option<S>) {
        let mut traces = Traces {
            seen: position,
            trusted: None,
            since: motion.period(),
        };
        if let DeviceTrack::Lost(before) = &self.device {
            traces.trusted = before.trusted;
            traces.since += before.since;
        }
        if let DeviceTrack::Tracked(interval) = &self.device {
            traces.trusted = Some(interval.device);
            let finished = ObjectState {
                position: self.object.position + interval.planned.by,
                velocity: interval.planned.velocity,
            };
            let kinetic_energy = motion.stored_energy(S::ZERO, finished.velocity);
            let finite = finished.position.is_finite() && kinetic_energy.is_finite();
            if finite && !motion.is_wall() {
                self.object = finished;
            }
        }
        self.device = DeviceTrack::Lost(traces);
        self.commanded = S::ZERO;
        self.commanded_slope = S::ZERO;
    }
}

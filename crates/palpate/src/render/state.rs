//! What a renderer remembers from one tick to the next.

use crate::Scalar;
use crate::actuator::UnderWay;
use crate::energy::Ledger;
use crate::motion::{Displacement, ObjectMotion, ObjectState, Rule, Start};

/// The state of one rendered contact: small and `Copy`, so it can be saved, restored, and moved
/// between threads at will. It is made by [`Renderer::start`](super::Renderer::start) and changed
/// by that renderer only.
#[derive(Clone, Copy, Debug)]
pub struct State<S, Memory> {
    /// The object at the last sample, on the canonical side.
    pub(super) object: ObjectState<S>,
    pub(super) device: DeviceTrack<S>,
    /// Where the object is to be put with the next sample.
    pub(super) teleport: Option<ObjectState<S>>,
    /// Force commanded at the last sample `[N]`.
    pub(super) commanded: S,
    pub(super) under_way: UnderWay<S>,
    pub(super) memory: Memory,
    pub(super) ledger: Ledger<S>,
    /// Whether the books have been opened by a first sample.
    opened: bool,
}

/// What is known of the device.
#[derive(Clone, Copy, Debug)]
pub(super) enum DeviceTrack<S> {
    /// Nothing yet.
    Unknown,
    /// Its last sample began this interval.
    Tracked(Interval<S>),
    /// A sample was refused.
    Lost(Traces<S>),
}

/// Where a device that is not followed has been.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traces<S> {
    /// Position of the last sample `[m]`, if it was a number.
    pub seen: Option<S>,
    /// Position of the last sample that was used `[m]`, if there was one.
    pub trusted: Option<S>,
    /// Time from that one to the last `[s]`, refused samples counted as one period each.
    pub since: S,
}

impl<S: Scalar> Traces<S> {
    /// Whether a device found at `device` `[m]`, `elapsed` `[s]` after the last sample, can have
    /// come there no faster than `speed` `[m/s]`: from where it was seen last, or, should that
    /// have been a glitch, from where it was before.
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

/// The interval in progress, as planned at its first sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval<S> {
    pub start: Start<S>,
    /// Device position xi_i `[m]`.
    pub device: S,
    pub rule: Rule<S>,
    /// What the rule does over a nominal period.
    pub planned: Displacement<S>,
    /// K p_i, or 0 `[N]`.
    pub original_force: S,
    /// Force that was held over it by what somebody else says `[N]`.
    pub reported: Option<S>,
}

impl<S: Scalar, Memory: Default> State<S, Memory> {
    pub(super) fn new(object: ObjectState<S>) -> Self {
        Self {
            object,
            device: DeviceTrack::Unknown,
            teleport: None,
            commanded: S::ZERO,
            under_way: UnderWay::nothing(),
            memory: Memory::default(),
            ledger: Ledger::default(),
            opened: false,
        }
    }

    /// Forgets what the method remembers of past forces and of the device, for a state that another
    /// method is to [`adopt`](super::Renderer::adopt): what its own method remembered does not
    /// describe the interval in progress. The object, its plan and the books stay.
    pub fn forget_past(&mut self) {
        self.memory = Memory::default();
    }

    /// What the method remembers.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Books of the object's energy, up to the last sample.
    pub fn ledger(&self) -> &Ledger<S> {
        &self.ledger
    }

    /// Takes the stored energy of a contact that begins anew: opens the books, or books what
    /// changed while the contact was not followed. False, and nothing changed, if the energy is
    /// not a finite number or an entry of the books would not be.
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

    /// The device was found at `position` `[m]`, or nowhere, by a sample that is not to be used.
    /// The object finishes the interval it is in as planned, then waits; it stays where the
    /// interval began if it is a wall, or the plan's energy is not a finite number. A position that is not trusted
    /// moves no energy, so nothing is booked: the next contact accounts for it all.
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
    }
}

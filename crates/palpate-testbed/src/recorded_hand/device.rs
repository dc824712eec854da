//! A device in a recorded hand, under a force that differs from the recorded one.
//!
//! The recorded force produced the recorded motion x̂. Under another force the device deviates from that motion by d,
//! and the hand's own force cancels:
//!
//! ```text
//! m d″ = f_recorded − f − k_h d − b_h d′        (forces on the object)
//! ```
//!
//! Errors in the estimated hand force therefore do not accumulate: they shift the device by at most as much as they
//! shift x̂.

use std::sync::Arc;

use crate::InvalidParameter;
use crate::device::{DevicePlant, PointMass};
use crate::hand::{Hand, Intention};
use crate::held_mass::HeldMass;

use super::RecordedHand;

/// A device in a recorded hand, on the canonical side.
#[derive(Clone, Debug)]
pub struct HeldByRecording {
    hand: Arc<RecordedHand>,
    sign: f64,
    /// The interval of the recording.
    piece: usize,
    /// Since the first sample `[s]`.
    time: f64,
    departure: Departure,
}

/// Deviation of the device from its recorded motion, as a separate mass.
#[derive(Clone, Debug)]
enum Departure {
    /// The hand does not pull the device back.
    Free(PointMass),
    /// The hand holds on to the recorded motion.
    Held(Box<HeldMass>),
}

impl Departure {
    fn new(hand: &RecordedHand) -> Result<Self, InvalidParameter> {
        let model = hand.model();
        if model.stiffness == 0.0 && model.damping == 0.0 {
            return PointMass::new(model.device_mass, 0.0).map(Self::Free);
        }
        let holds_on = Hand::Impedance {
            mass: 0.0,
            stiffness: model.stiffness,
            damping: model.damping,
            intention: Intention::constant(0.0),
            force: 0.0,
            tremor: None,
        };
        HeldMass::new(model.device_mass, holds_on).map(|held| Self::Held(Box::new(held)))
    }

    fn device(&self) -> &dyn DevicePlant {
        match self {
            Self::Free(device) => device,
            Self::Held(device) => &**device,
        }
    }
}

impl HeldByRecording {
    /// The device at the start of the recording; `sign` mirrors it to the canonical side.
    pub fn new(hand: Arc<RecordedHand>, sign: f64) -> Result<Self, InvalidParameter> {
        Ok(Self {
            departure: Departure::new(&hand)?,
            hand,
            sign,
            piece: 0,
            time: 0.0,
        })
    }

    /// The recorded motion now, position `[m]` and velocity `[m/s]`.
    fn recorded(&self) -> (f64, f64) {
        let (position, velocity, _) = self
            .hand
            .along(self.piece, self.time - self.hand.start_of(self.piece));
        (self.sign * position, self.sign * velocity)
    }
}

impl DevicePlant for HeldByRecording {
    fn position(&self) -> f64 {
        self.recorded().0 + self.departure.device().position()
    }

    fn velocity(&self) -> f64 {
        self.recorded().1 + self.departure.device().velocity()
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let before = self.position();
        let end = self.time + duration;
        while self.time < end {
            let bend = self.hand.end_of(self.piece);
            let until = bend.min(end);
            // Cancel the recorded motor force, which no longer acts.
            let force = force_on_object + self.sign * self.hand.held_force(self.piece);
            match &mut self.departure {
                Departure::Free(device) => device.advance(force, until - self.time),
                Departure::Held(device) => device.advance(force, until - self.time),
            };
            self.time = until;
            if until == bend {
                self.piece += 1;
            }
        }
        // The force is held, so the integral of power is force times travel.
        force_on_object * (self.position() - before)
    }

    /// m x′²/2 `[J]`; what the hand stores is not known.
    fn stored_energy(&self) -> f64 {
        let velocity = self.velocity();
        0.5 * self.hand.model().device_mass * velocity * velocity
    }
}

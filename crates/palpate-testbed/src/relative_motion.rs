//! The relative motion of device and object, in closed form over any number of collisions.
//!
//! ```text
//! p″ = a − ω² p h(p),    f = K p h(p),    ω² = K y
//! ```
//!
//! `h` is the unit step, `a` the relative acceleration without contact and `y` the sum of the
//! inverse masses that yield: 1/m + 1/M for a free device and a free object, 1/m before a wall,
//! 1/M when the device follows a prescribed straight path, 0 when neither yields. The motion is a
//! parabola while free and a harmonic while in contact; the instants in between are roots in closed
//! form.
//!
//! **This deliberately duplicates a closed form of the renderers' crate.** The coupled renderer predicts with the same
//! equation. If both called one function, an error in it would appear as agreement.
//!
//! # Roots
//!
//! Multiplied by p′, the equation has an integral. The speed r at which the motion will pass p = 0 is therefore known
//! before the instant, and a pass with r = 0 (grazing) is not an event. While free, the instant solves
//! p + v s + a s²/2 = 0. In contact the substitution y = 2 tan(ωs/2)/ω turns the harmonic into the same quadratic with
//! a − ω²p/2 in place of a; `atan2` then gives the half angle in the right half turn. Both quadratics avoid differences
//! of nearly equal numbers, so no iterative refinement is necessary, and ω → 0 needs no special case.

use std::f64::consts::PI;

use crate::InvalidParameter;
use crate::arc::Arc;
use crate::error::{finite, positive};
use crate::grid::Grid;
use crate::profile::{Collision, ForceProfile};

/// Most half oscillations of the contact that one call follows.
///
/// A contact that the motion comes back to lasts at least half an oscillation, so this bounds the
/// number of collisions, the memory for them, and the work.
const MAX_HALF_OSCILLATIONS: f64 = 1e7;

/// Penetration and its rate: the state of the relative motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RelativeState {
    /// Penetration p = ξ − η `[m]`, positive in contact.
    pub penetration: f64,
    /// Its rate p′ = ξ′ − η′ `[m/s]`, positive while device and object approach.
    pub velocity: f64,
}

/// Result of the relative motion over a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// State at the end of the step.
    pub state: RelativeState,
    /// Impulse J = ∫ f dt of the contact force `[N s]`.
    pub impulse: f64,
    /// ∫ f² dt `[N² s]`.
    pub squared_force: f64,
    /// The collisions of the step, in order; times are counted from the start of the step.
    pub collisions: Vec<Collision>,
}

/// The parameters of a relative motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeMotion {
    /// K `[N/m]`
    pub(crate) stiffness: f64,
    /// ω `[rad/s]`
    pub(crate) rate: f64,
    /// a `[m/s²]`
    pub(crate) acceleration: f64,
}

impl RelativeMotion {
    /// Relative motion for a contact `stiffness` K `[N/m]`, a `mobility` y `[1/kg]` and a relative
    /// `acceleration` a `[m/s²]` without contact, positive towards contact.
    ///
    /// # Errors
    ///
    /// `stiffness` is not finite and positive, `mobility` is not finite and at least 0, or
    /// `acceleration` is not finite.
    pub fn new(stiffness: f64, mobility: f64, acceleration: f64) -> Result<Self, InvalidParameter> {
        positive("stiffness", stiffness, "finite and above 0 N/m")?;
        InvalidParameter::unless(
            mobility >= 0.0 && (stiffness * mobility).is_finite(),
            "mobility",
            mobility,
            "at least 0 1/kg, and finite when multiplied by the stiffness",
        )?;
        Ok(Self {
            stiffness,
            rate: (stiffness * mobility).sqrt(),
            acceleration: finite("acceleration", acceleration, "finite [m/s²]")?,
        })
    }

    /// Moves on from `state` over `duration` `[s]`, however long and through however many
    /// collisions.
    ///
    /// # Errors
    ///
    /// `duration` is negative or not finite, holds more than 10⁷ half oscillations of the contact,
    /// or `state` is not finite.
    pub fn over(&self, state: RelativeState, duration: f64) -> Result<Passage, InvalidParameter> {
        finite("penetration", state.penetration, "finite [m]")?;
        finite("velocity", state.velocity, "finite [m/s]")?;
        InvalidParameter::unless(duration >= 0.0, "duration", duration, "at least 0 s")?;
        let arcs = self.arcs(state, 0.0, duration)?;
        let profile = ForceProfile::from_arcs(&arcs, Grid::even(0.0, duration, 1));
        Ok(Passage {
            state: arcs.last().map_or(state, |arc| arc.state(duration)),
            impulse: profile.impulses()[0],
            squared_force: profile.squared_forces()[0],
            collisions: profile.collisions().to_vec(),
        })
    }

    /// All arcs from `start` to `end`, the last one cut at `end`.
    pub(crate) fn arcs(
        &self,
        state: RelativeState,
        start: f64,
        end: f64,
    ) -> Result<Vec<Arc>, InvalidParameter> {
        self.affords(end - start)?;
        let mut arcs = vec![self.arc(state, start)];
        while let Some(last) = arcs.last_mut() {
            if last.end >= end {
                last.end = end;
                break;
            }
            let next = self.arc(last.at_end, last.end);
            arcs.push(next);
        }
        Ok(arcs)
    }

    /// Refuses a duration that holds too many oscillations to follow one by one.
    pub(crate) fn affords(&self, duration: f64) -> Result<(), InvalidParameter> {
        InvalidParameter::unless(
            duration.is_finite() && duration * self.rate <= PI * MAX_HALF_OSCILLATIONS,
            "duration",
            duration,
            "finite, and at most 1e7 half oscillations of the contact",
        )
        .map(|_| ())
    }

    /// Returns the arc that contains the instant `time`, for a motion in `state` at time 0.
    ///
    /// After the motion has left a contact and returned, it is periodic, so whole cycles are skipped: the cost does not
    /// depend on `time`.
    pub(crate) fn arc_at(&self, state: RelativeState, time: f64) -> Arc {
        let head = self.arc(state, 0.0);
        if time <= head.end {
            return head;
        }
        // At most one free arc before the first contact that begins at the surface.
        let mut contact = self.arc(head.at_end, head.end);
        if !contact.in_contact && contact.end < time {
            contact = self.arc(contact.at_end, contact.end);
        }
        if time <= contact.end {
            return contact;
        }
        let flight = self.arc(contact.at_end, contact.end);
        let cycles = ((time - contact.start) / (flight.end - contact.start)).floor();
        if cycles < 1.0 {
            return flight;
        }
        let again = contact.delayed(cycles * (flight.end - contact.start));
        if again.end < time {
            self.arc(again.at_end, again.end)
        } else {
            again
        }
    }

    /// The end `[s]` of the n-th contact (counted from 1), for a motion in `state` at time 0.
    pub(crate) fn end_of_contact(&self, state: RelativeState, n: usize) -> Option<f64> {
        let head = self.arc(state, 0.0);
        let first = if head.in_contact {
            head
        } else {
            head.end
                .is_finite()
                .then(|| self.arc(head.at_end, head.end))?
        };
        let repeats = n.checked_sub(1)?;
        if repeats == 0 || !first.end.is_finite() {
            return Some(first.end).filter(|end| end.is_finite());
        }
        let flight = self.arc(first.at_end, first.end);
        if !flight.end.is_finite() {
            return None;
        }
        let second = self.arc(flight.at_end, flight.end);
        let cycle = second.end - first.end;
        Some(first.end + repeats as f64 * cycle).filter(|end| end.is_finite())
    }

    /// The arc that begins in `state` at `start`.
    fn arc(&self, state: RelativeState, start: f64) -> Arc {
        let RelativeState {
            penetration: p,
            velocity: v,
        } = state;
        let a = self.acceleration;
        let in_contact = p > 0.0 || (p == 0.0 && (v > 0.0 || (v == 0.0 && a > 0.0)));
        let exit = if in_contact {
            self.release(p, v)
        } else {
            self.touch(p, v)
        };
        let (duration, passing_speed) = exit.unwrap_or((f64::INFINITY, 0.0));
        Arc {
            motion: *self,
            start,
            end: start + duration,
            in_contact,
            at_start: state,
            at_end: RelativeState {
                penetration: 0.0,
                velocity: if in_contact {
                    -passing_speed
                } else {
                    passing_speed
                },
            },
        }
    }

    /// Returns the time until a free motion from p ≤ 0 touches, and its speed at that instant.
    fn touch(&self, p: f64, v: f64) -> Option<(f64, f64)> {
        let a = self.acceleration;
        if a > 0.0 {
            // v² − 2 a p as a sum of squares: it cannot vanish by underflow.
            let r = v.hypot((2.0 * a).sqrt() * (-p).sqrt());
            let s = if v < 0.0 {
                (r - v) / a
            } else {
                -2.0 * p / (v + r)
            };
            Some((s, r))
        } else {
            let squared = v * v - 2.0 * a * p;
            (v > 0.0 && squared > 0.0).then(|| {
                let r = squared.sqrt();
                (-2.0 * p / (v + r), r)
            })
        }
    }

    /// Returns the time until a contact from p ≥ 0 releases, and its speed at that instant.
    fn release(&self, p: f64, v: f64) -> Option<(f64, f64)> {
        let (a, w) = (self.acceleration, self.rate);
        let r = if p == 0.0 {
            v.abs()
        } else {
            let squared = v * v + p * (w * w * p - 2.0 * a);
            if squared > 0.0 { squared.sqrt() } else { 0.0 }
        };
        if r <= 0.0 {
            return None;
        }
        // y = numerator / denominator is the root at which the motion passes downwards.
        let (numerator, denominator) = if v < 0.0 {
            (2.0 * p, r - v)
        } else {
            (r + v, 0.5 * w * w * p - a)
        };
        if w > 0.0 {
            let half_angle = (0.5 * w * numerator).atan2(denominator);
            Some((2.0 * half_angle / w, r))
        } else {
            (denominator > 0.0).then(|| (numerator / denominator, r))
        }
    }
}

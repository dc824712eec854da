//! Safety between renderer and device: what a renderer asks for passes through here, always.
//!
//! Limits shape a force that is asked for; a trip replaces it by none. Trips on what passes by
//! itself (a sample that is missing, a number that is none) end when it has passed, and the force
//! comes back softly. Trips on what does not (the device has left its box, the loop makes energy)
//! stay until somebody rearms, and so does one on recoveries that come too often.

mod oscillation;
mod params;
mod recoveries;
mod supervisor;
mod trip;

pub use oscillation::OscillationParams;
pub use params::{SafetyError, SafetyParams};
pub use recoveries::RecoveryParams;
pub use supervisor::{Heartbeat, Supervisor};
pub use trip::Trip;

use std::time::Duration;

use oscillation::Oscillation;
use palpate::Actuation;
use palpate_device::{Vector, Wrench};
use recoveries::Recoveries;

/// Limits that changed a wrench on its way to the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounded {
    /// Its force or its torque exceeded the largest one.
    pub force: bool,
    /// It changed faster than the slew limit.
    pub slew: bool,
    /// It was still coming back after a start or a trip.
    pub soft_start: bool,
    /// A safety stop that stays holds the force at 0.
    pub stopped: bool,
}

impl Bounded {
    /// Whether any limit changed a force. A safety stop is no limit.
    #[must_use]
    pub fn any(self) -> bool {
        self.force || self.slew || self.soft_start
    }
}

/// A fresh sample and what the renderer made of it.
#[derive(Clone, Copy, Debug)]
pub struct Rendered {
    /// Time since the last fresh sample `[s]`; `None` for the first.
    pub elapsed: Option<f64>,
    /// Position of the end-point `[m]`.
    pub position: Vector,
    /// The same along the contact's axis `[m]`.
    pub coordinate: f64,
    /// Force and torque on the device that are asked for.
    pub wrench: Wrench,
    /// Energy that held forces have created so far: the ledger's accumulated leak `[J]`.
    pub created_energy: f64,
    /// Whether the renderer refused the sample, and so asks for no force.
    pub refused: bool,
    /// Whether the loop stood still before this sample.
    pub stalled: bool,
}

/// What is to be commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Force and torque on the device; finite whatever was asked for.
    pub wrench: Wrench,
    /// Limits that changed it.
    pub bounded: Bounded,
    /// A trip that began with this sample.
    pub tripped: Option<Trip>,
    /// A trip that ended with this sample.
    pub recovered: Option<Trip>,
}

/// What a look at a sample has found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Looked {
    /// A trip that began with the sample.
    tripped: Option<Trip>,
    /// A trip that ended with it.
    recovered: Option<Trip>,
}

/// A force takes this many times as long to come back as a passing trip has kept it away, up to a
/// whole soft start: an outage of a millisecond is over before a hand has felt the wall go.
const TIMES_AWAY: f64 = 10.0;

/// A force on its way back.
#[derive(Clone, Copy, Debug)]
struct SoftStart {
    /// How far it has come, 0 to 1.
    part: f64,
    /// How far it comes in a period.
    step: f64,
}

/// The limits and the memory they need. One for each device; it lives in the loop's thread.
#[derive(Clone, Debug)]
pub struct Safety {
    params: SafetyParams,
    /// Factor from a command to the force that the limits bound, at least 1.
    gain: f64,
    /// Fastest change of the force that the rendering allows `[N/s]`.
    rendered_slew: f64,
    period: f64,
    /// What was commanded last.
    commanded: Wrench,
    last_position: Option<Vector>,
    trip: Option<Trip>,
    /// A force that comes back; `None`: it is all there, or there was nothing to bring back.
    soft: Option<SoftStart>,
    /// How long a force has to take to come back should the next sample find one `[s]`.
    fresh: Option<f64>,
    /// How long a trip has kept the force away `[s]`.
    away: f64,
    /// Whether the force is kept away since another device of the same loop has none.
    withheld: bool,
    missing: u32,
    recoveries: Recoveries,
    oscillation: Oscillation,
}

impl Safety {
    /// Safety for a loop of `period` `[s]`.
    ///
    /// # Errors
    /// The first parameter outside its range, by name, with what is allowed.
    pub fn new(params: SafetyParams, period: f64) -> Result<Self, SafetyError> {
        params.check()?;
        let of_loop = Duration::try_from_secs_f64(period).unwrap_or_default();
        let stall_after = params.stall_after(of_loop).as_secs_f64();
        Ok(Self {
            oscillation: Oscillation::new(params.oscillation),
            recoveries: Recoveries::new(params.recoveries, params.soft_start, period, stall_after),
            fresh: Some(params.soft_start),
            away: 0.0,
            withheld: false,
            params,
            gain: 1.0,
            rendered_slew: f64::INFINITY,
            period,
            commanded: Wrench::NONE,
            last_position: None,
            trip: None,
            soft: None,
            missing: 0,
        })
    }

    /// Follows the rendering: the limits bound both a command and the command times the modelled gain of `actuation`, and
    /// the force changes no faster than `slew_limit` `[N/s]` (infinite: by [`SafetyParams::slew_limit`] alone).
    #[must_use]
    pub fn rendering(mut self, actuation: &Actuation<f64>, slew_limit: f64) -> Self {
        self.follow(actuation, slew_limit);
        self
    }

    /// Does what [`rendering`](Self::rendering) does, while the loop runs.
    pub(crate) fn follow(&mut self, actuation: &Actuation<f64>, slew_limit: f64) {
        self.gain = actuation.limit_gain();
        self.rendered_slew = slew_limit;
    }

    /// The limits.
    #[must_use]
    pub fn params(&self) -> &SafetyParams {
        &self.params
    }

    /// The trip that holds the force at none, if one does.
    #[must_use]
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// What to command for a fresh sample.
    pub fn judge(&mut self, rendered: &Rendered) -> Verdict {
        let looked = self.look(rendered, false);
        self.answer(rendered, looked, false)
    }

    /// The first half of [`judge`](Self::judge), for a loop of several devices: looks at a fresh sample of this one for a
    /// reason to trip. Created energy is not counted where the force of any device of the loop `comes_in`.
    pub(crate) fn look(&mut self, rendered: &Rendered, comes_in: bool) -> Looked {
        self.missing = 0;
        let elapsed = rendered.elapsed.unwrap_or(self.period);
        let was_out = self.trip.is_some() || rendered.stalled || rendered.refused;
        if was_out || self.withheld {
            self.away += elapsed;
        }
        let found = self.find(rendered, comes_in);
        self.last_position = Some(rendered.position).filter(is_finite);
        let before = self.trip;
        let (mut tripped, mut recovered) = (None, None);
        match (before, found) {
            (Some(trip), None) if trip.is_passing() => {
                recovered = before;
                self.trip = None;
                self.come_back_softly();
            }
            // Of two, the one that stays is the one to know.
            (Some(trip), Some(new)) if trip.is_passing() && !new.is_passing() => {
                tripped = Some(new);
                self.trip = tripped;
            }
            (None, Some(new)) => {
                tripped = Some(new);
                self.trip = tripped;
            }
            _ => {}
        }
        let is_out = self.trip.is_some() || rendered.refused;
        if self.recoveries.watch(elapsed, was_out, is_out) {
            tripped = Some(Trip::TooManyRecoveries);
            recovered = None;
            self.trip = tripped;
        }
        Looked { tripped, recovered }
    }

    /// The second half of [`judge`](Self::judge): what to command. None where it is `withheld`, since another device of
    /// the loop has tripped.
    pub(crate) fn answer(
        &mut self,
        rendered: &Rendered,
        looked: Looked,
        withheld: bool,
    ) -> Verdict {
        let Looked { tripped, recovered } = looked;
        if self.trip.is_some() {
            return self.none(tripped, recovered);
        }
        if withheld {
            self.withheld = true;
            return self.none(tripped, recovered);
        }
        let was_withheld = self.withheld;
        if std::mem::take(&mut self.withheld) {
            self.come_back_softly();
        }
        if rendered.refused {
            self.come_back_softly();
            return self.none(tripped, recovered);
        }
        let mut bounded = Bounded::default();
        let SafetyParams {
            largest_force,
            largest_torque,
            slew_limit,
            torque_slew_limit,
            ..
        } = self.params;
        // Before it comes in: what is shortened afterwards is there at once.
        let force = shortened(rendered.wrench.force, largest_force / self.gain);
        let torque = shortened(rendered.wrench.torque, largest_torque / self.gain);
        bounded.force = force.is_some() || torque.is_some();
        let mut wrench = Wrench {
            force: force.unwrap_or(rendered.wrench.force),
            torque: torque.unwrap_or(rendered.wrench.torque),
        };
        self.away = 0.0;
        if let Some(duration) = self.fresh.take() {
            // A force that begins at 0 by itself need not be brought in.
            self.soft = (wrench != Wrench::NONE && duration > 0.0).then(|| SoftStart {
                part: 0.0,
                step: self.period / duration,
            });
        }
        if let Some(SoftStart { part, step }) = self.soft {
            wrench = wrench.each(|vector| vector.map(|x| x * part));
            bounded.soft_start = true;
            let part = part + step;
            self.soft = (part < 1.0).then_some(SoftStart { part, step });
        }
        // Nobody knows for how much of the time before it no force was commanded.
        let is_back = recovered.is_some() || was_withheld;
        let elapsed = rendered.elapsed.filter(|_| !is_back);
        // An invalid time allows no change.
        let elapsed = elapsed.unwrap_or(self.period).max(0.0);
        let slew_limit = slew_limit.min(self.rendered_slew) / self.gain;
        let force = slewed(self.commanded.force, wrench.force, slew_limit * elapsed);
        let largest_change = torque_slew_limit / self.gain * elapsed;
        let torque = slewed(self.commanded.torque, wrench.torque, largest_change);
        bounded.slew = force.is_some() || torque.is_some();
        wrench = Wrench {
            force: force.unwrap_or(wrench.force),
            torque: torque.unwrap_or(wrench.torque),
        };
        self.commanded = wrench;
        Verdict {
            wrench,
            bounded,
            tripped,
            recovered,
        }
    }

    /// What to command when there is no fresh sample: the last force for one period, then none.
    pub fn missing(&mut self) -> Verdict {
        match self.hold() {
            Some(verdict) => verdict,
            None => self.trip_on(Trip::StaleSample),
        }
    }

    /// What to command where this device has a fresh sample and another one of the loop has none, so that nothing is
    /// rendered: as [`missing`](Self::missing), but this one does not trip.
    pub(crate) fn wait(&mut self) -> Verdict {
        match self.hold() {
            Some(verdict) => verdict,
            None => self.withhold(),
        }
    }

    /// What was commanded last, if it may be held for one period more.
    fn hold(&mut self) -> Option<Verdict> {
        self.missing += 1;
        let may_hold = self.missing < self.params.stale_after && self.trip.is_none();
        may_hold.then_some(Verdict {
            wrench: self.commanded,
            bounded: Bounded::default(),
            tripped: None,
            recovered: None,
        })
    }

    /// Commands none, since another device of the loop has tripped; the force comes back softly when that has passed.
    pub(crate) fn withhold(&mut self) -> Verdict {
        self.withheld = true;
        self.none(None, None)
    }

    /// Whether the force is kept away, or still on its way back.
    pub(crate) fn is_not_all_there(&self) -> bool {
        self.trip.is_some() || self.withheld || self.soft.is_some()
    }

    /// Trips for a reason that was found elsewhere.
    pub fn trip_on(&mut self, trip: Trip) -> Verdict {
        let stays = self.trip.is_some_and(|held| !held.is_passing());
        let new = self.trip != Some(trip) && !stays;
        if new {
            self.trip = Some(trip);
        }
        self.none(new.then_some(trip), None)
    }

    /// Lets the force come back after a trip that stays; a reason that still holds trips again.
    /// Whether there was such a trip; else nothing changes.
    pub fn rearm(&mut self) -> bool {
        if self.trip.is_none_or(Trip::is_passing) {
            return false;
        }
        self.trip = None;
        self.fresh = Some(self.params.soft_start);
        self.last_position = None;
        self.oscillation = Oscillation::new(self.params.oscillation);
        self.recoveries.forget();
        true
    }

    /// Another method renders from the next sample on.
    pub fn another_method(&mut self) {
        self.oscillation.another_method();
    }

    /// Whether most of the energy that counts as an oscillation was created before the method that
    /// renders now began.
    #[must_use]
    pub fn oscillation_is_from_before(&self) -> bool {
        self.oscillation.is_from_before()
    }

    /// No force is held any more, by the loop's own will: should it go on, the next one comes in softly.
    pub fn let_go(&mut self) {
        self.commanded = Wrench::NONE;
        self.soft = None;
        self.fresh = Some(self.params.soft_start);
    }

    /// The next force takes as long as its absence asks for, and no less than what was still to come
    /// of an earlier soft start.
    fn come_back_softly(&mut self) {
        let asked = (TIMES_AWAY * self.away).min(self.params.soft_start);
        self.fresh = Some(self.fresh.map_or(asked, |pending| pending.max(asked)));
    }

    fn none(&mut self, tripped: Option<Trip>, recovered: Option<Trip>) -> Verdict {
        self.commanded = Wrench::NONE;
        if let Some(SoftStart { part, step }) = self.soft.take() {
            let to_come = (1.0 - part) / step * self.period;
            self.fresh = Some(self.fresh.map_or(to_come, |pending| pending.max(to_come)));
        }
        Verdict {
            wrench: Wrench::NONE,
            bounded: Bounded {
                stopped: self.trip.is_some_and(|trip| !trip.is_passing()),
                ..Bounded::default()
            },
            tripped,
            recovered,
        }
    }

    fn find(&mut self, rendered: &Rendered, comes_in: bool) -> Option<Trip> {
        let found = self
            .find_in_motion(rendered)
            .or(rendered.stalled.then_some(Trip::Stalled));
        let elapsed = rendered.elapsed.unwrap_or(self.period);
        if found.is_some() || comes_in || self.is_not_all_there() {
            // What a position that is no good makes of the energy says nothing, nor what becomes of
            // a contact without its force.
            self.oscillation.pass_over(rendered.created_energy);
            return found;
        }
        self.oscillation
            .watch(rendered.created_energy, elapsed)
            .then_some(Trip::Oscillation)
    }

    fn find_in_motion(&self, rendered: &Rendered) -> Option<Trip> {
        if !is_finite(&rendered.position) || !rendered.wrench.is_finite() {
            return Some(Trip::NotANumber);
        }
        if let Some([lower, upper]) = self.params.workspace {
            let mut axes = rendered.position.iter().zip(lower.iter().zip(&upper));
            if axes.any(|(x, (low, high))| x < low || x > high) {
                return Some(Trip::OutsideWorkspace);
            }
        }
        if let Some([from, to]) = self.params.range
            && !(from..=to).contains(&rendered.coordinate)
        {
            return Some(Trip::OutsideWorkspace);
        }
        if let (Some(last), Some(elapsed)) = (self.last_position, rendered.elapsed) {
            let moved = rendered.position.iter().zip(&last);
            let square: f64 = moved.map(|(x, last)| (x - last).powi(2)).sum();
            if square.sqrt() > self.params.largest_speed * elapsed {
                return Some(Trip::TooFast);
            }
        }
        None
    }
}

fn is_finite(position: &Vector) -> bool {
    position.iter().all(|x| x.is_finite())
}

/// The vector in its direction at this length, if it is longer by more than rounding; to the last digit
/// where it lies along an axis.
fn shortened(vector: Vector, longest: f64) -> Option<Vector> {
    let most = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if most == 0.0 {
        return None;
    }
    // In units of the largest component: the square of a huge number is none.
    let direction = vector.map(|x| x / most);
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let is_too_long = most * length > longest * (1.0 + 4.0 * f64::EPSILON);
    is_too_long.then(|| direction.map(|x| longest * (x / length)))
}

/// The vector on the straight line from `before` to `wanted` at this distance, if `wanted` is farther.
fn slewed(before: Vector, wanted: Vector, farthest: f64) -> Option<Vector> {
    let [x, y, z] = wanted;
    let [bx, by, bz] = before;
    let [dx, dy, dz] = shortened([x - bx, y - by, z - bz], farthest)?;
    Some([bx + dx, by + dy, bz + dz])
}

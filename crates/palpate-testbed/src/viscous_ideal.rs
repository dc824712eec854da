//! The ideal contact of a device with viscous friction and an object, both free to move.
//!
//! ```text
//! m ξ″ = f_u − b ξ′ − f,    M η″ = f_V + f,    f = K p h(p),    p = ξ − η
//! ```
//!
//! Between two events this is linear, so device, object and penetration are short power series in
//! time, over spans of at most one radian of the fastest rate. Touch and release are the first
//! zeros of the penetration's series, located to round-off; no time step enters. Without friction
//! the result is that of the [closed form](crate::ideal), by other means.

use crate::InvalidParameter;
use crate::arc::{ForceSums, GAUSS_LEGENDRE};
use crate::error::positive;
use crate::grid::Grid;
use crate::ideal::{Ideal, PointMassScene};
use crate::power_series::{MAX_TERMS, first_fall, integral, terms, value};
use crate::profile::{Collision, ForceProfile, Snapshot};

/// The ideal force over a window, and the motion that goes with it.
#[derive(Debug, Clone, PartialEq)]
pub struct ViscousIdeal {
    /// The contact force.
    pub profile: ForceProfile,
    /// States at the start, at the end of each period, and so at the end of the window.
    pub record: Vec<Snapshot>,
}

/// Most spans and events within a period. A contact lasts half an oscillation at least, so only
/// oscillations of less than a ten-thousandth of a period come near it.
const MAX_SPANS: usize = 100_000;

impl ViscousIdeal {
    /// The ideal of `scene` with friction b `[N s/m]` on its device, over `intervals` periods `[s]`.
    ///
    /// # Errors
    ///
    /// A field of `scene` outside its range, `friction` not finite and at least 0, `period` not
    /// finite and positive, or more than 10⁵ spans in a period.
    pub fn new(
        scene: &PointMassScene,
        friction: f64,
        period: f64,
        intervals: usize,
    ) -> Result<Self, InvalidParameter> {
        Ideal::new(*scene)?;
        positive("period", period, "finite and above 0 s")?;
        InvalidParameter::unless(
            friction >= 0.0 && (friction / scene.device_mass).is_finite(),
            "friction",
            friction,
            "at least 0 N s/m, and finite when divided by the mass",
        )?;
        let mut motion = DeviceAndObject::new(scene, friction);
        InvalidParameter::unless(
            period * motion.contact_rate < MAX_SPANS as f64,
            "period",
            period,
            "less than 1e5 radians of the contact",
        )?;
        let mut sums = Vec::with_capacity(intervals);
        let mut record = Vec::with_capacity(intervals + 1);
        record.push(motion.snapshot(0.0));
        for interval in 0..intervals {
            let start = interval as f64 * period;
            sums.push(motion.over(start, period));
            record.push(motion.snapshot((interval + 1) as f64 * period));
        }
        Ok(Self {
            profile: ForceProfile::from_sums(
                Grid::even(0.0, period, intervals),
                &sums,
                motion.collisions,
            ),
            record,
        })
    }
}

/// Device and object on their way.
struct DeviceAndObject {
    stiffness: f64,
    friction: f64,
    device_mobility: f64,
    object_mobility: f64,
    user_force: f64,
    /// f_V/M `[m/s²]`
    object_acceleration: f64,
    contact_rate: f64,
    in_contact: bool,
    penetration: f64,
    device_position: f64,
    device_velocity: f64,
    object_velocity: f64,
    collisions: Vec<Collision>,
}

/// Power series on a span, in units of the span.
struct Series {
    count: usize,
    penetration: [f64; MAX_TERMS],
    device: [f64; MAX_TERMS],
    object: [f64; MAX_TERMS],
}

impl DeviceAndObject {
    fn new(scene: &PointMassScene, friction: f64) -> Self {
        let device_mobility = 1.0 / scene.device_mass;
        let object_mobility = 1.0 / scene.object_mass;
        let is_wall = object_mobility == 0.0;
        let penetration = scene.device_position - scene.object_position;
        let mut motion = Self {
            stiffness: scene.stiffness,
            friction,
            device_mobility,
            object_mobility,
            user_force: scene.user_force,
            object_acceleration: if is_wall {
                0.0
            } else {
                scene.virtual_force * object_mobility
            },
            contact_rate: friction * device_mobility
                + (scene.stiffness * (device_mobility + object_mobility)).sqrt(),
            in_contact: penetration > 0.0,
            penetration,
            device_position: scene.device_position,
            device_velocity: scene.device_velocity,
            object_velocity: if is_wall { 0.0 } else { scene.object_velocity },
            collisions: Vec::new(),
        };
        if motion.in_contact {
            // The speed at which the energy of motion and spring together would arrive.
            let mobility = device_mobility + object_mobility;
            let of_spring = penetration * (scene.stiffness * mobility).sqrt();
            motion.begin_collision(0.0, motion.approach().hypot(of_spring));
        }
        motion
    }

    fn approach(&self) -> f64 {
        self.device_velocity - self.object_velocity
    }

    fn snapshot(&self, time: f64) -> Snapshot {
        Snapshot {
            time,
            device_position: self.device_position,
            device_velocity: self.device_velocity,
            object_position: self.device_position - self.penetration,
            object_velocity: self.object_velocity,
            force_on_object: self.stiffness * self.penetration.max(0.0),
        }
    }

    fn begin_collision(&mut self, start: f64, impact_speed: f64) {
        self.collisions.push(Collision {
            start,
            end: None,
            impulse: 0.0,
            peak_force: self.stiffness * self.penetration.max(0.0),
            impact_speed,
            release_speed: None,
        });
    }

    /// Moves on over a period; the integrals of the force, with the moment about the middle.
    fn over(&mut self, start: f64, period: f64) -> ForceSums {
        let (mut sum, mut done) = (ForceSums::default(), 0.0);
        for _ in 0..MAX_SPANS {
            let rate = if self.in_contact {
                self.contact_rate
            } else {
                self.friction * self.device_mobility
            };
            let left = period - done;
            let span = if rate * left > 1.0 { 1.0 / rate } else { left };
            let series = self.series(span, terms(rate * span));
            let count = series.count;
            let mut towards = [0.0; MAX_TERMS];
            for (toward, c) in towards.iter_mut().zip(&series.penetration[..count]) {
                *toward = if self.in_contact { *c } else { -*c };
            }
            let event = first_fall(&towards[..count]);
            let share = event.unwrap_or(1.0);
            if self.in_contact {
                let part = self.sums(&series, span, share);
                sum.add(part, done - 0.5 * period);
                self.note_force(&series, share, part.impulse);
            }
            self.device_position += span * integral(&series.device[..count], share);
            self.penetration = value(&series.penetration[..count], share);
            self.device_velocity = value(&series.device[..count], share);
            self.object_velocity = value(&series.object[..count], share);
            done += share * span;
            if event.is_some() {
                self.penetration = 0.0;
                self.in_contact = !self.in_contact;
                let approach = self.approach();
                if self.in_contact {
                    self.begin_collision(start + done, approach);
                } else if let Some(collision) = self.collisions.last_mut() {
                    collision.end = Some(start + done);
                    collision.release_speed = Some(approach.abs());
                }
            } else if span == left {
                break;
            }
        }
        sum
    }

    /// The motion over `span` from now on, were there no event in it.
    fn series(&self, span: f64, count: usize) -> Series {
        let (mut p, mut u, mut w) = ([0.0; MAX_TERMS], [0.0; MAX_TERMS], [0.0; MAX_TERMS]);
        (p[0], u[0], w[0]) = (self.penetration, self.device_velocity, self.object_velocity);
        let stiffness = if self.in_contact { self.stiffness } else { 0.0 };
        for n in 0..count - 1 {
            let step = span / (n + 1) as f64;
            let force = stiffness * p[n];
            let (mut push, mut acceleration) = (-self.friction * u[n] - force, 0.0);
            if n == 0 {
                push += self.user_force;
                acceleration = self.object_acceleration;
            }
            p[n + 1] = step * (u[n] - w[n]);
            u[n + 1] = step * push * self.device_mobility;
            w[n + 1] = step * (acceleration + force * self.object_mobility);
        }
        Series {
            count,
            penetration: p,
            device: u,
            object: w,
        }
    }

    /// The integrals over the first `share` of the span, with the moment about its beginning.
    fn sums(&self, series: &Series, span: f64, share: f64) -> ForceSums {
        let p = &series.penetration[..series.count];
        let half = 0.5 * share;
        let (mut sum_of_squares, mut moment) = (0.0, 0.0);
        for (abscissa, weight) in GAUSS_LEGENDRE {
            for s in [half * (1.0 - abscissa), half * (1.0 + abscissa)] {
                let at = value(p, s);
                sum_of_squares += weight * at * at;
                moment += weight * at * s;
            }
        }
        let k = self.stiffness;
        ForceSums {
            impulse: k * span * integral(p, share),
            moment: k * span * span * half * moment,
            square: k * k * span * half * sum_of_squares,
        }
    }

    /// EnergyLedger a part of the contact in progress.
    fn note_force(&mut self, series: &Series, share: f64, impulse: f64) {
        let p = &series.penetration[..series.count];
        let mut slope = [0.0; MAX_TERMS];
        for n in 1..series.count {
            slope[n - 1] = n as f64 * p[n];
        }
        let summit = first_fall(&slope[..series.count - 1]).filter(|s| *s < share);
        let highest = [0.0, share]
            .into_iter()
            .chain(summit)
            .map(|s| self.stiffness * value(p, s))
            .fold(0.0, f64::max);
        if let Some(collision) = self.collisions.last_mut() {
            collision.impulse += impulse;
            collision.peak_force = collision.peak_force.max(highest);
        }
    }
}

//! Bound of the guard by the acceleration of the devices.
//!
//! The mobility matrix W of a device gives its acceleration by the rendered wrench F. With an upper bound `W <= M` (in
//! the order of symmetric matrices) the largest product of two wrenches is
//!
//! ```text
//! max over 0 <= W <= M of x'W y = (x'M y + |x|_M |y|_M)/2,  |x|_M = sqrt(x'M x)
//! ```
//!
//! The last interval of length T1 had the mean velocity u and the wrench F(s). Wrenches on their way have the impulse
//! J, the own wrench has P = F T at the centroid t_f. With the acceleration a_h of everything else:
//!
//! ```text
//! late = (1/T1) integral of s F(s)
//! claim = J'u + |J| (a_h T1/2 + q/T1) + a_h moment + max J'W (late + J/2)
//! own   = P'u + |P| (a_h (T1/2 + t_f) + q/T1) + max P'W (late + J) + P'M P/2
//! ```
//!
//! With a lag the impulses overlap, and only their positive parts count.
//!
//! A hand with a largest force F and torque t accelerates a device of the least mass m and inertia I by at most
//!
//! ```text
//! a_h = F/m + t/(2 sqrt(m I)),  angular t/I + F/(2 sqrt(m I))
//! ```

use palpate_core::{Range, Uneven};

use super::{Both, WorldGuardParams};
use crate::device::commands::{Acting, OnWay};
use crate::geometry::rigid::Vector3;
use crate::{Vector, WorldField};

/// Bound on the acceleration of each device by everything except the rendered force and torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldHandBound {
    /// Largest effect of the hand.
    pub limit: WorldHandLimit,
    /// Least mass along each world axis that a rendered force can find on any device `[kg]`, above 0;
    /// [`WorldLoop::guard_masses`](crate::WorldLoop::guard_masses) has one for each device.
    pub least_mass: Vector,
    /// Least moment of inertia about any axis that a rendered torque can find on any device that turns `[kg m^2]`,
    /// above 0.
    pub least_inertia: f64,
}

/// Largest effect of everything except the rendered force and torque on each device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorldHandLimit {
    /// Largest accelerations, the same for all devices.
    Acceleration {
        /// Largest acceleration a_h `[m/s^2]`, above 0.
        linear: f64,
        /// Largest angular acceleration of a device that turns `[rad/s^2]`, above 0.
        angular: f64,
    },
    /// Largest force and torque. The accelerations follow from the least mass and inertia of each device.
    Force {
        /// Largest force `[N]`, above 0.
        force: f64,
        /// Largest torque on a device that turns `[N m]`, above 0.
        torque: f64,
    },
}

impl WorldHandBound {
    pub(super) fn ranges(&self) -> [(WorldField, f64, Range); 6] {
        let [x, y, z] = self.least_mass;
        let [linear, angular] = match self.limit {
            WorldHandLimit::Acceleration { linear, angular } => [
                (WorldField::GuardAcceleration, linear),
                (WorldField::GuardTurning, angular),
            ],
            WorldHandLimit::Force { force, torque } => [
                (WorldField::GuardHandForce, force),
                (WorldField::GuardHandTorque, torque),
            ],
        };
        [
            linear,
            angular,
            (WorldField::GuardMass, x),
            (WorldField::GuardMass, y),
            (WorldField::GuardMass, z),
            (WorldField::GuardInertia, self.least_inertia),
        ]
        .map(|(field, value)| (field, value, Range::Positive))
    }
}

/// Bound on the acceleration of one device.
#[derive(Clone, Copy, Debug)]
struct Hand {
    /// Largest acceleration `[m/s^2]`.
    acceleration: f64,
    /// Largest angular acceleration `[rad/s^2]`.
    turning: f64,
    /// Least mass along each axis `[kg]`.
    least_mass: Vector,
    /// Least moment of inertia `[kg m^2]`.
    least_inertia: f64,
}

impl Hand {
    /// Creates the bound for a device of this least mass `[kg]`.
    fn new(bound: &WorldHandBound, least_mass: Vector) -> Self {
        let least_inertia = bound.least_inertia;
        let [acceleration, turning] = match bound.limit {
            WorldHandLimit::Acceleration { linear, angular } => [linear, angular],
            WorldHandLimit::Force { force, torque } => {
                let mass = Vector3::from(least_mass).min();
                // Of a mobility with M = diag(1/m, 1/I), the block between force and torque has a norm of at most this.
                let across = 0.5 / (mass * least_inertia).sqrt();
                [
                    force / mass + torque * across,
                    torque / least_inertia + force * across,
                ]
            }
        };
        Self {
            acceleration,
            turning,
            least_mass,
            least_inertia,
        }
    }

    /// Returns x'M y for the bound M of the mobility.
    fn weighted(&self, [force, torque]: &Both, [other, other_torque]: &Both) -> f64 {
        let mass = Vector3::from(self.least_mass);
        force.component_div(&mass).dot(other) + torque.dot(other_torque) / self.least_inertia
    }

    /// Returns the largest x'W y of a mobility within the bound.
    fn largest(&self, one: &Both, other: &Both) -> f64 {
        let sizes = self.weighted(one, one) * self.weighted(other, other);
        0.5 * (self.weighted(one, other) + sizes.sqrt())
    }

    /// Returns the largest change of the product of the impulse with the velocity per second.
    fn accelerated(&self, [force, torque]: &Both) -> f64 {
        self.acceleration * force.norm() + self.turning * torque.norm()
    }

    /// Returns the largest energy that a wrench gave out beyond its port work `[J]`.
    fn hidden(&self, step: &Step, [force, torque]: &[Uneven<f64>; 2]) -> f64 {
        let by_hand = self.acceleration * force.course + self.turning * torque.course;
        let lead = step.lead.map(|lead| -lead);
        by_hand + self.largest(&lead, &step.held)
    }

    /// Returns whether two steps show an acceleration beyond the bound, for any mobility within the bound.
    fn is_exceeded(&self, params: &WorldGuardParams, before: &Step, now: &Step) -> bool {
        let h = 0.5 * (before.elapsed + now.elapsed);
        let rate = 3f64.sqrt() * (1.0 / before.elapsed + 1.0 / now.elapsed);
        let late = before.late();
        let half = 0.5 * now.elapsed;
        let early = [0, 1].map(|i| now.held[i] * half + now.lead[i] / now.elapsed);
        let impulse = [late[0] + early[0], late[1] + early[1]];
        // W g lies in a ball about M g/2.
        let size = 0.5 * self.weighted(&impulse, &impulse).sqrt();
        let mass = Vector3::from(self.least_mass);
        let middle = [
            impulse[0].component_div(&mass) * 0.5,
            impulse[1] * (0.5 / self.least_inertia),
        ];
        let most = [
            self.acceleration * h + params.quantum * rate + size / mass.min().sqrt(),
            self.turning * h + params.angle_quantum * rate + size / self.least_inertia.sqrt(),
        ];
        (0..2).any(|i| {
            let gained = now.velocity[i] - before.velocity[i];
            // Rounding of positions and times.
            (gained - middle[i]).norm() > most[i] * (1.0 + 1e-9) + 1e-12
        })
    }
}

/// Motion of a device over an interval, and the wrench in it.
#[derive(Clone, Copy, Debug)]
struct Step {
    elapsed: f64,
    /// Mean velocity `[m/s]`, `[rad/s]`.
    velocity: Both,
    /// Mean force `[N]` and torque `[N m]`.
    held: Both,
    /// See [`Held::lead`](palpate_core::Held::lead).
    lead: Both,
}

impl Step {
    /// Returns the impulse of the wrench, weighted by the time since the interval's beginning, over its duration.
    fn late(&self) -> Both {
        [0, 1].map(|i| self.held[i] * (0.5 * self.elapsed) - self.lead[i] / self.elapsed)
    }
}

/// Motion of a tool as the guard knows it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ToolMotion {
    /// Bound on the acceleration, with the least mass of this device.
    hand: Option<Hand>,
    /// The last interval; `None` after a lost sample.
    last: Option<Step>,
    /// Whether the last interval may be used for the bound by acceleration.
    is_within: bool,
    /// Mean force and torque over the last interval.
    held: Both,
    /// Earlier wrenches on their way.
    on_way: [OnWay; 2],
}

/// Energy that a wrench can give out, as a polynomial of its size relative to the computed one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Price {
    pub linear: f64,
    pub square: f64,
}

impl Price {
    /// Returns the largest part of the wrench, 0 to 1, that gives out at most `room` `[J]`.
    pub fn affordable(&self, room: f64) -> f64 {
        let Self { linear, square } = *self;
        if room.is_nan() || linear.is_nan() || square.is_nan() {
            return 0.0;
        }
        let room = room.max(0.0);
        if linear + square <= room {
            return 1.0;
        }
        let root = (linear * linear + 4.0 * square * room).sqrt();
        let part = if linear > 0.0 {
            2.0 * room / (linear + root)
        } else {
            (root - linear) / (2.0 * square)
        };
        if part.is_nan() {
            0.0
        } else {
            part.clamp(0.0, 1.0)
        }
    }
}

impl ToolMotion {
    /// Creates the motion of a tool before its first sample, with its own least mass `[kg]` if it has one.
    pub fn new(hand: Option<WorldHandBound>, own: Option<Vector>) -> Self {
        Self {
            hand: hand.map(|hand| Hand::new(&hand, own.unwrap_or(hand.least_mass))),
            ..Self::default()
        }
    }

    /// Returns whether the device accelerated beyond the bound in the last interval.
    pub fn is_exceeded(&self) -> bool {
        self.last.is_some() && !self.is_within
    }

    /// Returns the energy that the end of the last wrench can hide in the quanta of the sensors `[J]`.
    pub fn hidden_at_end(&self, params: &WorldGuardParams) -> f64 {
        params.in_quanta(&self.held)
    }

    /// Ends an interval of `elapsed` `[s]`, in which the device `moved` under a force and a torque with these bounds.
    /// Returns the energy that may have been given out unnoticed `[J]`.
    pub fn pass(
        &mut self,
        params: &WorldGuardParams,
        [force, torque]: [Acting; 2],
        uneven: &[Uneven<f64>; 2],
        moved: &Both,
        elapsed: f64,
    ) -> f64 {
        let now = Step {
            elapsed,
            velocity: moved.map(|way| way / elapsed),
            held: [force.sent, torque.sent],
            lead: [force.lead, torque.lead],
        };
        let by_speed = params.hidden_by_speed(&now.held, uneven, moved, elapsed);
        let before = self.last.replace(now);
        let by_course = match self.hand {
            None => by_speed,
            Some(hand) => {
                self.is_within = !before.is_some_and(|last| hand.is_exceeded(params, &last, &now));
                if self.is_within {
                    hand.hidden(&now, uneven).min(by_speed)
                } else {
                    by_speed
                }
            }
        };
        let change = [0, 1].map(|i| now.held[i] - self.held[i]);
        self.held = now.held;
        by_course + params.in_quanta(&change)
    }

    /// Ends an interval without positions at both ends. Returns the energy that the quanta hide `[J]`.
    pub fn lose(&mut self, params: &WorldGuardParams) -> f64 {
        self.last = None;
        self.is_within = false;
        let hidden = params.in_quanta(&self.held);
        self.held = Both::default();
        hidden
    }

    /// Takes the earlier wrenches on their way, and returns the largest energy that they can give out `[J]`.
    pub fn claim(&mut self, params: &WorldGuardParams, on_way: [OnWay; 2]) -> f64 {
        self.on_way = on_way;
        let total = on_way.each_ref().map(|on_way| on_way.push + on_way.pull);
        let by_speed =
            params.largest_speed * total[0].sum() + params.largest_turning * total[1].sum();
        let (Some(hand), Some(last)) = (self.hand, self.within()) else {
            return by_speed;
        };
        let (velocity, late) = (&last.velocity, last.late());
        let mut sum = hand.accelerated(&total.map(|total| Vector3::new(total.sum(), 0.0, 0.0)))
            * (0.5 * last.elapsed)
            + 2.0 * params.in_quanta(&total) / last.elapsed
            + hand.acceleration * on_way[0].moment
            + hand.turning * on_way[1].moment;
        if on_way.iter().any(|on_way| on_way.overlaps) {
            for (on_way, velocity) in on_way.iter().zip(velocity) {
                for axis in 0..3 {
                    sum += on_way.push[axis] * velocity[axis].max(0.0)
                        + on_way.pull[axis] * (-velocity[axis]).max(0.0);
                }
            }
            let size = hand.size(&total);
            sum += size * (hand.weighted(&late, &late).sqrt() + 0.5 * size);
        } else {
            let net = on_way.map(|on_way| on_way.push - on_way.pull);
            let with_half = [0, 1].map(|i| late[i] + net[i] * 0.5);
            sum += net[0].dot(&velocity[0]) + net[1].dot(&velocity[1]);
            sum += hand.largest(&net, &with_half);
        }
        // NaN yields to the bound by speed.
        by_speed.min(sum)
    }

    /// Returns the price of a delivered wrench over a `period` `[s]`.
    pub fn price(&self, params: &WorldGuardParams, wrench: &Both, period: f64) -> Price {
        let impulse = wrench.map(|part| part * period);
        let (Some(hand), Some(last)) = (self.hand, self.within()) else {
            return Price {
                linear: params.largest_speed * impulse[0].norm()
                    + params.largest_turning * impulse[1].norm(),
                square: 0.0,
            };
        };
        let (velocity, late) = (&last.velocity, last.late());
        let along = impulse[0].dot(&velocity[0]) + impulse[1].dot(&velocity[1]);
        let [own_at, _] = self.on_way.map(|on_way| on_way.own_at);
        let linear = hand.accelerated(&impulse) * (0.5 * last.elapsed + own_at)
            + 2.0 * params.in_quanta(&impulse) / last.elapsed;
        let square = 0.5 * hand.weighted(&impulse, &impulse);
        let before = if self.on_way.iter().any(|on_way| on_way.overlaps) {
            let total = self.on_way.map(|on_way| on_way.push + on_way.pull);
            let sizes = hand.weighted(&late, &late).sqrt() + hand.size(&total);
            along.max(0.0) + (2.0 * square).sqrt() * sizes
        } else {
            let net = self.on_way.map(|on_way| on_way.push - on_way.pull);
            let earlier = [0, 1].map(|i| late[i] + net[i]);
            along + hand.largest(&impulse, &earlier)
        };
        Price {
            linear: linear + before,
            square,
        }
    }

    fn within(&self) -> Option<&Step> {
        self.last.as_ref().filter(|_| self.is_within)
    }
}

impl Hand {
    /// Returns a bound on the sum of |J|_M over impulses with these sums of magnitudes along each axis.
    fn size(&self, [force, torque]: &Both) -> f64 {
        let mass = Vector3::from(self.least_mass);
        let roots = mass.map(|mass| 1.0 / mass.sqrt());
        force.dot(&roots) + torque.sum() / self.least_inertia.sqrt()
    }
}

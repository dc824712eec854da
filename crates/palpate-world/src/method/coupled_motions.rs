//! State of a device as estimated by its observers.

use crate::device::commands::Acting;
use crate::device::observer::{AxisForce, AxisMotion, AxisObserver};
use crate::dynamics::linkage::{Linkage, Passage, Start};
use crate::dynamics::moving_body::Drive;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::{Mobility, Vector3};

/// State of a device as estimated by its observers along each of its axes, relative to its measured position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motions {
    pub along: [AxisMotion; 3],
    pub axes: Axes,
    /// Inertia of its linkage over the current interval, if it has one.
    pub passage: Option<Passage>,
}

impl Motions {
    pub fn seen_by(observers: &[AxisObserver; 3], axes: Axes) -> Self {
        Self {
            along: observers.each_ref().map(|observer| observer.motion),
            axes,
            passage: None,
        }
    }

    /// Returns a quantity along each of the device's axes.
    pub fn own(&self, quantity: impl Fn(&AxisMotion) -> f64) -> Vector3 {
        Vector3::from(self.along.each_ref().map(quantity))
    }

    /// Returns a quantity as a vector in the world's axes.
    pub fn of(&self, quantity: impl Fn(&AxisMotion) -> f64) -> Vector3 {
        self.axes.out(&self.own(quantity))
    }

    /// Returns the mobility along each axis, for a linkage at its reference position `[1/kg]`.
    pub fn theta(&self) -> Vector3 {
        self.own(|axis| axis.mobility)
    }

    pub fn drive(&self) -> Drive {
        Drive {
            damping_rate: self.own(|axis| axis.damping_rate),
            spring_rate: self.own(|axis| axis.spring_rate),
            ..Drive::constant(self.of(|axis| axis.external))
        }
    }

    /// Begins an interval of `h` `[s]` with a `force` `[N]` on the device, at the measured position.
    pub fn pass(&mut self, linkage: &Linkage, measured: &Vector3, force: &Vector3, h: f64) {
        let start = Start {
            position: measured + self.of(|axis| axis.offset),
            velocity: self.of(|axis| axis.velocity),
            external: self.own(|axis| axis.external),
            force: *force,
        };
        self.passage = Some(linkage.over(&self.theta(), &start, h));
    }

    /// Begins an interval that has ended, with the measured displacement `way` `[m]`.
    pub fn pass_by(
        &mut self,
        linkage: &Linkage,
        measured: &Vector3,
        way: &Vector3,
        force: &Vector3,
        h: f64,
    ) {
        let theta = self.theta();
        let start = Start {
            position: *measured,
            velocity: way / h,
            external: self.own(|axis| axis.external),
            force: *force,
        };
        let by_place = linkage.over(&theta, &start, h);
        let own = self.axes.own(force);
        let pushed = by_place.bias(&theta, &start.external).mean
            + by_place.share().component_mul(&start.external)
            + theta.component_mul(&by_place.equivalent(&theta, &own).mean);
        let velocity = start.velocity - self.axes.out(&pushed) * (0.5 * h);
        self.passage = Some(linkage.over(&theta, &Start { velocity, ..start }, h));
    }

    /// Returns the forces acting along each axis.
    pub fn felt(&self, [mean, lead, deviation]: [&Vector3; 3]) -> [AxisForce; 3] {
        let [mut mean, mut lead] = [mean, lead].map(|force| self.axes.own(force));
        let deviation = self.axes.own_deviations(deviation);
        let (mut bias, mut bias_lead) = (Vector3::zeros(), Vector3::zeros());
        let mut share = Vector3::repeat(1.0);
        if let Some(passage) = &self.passage {
            let (theta, external) = (self.theta(), self.own(|axis| axis.external));
            let by_force = passage.equivalent(&theta, &mean);
            let by_hand = passage.bias(&theta, &external);
            lead = passage.equivalent(&theta, &lead).mean + by_force.lead;
            mean = by_force.mean;
            (bias, bias_lead) = (by_hand.mean, by_hand.lead);
            share = passage.share();
        }
        [0, 1, 2].map(|axis| AxisForce {
            mean: mean[axis],
            lead: lead[axis],
            impulse_deviation: deviation[axis],
            bias: bias[axis],
            bias_lead: bias_lead[axis],
            share: share[axis],
        })
    }

    /// Returns the device after `h` `[s]` under the intended force.
    pub fn under(&self, acting: &Acting, h: f64) -> Self {
        let mut after = *self;
        let felt = self.felt([&acting.intended, &acting.lead, &Vector3::zeros()]);
        for (motion, force) in after.along.iter_mut().zip(&felt) {
            let change = motion.under(force, h);
            motion.offset += change.travel;
            motion.velocity += change.gained;
            motion.external += change.external;
        }
        after
    }

    pub fn mobility(&self) -> Mobility {
        Mobility {
            linear: self.theta(),
            linear_axes: self.axes.own_axes(),
            ..Mobility::none()
        }
    }

    /// Returns the sum over all movable axes of the products of two vectors' components, divided by the mobility.
    pub fn weighted(&self, one: &Vector3, other: &Vector3) -> f64 {
        self.mobility().weighted(one, other)
    }
}

//! The contacts of a scene: which points can touch which surfaces, and how they lie.

use thiserror::Error;

use std::sync::Arc;

use super::between::{Between, Pair as Solids};
use super::cylinder::Cylinder;
use super::field::Field;
use super::mesh::{MAX_CONTACTS, OnMesh};
use super::pairing::of_pair;
use super::rod::Rod;
use super::scene::{ContactLaw, InvalidScene, Shape, WorldScene};
use super::surface::{Feature, feature, holds, nearest};
use super::vector::{Rotation, Vec3};

/// Corners of a hull that touches a half-space by them, at most.
pub(super) const MAX_CORNERS: usize = 64;

/// Invalid scene, or failure to solve it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] InvalidScene),
    /// A pair of shapes for which there is no contact yet.
    #[error(
        "pairs[{number}]: {reason}; allowed pairs: a sphere with a sphere, half-space, box, capsule, cylinder, mesh or \
         hull; a half-space with a box, capsule, cylinder, or hull or mesh of at most {MAX_CORNERS} convex corners; a \
         box or hull with a box or hull; a capsule with a box, hull, capsule or cylinder; a cylinder with a box, hull \
         or cylinder; the points of a mesh with a box, capsule, cylinder, or mesh with a distance grid"
    )]
    Pair {
        /// Number of the pair, from 0.
        number: usize,
        /// Reason for rejecting it.
        reason: String,
    },
    /// Contacts that change their state more often than is taken for a motion.
    #[error("more than {limit} steps and events within an interval, at {time} s")]
    TooManySteps {
        /// The limit.
        limit: usize,
        /// Time at which the limit was reached `[s]`.
        time: f64,
    },
    /// A motion that is another one with each length of step, see [`CheckedIdeal`](super::CheckedIdeal).
    #[error(
        "the motion depends on the integration step from {time} s on; there is no reference solution"
    )]
    Chaotic {
        /// Start of the dependence `[s]`.
        time: f64,
    },
}

/// One contact: a point or sphere of the first member on the surface of the second.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contact {
    /// Number of its pair in the scene.
    pub pair: usize,
    /// The member that has the point or sphere, by its place among all members.
    pub first: usize,
    /// The member that has the surface.
    pub second: usize,
    /// Position of the point or the sphere's centre, in the axes of the first.
    pub on_first: Vec3,
    /// Radius of the sphere, 0 for a point `[m]`.
    pub radius: f64,
    pub surface: Shape,
    /// Of two boxes or hulls, both of them, and the contact's number among those of the pair.
    pub solids: Option<(Arc<Solids>, usize)>,
    /// Of a capsule on another convex solid, both of them, and the end.
    pub rod: Option<(Arc<Rod>, usize)>,
    /// Of a cylinder on a solid with flat faces or another cylinder, both of them, and the contact's number among those
    /// of the pair.
    pub cylinder: Option<(Arc<Cylinder>, usize)>,
    /// Of a point on a mesh by its field, that field.
    pub field: Option<Arc<Field>>,
    pub law: ContactLaw,
}

/// Pose and velocity of a member of a contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub position: Vec3,
    pub rotation: Rotation,
    pub velocity: Vec3,
    /// Angular velocity in world axes `[rad/s]`.
    pub turning: Vec3,
}

impl Placed {
    /// Velocity of the material point that is at a place.
    pub fn velocity_at(&self, place: Vec3) -> Vec3 {
        self.velocity + self.turning.cross(place - self.position)
    }
}

/// The linear and the angular acceleration of a member.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Acceleration {
    pub linear: Vec3,
    pub angular: Vec3,
}

/// Penetration, normal and rates of one contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// p, negative where there is a gap `[m]`.
    pub penetration: f64,
    /// Approach speed of the two materials there `[m/s]`: p′, except for the ends of a capsule.
    pub rate: f64,
    /// p′ `[m/s]`
    pub growth: f64,
    /// n, from the second to the first.
    pub normal: Vec3,
    /// n′ `[1/s]`
    pub normal_rate: Vec3,
    /// Growth of p per displacement against n, and its rate `[1/s]`.
    pub slope: f64,
    pub slope_rate: f64,
    /// Midway between the two surfaces.
    pub point: Vec3,
    /// Velocity of that place, no material point's.
    point_velocity: Vec3,
    /// Velocity of the first's material point at it, less that of the second's.
    sliding: Vec3,
}

impl Touch {
    /// Returns a placeholder for a contact that has not been evaluated.
    pub fn none() -> Self {
        Self {
            penetration: 0.0,
            rate: 0.0,
            growth: 0.0,
            normal: Vec3::ZERO,
            normal_rate: Vec3::ZERO,
            slope: 1.0,
            slope_rate: 0.0,
            point: Vec3::ZERO,
            point_velocity: Vec3::ZERO,
            sliding: Vec3::ZERO,
        }
    }

    /// Creates a contact of two members that overlap by `penetration` along `normal` about `point`; all three move.
    pub fn across(
        penetration: f64,
        normal: Vec3,
        normal_rate: Vec3,
        point: Vec3,
        point_velocity: Vec3,
        [first, second]: [&Placed; 2],
    ) -> Self {
        let sliding = first.velocity_at(point) - second.velocity_at(point);
        let rate = -normal.dot(sliding);
        Self {
            penetration,
            rate,
            growth: rate,
            normal,
            normal_rate,
            slope: 1.0,
            slope_rate: 0.0,
            point,
            point_velocity,
            sliding,
        }
    }

    /// Returns the same touch for an inactive contact, with an infinite gap.
    pub fn of_none(self) -> Self {
        Self {
            penetration: f64::NEG_INFINITY,
            ..self
        }
    }

    /// Tangential relative velocity of the material points.
    pub fn tangential(&self) -> Vec3 {
        self.sliding.across(self.normal)
    }

    /// Returns the velocity of the point midway between the surfaces.
    #[cfg(test)]
    pub fn point_velocity(&self) -> Vec3 {
        self.point_velocity
    }

    /// Returns the rate of a tangent vector z that is carried with the normal: (n × n′) × z.
    pub fn carried(&self, z: Vec3) -> Vec3 {
        self.normal_rate * self.normal.dot(z) - self.normal * self.normal_rate.dot(z)
    }

    /// The rate of `rate` `[m/s²]`, from the accelerations of the two.
    pub fn second_rate(
        &self,
        [first, second]: [&Placed; 2],
        [first_rate, second_rate]: [&Acceleration; 2],
    ) -> f64 {
        let of = |placed: &Placed, rate: &Acceleration| {
            rate.linear
                + rate.angular.cross(self.point - placed.position)
                + placed.turning.cross(self.point_velocity - placed.velocity)
        };
        let relative = of(first, first_rate) - of(second, second_rate);
        let along = self.normal_rate.dot(self.sliding) + self.normal.dot(relative);
        -self.slope * along - self.slope_rate * self.normal.dot(self.sliding)
    }
}

/// Position of a surface relative to a point.
struct Lies {
    /// `[m]`
    distance: f64,
    /// Out of the surface, and how it turns `[1/s]`.
    normal: Vec3,
    normal_rate: Vec3,
    /// Growth of the distance per displacement along the normal, and its rate `[1/s]`.
    slope: f64,
    slope_rate: f64,
}

impl Contact {
    /// Returns the relative position of the two members, by the formula of `feature`.
    pub fn touch(&self, feature: Feature, placed: &[Placed]) -> Touch {
        let (first, second) = (&placed[self.first], &placed[self.second]);
        if let (Some((solids, number)), Feature::Between(plane)) = (&self.solids, feature) {
            return plane.touch(*number, solids, [first, second]);
        }
        if let (Some((cylinder, number)), Feature::OnCylinder(at)) = (&self.cylinder, feature) {
            let mut found = [Touch::none()];
            cylinder.touch(*number, at, [first, second], &mut found);
            return found[0];
        }
        if let Some((rod, end)) = &self.rod {
            return rod.touch(*end, [first, second]);
        }
        let centre = first.position + first.rotation.out(self.on_first);
        let velocity = first.velocity_at(centre);
        let relative = velocity - second.velocity_at(centre);
        let Lies {
            distance,
            normal,
            normal_rate,
            slope,
            slope_rate,
        } = self.lies(feature, centre, relative, second);
        let penetration = self.radius - distance;
        // n · (ω × (place − centre)) is 0 for every place on the normal through the centre.
        let rate = -slope * normal.dot(relative);
        let below = self.radius - 0.5 * penetration;
        let point = centre - normal * below;
        Touch {
            penetration,
            rate,
            growth: rate,
            normal,
            normal_rate,
            slope,
            slope_rate,
            point,
            point_velocity: velocity - normal_rate * below + normal * (0.5 * rate),
            sliding: first.velocity_at(point) - second.velocity_at(point),
        }
    }

    /// Computes this contact and the following ones if one plane that is expensive to find serves all. Returns whether
    /// it does.
    pub fn touch_all(&self, feature: Feature, placed: &[Placed], found: &mut [Touch]) -> bool {
        let (Some((cylinder, number)), Feature::OnCylinder(at)) = (&self.cylinder, feature) else {
            return false;
        };
        if *number == 0 {
            let two = [&placed[self.first], &placed[self.second]];
            cylinder.touch(0, at, two, found);
        }
        true
    }

    /// Returns the position of the second member's surface relative to a point in the world that moves against it.
    fn lies(&self, feature: Feature, centre: Vec3, relative: Vec3, second: &Placed) -> Lies {
        let local = || second.rotation.back(centre - second.position);
        let turned =
            |normal: Vec3, rate: Vec3| second.turning.cross(normal) + second.rotation.out(rate);
        if let Some(field) = &self.field {
            let at = field.at(local(), second.rotation.back(relative));
            let slope = at.gradient.norm();
            let own = at.gradient.direction().unwrap_or(Vec3([1.0, 0.0, 0.0]));
            let normal = second.rotation.out(own);
            let across = at.gradient_rate.across(own);
            return Lies {
                distance: at.value,
                normal,
                normal_rate: turned(normal, across * (1.0 / slope.max(f64::MIN_POSITIVE))),
                slope,
                slope_rate: at.gradient_rate.dot(own),
            };
        }
        let (distance, normal, normal_rate) = match (&self.surface, feature) {
            (Shape::HalfSpace { normal, offset }, _) => {
                // The body is fixed, so the normal does not turn.
                let normal = second.rotation.out(Vec3(*normal));
                let distance = normal.dot(centre - second.position) - offset;
                (distance, normal, Vec3::ZERO)
            }
            (Shape::Mesh(mesh), Feature::OnMesh(at)) => {
                let velocity = second.rotation.back(relative);
                let (depth, normal, rate) =
                    super::mesh::nearest(mesh, at, self.radius, local(), velocity);
                let normal = second.rotation.out(normal);
                (self.radius - depth, normal, turned(normal, rate))
            }
            (shape, _) => {
                let near = nearest(shape, feature, local());
                let normal = second.rotation.out(near.normal);
                let rate = near.normal_rate(second.rotation.back(relative));
                (near.distance, normal, turned(normal, rate))
            }
        };
        Lies {
            distance,
            normal,
            normal_rate,
            slope: 1.0,
            slope_rate: 0.0,
        }
    }

    /// Returns the required states of the contacts of a sphere with a mesh, for the present states `now`; this is one
    /// of these contacts. `None` for another shape.
    pub fn wanted_of_mesh(
        &self,
        now: &[OnMesh; MAX_CONTACTS],
        placed: &[Placed],
        shift: Vec3,
    ) -> Option<[OnMesh; MAX_CONTACTS]> {
        let Shape::Mesh(mesh) = &self.surface else {
            return None;
        };
        if self.field.is_some() {
            return None;
        }
        let centre = self.centre_in_second(placed) + shift;
        Some(super::mesh::wanted(mesh, now, self.radius, centre))
    }

    /// Returns the required feature of all contacts of two solids, for the present one `now`; `None` if each contact
    /// has its own feature.
    pub fn wanted_of_solids(
        &self,
        now: Option<Feature>,
        placed: &[Placed],
        slack: f64,
    ) -> Option<Feature> {
        let two = [&placed[self.first], &placed[self.second]];
        if let Some((solids, _)) = &self.solids {
            let now = match now {
                Some(Feature::Between(now)) => Some(now),
                _ => None,
            };
            return Some(Feature::Between(Between::least(now, solids, two, slack)));
        }
        let (cylinder, _) = self.cylinder.as_ref()?;
        let now = match now {
            Some(Feature::OnCylinder(now)) => Some(now),
            _ => None,
        };
        Some(Feature::OnCylinder(cylinder.wanted(now, two, slack)))
    }

    /// Whether it is of two solids that have one feature for all of their contacts.
    fn is_of_solids(&self) -> bool {
        self.solids.is_some() || self.cylinder.is_some()
    }

    /// Whether it is the first one of two such solids.
    pub fn begins_solids(&self) -> bool {
        matches!(self.solids, Some((_, 0))) || matches!(self.cylinder, Some((_, 0)))
    }

    /// Returns the number of contacts of two such solids.
    pub fn of_pair(&self) -> usize {
        let flat = self.solids.iter().map(|(solids, _)| solids.contacts());
        let round = self.cylinder.iter().map(|(with, _)| with.contacts());
        flat.chain(round).next().unwrap_or(1)
    }

    /// Whether its feature is found for several contacts together.
    pub fn is_of_several(&self) -> bool {
        self.is_with_mesh() || self.is_of_solids()
    }

    /// Whether it is with the triangles of a mesh.
    pub fn is_with_mesh(&self) -> bool {
        self.field.is_none() && matches!(self.surface, Shape::Mesh(_))
    }

    fn centre_in_second(&self, placed: &[Placed]) -> Vec3 {
        let (first, second) = (&placed[self.first], &placed[self.second]);
        let centre = first.position + first.rotation.out(self.on_first);
        second.rotation.back(centre - second.position)
    }

    /// The feature of the surface that is nearest.
    pub fn feature(&self, placed: &[Placed]) -> Feature {
        if let Some(feature) = self.wanted_of_solids(None, placed, 0.0) {
            return feature;
        }
        if self.rod.is_some() || self.field.is_some() {
            return Feature::Whole;
        }
        feature(&self.surface, self.centre_in_second(placed))
    }

    /// Whether `current` is that, but for `slack` `[m]`.
    pub fn holds(&self, current: Feature, placed: &[Placed], slack: f64) -> bool {
        current == Feature::Whole
            || self.is_of_solids()
            || holds(&self.surface, current, self.centre_in_second(placed), slack)
    }

    /// The contacts of every pair of a checked scene.
    pub fn of_scene(scene: &WorldScene) -> Result<Vec<Self>, WorldError> {
        let mut contacts = Vec::new();
        for (number, pair) in scene.pairs.iter().enumerate() {
            let found = of_pair(scene, number, pair)
                .map_err(|reason| WorldError::Pair { number, reason })?;
            contacts.extend(found);
        }
        Ok(contacts)
    }
}

//! A cylinder as it lies in the world, and how its rims lie behind a plane.

use super::contact::Placed;
use super::vector::Vec3;

/// A plane that moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub normal: Vec3,
    pub normal_rate: Vec3,
    /// A place in it, and the velocity of that place.
    pub on: Vec3,
    pub on_velocity: Vec3,
}

impl Moving {
    pub fn depth(&self, place: Vec3) -> f64 {
        self.normal.dot(self.on - place)
    }

    pub fn depth_rate(&self, place: Vec3, velocity: Vec3) -> f64 {
        self.normal_rate.dot(self.on - place) + self.normal.dot(self.on_velocity - velocity)
    }

    /// A place on a solid, and how it lies behind the plane.
    pub fn point(&self, place: Vec3, velocity: Vec3) -> Point {
        Point {
            place,
            velocity,
            depth: self.depth(place),
            depth_rate: self.depth_rate(place, velocity),
        }
    }
}

/// A point of a solid: where it is, how that moves, and how deep it lies.
pub(super) struct Point {
    pub place: Vec3,
    pub velocity: Vec3,
    pub depth: f64,
    pub depth_rate: f64,
}

/// How a rim lies behind a plane.
pub(super) struct Behind {
    /// Of its centre, and by how much more its deepest place is deep.
    pub depth: f64,
    pub more: f64,
}

impl Behind {
    pub fn deepest(&self) -> f64 {
        self.depth + self.more
    }

    /// The squared depths of the points of the rim that are behind the plane, one of them at the deepest place.
    pub fn squares(&self, cosines: &[f64]) -> f64 {
        if self.depth >= self.more {
            return cosines.len() as f64 * (self.depth * self.depth + 0.5 * self.more * self.more);
        }
        let depths = cosines.iter().map(|cosine| self.depth + self.more * cosine);
        depths.map(|depth| depth.max(0.0).powi(2)).sum()
    }
}

/// A cylinder as it lies.
pub(super) struct Tube<'a> {
    pub placed: &'a Placed,
    pub radius: f64,
    pub half_length: f64,
    /// Along it, and how that turns.
    pub axis: Vec3,
    pub axis_rate: Vec3,
}

impl<'a> Tube<'a> {
    pub fn new([radius, half_length]: [f64; 2], placed: &'a Placed) -> Self {
        let axis = placed.rotation.out(Vec3([0.0, 0.0, 1.0]));
        Self {
            placed,
            radius,
            half_length,
            axis,
            axis_rate: placed.turning.cross(axis),
        }
    }

    /// Of a rim.
    pub fn centre(&self, rim: usize) -> Vec3 {
        self.placed.position + self.axis * (side_of(rim) * self.half_length)
    }

    pub fn behind(&self, rim: usize, plane: &Moving) -> Behind {
        Behind {
            depth: plane.depth(self.centre(rim)),
            more: self.radius * plane.normal.across(self.axis).norm(),
        }
    }

    /// A place that turns about a rim with its deepest place, by an angle on from there.
    pub fn turned(&self, rim: usize, plane: &Moving, (sine, cosine): (f64, f64)) -> Point {
        let (a, a_rate) = (self.axis, self.axis_rate);
        let (along, along_rate) = (
            plane.normal.dot(a),
            plane.normal_rate.dot(a) + plane.normal.dot(a_rate),
        );
        // Part of the normal across the axis; the deepest place is on the other side.
        let across = plane.normal.across(a);
        let size = across.norm();
        let up = across.direction().unwrap_or(Vec3::ZERO);
        let across_rate = plane.normal_rate - a * along_rate - a_rate * along;
        let up_rate = if size > 0.0 {
            across_rate.across(up) * (1.0 / size)
        } else {
            Vec3::ZERO
        };
        let side = a.cross(up);
        let side_rate = a_rate.cross(up) + a.cross(up_rate);
        let (out, out_rate) = (
            (up * cosine + side * sine) * -1.0,
            (up_rate * cosine + side_rate * sine) * -1.0,
        );
        let (centre, radius) = (self.centre(rim), self.radius);
        let centre_velocity = self.placed.velocity_at(centre);
        Point {
            place: centre + out * radius,
            velocity: centre_velocity + out_rate * radius,
            depth: plane.depth(centre) + radius * size * cosine,
            depth_rate: plane.depth_rate(centre, centre_velocity)
                + radius * up.dot(across_rate) * cosine,
        }
    }

    /// A place of a rim by its angle about the cylinder's own axis.
    pub fn held(&self, rim: usize, plane: &Moving, (sine, cosine): (f64, f64)) -> Point {
        let out = self.placed.rotation.out(Vec3([cosine, sine, 0.0]));
        let place = self.centre(rim) + out * self.radius;
        plane.point(place, self.placed.velocity_at(place))
    }
}

/// On which side of the centre a rim is.
pub(super) fn side_of(rim: usize) -> f64 {
    if rim == 0 { -1.0 } else { 1.0 }
}

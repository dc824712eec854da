//! A host of its own: a body and a floor, computed finely, but only once in a while.

use palpate_world::ContactLaw;
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::LocalContact;

use crate::low_rate_simulator::scenes::{BODY_MASS, Body, GRAVITY, HALF, STIFFNESS, Scene};
use crate::low_rate_simulator::vector::{
    Vector, cross, dot, length, less, sum, times, turned, turned_back, turned_on,
};

/// Length of a part into which the host divides its steps `[s]`.
pub const FINE: f64 = 5e-5;

#[derive(Clone, Debug)]
pub struct Host {
    scene: Scene,
    pub position: Vector,
    pub orientation: [f64; 4],
    pub velocity: Vector,
    pub omega: Vector,
    /// Spheres that touch the floor, in the body's axes, and the bristle of each.
    feet: Vec<(Vector, Vector)>,
    /// Mean force and torque of the floor over the last step.
    by_floor: [Vector; 2],
    /// Work of the tool on the body.
    pub work: f64,
    /// Longest part of a step `[s]`.
    pub part: f64,
}

impl Host {
    pub fn new(scene: &Scene) -> Self {
        let corners = (0..8).map(|corner: usize| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { HALF } else { -HALF };
            ([side(0), side(1), side(2)], [0.0; 3])
        });
        let feet = match (scene.body, scene.floor) {
            (_, None) | (Body::Hill(_) | Body::Bumps, _) => Vec::new(),
            (Body::Ball(_), _) => vec![([0.0; 3], [0.0; 3])],
            (Body::Cube(_), _) => corners.collect(),
        };
        Self {
            scene: scene.clone(),
            position: scene.place,
            orientation: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.0; 3],
            omega: [0.0; 3],
            feet,
            by_floor: [[0.0; 3]; 2],
            work: 0.0,
            part: FINE,
        }
    }

    fn moves(&self) -> bool {
        !matches!(self.scene.body, Body::Hill(_) | Body::Bumps)
    }

    fn inverse_moment(&self) -> f64 {
        let square = HALF * HALF;
        match self.scene.body {
            Body::Cube(_) => 1.5 / (BODY_MASS * square),
            _ => 2.5 / (BODY_MASS * square),
        }
    }

    /// Radius of a foot.
    fn foot(&self) -> f64 {
        if let Body::Ball(radius) = self.scene.body {
            radius
        } else {
            0.0
        }
    }

    /// The law of a foot on the floor.
    fn floor_law(&self) -> Option<ContactLaw> {
        let (stiffness, damping, friction) = self.scene.floor?;
        // A cube that lies flat has four corners on the floor.
        let points = if self.feet.len() == 8 { 4.0 } else { 1.0 };
        let law = ContactLaw::spring(stiffness / points).with_damping(damping / points);
        Some(law.with_friction(friction))
    }

    /// A step of `h` `[s]`, in which the tool pushes the body by a force at a place, given the host as it is.
    pub fn step(&mut self, h: f64, mut push: impl FnMut(&Self, f64) -> [Vector; 2]) {
        let count = (h / self.part).ceil();
        let fine = h / count;
        let mut floor = [[0.0; 3]; 2];
        let mut done = 0.0;
        while done < count {
            done += 1.0;
            let [force, torque] = push(self, fine);
            if !self.moves() {
                continue;
            }
            self.work += fine * (dot(force, self.velocity) + dot(torque, self.omega));
            let [by_floor, floor_torque] = self.on_floor(fine);
            floor[0] = sum(floor[0], times(by_floor, 1.0 / count));
            floor[1] = sum(floor[1], times(floor_torque, 1.0 / count));
            let weight = [0.0, 0.0, -GRAVITY];
            let linear = sum(times(sum(force, by_floor), 1.0 / BODY_MASS), weight);
            let angular = times(sum(torque, floor_torque), self.inverse_moment());
            // By the mean velocity, which is exact in free fall.
            let before = self.velocity;
            self.velocity = sum(before, times(linear, fine));
            self.omega = sum(self.omega, times(angular, fine));
            let mean = times(sum(before, self.velocity), 0.5);
            self.position = sum(self.position, times(mean, fine));
            self.orientation = turned_on(self.orientation, self.omega, fine);
        }
        self.by_floor = floor;
    }

    fn on_floor(&mut self, h: f64) -> [Vector; 2] {
        let Some(law) = self.floor_law() else {
            return [[0.0; 3]; 2];
        };
        let radius = self.foot();
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        for (foot, bristle) in &mut self.feet {
            let centre = sum(self.position, turned(self.orientation, *foot));
            let depth = radius - centre[2];
            if depth <= 0.0 {
                *bristle = [0.0; 3];
                continue;
            }
            let place = [centre[0], centre[1], -0.5 * depth];
            let arm = less(place, self.position);
            let velocity = sum(self.velocity, cross(self.omega, arm));
            let normal = (law.stiffness * depth - law.damping * velocity[2]).max(0.0);
            let most = law.friction * normal / law.friction_stiffness;
            *bristle = sum(*bristle, times([velocity[0], velocity[1], 0.0], h));
            let stretched = length(*bristle);
            if stretched > most {
                *bristle = times(*bristle, if most > 0.0 { most / stretched } else { 0.0 });
            }
            let pull = times(*bristle, -law.friction_stiffness);
            let by_foot = [pull[0], pull[1], normal];
            force = sum(force, by_foot);
            torque = sum(torque, cross(arm, by_foot));
        }
        [force, torque]
    }

    /// Signed distance of a sphere's centre from the body, and the normal there.
    pub fn distance(&self, centre: Vector) -> (f64, Vector) {
        let from = less(centre, self.position);
        match self.scene.body {
            Body::Ball(radius) | Body::Hill(radius) => {
                let far = length(from);
                (far - radius, times(from, 1.0 / far))
            }
            Body::Bumps => {
                let mesh = self.scene.mesh.as_ref().unwrap();
                let out = less(from, mesh.nearest(from));
                let far = length(out);
                (far, times(out, 1.0 / far))
            }
            Body::Cube(half) => {
                let own = turned_back(self.orientation, from);
                let nearest = own.map(|x| x.clamp(-half, half));
                let out = less(own, nearest);
                let far = length(out);
                if far > 0.0 {
                    return (far, turned(self.orientation, times(out, 1.0 / far)));
                }
                let axis = (0..3).max_by(|a, b| own[*a].abs().total_cmp(&own[*b].abs()));
                let axis = axis.unwrap();
                let mut normal = [0.0; 3];
                normal[axis] = own[axis].signum();
                (own[axis].abs() - half, turned(self.orientation, normal))
            }
        }
    }

    /// The tool's contact and, if asked for, those with the floor, as they are published.
    pub fn contacts(
        &self,
        (tool, way): (Vector, Vector),
        is_curved: bool,
        with_floor: bool,
    ) -> Vec<Option<LocalContact>> {
        let (distance, normal) = self.distance(tool);
        let law = ContactLaw::spring(STIFFNESS).with_friction(self.scene.friction);
        let on = self.moves().then_some(0);
        let radius = self.scene.tool();
        let contact = LocalContact::at_gap((0, tool, radius), on, distance - radius, normal, law);
        let curvature = match self.scene.body {
            Body::Ball(radius) | Body::Hill(radius) if is_curved => 1.0 / radius,
            Body::Bumps if is_curved => self.curvature(tool, normal, way),
            _ => 0.0,
        };
        let mut contacts = vec![Some(contact.curved(curvature))];
        if let Some(law) = self.floor_law().filter(|_| with_floor) {
            let up = [0.0, 0.0, 1.0];
            contacts.extend(self.feet.iter().map(|(foot, _)| {
                let centre = sum(self.position, turned(self.orientation, *foot));
                let foot = (0, centre, self.foot());
                Some(LocalContact::of_body(
                    foot,
                    None,
                    [centre[0], centre[1], 0.0],
                    up,
                    law,
                ))
            }));
        }
        contacts
    }

    /// Curvature of the surface along the way that the tool goes until the next model, by the normal at its end.
    fn curvature(&self, tool: Vector, normal: Vector, way: Vector) -> f64 {
        let along = less(way, times(normal, dot(way, normal)));
        let far = length(along);
        if far < 1e-4 {
            return 0.0;
        }
        let (_, turned) = self.distance(sum(tool, along));
        // Of the surface on which the tool's centre goes, and so of the one below it.
        let of_centre = dot(less(turned, normal), along) / (far * far);
        of_centre / (1.0 - of_centre * self.scene.tool()).max(0.1)
    }

    /// The body, with what else accelerates it: the weight, and the floor where its contacts are not published.
    pub fn bodies(&self, with_floor: bool) -> Vec<BodyNow> {
        if !self.moves() {
            return Vec::new();
        }
        let mut now = BodyNow::fixed(self.position);
        now.orientation = self.orientation;
        now.velocity = self.velocity;
        now.angular_velocity = self.omega;
        now.acceleration = [0.0, 0.0, -GRAVITY];
        if !with_floor {
            now.acceleration = sum(now.acceleration, times(self.by_floor[0], 1.0 / BODY_MASS));
            now.angular_acceleration = times(self.by_floor[1], self.inverse_moment());
        }
        for axis in 0..3 {
            now.mobility[axis][axis] = 1.0 / BODY_MASS;
            now.mobility[axis + 3][axis + 3] = self.inverse_moment();
        }
        vec![now]
    }

    /// Force of a tool at `centre` on the body by a spring and damper, with its torque, for a tool that moves with
    /// `velocity`.
    pub fn pushed_by(&self, centre: Vector, velocity: Vector, damping: f64) -> [Vector; 2] {
        let (distance, normal) = self.distance(centre);
        let depth = self.scene.tool() - distance;
        if depth <= 0.0 {
            return [[0.0; 3]; 2];
        }
        let place = less(centre, times(normal, self.scene.tool() - 0.5 * depth));
        let arm = less(place, self.position);
        let own = sum(self.velocity, cross(self.omega, arm));
        let rate = dot(less(own, velocity), normal);
        let pressed = (STIFFNESS * depth + damping * rate).max(0.0);
        let force = times(normal, -pressed);
        [force, cross(arm, force)]
    }

    /// Returns the stored energy for a tool at `centre` `[J]`.
    pub fn stored(&self, centre: Vector) -> f64 {
        let depth = (self.scene.tool() - self.distance(centre).0).max(0.0);
        0.5 * STIFFNESS * depth * depth
    }
}

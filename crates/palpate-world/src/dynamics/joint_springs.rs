//! Springs of joints in motion.

use crate::description::joint::{Joint, JointKind, JointLaw};
use crate::dynamics::moving_body::{Part, Twist};
use crate::geometry::rigid::{Rigid, Rotation, Vector3};

/// Spring, damper and stops along a joint's coordinate.
#[derive(Clone, Copy, Debug)]
struct Along {
    spring: f64,
    rest: f64,
    damping: f64,
    stop: f64,
    limits: Option<[f64; 2]>,
}

impl Along {
    /// Returns the distance beyond a stop.
    fn beyond(&self, q: f64) -> f64 {
        self.limits
            .map_or(0.0, |[low, high]| q - q.clamp(low, high))
    }

    /// Returns the restoring force at q, without damping.
    fn force(&self, q: f64) -> f64 {
        -self.spring * (q - self.rest) - self.stop * self.beyond(q)
    }

    fn stored(&self, q: f64) -> f64 {
        0.5 * (self.spring * (q - self.rest).powi(2) + self.stop * self.beyond(q).powi(2))
    }
}

/// Quantity constrained by a link.
#[derive(Clone, Copy, Debug)]
enum Holds {
    /// A point of the first part, fixed to the second: stiffness and damping along the three axes of its frame.
    Point {
        stiffness: Vector3,
        damping: Vector3,
    },
    /// Displacement of that point along the first axis of the frame.
    Way(Along),
    /// Angle about the first axis of the frame. `mark` is a unit vector of the first part, initially along the
    /// frame's second axis.
    Angle { mark: Vector3, along: Along },
}

/// An element of a joint, with its state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Index of its joint.
    pub joint: usize,
    pub first: usize,
    /// `None`: the world.
    pub second: Option<usize>,
    /// The point in the axes of the first part `[m]`.
    on_first: Vector3,
    /// Initial position of the point in the axes of the second part `[m]`.
    on_second: Vector3,
    /// Frame in the axes of the second part.
    frame: [Vector3; 3],
    holds: Holds,
    /// Upper bound of the mobility at the point on each side, constant because it is in body axes `[1/kg]`.
    moves: [f64; 2],
    /// -1 or 1 beyond a stop.
    beyond: i8,
    /// Energy stored in its springs `[J]`.
    pub stored: f64,
    /// Force on the first part, at the point `[N]`.
    force: Vector3,
    /// Part of the force due to damping.
    by_damping: Vector3,
    /// Torque on the first part `[N m]`; `torque_by_damping` is its damping part.
    torque: Vector3,
    torque_by_damping: Vector3,
    place: Vector3,
    relative: Twist,
    damping_power: f64,
    /// Work on both sides since the interval began `[J]`.
    pub work: f64,
    /// Energy dissipated by damping since the interval began `[J]`.
    pub dissipated: f64,
}

/// Creates the links of a joint for the initial poses of the bodies.
pub(crate) fn links_of(
    joint: &Joint,
    number: usize,
    [first, second]: [Option<usize>; 2],
    parts: &[Part],
) -> Vec<Link> {
    let Some(first) = first else {
        return Vec::new();
    };
    let axis = Vector3::from(joint.axis).normalize();
    let one = &parts[first].rigid;
    let across = across(&axis, &one.orientation);
    let mount = Mount {
        law: &joint.law,
        number,
        sides: (first, second),
        axes: [axis, across, axis.cross(&across)],
        other: second.map_or(rigid_world(), |second| parts[second].rigid),
        parts,
    };
    let law = &joint.law;
    let point: Vector3 = joint.point.into();
    let half = 0.5 * law.span;
    match joint.kind {
        JointKind::Hinge => vec![
            mount.hold(point + axis * half, Vector3::repeat(0.5)),
            mount.hold(point - axis * half, Vector3::repeat(0.5)),
            mount.link(
                point,
                Holds::Angle {
                    mark: one.orientation.inverse() * across,
                    along: along(law, law.stiffness * half * half),
                },
            ),
        ],
        JointKind::Slider => {
            let weights = Vector3::new(0.0, 0.25, 0.25);
            let mut links: Vec<_> = [axis, -axis, across, -across]
                .map(|way| mount.hold(point + way * half, weights))
                .into();
            links.push(mount.link(point, Holds::Way(along(law, law.stiffness))));
            links
        }
    }
}

/// A joint at the initial poses of its bodies.
struct Mount<'a> {
    /// Law of the joint.
    law: &'a JointLaw,
    /// Index of the joint.
    number: usize,
    /// Indices of the moving body and of the reference body among the parts; `None`: the world.
    sides: (usize, Option<usize>),
    /// Frame of the joint, along the world's axes; the first is the joint's axis.
    axes: [Vector3; 3],
    /// Pose of the reference body.
    other: Rigid,
    /// Tools and bodies at their initial poses.
    parts: &'a [Part],
}

impl Mount<'_> {
    /// Creates a link at a point along the world's axes `[m]`.
    fn link(&self, place: Vector3, holds: Holds) -> Link {
        let (first, second) = self.sides;
        let (one, other) = (&self.parts[first].rigid, &self.other);
        let moves = |number: Option<usize>, lever: Vector3| {
            number.map_or(0.0, |number| moves_at(&self.parts[number], lever))
        };
        Link {
            moves: [
                moves(
                    Some(first),
                    one.orientation.inverse() * (place - one.position),
                ),
                moves(
                    second,
                    other.orientation.inverse() * (place - other.position),
                ),
            ],
            joint: self.number,
            first,
            second,
            on_first: one.orientation.inverse() * (place - one.position),
            on_second: other.orientation.inverse() * (place - other.position),
            frame: self.axes.map(|axis| other.orientation.inverse() * axis),
            holds,
            beyond: 0,
            stored: 0.0,
            force: Vector3::zeros(),
            by_damping: Vector3::zeros(),
            torque: Vector3::zeros(),
            torque_by_damping: Vector3::zeros(),
            place,
            relative: Twist::none(),
            damping_power: 0.0,
            work: 0.0,
            dissipated: 0.0,
        }
    }

    /// Creates a link that holds a point `[m]`, with these fractions of the joint's law along the three axes.
    fn hold(&self, place: Vector3, weights: Vector3) -> Link {
        self.link(
            place,
            Holds::Point {
                stiffness: weights * self.law.stiffness,
                damping: weights * self.law.damping,
            },
        )
    }
}

/// Returns the spring, damper and stops along the coordinate of a joint, for a stiffness of the stops `[N/m]`, of a
/// hinge `[N m/rad]`.
fn along(law: &JointLaw, stop: f64) -> Along {
    Along {
        spring: law.spring,
        rest: law.rest,
        damping: law.along_damping,
        stop,
        limits: law.limits,
    }
}

/// Tolerance for equal components of a unit vector.
const EQUAL: f64 = 1e-6;

/// Returns a unit vector perpendicular to the axis of a joint, from the body axis with the smallest component along
/// it; ties go to the lower index. It thus rotates with the whole world.
fn across(axis: &Vector3, orientation: &Rotation) -> Vector3 {
    let own = orientation.inverse() * axis;
    let most = own.amin() + EQUAL;
    let place = own.iter().position(|along| along.abs() <= most);
    let way = Vector3::ith(place.unwrap_or(0), 1.0);
    orientation * (way - own * own.dot(&way)).normalize()
}

/// Returns an upper bound of the mobility of a part at `lever` from its centre of mass, in its own axes `[1/kg]`.
fn moves_at(part: &Part, lever: Vector3) -> f64 {
    // The norm bounds the largest eigenvalue of 1/m - [r] I^-1 [r].
    let across = lever.cross_matrix();
    let turns = across * nalgebra::Matrix3::from_diagonal(&part.mobility.angular) * across;
    part.mobility.linear.max() + turns.norm()
}

fn rigid_world() -> Rigid {
    Rigid {
        position: Vector3::zeros(),
        orientation: Rotation::identity(),
        velocity: Vector3::zeros(),
        spin: Vector3::zeros(),
    }
}

impl Link {
    /// Attaches a new joint in a running world: point and axes are taken from the poses `described`, and the joint
    /// holds the bodies at their poses `now`, which may differ.
    pub fn is_borne(&mut self, described: &[Part], now: &[Part]) {
        let of_second = |parts: &[Part]| match self.second {
            Some(second) => parts[second].rigid,
            None => rigid_world(),
        };
        let (one, other) = (described[self.first].rigid, of_second(described));
        let place = one.position + one.orientation * self.on_first;
        let axes = self.frame.map(|axis| other.orientation * axis);
        let (one, other) = (now[self.first].rigid, of_second(now));
        self.place = place;
        self.on_first = one.orientation.inverse() * (place - one.position);
        self.on_second = other.orientation.inverse() * (place - other.position);
        self.frame = axes.map(|axis| other.orientation.inverse() * axis);
        if let Holds::Angle { mark, .. } = &mut self.holds {
            *mark = one.orientation.inverse() * axes[1];
        }
        self.find_moves(now);
    }

    fn find_moves(&mut self, parts: &[Part]) {
        let of_second = self
            .second
            .map_or(0.0, |second| moves_at(&parts[second], self.on_second));
        self.moves = [moves_at(&parts[self.first], self.on_first), of_second];
    }

    /// Takes the anchors of a link with the same bearing in another world, so that the coordinate continues.
    pub fn stays_at(&mut self, before: &Self, parts: &[Part]) {
        self.on_first = before.on_first;
        self.on_second = before.on_second;
        self.frame = before.frame;
        self.beyond = before.beyond;
        if let (Holds::Angle { mark, .. }, Holds::Angle { mark: was, .. }) =
            (&mut self.holds, &before.holds)
        {
            *mark = *was;
        }
        self.find_moves(parts);
    }

    /// Continues with the force of a link with the same bearing in another world.
    pub fn goes_on_from(&mut self, before: &Self) {
        self.beyond = before.beyond;
        self.force = before.force;
        self.by_damping = before.by_damping;
        self.torque = before.torque;
        self.torque_by_damping = before.torque_by_damping;
        self.place = before.place;
        self.relative = before.relative;
        self.damping_power = before.damping_power;
    }

    /// Begins an interval.
    pub fn begin(&mut self) {
        self.work = 0.0;
        self.dissipated = 0.0;
    }

    /// Returns whether contact with a stop has begun or ended.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.beyond != other.beyond
    }

    fn relative(&self, parts: &[Part], twist: fn(&Part) -> &Twist) -> Twist {
        let of = |number: usize| {
            let part = &parts[number];
            Twist {
                velocity: part.velocity_at(twist(part), &self.place),
                turning: twist(part).turning,
            }
        };
        let first = of(self.first);
        let second = self.second.map_or(Twist::none(), of);
        Twist {
            velocity: first.velocity - second.velocity,
            turning: first.turning - second.turning,
        }
    }

    /// Evaluates the link at the current poses and applies its load.
    pub fn meet(&mut self, parts: &mut [Part]) {
        let first = parts[self.first].rigid;
        let second = self
            .second
            .map_or(rigid_world(), |number| parts[number].rigid);
        self.place = first.position + first.orientation * self.on_first;
        let ahead = self.relative(parts, |part| &part.ahead);
        self.relative = self.relative(parts, |part| &part.twist);
        let axes = self.frame.map(|axis| second.orientation * axis);
        let off = self.place - second.position - second.orientation * self.on_second;
        let none = Vector3::zeros();
        (self.force, self.by_damping) = (none, none);
        (self.torque, self.torque_by_damping) = (none, none);
        let q = match self.holds {
            Holds::Point { stiffness, damping } => {
                self.stored = 0.0;
                for (number, axis) in axes.iter().enumerate() {
                    let way = axis.dot(&off);
                    self.stored += 0.5 * stiffness[number] * way * way;
                    self.force -= axis * (stiffness[number] * way);
                    self.by_damping -= axis * (damping[number] * axis.dot(&ahead.velocity));
                }
                0.0
            }
            Holds::Way(along) => {
                let q = axes[0].dot(&off);
                self.stored = along.stored(q);
                self.force = axes[0] * along.force(q);
                self.by_damping = axes[0] * (-along.damping * axes[0].dot(&ahead.velocity));
                along.beyond(q)
            }
            Holds::Angle { mark, along } => {
                let mark = first.orientation * mark;
                let (x, y) = (mark.dot(&axes[1]), mark.dot(&axes[2]));
                let q = y.atan2(x);
                // Rate of change of the angle with the relative rotation.
                let by = mark.cross(&(axes[2] * x - axes[1] * y)) / (x * x + y * y);
                self.stored = along.stored(q);
                self.torque = by * along.force(q);
                self.torque_by_damping = by * (-along.damping * by.dot(&ahead.turning));
                along.beyond(q)
            }
        };
        self.beyond = if q > 0.0 {
            1
        } else if q < 0.0 {
            -1
        } else {
            0
        };
        self.force += self.by_damping;
        self.torque += self.torque_by_damping;
        self.load(parts);
    }

    /// Applies the force and torque of the link to its bodies.
    pub fn load(&self, parts: &mut [Part]) {
        let (force, place) = (self.force, self.place);
        for (number, sign) in [(Some(self.first), 1.0), (self.second, -1.0)] {
            if let Some(part) = number.map(|number| &mut parts[number]) {
                part.load(&(force * sign), &place);
                part.torque += self.torque * sign;
            }
        }
    }

    /// Computes the power dissipated by damping at the current velocities.
    pub fn watch_damping(&mut self, parts: &[Part]) {
        let relative = self.relative(parts, |part| &part.twist);
        let power =
            self.by_damping.dot(&relative.velocity) + self.torque_by_damping.dot(&relative.turning);
        self.damping_power = (-power).max(0.0);
    }

    /// Keeps the force between two parts that have come to rest.
    pub fn rest(&mut self) {
        self.relative = Twist::none();
        self.damping_power = 0.0;
    }

    /// Adds half a sub-step under the force to the sums, ending at the current velocities.
    pub fn entry(&mut self, parts: &[Part], half: f64) {
        let now = self.relative(parts, |part| &part.twist);
        let velocity = self.relative.velocity + now.velocity;
        let turning = self.relative.turning + now.turning;
        self.work += 0.5 * half * (self.force.dot(&velocity) + self.torque.dot(&turning));
        self.dissipated += half * self.damping_power;
        self.relative = now;
    }

    /// Returns the indices of its bodies.
    pub fn sides(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.first), self.second].into_iter().flatten()
    }

    /// Returns bounds of the squared angular frequency `[1/s^2]` and damping rate `[1/s]` at each of its bodies.
    pub fn rates(&self, parts: &[Part]) -> impl Iterator<Item = (usize, f64, f64)> {
        let of = |(number, moves): (usize, f64)| {
            let turns = parts[number].mobility.angular.max();
            let (square, rate) = match self.holds {
                Holds::Point { stiffness, damping } => {
                    (stiffness.max() * moves, damping.max() * moves)
                }
                Holds::Way(along) => ((along.spring + along.stop) * moves, along.damping * moves),
                Holds::Angle { along, .. } => {
                    ((along.spring + along.stop) * turns, along.damping * turns)
                }
            };
            (number, square, rate)
        };
        self.sides().zip(self.moves).map(of)
    }
}

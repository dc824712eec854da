//! A world in motion: where everything is, what the contacts do, and what has passed since an interval began.

use crate::blocks::Blocks;
use crate::interval::SubStepped;
use crate::law::{Mode, carried};
use crate::link::Link;
use crate::linkage::Carried;
use crate::mesh::Surface;
use crate::nearby::{NEARER, Nearby, approached};
use crate::pairs::Point;
use crate::part::{Part, Twist};
use crate::rigid::Vector3;
use crate::solid::{Nearest, Solid};

/// Cosine of the angle by which a normal has to turn in a sub-step to be that of another face.
pub(crate) const SAME_FACE: f64 = 0.9;

/// What a point of contact does, and has done since the interval began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub mode: Mode,
    /// Where the force acts `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// Above 0 where they touch, else 0 `[m]`.
    pub penetration: f64,
    /// Deflection of the bristle `[m]`.
    pub bristle: Vector3,
    /// Normal force `[N]`,
    pub normal_force: f64,
    /// what of it damping adds to the spring `[N]`.
    by_damping: f64,
    /// How fast the two were expected to approach at the sub-step's end `[m/s]`.
    expected: f64,
    /// By how much faster they did approach `[m/s]`. The next sub-step adds this to what it expects, if it is as long.
    missed: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    /// Velocity of the first against the second there `[m/s]`.
    relative: Vector3,
    /// Tangential displacement that the bristle has yet to follow `[m]`.
    pub slid: Vector3,
    /// Power that material damping takes `[W]`.
    damping_power: f64,
    /// Power of the material's damping on what only seems to move, a tool that is held between samples `[W]`.
    apparent_power: f64,
    /// Of what is apart: so far the two may move since the interval began before they can touch; 0 if that is not known `[m]`.
    clear: f64,
    pub past: Past,
}

/// What has passed at a point of contact since the interval began.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Past {
    /// Impulse on the first `[N s]`.
    pub impulse: Vector3,
    /// Angular impulse on the tool of the two about its mass centre `[N m s]`.
    pub angular_impulse: Vector3,
    /// Work on the first and the second together `[J]`.
    pub work: f64,
    /// Work on the tool of the two `[J]`,
    pub work_on_tool: f64,
    /// and what of it the torque does on a turn that the hand alone makes `[J]`.
    pub work_on_led_turn: f64,
    /// Energy that damping and friction took, not below 0 `[J]`.
    pub dissipated: f64,
    /// Energy that other points of the same pair handed to it `[J]`.
    pub handed: f64,
}

/// A contact whose force is held over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Where the force acts `[m]`.
    pub place: Vector3,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// `[N]`
    pub normal_force: f64,
    /// Force on the first `[N]`.
    pub force: Vector3,
    pub slides: bool,
}

impl Touch {
    /// Holds a force from now on.
    pub fn hold(&mut self, held: Held) {
        *self = Self {
            mode: if held.slides {
                Mode::Slides
            } else {
                Mode::Sticks
            },
            place: held.place,
            normal: held.normal,
            normal_force: held.normal_force,
            force: held.force,
            past: self.past,
            ..Self::apart()
        };
    }

    /// Holds no force any more.
    pub fn let_go(&mut self) {
        *self = Self {
            past: self.past,
            ..Self::apart()
        };
    }

    pub fn apart() -> Self {
        let none = Vector3::zeros();
        Self {
            mode: Mode::Free,
            place: none,
            normal: Vector3::x(),
            penetration: 0.0,
            bristle: none,
            normal_force: 0.0,
            by_damping: 0.0,
            expected: 0.0,
            missed: 0.0,
            force: none,
            relative: none,
            slid: none,
            damping_power: 0.0,
            apparent_power: 0.0,
            clear: 0.0,
            past: Past::default(),
        }
    }

    /// The same touch at another point, at which something else has passed.
    pub fn at_the_point_of(self, other: &Self) -> Self {
        Self {
            past: other.past,
            ..self
        }
    }

    pub fn is_apart(&self) -> bool {
        self.mode == Mode::Free
    }

    /// Comes to be as `other`. Of what is apart, nothing but this differs.
    fn copy_from(&mut self, other: &Self) {
        if self.is_apart() && other.is_apart() {
            (self.past, self.clear) = (other.past, other.clear);
        } else {
            *self = *other;
        }
    }

    /// Whether its mode is another than in `other`, or it presses across an edge on another face.
    fn changed_from(&self, other: &Self) -> bool {
        self.mode != other.mode || !self.is_apart() && self.normal.dot(&other.normal) < SAME_FACE
    }

    /// Half a sub-step under the force, while the relative velocity goes from what it was to `relative`, and that of
    /// the tool, if one of the two is, moves as in its own mean.
    fn book(&mut self, relative: &Vector3, tool: Option<(&Part, f64)>, half: f64) {
        let impulse = self.force * half;
        self.past.impulse += impulse;
        let apparent = half * self.apparent_power;
        self.past.work += 0.5 * impulse.dot(&(self.relative + relative)) + apparent;
        if let Some((part, sign)) = tool {
            let on_tool = impulse * sign;
            let arm = self.place - part.rigid.position;
            let mut mean = part.mean.velocity;
            if part.has_torque {
                let by_turning = part.mean.turning.cross(&arm);
                self.past.angular_impulse += arm.cross(&on_tool);
                mean += by_turning;
                if part.led {
                    self.past.work_on_led_turn += on_tool.dot(&by_turning);
                }
            }
            self.past.work_on_tool += on_tool.dot(&mean) + apparent;
        }
        self.past.dissipated += half * self.damping_power;
    }
}

/// A world in motion.
#[derive(Clone, Debug)]
pub(crate) struct Moving {
    /// Tools, then bodies.
    pub parts: Vec<Part>,
    /// How many tools there are.
    pub tools: usize,
    pub touches: Vec<Touch>,
    /// The points that are looked at. No other one touches.
    pub nearby: Nearby,
    /// The meshes that spheres touch.
    pub surfaces: Vec<Surface>,
    /// The pairs of boxes, hulls and capsules.
    pub blocks: Vec<Blocks>,
    /// The springs of the joints.
    pub links: Vec<Link>,
    /// Of each tool, what carries an avatar whose mass changes with its place; of no tool if none has one.
    pub carried: Vec<Option<Carried>>,
    /// Whether the dampers of contacts add to the velocity that they expect what the last sub-step missed.
    pub expects_the_missed: bool,
}

impl Moving {
    /// Takes over the state of another motion of the same world, without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.parts.copy_from_slice(&other.parts);
        self.touches.copy_from_slice(&other.touches);
        self.nearby.copy_from(&other.nearby);
        self.copy_between(other);
    }

    fn copy_between(&mut self, other: &Self) {
        for (surface, other) in self.surfaces.iter_mut().zip(&other.surfaces) {
            surface.copy_from(other);
        }
        for (blocks, other) in self.blocks.iter_mut().zip(&other.blocks) {
            blocks.copy_from(other);
        }
        self.links.copy_from_slice(&other.links);
    }

    pub fn is_finite(&self) -> bool {
        let mut sum = 0.0;
        for Part { rigid, .. } in &self.parts {
            sum += rigid.position.sum() + rigid.velocity.sum() + rigid.spin.sum();
            sum += rigid.orientation.coords.sum();
        }
        for touch in &self.touches {
            sum += touch.bristle.sum() + touch.force.sum() + touch.past.work;
        }
        sum.is_finite()
    }

    /// An interval begins: nothing has passed.
    pub fn begin(&mut self) {
        for touch in &mut self.touches {
            touch.past = Past::default();
        }
        for link in &mut self.links {
            link.begin();
        }
        for part in &mut self.parts {
            part.begin();
        }
    }

    /// Spheres may be on another side of the meshes than they were, and boxes beside other faces of each other.
    pub fn forget_sides(&mut self) {
        for blocks in &mut self.blocks {
            blocks.forget();
        }
        for surface in &mut self.surfaces {
            surface.forget();
        }
    }

    /// Largest number of triangles or contacts of the meshes, or of points of contact, that were left out at a time since this was
    /// last asked.
    pub fn take_left_out(&mut self) -> u32 {
        let each = self.surfaces.iter_mut().map(Surface::take_left_out);
        each.fold(self.nearby.take_left_out(), u32::max)
    }

    /// Looks at all points that touch, after a change from outside.
    pub fn recollect(&mut self) {
        let touches = |number: usize| !self.touches[number].is_apart();
        self.nearby.recollect(touches);
    }

    /// Looks for the points that touch, or may within `h` `[s]`.
    pub fn gather(&mut self, points: &[Point], h: f64) {
        let touches = |number: usize| !self.touches[number].is_apart();
        self.nearby.gather(&self.parts, points, touches, h);
    }

    /// Energy stored in the contact at a point `[J]`.
    pub fn stored(&self, number: usize, point: &Point) -> f64 {
        let touch = &self.touches[number];
        point.law.stored(touch.penetration, &touch.bristle)
    }

    /// An interval begins, so ways are counted anew: no point is known to be clear.
    pub fn look_at_all(&mut self) {
        for &number in self.nearby.numbers() {
            self.touches[number].clear = 0.0;
        }
    }

    /// Looks at the contacts anew, after tools or bodies were put to other places.
    pub fn look(&mut self, points: &[Point]) {
        for part in &mut self.parts {
            part.settle();
        }
        self.gather(points, 0.0);
        self.look_at_all();
        self.meet(points, 0.0);
        self.measure(points);
    }

    fn moving_parts(&mut self) -> impl Iterator<Item = &mut Part> {
        self.parts.iter_mut().filter(|part| !part.is_fixed)
    }

    /// The contacts of where everything is now, half a sub-step after it began to move as it does, and their loads.
    fn meet(&mut self, points: &[Point], half: f64) {
        for part in &mut self.parts {
            part.force = Vector3::zeros();
            part.torque = Vector3::zeros();
        }
        for surface in &mut self.surfaces {
            let [first, second] = surface.parts().map(|number| &self.parts[number].rigid);
            surface.look(first, second);
        }
        for blocks in &mut self.blocks {
            let [first, second] = blocks.parts.map(|number| &self.parts[number].rigid);
            blocks.look(first, second, &mut self.touches, points);
        }
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
            if point.is_held {
                if !touch.is_apart() {
                    touch.relative =
                        relative(first, &first.twist, second, &second.twist, &touch.place);
                    for (side, force) in [(point.first, touch.force), (point.second, -touch.force)]
                    {
                        self.parts[side].load(&force, &touch.place);
                    }
                }
                continue;
            }
            let is_looked_up = matches!(point.solid, Solid::Mesh { .. } | Solid::Between { .. });
            let moved = if touch.is_apart() && !is_looked_up {
                approached(first, second, point)
            } else {
                0.0
            };
            if touch.is_apart() && moved < touch.clear {
                continue;
            }
            let of_sphere = |nearest: Nearest| {
                let penetration = point.radius - nearest.distance;
                let below = point.radius - 0.5 * penetration;
                let centre = point.centre_of(&first.rigid);
                Met {
                    penetration,
                    normal: nearest.normal,
                    slope: nearest.slope,
                    place: centre - nearest.normal * below,
                }
            };
            let met = match point.solid {
                Solid::Mesh { surface, point, .. } => match self.surfaces[surface].found(point) {
                    None if touch.is_apart() => continue,
                    found => of_sphere(found.map_or(Nearest::far(), |found| Nearest {
                        normal: second.rigid.orientation * found.normal,
                        ..Nearest::exact(found.distance, found.normal)
                    })),
                },
                Solid::Between { blocks, point, .. } => {
                    let blocks = &self.blocks[blocks];
                    let found = blocks.found(point);
                    Met {
                        penetration: found.penetration,
                        normal: blocks.normal(),
                        slope: 1.0,
                        place: found.place,
                    }
                }
                _ => {
                    let centre = point.centre_of(&first.rigid);
                    let solid = &point.solid;
                    of_sphere(solid.nearest_within(&second.rigid, &centre, point.radius))
                }
            };
            if met.penetration > 0.0 {
                let Met { normal, place, .. } = met;
                let relative = relative(first, &first.twist, second, &second.twist, &place);
                let ahead = self::relative(first, &first.ahead, second, &second.ahead, &place);
                touch.press(point, &met, -normal.dot(&ahead));
                touch.rub(point, normal, relative * half);
                touch.normal = normal;
                touch.place = place;
                touch.relative = relative;
                touch.force =
                    normal * touch.normal_force - touch.bristle * point.law.friction_stiffness;
                let (force, place) = (touch.force, touch.place);
                self.parts[point.first].load(&force, &place);
                self.parts[point.second].load(&-force, &place);
            } else if !touch.is_apart() {
                touch.part(point);
            } else if !is_looked_up {
                touch.clear = moved - NEARER * met.penetration;
            }
        }
        for link in &mut self.links {
            link.meet(&mut self.parts);
        }
    }

    /// What the contacts' damping takes from where everything is now.
    fn measure(&mut self, points: &[Point]) {
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if !touch.is_apart() {
                let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
                let relative = touch.relative;
                touch.watch_damping(point, &relative, first, second);
            }
        }
        for link in &mut self.links {
            link.watch_damping(&self.parts);
        }
    }
}

impl SubStepped for Moving {
    type Pair = Point;

    fn copy_near_from(&mut self, other: &Self) {
        for (part, other) in self.parts.iter_mut().zip(&other.parts) {
            if !part.is_fixed {
                part.copy_motion_from(other);
            }
        }
        for &number in self.nearby.numbers() {
            self.touches[number].copy_from(&other.touches[number]);
        }
        self.copy_between(other);
    }

    /// One sub-step of `h` `[s]`, by the velocity form of Verlet's method. Damping and friction see the velocities
    /// that are expected at its end, which keeps it of second order.
    fn sub_step(&mut self, points: &[Point], h: f64) {
        let half = 0.5 * h;
        for (part, carried) in self.parts.iter_mut().zip(&self.carried) {
            if let Some(carried) = carried {
                carried.carry(part, h);
            }
        }
        for part in self.moving_parts() {
            part.first_push(half);
        }
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if touch.is_apart() {
                continue;
            }
            let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
            let relative = relative(first, &first.twist, second, &second.twist, &touch.place);
            touch.book(&relative, tool_of(&self.parts, point, self.tools), half);
            touch.slid += (relative - touch.normal * touch.normal.dot(&relative)) * half;
        }
        for link in &mut self.links {
            link.book(&self.parts, half);
        }
        for part in self.moving_parts() {
            part.drift(h);
        }
        self.meet(points, half);
        for part in self.moving_parts() {
            part.second_push(half);
        }
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if touch.is_apart() {
                continue;
            }
            let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
            let relative = relative(first, &first.twist, second, &second.twist, &touch.place);
            touch.watch_damping(point, &relative, first, second);
            if !self.expects_the_missed {
                touch.missed = 0.0;
            }
            touch.book(&relative, tool_of(&self.parts, point, self.tools), half);
            touch.relative = relative;
        }
        for link in &mut self.links {
            link.watch_damping(&self.parts);
            link.book(&self.parts, half);
        }
    }

    fn changed_from(&self, other: &Self) -> bool {
        let mut modes = self.nearby.numbers().iter();
        let mut blocks = self.blocks.iter().zip(&other.blocks);
        let mut links = self.links.iter().zip(&other.links);
        modes.any(|&number| self.touches[number].changed_from(&other.touches[number]))
            || blocks.any(|(one, other)| one.changed_from(other))
            || links.any(|(one, other)| one.changed_from(other))
    }

    fn expect_the_missed(&mut self, is_added: bool) {
        self.expects_the_missed = is_added;
    }

    fn expect_anew(&mut self) {
        for &number in self.nearby.numbers() {
            self.touches[number].missed = 0.0;
        }
    }
}

/// The tool of a point's two, and on which side it is: see [`Point::sign_on`].
fn tool_of<'a>(parts: &'a [Part], point: &Point, tools: usize) -> Option<(&'a Part, f64)> {
    let tool = point.tool(tools)?;
    Some((&parts[tool], point.sign_on(tool)?))
}

/// Velocity of the first's material at `place` against the second's `[m/s]`.
fn relative(
    first: &Part,
    of_first: &Twist,
    second: &Part,
    of_second: &Twist,
    place: &Vector3,
) -> Vector3 {
    let of_first = first.velocity_at(of_first, place);
    if second.is_fixed {
        of_first
    } else {
        of_first - second.velocity_at(of_second, place)
    }
}

/// How a point and a solid overlap.
struct Met {
    /// Not above 0 where they do not `[m]`.
    penetration: f64,
    /// From the second to the first.
    normal: Vector3,
    /// By how much the penetration grows per length of a way against the normal.
    slope: f64,
    /// Midway between the two surfaces `[m]`.
    place: Vector3,
}

impl Touch {
    /// Takes a penetration above 0, and how fast the two approach `[m/s]`. The force is the law's, of the penetration and its
    /// rate, times the slope: that of the penetration's energy.
    fn press(&mut self, point: &Point, met: &Met, approach: f64) {
        if self.is_apart() {
            self.normal = met.normal;
        }
        let law = &point.law;
        self.expected = approach;
        let push = law.normal_force(met.penetration, met.slope * (approach + self.missed));
        self.penetration = met.penetration;
        self.normal_force = met.slope * push;
        self.by_damping = met.slope * (push - law.stiffness * met.penetration);
    }

    /// Carries the bristle with the contact's plane, lets it follow what has slid before and over `way` `[m]`, and
    /// cuts it to what the normal force holds.
    fn rub(&mut self, point: &Point, normal: Vector3, way: Vector3) {
        let law = &point.law;
        if law.friction <= 0.0 {
            self.mode = law.cut(Vector3::zeros(), self.normal_force).mode;
            self.slid = Vector3::zeros();
            return;
        }
        let before = carried(self.bristle, &self.normal, &normal);
        let slid = carried(self.slid, &self.normal, &normal);
        let follows = before + slid + way - normal * normal.dot(&way);
        let cut = law.cut(follows, self.normal_force);
        let torn = (before + cut.bristle).dot(&(follows - cut.bristle));
        self.past.dissipated += (0.5 * law.friction_stiffness * torn).max(0.0);
        self.bristle = cut.bristle;
        self.mode = cut.mode;
        self.slid = Vector3::zeros();
    }

    /// The surfaces are apart: what the bristle stored is lost.
    fn part(&mut self, point: &Point) {
        let lost = point.law.stored(0.0, &self.bristle);
        self.past.dissipated += lost;
        *self = Self {
            past: self.past,
            ..Self::apart()
        };
    }

    /// Power of the material's damping at a relative velocity: (N - K p) p'.
    fn watch_damping(&mut self, point: &Point, relative: &Vector3, first: &Part, second: &Part) {
        if point.is_held {
            return;
        }
        let apparent =
            first.apparent_velocity_at(&self.place) - second.apparent_velocity_at(&self.place);
        let rate = -self.normal.dot(&(relative + apparent));
        self.missed = rate - self.expected;
        self.damping_power = (self.by_damping * rate).max(0.0);
        self.apparent_power = self.by_damping * self.normal.dot(&apparent);
    }
}

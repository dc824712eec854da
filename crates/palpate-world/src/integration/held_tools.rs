//! Tools that are held between samples, each contact at its own place, as in HFCR.
//!
//! A contact that exists at the sample holds its tool there. The tool of a contact that begins within the interval is
//! predicted to move on at its last velocity until the two meet, and is held there. A contact ends when the tool, had
//! it moved on, would have left. Each solid is evaluated for a single point; the points of a mesh or of a pair of
//! convex solids share one evaluation, so they begin and end together.

use crate::contact::convex_pairs::Blocks;
use crate::contact::islands::Kind;
use crate::contact::pairs::Point;
use crate::contact::point::{Met, Touch};
use crate::dynamics::moving_body::{Part, Twist};
use crate::geometry::mesh::Surface;
use crate::geometry::rigid::{Rigid, Vector3};
use crate::geometry::solid::{Nearest, Solid};
use crate::integration::held_load::{Load, Passage, Step};
use crate::integration::moving::{Moving, overlap, relative};

/// Contact of a held tool over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// Time at which the contact began, since the interval began `[s]`.
    from: f64,
    /// Duration of the contact `[s]`; known at its end.
    pub duration: f64,
    ended: bool,
    /// Time and penetration `[m]` of the tool's predicted motion at the last evaluation.
    seen: Option<(f64, f64)>,
    /// Overlap and bristle at the place at which the tool is held, at the end of the interval.
    start: Option<(Met, Vector3)>,
    /// Unit vector from the second to the first.
    pub normal: Vector3,
    /// Point of application of the force `[m]`.
    pub place: Vector3,
    /// Impulse on the tool over the interval: the mean force times the duration of the contact.
    pub impulse: Load,
}

impl Span {
    fn new() -> Self {
        Self {
            from: 0.0,
            duration: 0.0,
            ended: false,
            seen: None,
            start: None,
            normal: Vector3::x(),
            place: Vector3::zeros(),
            impulse: Load::none(),
        }
    }
}

/// A pair of solids that is evaluated for several points at once.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Time at which its contact began `[s]`, if it has.
    from: Option<f64>,
    ended: bool,
    /// Largest penetration of the tool's predicted motion at the last evaluation `[m]`.
    deepest: f64,
}

/// Tools that are held between samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeldTools {
    /// Whether an interval is in progress.
    pub is_holding: bool,
    /// Whether contacts begin and end within the interval.
    is_smooth: bool,
    /// Each tool at the sample, and its predicted twist.
    paths: Vec<(Rigid, Twist)>,
    /// Contacts of tools, by the numbers of their points.
    spans: Vec<Span>,
    /// Meshes, then pairs of convex solids.
    pairs: Vec<Pair>,
    /// Number of meshes.
    surfaces: usize,
    /// Time since the interval began `[s]`.
    time: f64,
}

impl HeldTools {
    pub fn new(
        is_smooth: bool,
        tools: &[Part],
        points: usize,
        [surfaces, blocks]: [usize; 2],
    ) -> Self {
        let pair = Pair {
            from: None,
            ended: false,
            deepest: f64::NEG_INFINITY,
        };
        Self {
            is_holding: false,
            is_smooth,
            paths: tools
                .iter()
                .map(|tool| (tool.rigid, Twist::none()))
                .collect(),
            spans: vec![Span::new(); points],
            pairs: vec![pair; surfaces + blocks],
            surfaces,
            time: 0.0,
        }
    }

    /// Returns the contact at a point over the last interval.
    pub fn span(&self, number: usize) -> &Span {
        &self.spans[number]
    }

    /// Copies the state that sub-steps change.
    pub fn copy_near_from(&mut self, other: &Self, numbers: &[usize]) {
        if self.spans.is_empty() {
            return;
        }
        let spans = self.spans.len();
        for &number in numbers.iter().filter(|&&number| number < spans) {
            self.spans[number] = other.spans[number];
        }
        self.pairs.copy_from_slice(&other.pairs);
        self.time = other.time;
    }

    /// Moves the tools on along their paths, by `h` `[s]`.
    pub fn move_on(&mut self, parts: &mut [Part], h: f64) {
        self.time += h;
        for (number, part) in parts.iter_mut().enumerate().take(self.paths.len()) {
            part.rigid = self.pose(number, self.time);
            part.way = part.step.velocity.norm() * self.time;
            part.turned = part.step.turning.norm() * self.time;
        }
    }

    /// Returns the motion of a tool along its path over a time `[s]`.
    fn step(&self, tool: usize, time: f64) -> Step {
        let (_, twist) = &self.paths[tool];
        Step {
            way: twist.velocity * time,
            turn: twist.turning * time,
        }
    }

    /// Returns a tool at a time along its path `[s]`.
    fn pose(&self, tool: usize, time: f64) -> Rigid {
        self.step(tool, time).moved(&self.paths[tool].0)
    }

    fn pair_of(&self, point: &Point) -> Option<usize> {
        match point.solid {
            Solid::Mesh { surface, .. } => Some(surface),
            Solid::Between { blocks, .. } => Some(self.surfaces + blocks),
            _ => None,
        }
    }

    /// Returns the poses of a point's two parts, with its tool as held from a time on `[s]`.
    fn poses(&self, parts: &[Part], [first, second]: [usize; 2], from: f64) -> [Rigid; 2] {
        [first, second].map(|number| {
            if number < self.paths.len() {
                self.pose(number, from)
            } else {
                parts[number].rigid
            }
        })
    }

    /// Evaluates a contact of a tool, as [`Moving::meet`] does for two bodies.
    pub fn meet(
        &mut self,
        number: usize,
        point: &Point,
        touch: &mut Touch,
        parts: &mut [Part],
        (surfaces, blocks): (&[Surface], &[Blocks]),
        half: f64,
    ) {
        if self.spans[number].ended {
            return;
        }
        let met = if let Some(pair) = self.pair_of(point) {
            let met = overlap(
                point,
                [&parts[point.first], &parts[point.second]],
                surfaces,
                blocks,
            );
            self.meet_pair((number, pair), point, touch, met)
        } else {
            self.meet_solid(number, point, touch, parts)
        };
        let Some(met) = met else {
            return;
        };
        let Met { normal, place, .. } = met;
        let (first, second) = (&parts[point.first], &parts[point.second]);
        let relative = relative(first, &first.twist, second, &second.twist, &place);
        let ahead = self::relative(first, &first.ahead, second, &second.ahead, &place);
        touch.press_held(point, &met, -normal.dot(&ahead));
        touch.rub::<true>(point, normal, relative * half, &ahead);
        touch.normal = normal;
        touch.place = place;
        touch.relative = relative;
        touch.force = touch.force_of(point);
        let force = touch.force;
        parts[point.first].load(&force, &place);
        parts[point.second].load(&-force, &place);
        let span = &mut self.spans[number];
        (span.normal, span.place) = (normal, place);
    }

    /// Returns the overlap of a point with a solid of its own, if the two touch.
    fn meet_solid(
        &mut self,
        number: usize,
        point: &Point,
        touch: &mut Touch,
        parts: &[Part],
    ) -> Option<Met> {
        let sides = [point.first, point.second];
        let time = self.time;
        if !self.is_smooth && touch.is_apart() {
            return None;
        }
        if self.is_smooth {
            let ahead = met_within(point, &sides.map(|side| parts[side].rigid));
            let seen = self.spans[number].seen.replace((time, ahead.penetration));
            // Time of zero penetration, interpolated from the last evaluation.
            let crossing = seen.map_or(time, |(before, depth)| {
                let change = ahead.penetration - depth;
                if depth.is_finite() && change != 0.0 {
                    (before - (time - before) * depth / change)
                        .max(before)
                        .min(time)
                } else {
                    time
                }
            });
            if touch.is_apart() {
                if ahead.penetration <= 0.0 {
                    return None;
                }
                self.spans[number].from = crossing;
            } else if ahead.penetration <= 0.0 {
                let from = self.spans[number].from;
                let poses = self.poses(parts, sides, from);
                let step = self.step(point.tool(self.paths.len())?, crossing - from);
                self.release(number, point, touch, met_at(point, &poses), step, crossing);
                return None;
            }
        }
        let poses = self.poses(parts, sides, self.spans[number].from);
        Some(met_at(point, &poses))
    }

    /// Returns the overlap `met` of one of the points of a pair, if it touches.
    fn meet_pair(
        &mut self,
        (number, pair): (usize, usize),
        point: &Point,
        touch: &mut Touch,
        met: Met,
    ) -> Option<Met> {
        let tool = point.tool(self.paths.len())?;
        let sign = point.sign_on(tool)?;
        if met.penetration <= 0.0 {
            if !touch.is_apart() {
                touch.part(point);
            }
            return None;
        }
        if self.pairs[pair].ended || !self.is_smooth && self.pairs[pair].from.is_none() {
            return None;
        }
        let from = *self.pairs[pair].from.get_or_insert(self.time);
        self.spans[number].from = from;
        let ahead = self.step(tool, self.time - from);
        let arm = met.place - self.pose(tool, from).position;
        let depth = met.penetration - met.normal.dot(&ahead.at(&arm)) * sign;
        self.pairs[pair].deepest = self.pairs[pair].deepest.max(depth);
        Some(met)
    }

    /// Ends the contacts of each pair whose solids would have left each other.
    pub fn release_pairs(
        &mut self,
        numbers: &[usize],
        points: &[Point],
        touches: &mut [Touch],
        parts: &mut [Part],
    ) {
        if !self.is_smooth {
            return;
        }
        for number in 0..self.pairs.len() {
            let pair = self.pairs[number];
            let Some(from) = pair.from.filter(|_| !pair.ended && pair.deepest <= 0.0) else {
                continue;
            };
            self.pairs[number].ended = true;
            for &point in numbers {
                let (of, touch) = (&points[point], &mut touches[point]);
                if self.pair_of(of) != Some(number) || touch.is_apart() {
                    continue;
                }
                let Some(tool) = of.tool(self.paths.len()) else {
                    continue;
                };
                // It has just been evaluated as a contact.
                parts[of.first].load(&-touch.force, &touch.place);
                parts[of.second].load(&touch.force, &touch.place);
                let met = Met {
                    penetration: touch.penetration,
                    normal: touch.normal,
                    slope: 1.0,
                    place: touch.place,
                };
                let step = self.step(tool, self.time - from);
                self.release(point, of, touch, met, step, self.time);
            }
        }
    }

    /// Ends a contact at a time `[s]`. The tool leaves by `step` and takes the energy of the spring.
    fn release(
        &mut self,
        number: usize,
        point: &Point,
        touch: &mut Touch,
        start: Met,
        step: Step,
        time: f64,
    ) {
        let Some(tool) = point.tool(self.paths.len()) else {
            return;
        };
        let from = self.spans[number].from;
        let load = Passage {
            point,
            sign: point.sign_on(tool).unwrap_or(1.0),
            centre: self.pose(tool, from).position,
            step,
            bristle: touch.bristle,
            start,
            middle: None,
            end: start.apart(),
            begins: false,
            snaps: false,
        }
        .load();
        let span = &mut self.spans[number];
        span.ended = true;
        span.duration = time - from;
        span.impulse.add(&load.times(span.duration));
        let given = point.law.stored(start.penetration, &Vector3::zeros());
        touch.past.work += given;
        touch.past.work_on_tool += given;
        touch.part(point);
    }
}

/// Returns the overlap of a sphere with its solid for the poses of its two parts.
fn met_at(point: &Point, [first, second]: &[Rigid; 2]) -> Met {
    let centre = point.centre_of(first);
    met_of(point, &centre, &point.solid.nearest(second, &centre))
}

/// Returns the overlap, or a bound of a negative one that may be cheaper.
fn met_within(point: &Point, [first, second]: &[Rigid; 2]) -> Met {
    let centre = point.centre_of(first);
    let nearest = point.solid.nearest_within(second, &centre, point.radius);
    met_of(point, &centre, &nearest)
}

pub(super) fn met_of(point: &Point, centre: &Vector3, nearest: &Nearest) -> Met {
    let penetration = point.radius - nearest.distance;
    Met {
        penetration,
        normal: nearest.normal,
        slope: nearest.slope,
        place: centre - nearest.normal * (point.radius - 0.5 * penetration),
    }
}

impl Moving {
    /// Begins to hold the tools where they are, with their apparent velocities as predicted ones.
    pub fn hold_tools(&mut self) {
        self.held.is_holding = true;
        let paths = self.held.paths.iter_mut();
        for (part, (start, twist)) in self.parts.iter_mut().zip(paths) {
            *start = part.rigid;
            *twist = Twist {
                velocity: part.drive.apparent_velocity,
                turning: part.turning_drive.apparent_turning,
            };
            part.step = *twist;
        }
    }

    /// Ends the holding: the tools are where they were at the sample.
    pub fn let_tools_go(&mut self) {
        self.held.is_holding = false;
        for (part, (start, _)) in self.parts.iter_mut().zip(&self.held.paths) {
            part.rigid = *start;
            part.step = Twist::none();
        }
    }

    /// Begins the contacts of held tools, after the active points have been selected.
    pub fn begin_holding(&mut self, points: &[Point]) {
        if !self.held.is_holding {
            return;
        }
        let held = &mut self.held;
        held.time = 0.0;
        held.spans.fill(Span::new());
        for pair in &mut held.pairs {
            *pair = Pair {
                from: None,
                ended: false,
                deepest: f64::NEG_INFINITY,
            };
        }
        for &number in self.nearby.numbers() {
            let (point, touch) = (&points[number], &self.touches[number]);
            if point.tool(self.tools).is_none() {
                continue;
            }
            (held.spans[number].normal, held.spans[number].place) = (touch.normal, touch.place);
            let pair = held.pair_of(point);
            match pair {
                Some(pair) if !touch.is_apart() => held.pairs[pair].from = Some(0.0),
                None if held.is_smooth => {
                    let poses = [point.first, point.second].map(|side| self.parts[side].rigid);
                    held.spans[number].seen = Some((0.0, met_within(point, &poses).penetration));
                }
                _ => {}
            }
        }
    }

    /// Evaluates the meshes and the pairs of convex solids. If a pair touches, its tool is at its held position.
    pub(super) fn look_at_held_shapes(&mut self, points: &[Point]) {
        for pair in &mut self.held.pairs {
            pair.deepest = f64::NEG_INFINITY;
        }
        for &number in self.nearby.islands.all(Kind::Surfaces) {
            let surface = &mut self.surfaces[number];
            let [first, second] = self.held.pair_poses(number, surface.parts(), &self.parts);
            surface.look(&first, &second);
        }
        for &number in self.nearby.blocks() {
            let blocks = &mut self.blocks[number];
            let number = self.held.surfaces + number;
            let [first, second] = self.held.pair_poses(number, blocks.parts, &self.parts);
            blocks.look(&first, &second, &mut self.touches, points);
        }
    }

    /// Adds the impulse of material damping on the tools over `half` a sub-step `[s]`.
    pub(super) fn add_held_damping(&mut self, points: &[Point], half: f64) {
        for &number in self.nearby.numbers() {
            let (point, touch) = (&points[number], &self.touches[number]);
            let law = &point.law;
            let Some(tool) = point.tool(self.tools) else {
                continue;
            };
            if touch.is_apart() || law.damping <= 0.0 && law.friction_damping <= 0.0 {
                continue;
            }
            let sign = point.sign_on(tool).unwrap_or(1.0);
            let force = touch.damping_force() * (sign * half);
            let arm = touch.place - self.parts[tool].rigid.position;
            self.held.spans[number].impulse.add(&Load {
                force,
                torque: arm.cross(&force),
            });
        }
    }

    /// Computes the impulses of the contacts that last until the end of the interval.
    pub fn conclude_holding(&mut self, points: &[Point]) {
        let time = self.held.time;
        for &number in self.nearby.numbers() {
            let (point, touch) = (&points[number], &self.touches[number]);
            let held = &mut self.held;
            let pair = held.pair_of(point).map(|pair| held.pairs[pair]);
            // A point of a pair that touches may begin to touch along the step.
            let may_touch = pair.is_some_and(|pair| pair.from.is_some() && !pair.ended);
            if point.tool(self.tools).is_none() || touch.is_apart() && !may_touch {
                continue;
            }
            let met = if let Some(pair) = pair {
                let parts = [point.first, point.second].map(|side| &self.parts[side]);
                held.spans[number].from = pair.from.unwrap_or_default();
                overlap(point, parts, &self.surfaces, &self.blocks)
            } else {
                let from = held.spans[number].from;
                met_at(
                    point,
                    &held.poses(&self.parts, [point.first, point.second], from),
                )
            };
            held.spans[number].start = Some((met, touch.bristle));
        }
        // The pairs of solids at the predicted poses.
        for pair in &mut self.held.pairs {
            pair.from = None;
        }
        self.look_at_held_shapes(points);
        for &number in self.nearby.numbers() {
            let point = &points[number];
            let held = &self.held;
            let Some(tool) = point.tool(self.tools) else {
                continue;
            };
            let Some((mut start, bristle)) = held.spans[number].start else {
                continue;
            };
            let from = held.spans[number].from;
            let sides = [point.first, point.second];
            let mut begins = false;
            let (middle, end) = if held.pair_of(point).is_some() {
                let parts = sides.map(|side| &self.parts[side]);
                let mut end = overlap(point, parts, &self.surfaces, &self.blocks);
                // A separated point of a pair has no contact position.
                match [start, end].map(|met| met.penetration > 0.0) {
                    [true, true] => {}
                    [true, false] => end = start.apart(),
                    [false, true] => (start, begins) = (end.apart(), true),
                    [false, false] => continue,
                }
                (None, end)
            } else {
                let half = held.poses(&self.parts, sides, 0.5 * (from + time));
                let end = sides.map(|side| self.parts[side].rigid);
                (Some(met_at(point, &half)), met_at(point, &end))
            };
            let load = Passage {
                point,
                sign: point.sign_on(tool).unwrap_or(1.0),
                centre: held.pose(tool, from).position,
                step: held.step(tool, time - from),
                bristle,
                start,
                middle,
                end,
                begins,
                snaps: !held.is_smooth,
            }
            .load();
            let span = &mut self.held.spans[number];
            span.duration = time - from;
            span.impulse.add(&load.times(span.duration));
        }
    }

    /// Sets each contact's slip to the way of its tool from where it was held to where it is now.
    pub fn slide_held(&mut self, points: &[Point]) {
        for &number in self.nearby.numbers() {
            let (point, touch) = (&points[number], &mut self.touches[number]);
            let Some(tool) = point.tool(self.tools).filter(|_| !touch.is_apart()) else {
                continue;
            };
            let held = self.held.pose(tool, self.held.spans[number].from);
            let now = &self.parts[tool].rigid;
            let step = Step {
                way: now.position - held.position,
                turn: (now.orientation * held.orientation.inverse()).scaled_axis(),
            };
            let sign = point.sign_on(tool).unwrap_or(1.0);
            let way = step.at(&(touch.place - held.position)) * sign;
            touch.slid = way - touch.normal * touch.normal.dot(&way);
        }
    }
}

impl HeldTools {
    /// Returns the poses at which a pair of solids is evaluated: with the tool as held if they touch, else as
    /// predicted.
    fn pair_poses(&self, number: usize, sides: [usize; 2], parts: &[Part]) -> [Rigid; 2] {
        let pair = &self.pairs[number];
        match pair.from.filter(|_| !pair.ended) {
            Some(from) => self.poses(parts, sides, from),
            None => sides.map(|side| parts[side].rigid),
        }
    }
}

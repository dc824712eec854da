//! Integration of proxies and images over one step of an engine.

use super::contact_point::Touch;
use super::image::Image;
use super::pairs::{MAX_PAIRS, Pair, Toucher};
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;
use crate::integration::interval::{Fastest, SubStepped, integrate, whole};
use crate::integration::yielding::ForceLimit;
use crate::{Effort, SubSteps};

/// Proxies and images in motion.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    pub tools: Vec<Part>,
    /// Displacement of each tool due to the impulses since the period began, per mass `[N s^2]`.
    pub leads: Vec<Vector3>,
    /// Impulse on each tool since the period began `[N s]`.
    pub impulses: Vec<Vector3>,
    pub images: Vec<Image>,
    pub touches: Vec<Touch>,
    /// Force limits of the tools; empty if there are none.
    pub limits: Vec<ForceLimit>,
    /// Whether contact dampers add the prediction error of the last sub-step to the velocity that they expect.
    pub expects_the_missed: bool,
}

impl Meeting {
    /// Begins a period with the proxies at their assigned positions.
    pub fn begin(&mut self) {
        for touch in &mut self.touches {
            touch.begin();
        }
        for limit in &mut self.limits {
            limit.has_acted = false;
        }
        self.leads.fill(Vector3::zeros());
        self.impulses.fill(Vector3::zeros());
        for tool in &mut self.tools {
            tool.begin();
        }
    }

    /// Re-evaluates the contacts after proxies or images have been displaced.
    pub fn look(&mut self, pairs: &[Pair]) {
        for tool in &mut self.tools {
            tool.settle();
        }
        for image in &mut self.images {
            image.ahead = image.twist;
        }
        self.expect_anew();
        self.meet(pairs, 0.0);
    }

    fn push(&mut self, half: f64, pushed: fn(&mut Part, f64)) {
        for (tool, impulse) in self.tools.iter_mut().zip(&mut self.impulses) {
            *impulse += tool.force * half;
            pushed(tool, half);
        }
        for image in &mut self.images {
            image.push(half);
        }
    }

    fn entry(&mut self, pairs: &[Pair], half: f64) {
        for (touch, pair) in self.touches.iter_mut().zip(pairs) {
            if touch.is_apart() {
                continue;
            }
            let relative = relative(&self.tools, &self.images, pair, &touch.place);
            let tool = pair.toucher.tool().and_then(|tool| self.tools.get(tool));
            let mean = tool.map_or(Vector3::zeros(), |tool| {
                tool.rigid.velocity - tool.gained * 0.5
            });
            touch.entry(&relative, &mean, half);
            touch.relative = relative;
        }
    }

    /// Evaluates the contacts and their loads at the current positions, which were reached by moving for `half` a
    /// sub-step with the current velocities.
    fn meet(&mut self, pairs: &[Pair], half: f64) {
        for tool in &mut self.tools {
            tool.force = Vector3::zeros();
            tool.torque = Vector3::zeros();
        }
        for image in &mut self.images {
            image.load.fill(0.0);
            image.other_load.fill(0.0);
        }
        for (touch, pair) in self.touches.iter_mut().zip(pairs) {
            let found = found(&self.tools, &self.images, pair);
            let Some(found) = found.filter(|found| found.penetration > 0.0) else {
                if !touch.is_apart() {
                    touch.part(&pair.law);
                }
                continue;
            };
            touch.place = found.place;
            let now = relative(&self.tools, &self.images, pair, &touch.place);
            let ahead = ahead(&self.tools, &self.images, pair, &found.place);
            let rate = pair.rate_of(&found.normal, &ahead);
            touch.press(
                &pair.law,
                [found.penetration, rate],
                found.normal,
                &(now * half),
                &ahead,
            );
            touch.relative = now;
            let image = &mut self.images[pair.body];
            match pair.toucher {
                Toucher::Tool(tool) => {
                    image.pushed_at(&-touch.force, &touch.place);
                    self.tools[tool].load(&touch.force, &touch.place);
                }
                Toucher::Body { body, .. } => {
                    image.pushed_otherwise_at(&-touch.force, &touch.place);
                    self.images[body].pushed_otherwise_at(&touch.force, &touch.place);
                }
            }
        }
        self.yield_to_limits(pairs);
    }

    /// Returns whether the force limit of a tool acted since the period began.
    pub fn has_yielded(&self, tool: usize) -> bool {
        self.limits.get(tool).is_some_and(|limit| limit.has_acted)
    }

    /// Scales the contacts of each tool whose elastic force or total force exceeds its limit.
    fn yield_to_limits(&mut self, pairs: &[Pair]) {
        for (tool, limit) in self.limits.iter_mut().enumerate() {
            let mut elastic = Vector3::zeros();
            let mut is_along = true;
            for (touch, pair) in self.touches.iter().zip(pairs) {
                if pair.toucher.is_tool(tool) && !touch.is_apart() {
                    elastic += touch.force - touch.damping_force();
                    is_along &= limit.is_along(&touch.normal);
                }
            }
            let part = &mut self.tools[tool];
            if !is_along {
                continue;
            }
            let Some(scales) = limit.scales(&elastic, &part.force) else {
                continue;
            };
            for (touch, pair) in self.touches.iter_mut().zip(pairs) {
                if pair.toucher.is_tool(tool) && !touch.is_apart() {
                    let before = touch.force;
                    touch.scale(scales);
                    let change = touch.force - before;
                    part.load(&change, &touch.place);
                    self.images[pair.body].pushed_at(&-change, &touch.place);
                }
            }
        }
    }

    /// Integrates over `h` `[s]`. The number of sub-steps is the share of `h` in a period, and up to `times` the
    /// maximum if the integration would be unstable. `before` is overwritten.
    pub fn advance(
        &mut self,
        before: &mut Self,
        pairs: &[Pair],
        sub_steps: &SubSteps,
        times: u32,
        h: f64,
        period: f64,
    ) -> Effort {
        let least = whole((f64::from(sub_steps.least) * h / period).ceil()).max(2);
        let sub_steps = SubSteps {
            least,
            most: sub_steps.most.max(least),
            ..*sub_steps
        };
        let fastest = self.fastest(pairs, h);
        integrate(self, before, pairs, fastest, &sub_steps, times, h)
    }

    /// Returns bounds of the fastest modes among the contacts that touch or may touch within `h` `[s]`. The bound at
    /// each side of a contact is the sum of stiffness or damping times mobility over all contacts there, plus the
    /// stiffest drive spring.
    fn fastest(&self, pairs: &[Pair], h: f64) -> Fastest {
        let mut near = [None; MAX_PAIRS];
        for (near, (touch, pair)) in near.iter_mut().zip(self.touches.iter().zip(pairs)) {
            *near = self.rates(touch, pair, h);
        }
        let sum_at = |side: Side| {
            let each = near.iter().flatten().flatten();
            let here = each.filter(|rates| rates.side == side);
            here.fold((0.0, 0.0), |sum, rates| {
                (sum.0 + rates.square, sum.1 + rates.damping)
            })
        };
        let (mut most_square, mut most_damping) = (0.0_f64, 0.0_f64);
        for [first, second] in near.iter().flatten() {
            let (one, other) = (sum_at(first.side), sum_at(second.side));
            most_square = most_square.max(one.0 + other.0);
            most_damping = most_damping.max(one.1 + other.1);
        }
        let of_drives = self.tools.iter().map(|tool| tool.drive.spring_rate.max());
        let most_drive = of_drives.fold(0.0, f64::max);
        Fastest {
            frequency: (most_square + most_drive).sqrt(),
            damping: most_damping,
            passing: 0.0,
        }
    }

    /// Returns the rates at both sides of a contact that touches or may touch within `h` `[s]`.
    fn rates(&self, touch: &Touch, pair: &Pair, h: f64) -> Option<[Rates; 2]> {
        let found = found(&self.tools, &self.images, pair)?;
        let (normal, gap) = (found.normal, -found.penetration);
        // Point on the touched surface.
        let place = found.centre - normal * (gap + pair.radius);
        let relative = relative(&self.tools, &self.images, pair, &place);
        // The factor 2 allows for acceleration by forces during the step.
        if touch.is_apart() && gap > 2.0 * relative.norm() * h + RESTING_SPEED * h {
            return None;
        }
        let toucher = match pair.toucher {
            Toucher::Tool(tool) => Side::Tool(tool),
            Toucher::Body { body, .. } => Side::Body(body),
        };
        let law = &pair.at_full_strength;
        let sides = [toucher, Side::Body(pair.body)];
        Some(sides.map(|side| {
            let mobility_along = |axis: &Vector3| match side {
                Side::Tool(tool) => self.tools[tool].mobility.linear.max(),
                Side::Body(body) => self.images[body].mobility_at(axis, &place),
            };
            let along = mobility_along(&normal);
            let across = match side {
                Side::Tool(_) => along,
                Side::Body(_) => axes().iter().map(mobility_along).sum(),
            };
            let tangential = if law.friction > 0.0 {
                law.friction_stiffness * across
            } else {
                0.0
            };
            Rates {
                side,
                square: (law.stiffness * along).max(tangential),
                damping: law.damping_rate(along, across),
            }
        }))
    }
}

impl SubStepped for Meeting {
    type Pair = Pair;

    fn copy_near_from(&mut self, other: &Self) {
        self.tools.copy_from_slice(&other.tools);
        self.leads.copy_from_slice(&other.leads);
        self.impulses.copy_from_slice(&other.impulses);
        self.images.copy_from_slice(&other.images);
        self.touches.copy_from_slice(&other.touches);
    }

    fn sub_step(&mut self, pairs: &[Pair], h: f64) {
        let half = 0.5 * h;
        self.push(half, Part::first_push::<true>);
        self.entry(pairs, half);
        for (number, tool) in self.tools.iter_mut().enumerate() {
            self.leads[number] += self.impulses[number] * h;
            tool.drift(h);
        }
        for image in &mut self.images {
            image.drift(h);
        }
        for (touch, pair) in self.touches.iter_mut().zip(pairs) {
            if !touch.is_apart() {
                let relative = relative(&self.tools, &self.images, pair, &touch.place);
                touch.slide(&relative, half);
            }
        }
        self.meet(pairs, half);
        self.push(half, Part::second_push::<true>);
        self.entry(pairs, half);
        if self.expects_the_missed {
            for (touch, pair) in self.touches.iter_mut().zip(pairs) {
                if !touch.is_apart() {
                    touch.miss(pair.rate_of(&touch.normal, &touch.relative));
                }
            }
        }
    }

    fn changed_from(&self, other: &Self) -> bool {
        let mut touches = self.touches.iter().zip(&other.touches);
        touches.any(|(one, other)| one.changed_from(other))
    }

    fn expect_the_missed(&mut self, is_added: bool) {
        self.expects_the_missed = is_added;
    }

    fn expect_anew(&mut self) {
        for touch in &mut self.touches {
            touch.missed = 0.0;
        }
    }
}

/// A tool or a body on one side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Tool(usize),
    Body(usize),
}

/// Rates of a contact at one side: squared angular frequency `[rad^2/s^2]` and damping rate `[1/s]`.
#[derive(Clone, Copy, Debug)]
struct Rates {
    side: Side,
    square: f64,
    damping: f64,
}

/// Speed that a resting body may gain within a step `[m/s]`.
const RESTING_SPEED: f64 = 0.1;

fn axes() -> [Vector3; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()]
}

/// Geometry of a possible contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub centre: Vector3,
    /// Midpoint between the two surfaces.
    pub place: Vector3,
    pub normal: Vector3,
    /// Overlap, negative if apart `[m]`.
    pub penetration: f64,
}

/// Returns the contact geometry of a pair, or `None` if the pair cannot touch.
pub(super) fn found(tools: &[Part], images: &[Image], pair: &Pair) -> Option<Found> {
    let centre = match pair.toucher {
        Toucher::Tool(tool) => tools.get(tool)?.rigid.position,
        Toucher::Body { body, centre } => {
            let image = &images[body];
            image.position + image.orientation * centre
        }
    };
    if !pair.is_open {
        return None;
    }
    let placed = images[pair.body].place(&pair.position, &pair.orientation);
    let nearest = pair.outline.nearest(&placed, &centre);
    let mut penetration = pair.radius - nearest.distance;
    let mut normal = nearest.normal;
    if let Some(shift) = &pair.shift {
        penetration += shift.depth;
        let turned = normal + shift.normal;
        let length = turned.norm();
        if length > f64::MIN_POSITIVE {
            normal = turned / length;
        }
    }
    Some(Found {
        centre,
        place: centre - normal * (pair.radius - 0.5 * penetration),
        normal,
        penetration,
    })
}

/// Returns the penetration rate expected at the end of the sub-step `[m/s]`.
pub(super) fn rate(tools: &[Part], images: &[Image], pair: &Pair, found: &Found) -> f64 {
    pair.rate_of(&found.normal, &ahead(tools, images, pair, &found.place))
}

/// Returns the velocity of the sphere relative to the image at `place`, expected at the end of the sub-step `[m/s]`.
fn ahead(tools: &[Part], images: &[Image], pair: &Pair, place: &Vector3) -> Vector3 {
    let touching = match pair.toucher {
        Toucher::Tool(tool) => tools[tool].ahead.velocity,
        Toucher::Body { body, .. } => images[body].velocity_at(&images[body].ahead, place),
    };
    let image = &images[pair.body];
    touching - image.velocity_at(&image.ahead, place)
}

/// Returns the velocity of the sphere relative to the image at `place` `[m/s]`.
fn relative(tools: &[Part], images: &[Image], pair: &Pair, place: &Vector3) -> Vector3 {
    let touching = match pair.toucher {
        Toucher::Tool(tool) => tools[tool].rigid.velocity,
        Toucher::Body { body, .. } => images[body].velocity_at(&images[body].twist, place),
    };
    let image = &images[pair.body];
    touching - image.velocity_at(&image.twist, place)
}

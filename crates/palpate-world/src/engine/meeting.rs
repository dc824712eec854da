//! Avatars and images in motion, over one step of an engine.

use super::image::Image;
use super::pairs::{Pair, Toucher};
use super::touch::Touch;
use crate::part::Part;
use crate::rigid::Vector3;
use crate::{Effort, SubSteps};

/// Avatars and images in motion.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    pub tools: Vec<Part>,
    /// The way of each tool that the impulses since the period began have made, per mass `[N s^2]`.
    pub leads: Vec<Vector3>,
    /// Impulse on each tool since the period began `[N s]`.
    pub impulses: Vec<Vector3>,
    pub images: Vec<Image>,
    pub touches: Vec<Touch>,
}

impl Meeting {
    /// Takes over the state of another, without allocating.
    fn copy_from(&mut self, other: &Self) {
        self.tools.copy_from_slice(&other.tools);
        self.leads.copy_from_slice(&other.leads);
        self.impulses.copy_from_slice(&other.impulses);
        self.images.copy_from_slice(&other.images);
        self.touches.copy_from_slice(&other.touches);
    }

    /// A period begins, with the avatars where they have been put.
    pub fn begin(&mut self) {
        for touch in &mut self.touches {
            touch.begin();
        }
        self.leads.fill(Vector3::zeros());
        self.impulses.fill(Vector3::zeros());
        for tool in &mut self.tools {
            tool.begin();
        }
    }

    /// Looks at the contacts anew, after avatars or images were put to other places.
    pub fn look(&mut self, pairs: &[Pair]) {
        for tool in &mut self.tools {
            tool.settle();
        }
        for image in &mut self.images {
            image.ahead = image.twist;
        }
        self.meet(pairs, 0.0);
    }

    fn sub_step(&mut self, pairs: &[Pair], h: f64) {
        let half = 0.5 * h;
        self.push(half, Part::first_push);
        self.book(pairs, half);
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
        self.push(half, Part::second_push);
        self.book(pairs, half);
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

    fn book(&mut self, pairs: &[Pair], half: f64) {
        for (touch, pair) in self.touches.iter_mut().zip(pairs) {
            if touch.is_apart() {
                continue;
            }
            let relative = relative(&self.tools, &self.images, pair, &touch.place);
            let tool = pair.toucher.tool().and_then(|tool| self.tools.get(tool));
            let mean = tool.map_or(Vector3::zeros(), |tool| {
                tool.rigid.velocity - tool.gained * 0.5
            });
            touch.book(&pair.law, &relative, &mean, half);
            touch.relative = relative;
        }
    }

    /// The contacts of where everything is now, half a sub-step after it began to move as it does, and their loads.
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
            let rate = rate(&self.tools, &self.images, pair, &found);
            touch.press(
                &pair.law,
                found.penetration,
                rate,
                found.normal,
                &(now * half),
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
    }

    fn changed_from(&self, other: &Self) -> bool {
        let mut modes = self.touches.iter().zip(&other.touches);
        modes.any(|(one, other)| one.mode != other.mode)
    }

    /// Integrates over `h` `[s]`, in so many sub-steps of a period as `h` is part of it. `before` is overwritten.
    pub fn advance(
        &mut self,
        before: &mut Self,
        pairs: &[Pair],
        sub_steps: &SubSteps,
        h: f64,
        period: f64,
    ) -> Effort {
        let mut effort = Effort::default();
        let asked = self.fastest(pairs, h) * h / sub_steps.phase;
        let least = (f64::from(sub_steps.least) * h / period).ceil().max(2.0);
        let most = f64::from(sub_steps.most).max(least);
        effort.too_fast = asked > most;
        let count = asked.clamp(least, most).ceil();
        let step = h / count;
        let mut done = 0.0;
        while done < count {
            done += 1.0;
            before.copy_from(self);
            self.sub_step(pairs, step);
            effort.sub_steps += 1;
            if !self.changed_from(before) {
                continue;
            }
            if effort.refined == sub_steps.refined {
                effort.unrefined += 1;
                continue;
            }
            effort.refined += 1;
            self.copy_from(before);
            let finer = step / f64::from(sub_steps.finer);
            for _ in 0..sub_steps.finer {
                self.sub_step(pairs, finer);
            }
            effort.sub_steps += sub_steps.finer;
        }
        effort
    }

    /// A bound of the largest angular frequency among the contacts that touch, or may within `h` `[s]` `[rad/s]`.
    fn fastest(&self, pairs: &[Pair], h: f64) -> f64 {
        let (mut square, mut damping) = (0.0, 0.0);
        for (touch, pair) in self.touches.iter().zip(pairs) {
            let Some(found) = found(&self.tools, &self.images, pair) else {
                continue;
            };
            let (normal, gap) = (found.normal, -found.penetration);
            // On the surface that is touched.
            let place = found.centre - normal * (gap + pair.radius);
            let relative = relative(&self.tools, &self.images, pair, &place);
            // Twice the way, for what pushes them meanwhile.
            if touch.is_apart() && gap > 2.0 * relative.norm() * h + RESTING_SPEED * h {
                continue;
            }
            let image = &self.images[pair.body];
            let toucher_along = |axis: &Vector3| match pair.toucher {
                Toucher::Tool(tool) => self.tools[tool].mobility.linear.max(),
                Toucher::Body { body, .. } => self.images[body].mobility_at(axis, &place),
            };
            let along = toucher_along(&normal) + image.mobility_at(&normal, &place);
            let law = &pair.law;
            let tangential = if law.friction > 0.0 {
                let toucher_across = match pair.toucher {
                    Toucher::Tool(tool) => self.tools[tool].mobility.linear.max(),
                    Toucher::Body { body, .. } => axes()
                        .iter()
                        .map(|axis| self.images[body].mobility_at(axis, &place))
                        .sum(),
                };
                let across: f64 = axes()
                    .iter()
                    .map(|axis| image.mobility_at(axis, &place))
                    .sum();
                law.friction_stiffness * (toucher_across + across)
            } else {
                0.0
            };
            square += (law.stiffness * along).max(tangential);
            damping += law.damping * along;
        }
        let of_drives = self.tools.iter().map(|tool| tool.drive.spring_rate.max());
        let most_drive = of_drives.fold(0.0, f64::max);
        (square + most_drive).sqrt().max(0.5 * damping)
    }
}

/// What is at rest may gain this much within a step `[m/s]`.
const RESTING_SPEED: f64 = 0.1;

fn axes() -> [Vector3; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()]
}

/// Where a pair would touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub centre: Vector3,
    /// Midway between the two surfaces.
    pub place: Vector3,
    pub normal: Vector3,
    /// How far they overlap, below 0 where they do not `[m]`.
    pub penetration: f64,
}

/// Where a pair would touch; none of one that cannot.
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

/// How fast a pair gets deeper, as expected at the end of the sub-step `[m/s]`.
pub(super) fn rate(tools: &[Part], images: &[Image], pair: &Pair, found: &Found) -> f64 {
    let place = &found.place;
    let touching = match pair.toucher {
        Toucher::Tool(tool) => tools[tool].ahead.velocity,
        Toucher::Body { body, .. } => images[body].velocity_at(&images[body].ahead, place),
    };
    let image = &images[pair.body];
    let ahead = touching - image.velocity_at(&image.ahead, place);
    pair.shift.map_or(0.0, |shift| shift.rate) - found.normal.dot(&ahead)
}

/// Velocity of what touches against the image at `place` `[m/s]`.
fn relative(tools: &[Part], images: &[Image], pair: &Pair, place: &Vector3) -> Vector3 {
    let touching = match pair.toucher {
        Toucher::Tool(tool) => tools[tool].rigid.velocity,
        Toucher::Body { body, .. } => images[body].velocity_at(&images[body].twist, place),
    };
    let image = &images[pair.body];
    touching - image.velocity_at(&image.twist, place)
}

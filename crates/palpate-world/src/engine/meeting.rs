//! Avatars and images in motion, over one step of an engine.

use super::image::Image;
use super::pairs::Pair;
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
                let relative = relative(&self.tools[pair.tool], &self.images[pair.body], touch);
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
            let tool = &self.tools[pair.tool];
            let relative = relative(tool, &self.images[pair.body], touch);
            let mean = tool.rigid.velocity - tool.gained * 0.5;
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
        }
        for (touch, pair) in self.touches.iter_mut().zip(pairs) {
            let (tool, image) = (&mut self.tools[pair.tool], &mut self.images[pair.body]);
            let centre = tool.rigid.position;
            let placed = image.place(&pair.position, &pair.orientation);
            let nearest = pair.outline.nearest(&placed, &centre);
            let penetration = pair.radius - nearest.distance;
            if penetration > 0.0 {
                touch.place = centre - nearest.normal * (pair.radius - 0.5 * penetration);
                let now = relative(tool, image, touch);
                let ahead = tool.ahead.velocity - image.velocity_at(&image.ahead, &touch.place);
                let rate = -nearest.normal.dot(&ahead);
                touch.press(&pair.law, penetration, rate, nearest.normal, &(now * half));
                touch.relative = now;
                tool.load(&touch.force, &touch.place);
                image.pushed_at(&-touch.force, &touch.place);
            } else if !touch.is_apart() {
                touch.part(&pair.law);
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
            let (tool, image) = (&self.tools[pair.tool], &self.images[pair.body]);
            let centre = tool.rigid.position;
            let placed = image.place(&pair.position, &pair.orientation);
            let nearest = pair.outline.nearest(&placed, &centre);
            let place = centre - nearest.normal * nearest.distance;
            let relative = tool.rigid.velocity - image.velocity_at(&image.twist, &place);
            let gap = nearest.distance - pair.radius;
            // Twice the way, for what pushes them meanwhile.
            if touch.is_apart() && gap > 2.0 * relative.norm() * h + RESTING_SPEED * h {
                continue;
            }
            let of_tool = tool.mobility.linear.max();
            let along = of_tool + image.mobility_at(&nearest.normal, &place);
            let law = &pair.law;
            let tangential = if law.friction > 0.0 {
                let across: f64 = [Vector3::x(), Vector3::y(), Vector3::z()]
                    .iter()
                    .map(|axis| image.mobility_at(axis, &place))
                    .sum();
                law.friction_stiffness * (of_tool + across)
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

/// Velocity of the tool against the image where they touch `[m/s]`.
fn relative(tool: &Part, image: &Image, touch: &Touch) -> Vector3 {
    tool.rigid.velocity - image.velocity_at(&image.twist, &touch.place)
}

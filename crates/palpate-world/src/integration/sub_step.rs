//! One sub-step of a world in motion.

use crate::contact::islands::Kind;
use crate::contact::pairs::Point;
use crate::dynamics::moving_body::Part;
use crate::integration::interval::SubStepped;
use crate::integration::moving::{Moving, relative};

impl SubStepped for Moving {
    type Pair = Point;

    fn copy_near_from(&mut self, other: &Self) {
        for &number in self.nearby.parts() {
            self.parts[number].copy_motion_from(&other.parts[number]);
        }
        for &number in self.nearby.numbers() {
            let (touch, other) = (&mut self.touches[number], &other.touches[number]);
            touch.copy_from(other);
            if self.held.is_holding {
                // The contact of a pair can begin and end at one evaluation.
                touch.past = other.past;
            }
        }
        self.held.copy_near_from(&other.held, self.nearby.numbers());
        self.elapsed = other.elapsed;
        let islands = &self.nearby.islands;
        for &number in islands.all(Kind::Surfaces) {
            self.surfaces[number].copy_from(&other.surfaces[number]);
        }
        for &number in islands.all(Kind::Blocks) {
            self.blocks[number].copy_from(&other.blocks[number]);
        }
        for &number in islands.all(Kind::Links) {
            self.links[number] = other.links[number];
        }
        self.copy_near_fields_from(other);
    }

    fn sub_step(&mut self, points: &[Point], h: f64) {
        if self.keeps_books {
            self.sub_step_by::<true>(points, h);
        } else {
            self.sub_step_by::<false>(points, h);
        }
    }

    fn changed_from(&self, other: &Self) -> bool {
        let mut modes = self.nearby.numbers().iter();
        let mut blocks = self.nearby.blocks().iter();
        let mut links = self.nearby.islands.all(Kind::Links).iter();
        modes.any(|&number| self.touches[number].changed_from(&other.touches[number]))
            || blocks.any(|&number| self.blocks[number].changed_from(&other.blocks[number]))
            || links.any(|&number| self.links[number].changed_from(&other.links[number]))
            || self.has_changed_fields_from(other)
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

impl Moving {
    /// Performs one sub-step of `h` `[s]` with the velocity form of Verlet's method. Damping and friction use the
    /// velocities expected at its end, which preserves second order.
    fn sub_step_by<const BOOKS: bool>(&mut self, points: &[Point], h: f64) {
        let half = 0.5 * h;
        for &number in self.nearby.parts() {
            let part = &mut self.parts[number];
            if let Some(Some(carried)) = self.carried.get(number) {
                carried.carry(part, h);
            }
            part.first_push::<BOOKS>(half);
        }
        self.leave::<BOOKS>(points, half);
        for &number in self.nearby.islands.all(Kind::Links) {
            self.links[number].entry(&self.parts, half);
        }
        self.pull::<BOOKS>(half);
        self.elapsed += h;
        for &number in self.nearby.parts() {
            self.parts[number].drift(h);
        }
        if self.held.is_holding {
            self.add_held_damping(points, half);
            self.held.move_on(&mut self.parts, h);
        }
        self.meet::<BOOKS>(points, half);
        if self.held.is_holding {
            self.add_held_damping(points, half);
        }
        for &number in self.nearby.parts() {
            self.parts[number].second_push::<BOOKS>(half);
        }
        self.arrive::<BOOKS>(points, half);
        for &number in self.nearby.islands.all(Kind::Links) {
            self.links[number].watch_damping(&self.parts);
            self.links[number].entry(&self.parts, half);
        }
        self.pull::<BOOKS>(half);
    }

    /// Adds the first half of a sub-step to the sums of the contacts.
    #[inline]
    fn leave<const BOOKS: bool>(&mut self, points: &[Point], half: f64) {
        for &number in self.nearby.numbers() {
            let touch = &mut self.touches[number];
            if touch.is_apart() {
                continue;
            }
            let point = &points[number];
            let tool = tool_of(&self.parts, point, self.tools);
            touch.entry(tool, [half, self.elapsed]);
            if BOOKS || point.law.friction > 0.0 {
                let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
                let relative = relative(first, &first.twist, second, &second.twist, &touch.place);
                if BOOKS {
                    touch.entry_of_work(&relative, tool, half);
                }
                touch.slid += (relative - touch.normal * touch.normal.dot(&relative)) * half;
            }
        }
    }

    /// Adds the second half of a sub-step to the sums of the contacts.
    #[inline]
    fn arrive<const BOOKS: bool>(&mut self, points: &[Point], half: f64) {
        for &number in self.nearby.numbers() {
            let touch = &mut self.touches[number];
            if touch.is_apart() {
                continue;
            }
            let point = &points[number];
            let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
            let relative = relative(first, &first.twist, second, &second.twist, &touch.place);
            touch.watch_damping::<BOOKS>(point, &relative, first, second);
            if !self.expects_the_missed {
                touch.missed = 0.0;
            }
            let tool = tool_of(&self.parts, point, self.tools);
            touch.entry(tool, [half, self.elapsed]);
            if BOOKS {
                touch.entry_of_work(&relative, tool, half);
                touch.relative = relative;
            }
        }
    }
}

/// Returns the tool of a point's pair and its sign: see [`Point::sign_on`].
#[inline]
fn tool_of<'a>(parts: &'a [Part], point: &Point, tools: usize) -> Option<(&'a Part, f64)> {
    if point.first < tools {
        Some((&parts[point.first], 1.0))
    } else if point.second < tools {
        Some((&parts[point.second], -1.0))
    } else {
        None
    }
}

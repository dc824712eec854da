//! The ideal of any device: integrated, where [`ideal`](crate::ideal) is exact.
//!
//! A device with friction, links or a hand has no closed form together with the object, so both are
//! advanced in small steps under a contact force that is held over each. The force is the one whose
//! work equals the change of the spring's energy,
//!
//! ```text
//! f = (V(p⁺) − V(p)) / (p⁺ − p),    V(p) = K p² [p > 0] / 2,
//! ```
//!
//! found by iteration. Whatever the step, the contact then creates and destroys no energy; the
//! error is that of a second-order step, and halving the step tells how large it is.

use thiserror::Error;

use crate::InvalidParameter;
use crate::arc::ForceSums;
use crate::device::DevicePlant;
use crate::error::{finite, positive};
use crate::grid::Grid;
use crate::profile::{Collision, ForceProfile, Snapshot};

/// The object a device meets, and how finely their meeting is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceScene {
    /// Stiffness K of the contact `[N/m]`.
    pub stiffness: f64,
    /// Mass M of the object `[kg]`; infinite for a wall.
    pub object_mass: f64,
    /// Force f_V on the object `[N]`; without effect on a wall.
    pub virtual_force: f64,
    /// Position η of the object at t = 0 `[m]`.
    pub object_position: f64,
    /// Velocity η′ of the object at t = 0 `[m/s]`; without effect on a wall.
    pub object_velocity: f64,
    /// Period of the sampled loop `[s]`. The device's own controllers sample at it here, too.
    pub period: f64,
    /// Steps for each period.
    pub steps_per_period: usize,
}

/// Duration of a reference solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Window of this number of collisions, ⌈(t_n + T/2)/T⌉ periods.
    AfterCollisions(usize),
    /// This number of periods.
    AfterPeriods(usize),
}

/// Reason why a reference solution cannot be integrated.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ReferenceError {
    /// A value of the scene outside its range.
    #[error(transparent)]
    Scene(#[from] InvalidParameter),
    /// The search was to stop after no collision at all.
    #[error("collisions = 0 is not allowed; allowed: at least 1")]
    NoCollisions,
    /// The search found too few collisions.
    #[error(
        "collisions = {asked} is not allowed; allowed: at most the number within {LONGEST_SEARCH} periods"
    )]
    TooFewCollisions {
        /// Requested number of collisions.
        asked: usize,
        /// Collisions that ended within the search.
        found: usize,
    },
}

/// The integrated ideal of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The contact force over the window.
    pub profile: ForceProfile,
    /// States at `points_per_period` points of each period and at the end of the window.
    pub record: Vec<Snapshot>,
}

/// Points of the record for each period.
pub const POINTS_PER_PERIOD: usize = 20;

/// Longest search for collisions `[periods]`.
const LONGEST_SEARCH: usize = 2_000;

/// Most corrections of the force of a step. Each is better by the step's share of an oscillation,
/// squared, so a few reach round-off.
const MAX_CORRECTIONS: usize = 12;

struct Object {
    mobility: f64,
    acceleration: f64,
    position: f64,
    velocity: f64,
}

impl Object {
    fn advanced(&self, force: f64, duration: f64) -> (f64, f64) {
        let acceleration = self.acceleration + force * self.mobility;
        (
            self.position + duration * (self.velocity + 0.5 * acceleration * duration),
            self.velocity + acceleration * duration,
        )
    }
}

impl ReferenceScene {
    fn check(&self) -> Result<(), InvalidParameter> {
        positive("stiffness", self.stiffness, "finite and above 0 N/m")?;
        positive("period", self.period, "finite and above 0 s")?;
        InvalidParameter::unless(
            self.object_mass > 0.0,
            "object_mass",
            self.object_mass,
            "above 0 kg; infinite for a wall",
        )?;
        finite("virtual_force", self.virtual_force, "finite [N]")?;
        finite("object_position", self.object_position, "finite [m]")?;
        finite("object_velocity", self.object_velocity, "finite [m/s]")?;
        InvalidParameter::unless(
            self.steps_per_period >= POINTS_PER_PERIOD
                && self.steps_per_period.is_multiple_of(POINTS_PER_PERIOD),
            "steps_per_period",
            self.steps_per_period as f64,
            "a multiple of 20",
        )?;
        Ok(())
    }
}

/// Integrates `device` against the object of `scene`.
///
/// # Errors
///
/// A value of the scene outside its range, or a search for collisions that finds too few within
/// 2000 periods.
pub fn integrate<D: DevicePlant + Clone>(
    device: &D,
    scene: &ReferenceScene,
    stop: Stop,
) -> Result<Reference, ReferenceError> {
    scene.check()?;
    let mut run = Run::new(device.clone(), scene);
    let periods = match stop {
        Stop::AfterPeriods(periods) => periods,
        Stop::AfterCollisions(count) => {
            if count == 0 {
                return Err(ReferenceError::NoCollisions);
            }
            while run.ended < count {
                if run.sums.len() >= LONGEST_SEARCH {
                    return Err(ReferenceError::TooFewCollisions {
                        asked: count,
                        found: run.ended,
                    });
                }
                run.period();
            }
            let end = run.collisions[count - 1].end.unwrap_or(0.0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a number of periods from 1 to LONGEST_SEARCH + 1"
            )]
            let window = ((end + 0.5 * scene.period) / scene.period).ceil() as usize;
            window
        }
    };
    while run.sums.len() < periods {
        run.period();
    }
    Ok(run.finish(periods).0)
}

/// Integrates `device` against the object of `scene` over the periods that `grid`, which begins at
/// 0, covers: the reference by whole periods, and its force by the intervals of the grid.
///
/// # Errors
///
/// A value of the scene outside its range.
pub fn integrate_on<D: DevicePlant + Clone>(
    device: &D,
    scene: &ReferenceScene,
    grid: &Grid,
) -> Result<(Reference, ForceProfile), InvalidParameter> {
    scene.check()?;
    let mut run = Run::new(device.clone(), scene);
    // The periods of an even grid are gathered anyway.
    run.cells = (!grid.is_even()).then(|| Cells::new(grid.clone()));
    // An excess of a millionth of a period is rounding.
    while (run.sums.len() as f64 + 1e-6) * scene.period < grid.end() {
        run.period();
    }
    let periods = run.sums.len();
    let (reference, cells) = run.finish(periods);
    let profile = cells.map(|cells| {
        let collisions = reference.profile.collisions().to_vec();
        ForceProfile::from_sums(cells.grid, &cells.sums, collisions)
    });
    let profile = profile.unwrap_or_else(|| reference.profile.clone());
    Ok((reference, profile))
}

/// Impulses and squares by the intervals of a grid, gathered step by step.
struct Cells {
    grid: Grid,
    sums: Vec<ForceSums>,
    current: usize,
}

impl Cells {
    fn new(grid: Grid) -> Self {
        Self {
            sums: vec![ForceSums::default(); grid.intervals()],
            current: 0,
            grid,
        }
    }

    /// Records a step of `h` `[s]` from `time` `[s]`, over which the penetration changes linearly from `before` to
    /// `after`; an edge of the grid may lie within it.
    fn entry(&mut self, k: f64, time: f64, h: f64, before: f64, after: f64) {
        let end = time + h;
        let at = |instant: f64| before + (after - before) * ((instant - time) / h);
        let mut from = time;
        while self.current < self.sums.len() {
            let edge = self.grid.edge(self.current + 1);
            let to = edge.min(end);
            if to > from {
                let (a, b, length) = (at(from), at(to), to - from);
                let part = ForceSums {
                    impulse: balanced_force(k, a, b) * length,
                    moment: moment(k, a, b, length),
                    square: squared_force(k, a, b, length),
                };
                let begin = self.grid.edge(self.current);
                let later = 0.5 * ((from - begin) + (to - edge));
                self.sums[self.current].add(part, later);
                from = to;
            }
            if edge > end {
                break;
            }
            self.current += 1;
        }
    }
}

struct Run<'a, D> {
    scene: &'a ReferenceScene,
    device: D,
    object: Object,
    step: f64,
    /// Of each period, with the moment about its middle.
    sums: Vec<ForceSums>,
    collisions: Vec<Collision>,
    ended: usize,
    record: Vec<Snapshot>,
    cells: Option<Cells>,
}

impl<'a, D: DevicePlant + Clone> Run<'a, D> {
    fn new(device: D, scene: &'a ReferenceScene) -> Self {
        let mobility = 1.0 / scene.object_mass;
        let is_wall = mobility == 0.0;
        let mut run = Self {
            scene,
            object: Object {
                mobility,
                acceleration: if is_wall {
                    0.0
                } else {
                    scene.virtual_force * mobility
                },
                position: scene.object_position,
                velocity: if is_wall { 0.0 } else { scene.object_velocity },
            },
            device,
            step: scene.period / scene.steps_per_period as f64,
            sums: Vec::new(),
            collisions: Vec::new(),
            ended: 0,
            record: Vec::new(),
            cells: None,
        };
        run.keep(0.0);
        run
    }

    fn penetration(&self) -> f64 {
        self.device.position() - self.object.position
    }

    fn keep(&mut self, time: f64) {
        self.record.push(Snapshot {
            time,
            device_position: self.device.position(),
            device_velocity: self.device.velocity(),
            object_position: self.object.position,
            object_velocity: self.object.velocity,
            force_on_object: self.scene.stiffness * self.penetration().max(0.0),
        });
    }

    /// One period of the loop.
    fn period(&mut self) {
        let start = self.sums.len() as f64 * self.scene.period;
        self.device.sample(self.scene.period);
        let mut sum = ForceSums::default();
        for step in 0..self.scene.steps_per_period {
            let before = step as f64 * self.step;
            let part = self.step(start + before);
            sum.add(part, before - 0.5 * (self.scene.period - self.step));
            if (step + 1).is_multiple_of(self.scene.steps_per_period / POINTS_PER_PERIOD) {
                self.keep(start + (step + 1) as f64 * self.step);
            }
        }
        self.sums.push(sum);
    }

    /// One step from `time` `[s]`: the integrals of the force, with the moment about the step's middle.
    fn step(&mut self, time: f64) -> ForceSums {
        let (k, h) = (self.scene.stiffness, self.step);
        let before = self.penetration();
        let approach = self.device.velocity() - self.object.velocity;
        // Initial guess: the penetration at the middle of the step for constant speed.
        let mut force = k * (before + 0.5 * h * approach).max(0.0);
        let mut device = self.device.clone();
        let mut object = self.object.advanced(force, h);
        device.advance(force, h);
        for _ in 0..MAX_CORRECTIONS {
            let balanced = balanced_force(k, before, device.position() - object.0);
            // The same force would reproduce the motion; out of contact this holds at once.
            if balanced == force {
                break;
            }
            let change = (balanced - force).abs();
            force = balanced;
            device = self.device.clone();
            device.advance(force, h);
            object = self.object.advanced(force, h);
            if change <= 1e-14 * force.abs() {
                break;
            }
        }
        self.device = device;
        (self.object.position, self.object.velocity) = object;
        let after = self.penetration();
        self.follow_collision(time, before, after, approach, force);
        if let Some(cells) = &mut self.cells {
            cells.entry(k, time, h, before, after);
        }
        ForceSums {
            impulse: force * h,
            moment: moment(k, before, after, h),
            square: squared_force(k, before, after, h),
        }
    }

    fn follow_collision(&mut self, time: f64, before: f64, after: f64, speed: f64, force: f64) {
        let (h, k) = (self.step, self.scene.stiffness);
        let pressed = before > 0.0 || after > 0.0;
        let open = self.collisions.len() > self.ended;
        if pressed && !open {
            let start = if before > 0.0 {
                time
            } else {
                time + h * (1.0 - in_contact(before, after))
            };
            self.collisions.push(Collision {
                start,
                end: None,
                impulse: 0.0,
                peak_force: 0.0,
                impact_speed: speed.abs(),
                release_speed: None,
            });
        }
        let left_at = self.device.velocity() - self.object.velocity;
        if let Some(collision) = self.collisions.last_mut().filter(|_| pressed) {
            collision.impulse += force * h;
            collision.peak_force = collision.peak_force.max(k * after);
            if after <= 0.0 {
                let share = in_contact(before, after);
                collision.end = Some(time + h * share);
                collision.release_speed = Some((speed + share * (left_at - speed)).abs());
                self.ended += 1;
            }
        }
    }

    fn finish(mut self, periods: usize) -> (Reference, Option<Cells>) {
        let end = periods as f64 * self.scene.period;
        self.sums.truncate(periods);
        self.record.truncate(periods * POINTS_PER_PERIOD + 1);
        self.collisions.retain(|collision| collision.start < end);
        let reference = Reference {
            profile: ForceProfile::from_sums(
                Grid::even(0.0, self.scene.period, periods),
                &self.sums,
                self.collisions,
            ),
            record: self.record,
        };
        (reference, self.cells)
    }
}

/// Returns ∫ f² dt of a spring of stiffness `k` over `h` `[s]`, in which the penetration changes linearly from `before`
/// to `after`.
fn squared_force(k: f64, before: f64, after: f64, h: f64) -> f64 {
    let (first, last) = (k * before.max(0.0), k * after.max(0.0));
    let share = in_contact(before, after);
    share * h * (first * first + first * last + last * last) / 3.0
}

/// Returns ∫ f (t − h/2) dt of the same force.
fn moment(k: f64, before: f64, after: f64, h: f64) -> f64 {
    let (first, last) = (k * before.max(0.0), k * after.max(0.0));
    let pressed = in_contact(before, after) * h;
    // A line over the pressed part, which begins or ends the step.
    let later = if before > 0.0 {
        pressed - h
    } else {
        h - pressed
    };
    pressed * (pressed * (last - first) / 12.0 + 0.25 * later * (first + last))
}

/// Mean force of a spring of stiffness `k` that takes the penetration from `before` to `after`,
/// with the work of that path.
fn balanced_force(k: f64, before: f64, after: f64) -> f64 {
    if before > 0.0 && after > 0.0 {
        0.5 * k * (before + after)
    } else {
        // One of them, or none, is pressed: V over the way.
        let pressed = before.max(after).max(0.0);
        0.5 * k * pressed * in_contact(before, after)
    }
}

/// Share of the way from `before` to `after` on which the penetration is positive.
fn in_contact(before: f64, after: f64) -> f64 {
    match (before > 0.0, after > 0.0) {
        (true, true) => 1.0,
        (false, false) => 0.0,
        (true, false) => before / (before - after),
        (false, true) => after / (after - before),
    }
}

//! The ideal contact force over a window, cut into the intervals of a sampled loop.
//!
//! Every ideal, coupled or driven, ends in this one type, so the same metrics apply to all.

use crate::arc::{Arc, ForceSums};
use crate::grid::Grid;

/// One collision of an ideal contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// Instant at which contact begins `[s]`; the start of the window if contact was there before.
    pub start: f64,
    /// Instant at which contact ends `[s]`, `None` if it lasts beyond the window.
    pub end: Option<f64>,
    /// Impulse ∫ f dt on the object `[N s]`, up to the window's end.
    pub impulse: f64,
    /// Largest force `[N]`, up to the window's end.
    pub peak_force: f64,
    /// Relative speed at impact `[m/s]`.
    ///
    /// A contact that is already there when the window begins may be deep and at rest; it gets the
    /// speed at which the energy of its motion and of its spring together would arrive.
    pub impact_speed: f64,
    /// Speed at which device and object part `[m/s]`, `None` where `end` is.
    pub release_speed: Option<f64>,
}

/// State of device and object at one instant, and the force between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot {
    /// `[s]`
    pub time: f64,
    /// ξ `[m]`
    pub device_position: f64,
    /// ξ′ `[m/s]`
    pub device_velocity: f64,
    /// η `[m]`
    pub object_position: f64,
    /// η′ `[m/s]`
    pub object_velocity: f64,
    /// Force on the object `[N]`; in the record of a loop, the force held from this instant on.
    pub force_on_object: f64,
}

impl Snapshot {
    /// Penetration p = ξ − η `[m]`.
    #[must_use]
    pub fn penetration(&self) -> f64 {
        self.device_position - self.object_position
    }

    /// Whether every number in it is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [
            self.time,
            self.device_position,
            self.device_velocity,
            self.object_position,
            self.object_velocity,
            self.force_on_object,
        ]
        .iter()
        .all(|number| number.is_finite())
    }
}

/// The ideal contact force over a window, cut where a loop changes the force it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceProfile {
    grid: Grid,
    impulses: Vec<f64>,
    moments: Vec<f64>,
    squared_forces: Vec<f64>,
    collisions: Vec<Collision>,
}

impl ForceProfile {
    /// Gathers `arcs`, which follow each other and cover the window.
    pub(crate) fn from_arcs(arcs: &[Arc], grid: Grid) -> Self {
        let intervals = grid.intervals();
        let mut sums = Vec::with_capacity(intervals);
        let mut first = 0;
        for interval in 0..intervals {
            let (begin, end) = (grid.edge(interval), grid.edge(interval + 1));
            while arcs.get(first).is_some_and(|arc| arc.end <= begin) {
                first += 1;
            }
            let mut sum = ForceSums::default();
            for arc in arcs[first..].iter().take_while(|arc| arc.start < end) {
                let (from, to) = (arc.start.max(begin), arc.end.min(end));
                sum.add(arc.sums(from, to), 0.5 * ((from - begin) + (to - end)));
            }
            sums.push(sum);
        }
        let collisions = collisions(arcs, grid.end());
        Self::from_sums(grid, &sums, collisions)
    }

    /// A profile that has been integrated interval by interval.
    /// The moments of `sums` are about the middles of the intervals.
    pub(crate) fn from_sums(grid: Grid, sums: &[ForceSums], collisions: Vec<Collision>) -> Self {
        Self {
            grid,
            impulses: sums.iter().map(|sum| sum.impulse).collect(),
            moments: sums.iter().map(|sum| sum.moment).collect(),
            squared_forces: sums.iter().map(|sum| sum.square).collect(),
            collisions,
        }
    }

    /// Returns the intervals of the window.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Start of the window `[s]`.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.grid.start()
    }

    /// Nominal period of the loop `[s]`.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.grid.period()
    }

    /// Number of intervals in the window.
    #[must_use]
    pub fn intervals(&self) -> usize {
        self.impulses.len()
    }

    /// Impulse J = ∫ f dt of each interval `[N s]`.
    #[must_use]
    pub fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// First moment J₁ = ∫ f (t − t₀) dt of each interval about its middle t₀ `[N s²]`.
    #[must_use]
    pub fn moments(&self) -> &[f64] {
        &self.moments
    }

    /// Q = ∫ f² dt of each interval `[N² s]`.
    #[must_use]
    pub fn squared_forces(&self) -> &[f64] {
        &self.squared_forces
    }

    /// Mean force J/h of each interval of length h `[N]`: the best that can be held over it.
    pub fn mean_forces(&self) -> impl Iterator<Item = f64> + '_ {
        self.impulses
            .iter()
            .zip(self.grid.durations())
            .map(|(impulse, duration)| impulse / duration)
    }

    /// Slope 12 J₁/h³ of each interval of length h `[N/s]`: that of the best line over it, whose mean is J/h.
    pub fn slopes(&self) -> impl Iterator<Item = f64> + '_ {
        self.moments
            .iter()
            .zip(self.grid.durations())
            .map(|(moment, duration)| 12.0 * moment / duration.powi(3))
    }

    /// The collisions that begin before the window ends, in order.
    #[must_use]
    pub fn collisions(&self) -> &[Collision] {
        &self.collisions
    }
}

/// The collisions among `arcs` up to `until`. Neighbouring arcs in contact are one collision.
fn collisions(arcs: &[Arc], until: f64) -> Vec<Collision> {
    let mut collisions: Vec<Collision> = Vec::new();
    let mut open = false;
    for (index, arc) in arcs.iter().enumerate() {
        if !arc.in_contact {
            open = false;
            continue;
        }
        if arc.start >= until {
            break;
        }
        let end = arc.end.min(until);
        let impulse = arc.sums(arc.start, end).impulse;
        let peak_force = arc.peak_force(arc.start, end);
        let released = arc.end <= until && arcs.get(index + 1).is_some_and(|next| !next.in_contact);
        let end = released.then_some(arc.end);
        let release_speed = end.map(|end| arc.state(end).velocity.abs());
        match collisions.last_mut() {
            Some(collision) if open => {
                collision.end = end;
                collision.release_speed = release_speed;
                collision.impulse += impulse;
                collision.peak_force = collision.peak_force.max(peak_force);
            }
            _ => collisions.push(Collision {
                start: arc.start,
                end,
                impulse,
                peak_force,
                impact_speed: arc
                    .at_start
                    .velocity
                    .hypot(arc.motion.rate * arc.at_start.penetration),
                release_speed,
            }),
        }
        open = true;
    }
    collisions
}

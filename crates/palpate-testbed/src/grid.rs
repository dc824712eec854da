//! Division of a time window into the intervals over which a loop holds its forces.

use crate::InvalidParameter;
use crate::error::{finite, positive};

/// A time window, divided into consecutive intervals.
///
/// A perfect loop has equal intervals. With late or missing samples or a varying rate, the intervals end where commands
/// actually reach the motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    start: f64,
    period: f64,
    cuts: Cuts,
}

#[derive(Debug, Clone, PartialEq)]
enum Cuts {
    /// This number of periods.
    Even(usize),
    /// These instants, including the first and the last of the window.
    At(Vec<f64>),
}

impl Grid {
    /// `intervals` periods `[s]` from `start` `[s]`.
    #[must_use]
    pub fn even(start: f64, period: f64, intervals: usize) -> Self {
        Self {
            start,
            period,
            cuts: Cuts::Even(intervals),
        }
    }

    /// The intervals between `edges` `[s]` of a loop with a nominal `period` `[s]`.
    ///
    /// # Errors
    ///
    /// There are fewer than two edges, one is not finite or not after the one before it, or the
    /// period is not finite and positive.
    pub fn cut_at(edges: Vec<f64>, period: f64) -> Result<Self, InvalidParameter> {
        positive("period", period, "finite and above 0 s")?;
        InvalidParameter::unless(
            edges.len() >= 2,
            "edges",
            edges.len() as f64,
            "at least two instants",
        )?;
        for edge in &edges {
            finite("edges", *edge, "finite [s]")?;
        }
        if let Some(pair) = edges.windows(2).find(|pair| pair[1] <= pair[0]) {
            InvalidParameter::unless(false, "edges", pair[1], "instants in rising order [s]")?;
        }
        Ok(Self {
            start: edges[0],
            period,
            cuts: Cuts::At(edges),
        })
    }

    /// Returns the grid of the first intervals, at least one, at most all.
    #[must_use]
    pub fn shortened(&self, intervals: usize) -> Self {
        let cuts = match &self.cuts {
            Cuts::Even(all) => Cuts::Even(intervals.clamp(1, (*all).max(1))),
            Cuts::At(edges) => Cuts::At(edges[..edges.len().min(intervals.max(1) + 1)].to_vec()),
        };
        Self {
            cuts,
            ..self.clone()
        }
    }

    /// Start of the window `[s]`.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// End of the window `[s]`.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.edge(self.intervals())
    }

    /// Nominal period of the loop `[s]`.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Number of intervals.
    #[must_use]
    pub fn intervals(&self) -> usize {
        match &self.cuts {
            Cuts::Even(intervals) => *intervals,
            Cuts::At(edges) => edges.len() - 1,
        }
    }

    /// Whether every interval is one period.
    #[must_use]
    pub fn is_even(&self) -> bool {
        matches!(self.cuts, Cuts::Even(_))
    }

    /// Start of an interval `[s]`, or the end of the window for their number.
    ///
    /// # Panics
    ///
    /// Beyond the end of an uneven grid.
    #[must_use]
    pub fn edge(&self, interval: usize) -> f64 {
        match &self.cuts {
            Cuts::Even(_) => self.start + interval as f64 * self.period,
            Cuts::At(edges) => edges[interval],
        }
    }

    /// Length of an interval `[s]`; of an even grid exactly its period.
    ///
    /// # Panics
    ///
    /// Beyond the end of an uneven grid.
    #[must_use]
    pub fn duration(&self, interval: usize) -> f64 {
        match &self.cuts {
            Cuts::Even(_) => self.period,
            Cuts::At(edges) => edges[interval + 1] - edges[interval],
        }
    }

    /// Lengths of all intervals `[s]`.
    pub fn durations(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.intervals()).map(|interval| self.duration(interval))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_grid_has_exact_periods_and_products_for_edges() {
        let grid = Grid::even(0.5, 0.1, 1000);
        assert_eq!((grid.start(), grid.end()), (0.5, 0.5 + 1000.0 * 0.1));
        assert_eq!(grid.edge(3), 0.5 + 3.0 * 0.1);
        assert!(grid.durations().all(|duration| duration == 0.1));
        assert_eq!(grid.durations().count(), 1000);
    }

    #[test]
    fn a_shortened_grid_is_the_first_part_of_it() {
        let even = Grid::even(0.5, 0.1, 10).shortened(3);
        assert_eq!((even.intervals(), even.end()), (3, 0.5 + 3.0 * 0.1));
        let cut = Grid::cut_at(vec![0.0, 1.0, 4.0], 2.0).unwrap();
        assert_eq!(
            (cut.shortened(1).intervals(), cut.shortened(1).end()),
            (1, 1.0)
        );
        assert_eq!(cut.shortened(7), cut);
    }

    #[test]
    fn a_cut_grid_is_where_it_was_cut() {
        let grid = Grid::cut_at(vec![0.0, 1.0, 4.0], 2.0).unwrap();
        assert_eq!((grid.intervals(), grid.end(), grid.period()), (2, 4.0, 2.0));
        assert_eq!(grid.durations().collect::<Vec<_>>(), [1.0, 3.0]);
        for bad in [vec![0.0], vec![0.0, 0.0], vec![0.0, f64::NAN]] {
            assert_eq!(Grid::cut_at(bad, 1.0).unwrap_err().name, "edges");
        }
        assert_eq!(
            Grid::cut_at(vec![0.0, 1.0], 0.0).unwrap_err().name,
            "period"
        );
    }
}

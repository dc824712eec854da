//! Timing of a loop: its durations, each as quantiles and as a histogram.

use super::file_name;
use palpate_record::recording::{Recording, Tick};
use serde::Serialize;

use super::ticks::Ticks;
use crate::recording::scene_of;

/// Bins per decade of a duration.
const PER_DECADE: f64 = 8.0;
/// Bins of a histogram with even steps.
const EVEN_BINS: usize = 48;
/// Lower limit of a duration `[s]`, about the resolution of a clock; shorter ones count as this value.
const SHORTEST: f64 = 1e-7;

/// Timing of a recorded loop.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TimingCard {
    /// The recording.
    pub recording: String,
    /// Version of palpate that made the recording.
    pub palpate_version: String,
    /// Title of its scene; none if the recording does not contain it.
    pub scene: Option<String>,
    /// Rendering method; none if the recording does not contain it.
    pub method: Option<String>,
    /// Nominal period of the loop `[s]`; none if the recording does not contain it.
    pub period_asked_s: Option<f64>,
    /// Number of recorded ticks.
    pub ticks: u64,
    /// Number of ticks missing in the recording.
    pub ticks_lost: u64,
    /// Duration of the loop `[s]`; none if unknown.
    pub lasted_s: Option<f64>,
    /// Number of ticks that started or ended after their deadline.
    pub missed_deadlines: u64,
    /// Time from one sample to the next.
    pub period_s: Option<Distribution>,
    /// Time of a sample after its planned instant; negative if early.
    pub lateness_s: Option<Distribution>,
    /// Time from a sample to its command.
    pub tick_s: Option<Distribution>,
    /// Response time of the device.
    pub round_trip_s: Option<Distribution>,
}

/// Durations `[s]`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Distribution {
    /// Number of durations.
    pub count: u64,
    /// The smallest.
    pub smallest: f64,
    /// Median.
    pub median: f64,
    /// 99 % quantile.
    pub p99: f64,
    /// The longest.
    pub largest: f64,
    /// Histogram of the durations.
    pub histogram: Histogram,
}

/// Counts of values per bin: bin `i` extends from edge `i` to edge `i + 1`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Histogram {
    /// Edges of the bins `[s]`, one more than there are bins.
    pub edges_s: Vec<f64>,
    /// Number of values in each bin; values below the first edge are in the first bin.
    pub counts: Vec<u64>,
    /// Whether the bins are logarithmically spaced; otherwise linearly.
    pub is_logarithmic: bool,
}

impl TimingCard {
    pub(super) fn new(recording: &Recording, ticks: &Ticks) -> Self {
        let scene = scene_of(recording).ok().map(|file| file.scene);
        let counted = recording.counted.as_ref();
        let all = |of: fn(&Tick) -> f64, bins: fn(&[f64]) -> Histogram| {
            Distribution::new(ticks.all.iter().map(|row| of(&row.tick)), bins)
        };
        Self {
            recording: file_name(recording.path()),
            palpate_version: recording.metadata.palpate_version.clone(),
            scene: scene.as_ref().map(|scene| scene.title.clone()),
            method: scene.as_ref().map(|scene| scene.method.name().to_owned()),
            period_asked_s: scene.as_ref().map(|scene| scene.loop_params.period),
            ticks: recording.ticks,
            ticks_lost: recording.lost(),
            lasted_s: counted
                .and_then(|count| count.time)
                .map(|time| time.lasted.as_secs_f64()),
            missed_deadlines: ticks.missed_deadlines,
            period_s: all(|tick| tick.period, even),
            lateness_s: all(|tick| tick.lateness, logarithmic),
            tick_s: all(|tick| tick.tick_duration, logarithmic),
            round_trip_s: all(|tick| tick.device_round_trip, logarithmic),
        }
    }
}

impl Distribution {
    /// Creates the distribution of the finite values; `None` if there are none.
    fn new(values: impl Iterator<Item = f64>, bins: fn(&[f64]) -> Histogram) -> Option<Self> {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let at = |part: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an index from 0 to the last"
            )]
            let rank = (part * values.len() as f64).ceil() as usize;
            values.get(rank.max(1) - 1).copied()
        };
        Some(Self {
            count: values.len() as u64,
            smallest: *values.first()?,
            median: at(0.5)?,
            p99: at(0.99)?,
            largest: *values.last()?,
            histogram: bins(&values),
        })
    }
}

/// Returns logarithmically spaced bins; `values` are in ascending order.
fn logarithmic(values: &[f64]) -> Histogram {
    let step = |value: f64| PER_DECADE * value.max(SHORTEST).log10();
    let (first, last) = (values[0], values[values.len() - 1]);
    let from = (step(first) + 1e-9).floor();
    let to = (step(last) + 1e-9).floor() + 1.0;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some hundreds: durations are finite, and from 1e-7 s on"
    )]
    let bins = (to - from) as usize;
    let edge = |bin: usize| 10.0_f64.powf((from + bin as f64) / PER_DECADE);
    counted((0..=bins).map(edge).collect(), true, values)
}

/// Returns bins of equal width; `values` are in ascending order.
fn even(values: &[f64]) -> Histogram {
    let (first, last) = (values[0], values[values.len() - 1]);
    // If all values are equal, they are in the middle of a bin.
    let width = ((last - first) / EVEN_BINS as f64).max(0.002 * last.abs().max(SHORTEST));
    let middle = 0.5 * (first + last);
    let edge = |bin: usize| middle + width * (bin as f64 - 0.5 * EVEN_BINS as f64);
    counted((0..=EVEN_BINS).map(edge).collect(), false, values)
}

fn counted(edges_s: Vec<f64>, is_logarithmic: bool, values: &[f64]) -> Histogram {
    let mut counts = vec![0; edges_s.len() - 1];
    let last = counts.len() - 1;
    for value in values {
        let bin = edges_s.partition_point(|edge| edge <= value);
        counts[bin.saturating_sub(1).min(last)] += 1;
    }
    Histogram {
        edges_s,
        counts,
        is_logarithmic,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_and_no_value_is_lost_in_a_histogram() {
        let values = (1..=200).map(|i| 1e-5 * f64::from(i)).chain([f64::NAN]);
        for bins in [even, logarithmic] {
            let found = Distribution::new(values.clone(), bins).unwrap();
            assert_eq!((found.count, found.smallest), (200, 1e-5));
            assert_eq!(
                (found.median, found.p99, found.largest),
                (1e-5 * 100.0, 1e-5 * 198.0, 1e-5 * 200.0)
            );
            let histogram = &found.histogram;
            assert_eq!(histogram.counts.iter().sum::<u64>(), 200);
            assert_eq!(histogram.edges_s.len(), histogram.counts.len() + 1);
            let edges = &histogram.edges_s;
            assert!(edges[0] <= 1e-5 * (1.0 + 1e-9), "{edges:?}");
            assert!(edges[edges.len() - 1] >= 2e-3 * (1.0 - 1e-9), "{edges:?}");
        }
        assert!(Distribution::new([f64::NAN].into_iter(), even).is_none());
    }

    #[test]
    fn values_that_are_all_the_same_and_values_below_zero_have_a_bin() {
        for bins in [even, logarithmic] {
            for value in [1e-3, 0.0, -1e-3] {
                let found = Distribution::new([value; 5].into_iter(), bins).unwrap();
                assert_eq!(found.histogram.counts.iter().sum::<u64>(), 5, "{value}");
                assert_eq!(found.histogram.counts.iter().max(), Some(&5), "{value}");
            }
        }
    }
}

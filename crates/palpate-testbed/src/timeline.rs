//! Timeline of an imperfect loop over a window of time.
//!
//! A [`Schedule`] determines when samples are taken and when their commands reach the motor. Between two such instants
//! the device moves under one held force. A timeline lists these stretches, so a loop is one pass over them for any
//! timing imperfection.

use crate::InvalidParameter;
use crate::error::positive;
use crate::grid::Grid;
use crate::schedule::{Schedule, ScheduleParams};

/// Instants this close together, in nominal periods, are the same one: sums of delays and products
/// of periods differ by rounding.
const SAME_INSTANT: f64 = 1e-6;

/// An interval between samples this near to the nominal period, relatively, is exactly that.
const NOMINAL: f64 = 1e-9;

/// A sample of a timeline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenSample {
    /// Time of the sample `[s]`.
    pub time: f64,
    /// Time since the sample before it `[s]`; one nominal period for the first.
    pub elapsed: f64,
    /// Arrival of its command at the motor `[s]`; `None` after the window's end.
    pub command_from: Option<f64>,
}

/// A stretch of time in which nothing happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The sample it begins with, if it does.
    pub sample: Option<usize>,
    /// The sample whose command is held in it; none as long as no command has arrived.
    pub command: Option<usize>,
    /// Whether another force may be held here than in the stretch before.
    pub begins_hold: bool,
    /// Length `[s]`; 0 for the last, which only takes the sample at the window's end.
    pub duration: f64,
}

/// The samples and commands of a loop in a window of whole nominal periods from t = 0.
///
/// The window ends with a sample that completes the energy ledger, even if the schedule has no sample there.
#[derive(Debug, Clone, PartialEq)]
pub struct Timeline {
    samples: Vec<TakenSample>,
    stretches: Vec<Stretch>,
    grid: Grid,
}

impl Timeline {
    /// Creates the timeline of a schedule over `periods` nominal periods.
    ///
    /// # Errors
    ///
    /// Those of [`Schedule::new`], or the window has no period.
    pub fn new(params: ScheduleParams, periods: usize) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(periods > 0, "periods", 0.0, "at least 1")?;
        let period = params.period;
        let end = periods as f64 * period;
        let near = SAME_INSTANT * period;
        let mut samples = Vec::with_capacity(periods + 1);
        // When each sample's command reaches the motor [s].
        let mut arrivals = Vec::with_capacity(periods + 1);
        let mut last = f64::INFINITY;
        for tick in Schedule::new(params)? {
            if tick.sample_time >= end - near {
                if tick.sample_time <= end + near {
                    last = tick.hold_from.max(end);
                }
                break;
            }
            samples.push(taken(samples.last(), tick.sample_time, period));
            arrivals.push(tick.hold_from);
        }
        samples.push(taken(samples.last(), end, period));
        arrivals.push(last);
        Self::built(samples, &arrivals, period, periods)
    }

    /// Creates the timeline of a loop that sampled at `instants` `[s]`, over a number of its nominal periods `[s]`. The
    /// first instant is 0 and they increase. A command reaches the motor `seconds` after the sample that is `delay`
    /// samples after its own.
    ///
    /// # Errors
    ///
    /// The window has no period, or the instants do not increase.
    pub fn at_instants(
        instants: &[f64],
        (delay, seconds): (usize, f64),
        period: f64,
        periods: usize,
    ) -> Result<Self, InvalidParameter> {
        positive("period", period, "finite and above 0 s")?;
        InvalidParameter::unless(
            seconds.is_finite() && seconds >= 0.0,
            "delay",
            seconds,
            "finite and at least 0 s",
        )?;
        InvalidParameter::unless(periods > 0, "periods", 0.0, "at least 1")?;
        let first = instants.first().copied().unwrap_or(f64::NAN);
        InvalidParameter::unless(first == 0.0, "instants", first, "0 s for the first")?;
        for pair in instants.windows(2) {
            let rises = pair[1] > pair[0];
            InvalidParameter::unless(rises, "instants", pair[1], "in rising order [s]")?;
        }
        let end = periods as f64 * period;
        let near = SAME_INSTANT * period;
        let within = instants.partition_point(|&instant| instant < end - near);
        let mut samples = Vec::with_capacity(within + 1);
        for &instant in &instants[..within] {
            samples.push(taken(samples.last(), instant, period));
        }
        samples.push(taken(samples.last(), end, period));
        let arrivals: Vec<f64> = (0..samples.len())
            .map(|sample| {
                let arrives = samples.get(sample.saturating_add(delay));
                arrives.map_or(f64::INFINITY, |arrives| arrives.time + seconds)
            })
            .collect();
        Self::built(samples, &arrivals, period, periods)
    }

    fn built(
        samples: Vec<TakenSample>,
        arrivals: &[f64],
        period: f64,
        periods: usize,
    ) -> Result<Self, InvalidParameter> {
        let mut built = Self {
            samples,
            stretches: Vec::with_capacity(periods + 1),
            grid: Grid::even(0.0, period, periods),
        };
        built.fill(arrivals, SAME_INSTANT * period);
        built.cut(period, periods)?;
        Ok(built)
    }

    /// The stretches, from the samples and the `arrivals` of their commands.
    fn fill(&mut self, arrivals: &[f64], near: f64) {
        let closing = self.samples.len() - 1;
        let mut command = None;
        let mut next = 0;
        for sample in 0..=closing {
            let (start, end) = match self.samples.get(sample + 1) {
                Some(after) => (self.samples[sample].time, after.time),
                None => (self.samples[sample].time, self.samples[sample].time),
            };
            let mut from = start;
            let mut begins_with = Some(sample);
            loop {
                // Commands that arrive together replace each other at once.
                let before = command;
                while next <= sample && arrivals[next] <= from + near {
                    command = Some(next);
                    self.samples[next].command_from = Some(from);
                    next += 1;
                }
                let arrival = match arrivals.get(next) {
                    Some(&arrival) if next <= sample && arrival < end - near => arrival,
                    _ => end,
                };
                let whole = begins_with.is_some() && arrival == end && sample < closing;
                self.stretches.push(Stretch {
                    sample: begins_with,
                    command,
                    begins_hold: self.stretches.is_empty()
                        || command != before
                        || command.is_none(),
                    duration: if whole {
                        self.samples[sample + 1].elapsed
                    } else {
                        arrival - from
                    },
                });
                if arrival == end {
                    break;
                }
                from = arrival;
                begins_with = None;
            }
        }
    }

    /// Cuts the window where another force may be held.
    fn cut(&mut self, period: f64, periods: usize) -> Result<(), InvalidParameter> {
        let closing = self.stretches.len() - 1;
        let mut edges = Vec::with_capacity(periods + 1);
        let mut at = 0.0;
        for stretch in &self.stretches[..closing] {
            if let Some(sample) = stretch.sample {
                at = self.samples[sample].time;
            } else if let Some(command) = stretch.command {
                at = self.samples[command].command_from.unwrap_or(at);
            }
            if stretch.begins_hold {
                edges.push(at);
            }
        }
        edges.push(self.samples[self.samples.len() - 1].time);
        let even = edges.len() == periods + 1
            && (0..=periods).all(|edge| edges[edge] == edge as f64 * period);
        if !even {
            self.grid = Grid::cut_at(edges, period)?;
        }
        Ok(())
    }

    /// The samples, from the one at 0 to the one at the window's end.
    #[must_use]
    pub fn samples(&self) -> &[TakenSample] {
        &self.samples
    }

    /// The stretches between samples and arrivals, in order. The last has no length: it takes the
    /// sample at the window's end.
    #[must_use]
    pub fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The window, cut where another force may be held: where a command reaches the motor, and at
    /// every sample before the first one does.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

fn taken(before: Option<&TakenSample>, time: f64, period: f64) -> TakenSample {
    let elapsed = before.map_or(period, |before| time - before.time);
    TakenSample {
        time,
        elapsed: if (elapsed / period - 1.0).abs() <= NOMINAL {
            period
        } else {
            elapsed
        },
        command_from: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{ActuationDelay, Dropped, Jitter, RateCollapse};

    fn timeline(params: ScheduleParams, periods: usize) -> Timeline {
        Timeline::new(params, periods).unwrap()
    }

    /// Returns the sample whose command is held at `time`, read from the stretches.
    fn command_at(timeline: &Timeline, time: f64) -> Option<usize> {
        let mut at = 0.0;
        for stretch in timeline.stretches() {
            if time < at + stretch.duration {
                return stretch.command;
            }
            at += stretch.duration;
        }
        None
    }

    #[test]
    fn a_perfect_loop_has_whole_periods_and_an_even_grid_with_any_delay() {
        for samples in [0, 1, 3, 50] {
            let delay = ActuationDelay {
                samples,
                fraction: 0.0,
                ..ActuationDelay::default()
            };
            let perfect = timeline(
                ScheduleParams {
                    delay,
                    ..ScheduleParams::perfect(0.007)
                },
                40,
            );
            assert_eq!(perfect.grid(), &Grid::even(0.0, 0.007, 40));
            assert_eq!(perfect.stretches().len(), 41);
            for (i, (stretch, sample)) in perfect
                .stretches()
                .iter()
                .zip(perfect.samples())
                .enumerate()
            {
                assert_eq!(stretch.sample, Some(i));
                assert_eq!(stretch.command, i.checked_sub(samples as usize));
                assert_eq!(stretch.duration, if i < 40 { 0.007 } else { 0.0 });
                assert_eq!((sample.time, sample.elapsed), (i as f64 * 0.007, 0.007));
                let arrives = i + samples as usize;
                let expected = (arrives <= 40).then_some(arrives as f64 * 0.007);
                assert_eq!(sample.command_from, expected);
            }
        }
    }

    #[test]
    fn instants_of_a_schedule_make_its_timeline() {
        for (delay, seed) in [(0, 1), (1, 2), (3, 3)] {
            let params = ScheduleParams {
                dropped: Dropped::Probability(0.2),
                jitter: Jitter::Uniform { bound: 0.002 },
                seed,
                ..ScheduleParams::perfect(0.01)
            };
            let scheduled = timeline(params, 40);
            let mut instants: Vec<f64> = scheduled.samples().iter().map(|s| s.time).collect();
            // Samples after the window are ignored.
            instants.extend([0.403, 0.41]);
            let given = Timeline::at_instants(&instants, (delay, 0.0), 0.01, 40).unwrap();
            let of = |timeline: &Timeline| -> Vec<(f64, f64)> {
                let samples = timeline.samples().iter();
                samples
                    .map(|sample| (sample.time, sample.elapsed))
                    .collect()
            };
            assert_eq!(of(&given), of(&scheduled));
            for (index, stretch) in given.stretches().iter().enumerate() {
                assert_eq!(stretch.sample, Some(index));
                assert_eq!(stretch.command, index.checked_sub(delay));
            }
            if delay == 0 {
                assert_eq!(given.grid(), scheduled.grid());
                // The last has no length, and its command none to act in.
                let closing = given.stretches().len() - 1;
                assert_eq!(
                    given.stretches()[..closing],
                    scheduled.stretches()[..closing]
                );
            }
        }
    }

    #[test]
    fn instants_that_cannot_be_are_refused_by_name() {
        for instants in [&[][..], &[0.1, 0.2], &[0.0, 0.2, 0.2], &[0.0, f64::NAN]] {
            let error = Timeline::at_instants(instants, (0, 0.0), 0.1, 2).unwrap_err();
            assert_eq!(error.name, "instants", "{instants:?}");
        }
        assert!(Timeline::at_instants(&[0.0, 0.1], (0, 0.0), 0.1, 0).is_err());
        assert!(Timeline::at_instants(&[0.0, 0.1], (0, 0.0), 0.0, 1).is_err());
    }

    #[test]
    fn a_dropped_sample_leaves_the_force_until_the_next_command() {
        let dropped = timeline(
            ScheduleParams {
                dropped: Dropped::Listed(vec![2, 3, 6]),
                ..ScheduleParams::perfect(0.5)
            },
            6,
        );
        let times: Vec<f64> = dropped.samples().iter().map(|sample| sample.time).collect();
        // The window is closed by a sample that the schedule does not have.
        assert_eq!(times, [0.0, 0.5, 2.0, 2.5, 3.0]);
        assert_eq!(dropped.samples()[2].elapsed, 1.5);
        assert_eq!(dropped.samples()[4].command_from, None);
        let durations: Vec<f64> = dropped.grid().durations().collect();
        assert_eq!(durations, [0.5, 1.5, 0.5, 0.5]);
    }

    #[test]
    fn a_late_command_replaces_the_held_one_between_samples() {
        let delay = ActuationDelay {
            samples: 1,
            fraction: 0.25,
            ..ActuationDelay::default()
        };
        let late = timeline(
            ScheduleParams {
                delay,
                ..ScheduleParams::perfect(1.0)
            },
            3,
        );
        let of = |stretch: &Stretch| (stretch.sample, stretch.command, stretch.duration);
        let expected = [
            (Some(0), None, 1.0),
            (Some(1), None, 0.25),
            (None, Some(0), 0.75),
            (Some(2), Some(0), 0.25),
            (None, Some(1), 0.75),
            (Some(3), Some(1), 0.0),
        ];
        assert!(late.stretches().iter().map(of).eq(expected), "{late:?}");
        let edges: Vec<f64> = (0..=4).map(|i| late.grid().edge(i)).collect();
        assert_eq!(edges, [0.0, 1.0, 1.25, 2.25, 3.0]);
    }

    #[test]
    fn whatever_is_wrong_the_window_is_covered_and_no_command_comes_before_its_sample() {
        for seed in 0..200_u32 {
            let params = ScheduleParams {
                period: 0.01,
                jitter: Jitter::Normal {
                    deviation: 1e-3,
                    bound: 0.9e-3,
                },
                dropped: Dropped::Probability(0.3),
                collapse: Some(RateCollapse {
                    from: 0.05,
                    until: 0.2,
                    period: if seed % 2 == 0 { 0.033 } else { 0.002 },
                }),
                delay: ActuationDelay {
                    samples: seed % 4,
                    fraction: 0.1 * f64::from(seed % 10),
                    ..ActuationDelay::default()
                },
                seed: u64::from(seed),
            };
            let timeline = timeline(params.clone(), 57);
            let total: f64 = timeline.stretches().iter().map(|s| s.duration).sum();
            assert!((total - 0.57).abs() < 1e-12, "{total}");
            assert_eq!(timeline.grid().end(), 57.0 * 0.01);
            let mut samples = 0;
            for stretch in timeline.stretches() {
                assert!(stretch.duration >= 0.0);
                samples += usize::from(stretch.sample.is_some());
                assert!(stretch.command.is_none_or(|command| command < samples));
            }
            assert_eq!(samples, timeline.samples().len());
            // Against the schedule itself: the last command that has arrived is held.
            let ticks: Vec<_> = Schedule::new(params).unwrap().take(400).collect();
            for i in 0..1000 {
                let time = 0.57 * (f64::from(i) + 0.5) / 1000.0;
                let expected = ticks.iter().rposition(|tick| tick.hold_from <= time);
                assert_eq!(command_at(&timeline, time), expected, "{seed} at {time}");
            }
        }
    }
}

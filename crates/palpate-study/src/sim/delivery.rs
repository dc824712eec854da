//! Force on a recorded device: each command after the loop's delay, through its actuator.

use palpate_core::Actuation;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};
use palpate_testbed::device::DevicePlant;

use crate::sim::run::Held;

/// Times at which the commands of a loop begin to act.
#[derive(Clone, Debug)]
pub(crate) struct Delivery {
    /// The samples `[s]`; the last one ends the window.
    times: Vec<f64>,
    /// Start of each sample's command `[s]`, within the window.
    arrivals: Vec<f64>,
    /// Edges of the force intervals `[s]`, including the window's end.
    edges: Vec<f64>,
    actuator: Actuator,
}

/// The force on the object that acted.
pub(crate) struct Delivered {
    /// Force at each sample `[N]`.
    pub at_samples: Vec<f64>,
    /// Its mean over each interval.
    pub means: Vec<Held>,
}

impl Delivery {
    /// Creates the delivery for a loop that samples at `times` `[s]`, with a delay of whole `samples` and a `fraction`
    /// of its `period` `[s]`.
    ///
    /// # Errors
    /// A gain or a lag is out of range.
    pub fn new(
        times: &[f64],
        (samples, fraction): (usize, f64),
        period: f64,
        actuation: &Actuation<f64>,
    ) -> Result<Self, InvalidParameter> {
        let actuator = Actuator::new(ActuatorParams {
            gain: actuation.gain,
            lag: actuation.lag,
        })?;
        let end = times[times.len() - 1];
        let (arrivals, edges) = if fraction > 0.0 {
            let late = (samples as f64 + fraction) * period;
            let arrivals: Vec<f64> = times
                .iter()
                .map(|time| time + late)
                .take_while(|arrival| *arrival < end)
                .collect();
            let first = arrivals.first().copied().unwrap_or(end);
            let before = times.iter().copied().take_while(|time| *time < first);
            let edges = before
                .chain(arrivals.iter().copied())
                .chain([end])
                .collect();
            (arrivals, edges)
        } else {
            let arrivals = times.iter().skip(samples).copied();
            (arrivals.collect(), times.to_vec())
        };
        Ok(Self {
            times: times.to_vec(),
            arrivals,
            edges,
            actuator,
        })
    }

    /// Returns the edges of the force intervals `[s]`.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// Returns the time at which the command of a sample begins to act `[s]`; `None` after the window's end.
    pub fn arrival(&self, sample: usize) -> Option<f64> {
        self.arrivals.get(sample).copied()
    }

    /// Returns the delivered force for `commands` `[N]`, one for each sample.
    pub fn of(&self, commands: &[f64]) -> Delivered {
        let mut actuator = self.actuator;
        let mut at_samples = Vec::with_capacity(self.times.len());
        let mut means = Vec::with_capacity(self.edges.len() - 1);
        let (mut sample, mut arrived) = (0, 0);
        for edge in self.edges.windows(2) {
            let (from, until) = (edge[0], edge[1]);
            let (mut now, mut impulse) = (from, 0.0);
            let mean = loop {
                while self.arrivals.get(arrived).is_some_and(|at| *at <= now) {
                    arrived += 1;
                }
                let command = arrived.checked_sub(1).map_or(0.0, |last| commands[last]);
                // A sample sees what acts from it on.
                while self.times.get(sample).is_some_and(|at| *at <= now) {
                    at_samples.push(actuator.drive(&mut Recorded, command, 0.0).mean_force);
                    sample += 1;
                }
                let next = self.times.get(sample).copied().unwrap_or(until).min(until);
                let duration = next - now;
                let mean = actuator.drive(&mut Recorded, command, duration).mean_force;
                impulse += mean * duration;
                if next >= until {
                    // A single piece keeps its value to the last bit as the mean.
                    break if now > from {
                        impulse / (until - from)
                    } else {
                        mean
                    };
                }
                now = next;
            };
            means.push(Held {
                from,
                force_on_object: mean,
                slope_on_object: 0.0,
            });
        }
        // No command is held at the window's end; its sample sees the force that would act.
        while at_samples.len() < self.times.len() {
            let command = self.arrivals.len().checked_sub(1);
            let command = command.map_or(0.0, |last| commands[last]);
            at_samples.push(actuator.drive(&mut Recorded, command, 0.0).mean_force);
        }
        Delivered { at_samples, means }
    }
}

/// A device that follows the recording, independently of the force.
struct Recorded;

impl DevicePlant for Recorded {
    fn position(&self) -> f64 {
        0.0
    }

    fn velocity(&self) -> f64 {
        0.0
    }

    fn advance(&mut self, _force_on_object: f64, _duration: f64) -> f64 {
        0.0
    }

    fn stored_energy(&self) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delivery(delay: (usize, f64), actuation: Actuation<f64>) -> Delivery {
        let times: Vec<f64> = (0..=4).map(f64::from).collect();
        Delivery::new(&times, delay, 1.0, &actuation).unwrap()
    }

    fn means(delivered: &Delivered) -> Vec<(f64, f64)> {
        let means = delivered.means.iter();
        means
            .map(|held| (held.from, held.force_on_object))
            .collect()
    }

    #[test]
    fn a_command_acts_after_its_delay_and_with_its_gain() {
        let commands = [1.0, 2.0, 3.0, 4.0, 5.0];
        let whole = delivery((1, 0.0), Actuation::after(1.0).with_gain(0.5));
        let delivered = whole.of(&commands);
        assert_eq!(delivered.at_samples, [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(
            means(&delivered),
            [(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (3.0, 1.5)]
        );
        assert_eq!(
            [0, 3, 4].map(|i| whole.arrival(i)),
            [Some(1.0), Some(4.0), None]
        );

        let half = delivery((1, 0.5), Actuation::after(1.5));
        let delivered = half.of(&commands);
        assert_eq!(delivered.at_samples, [0.0, 0.0, 1.0, 2.0, 3.0]);
        let expected = [(0.0, 0.0), (1.0, 0.0), (1.5, 1.0), (2.5, 2.0), (3.5, 3.0)];
        assert_eq!(means(&delivered), expected);
        assert_eq!(half.edges(), [0.0, 1.0, 1.5, 2.5, 3.5, 4.0]);
    }

    /// 1 N at once through a lag τ: the impulse up to t is t - τ (1 - e^(-t/τ)).
    #[test]
    fn a_lag_takes_its_part_of_the_impulse() {
        let lag: f64 = 0.3;
        let lagging = delivery((0, 0.0), Actuation::default().with_lag(lag));
        let delivered = lagging.of(&[1.0; 5]);
        let impulse = |t: f64| t - lag * (1.0 - (-t / lag).exp());
        for (i, held) in delivered.means.iter().enumerate() {
            let (from, until) = (i as f64, i as f64 + 1.0);
            let expected = impulse(until) - impulse(from);
            assert!((held.force_on_object - expected).abs() < 1e-12, "{i}");
            let at = 1.0 - (-from / lag).exp();
            assert!((delivered.at_samples[i] - at).abs() < 1e-12, "{i}");
        }
    }
}

//! Record of a sampled-data loop over a window: its ticks and its held forces.

use palpate_core::Method;
use palpate_testbed::device::DevicePlant;
use palpate_testbed::profile::Snapshot;
use palpate_testbed::timeline::{Stretch, TakenSample, Timeline};

use crate::sim::plant::Plant;
use crate::sim::run::{Held, Tick};
use crate::sim::sampled_loop::{Sampled, SampledLoop};

/// Record of a loop.
pub(super) struct LoopRecord {
    /// The samples with their answers, in the user's frame.
    pub ticks: Vec<Tick>,
    /// Device and object at each sample, on the canonical side.
    pub snapshots: Vec<Snapshot>,
    /// Force of each interval of the timeline's grid, in the user's frame.
    pub held: Vec<Held>,
    /// Work through the port `[J]`.
    pub port_work: f64,
    /// Time at which the device jammed `[s]`.
    pub jammed_at: Option<f64>,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at: Option<f64>,
    /// Force that was delivered in the current interval.
    delivered: HeldSince,
    /// Current time `[s]`.
    time: f64,
}

impl LoopRecord {
    /// Runs a loop over the window of `timeline` and records it.
    pub fn of<M: Method<f64>>(
        in_progress: &mut SampledLoop<'_, M, Plant>,
        timeline: &Timeline,
    ) -> Self {
        let samples = timeline.samples();
        let grid = timeline.grid();
        let mut record = Self {
            ticks: Vec::with_capacity(samples.len()),
            snapshots: Vec::with_capacity(samples.len()),
            held: Vec::with_capacity(grid.intervals()),
            port_work: 0.0,
            jammed_at: None,
            left_box_at: None,
            delivered: HeldSince::default(),
            time: 0.0,
        };
        for stretch in timeline.stretches() {
            let answer = stretch.sample.map(|index| {
                let sampled = record.take_sample(in_progress, index, &samples[index]);
                (index, sampled)
            });
            let (sent, slope) = record.sent(in_progress, stretch, answer.as_ref());
            let force = in_progress.acting_force(sent);
            if let Some((index, sampled)) = answer {
                record.add_tick(in_progress, &samples[index], sampled, force);
            }
            if stretch.begins_hold && record.held.len() < grid.intervals() {
                record.delivered = HeldSince::default();
                record.held.push(Held {
                    from: grid.edge(record.held.len()),
                    force_on_object: force,
                    slope_on_object: in_progress.actuator.params().gain * slope,
                });
            }
            if stretch.duration > 0.0 {
                record.drive(in_progress, (sent, slope), stretch.duration);
            }
        }
        record
    }

    /// Takes the sample `index`, reports the sent force to the renderer, and returns the answer.
    fn take_sample<M: Method<f64>>(
        &mut self,
        in_progress: &mut SampledLoop<'_, M, Plant>,
        index: usize,
        sample: &TakenSample,
    ) -> Sampled {
        self.time = sample.time;
        // Nothing was measured before the first sample.
        let measured_time = (index > 0).then_some(sample.elapsed);
        let sampled = in_progress.sample(sample.elapsed, measured_time);
        let (sent, slope) = in_progress.given_line(&sampled.output);
        in_progress.report_sent_line(sent, slope);
        if self.left_box_at.is_none() && in_progress.device.has_left_box() {
            self.left_box_at = Some(self.time);
        }
        sampled
    }

    /// Returns the line that is held in `stretch`, in the user's frame: its mean over one period `[N]`, and its slope
    /// `[N/s]`. `answer` is that of the stretch's own sample.
    fn sent<M: Method<f64>>(
        &self,
        in_progress: &SampledLoop<'_, M, Plant>,
        stretch: &Stretch,
        answer: Option<&(usize, Sampled)>,
    ) -> (f64, f64) {
        let output = match (stretch.command, answer) {
            (None, _) => return (in_progress.given_force(0.0), 0.0),
            (Some(own), Some((index, sampled))) if own == *index => &sampled.output,
            (Some(earlier), _) => &self.ticks[earlier].output,
        };
        in_progress.given_line(output)
    }

    /// Adds a sample and its answer, with the `force` that acts on the object after it `[N]`, in the user's frame.
    fn add_tick<M: Method<f64>>(
        &mut self,
        in_progress: &SampledLoop<'_, M, Plant>,
        sample: &TakenSample,
        sampled: Sampled,
        force: f64,
    ) {
        let (device, sign) = (&in_progress.device, in_progress.sign);
        let Sampled { measured, output } = sampled;
        self.ticks.push(Tick {
            time: self.time,
            device_position: measured,
            true_device_position: sign * device.position(),
            output,
            held_force_on_object: force,
            command_from: sample.command_from,
            ledger: *in_progress.state.ledger(),
        });
        self.snapshots.push(Snapshot {
            time: self.time,
            device_position: device.position(),
            device_velocity: device.velocity(),
            object_position: sign * output.object_position,
            object_velocity: sign * output.object_velocity,
            force_on_object: sign * force,
        });
    }

    /// Moves the device while a line is held at the actuator's input for `duration` `[s]`: its mean over one period
    /// `[N]`, and its slope `[N/s]`.
    fn drive<M: Method<f64>>(
        &mut self,
        in_progress: &mut SampledLoop<'_, M, Plant>,
        (sent, slope): (f64, f64),
        duration: f64,
    ) {
        let driven = if slope == 0.0 {
            in_progress.drive(sent, duration)
        } else {
            // The line began with the interval of the grid.
            let period = in_progress.renderer.loop_params().period;
            let middle = self.delivered.duration + 0.5 * duration;
            let mean = sent + slope * (middle - 0.5 * period);
            in_progress.drive_line(mean, slope, duration)
        };
        self.port_work += driven.work;
        self.delivered.add(driven.mean_force, duration);
        if let (Some(held), Some(mean)) = (self.held.last_mut(), self.delivered.mean()) {
            held.force_on_object = mean;
        }
        self.time += duration;
        if self.jammed_at.is_none() && in_progress.device.is_jammed() {
            self.jammed_at = Some(self.time);
        }
    }
}

/// Delivered force since a command began to act.
#[derive(Default)]
struct HeldSince {
    first: Option<f64>,
    changed: bool,
    impulse: f64,
    duration: f64,
}

impl HeldSince {
    fn add(&mut self, force: f64, duration: f64) {
        self.changed |= self.first.is_some_and(|first| first != force);
        self.first = self.first.or(Some(force));
        self.impulse += force * duration;
        self.duration += duration;
    }

    /// The force, or where it changed its mean over time; none before anything was.
    fn mean(&self) -> Option<f64> {
        if self.changed {
            Some(self.impulse / self.duration)
        } else {
            self.first
        }
    }
}

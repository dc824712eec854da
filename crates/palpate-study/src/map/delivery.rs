//! From commands to the forces that act on the device of a bounce.

use palpate::Method;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::grid::Grid;
use palpate_testbed::hold::DelayedHold;

use super::bounce::Bounce;
use palpate_sim::sampled_loop::{LoopDevice, SampledLoop};

/// Each command after the delay of its bounce, through the motor of its bounce.
#[derive(Clone, Debug)]
pub(super) struct Delivery {
    hold: DelayedHold,
    /// Part of a period before which the force of the period before goes on.
    fraction: f64,
    /// Whether forces act as they are, from a sample to the next.
    is_plain: bool,
    /// The command that acts at the end of a period `[N]`.
    acting: f64,
    /// Impulse of the interval in progress `[N s]`.
    impulse: f64,
}

impl Delivery {
    /// The delivery of a bounce, before its first command.
    pub fn new(bounce: &Bounce) -> Result<Self, InvalidParameter> {
        Ok(Self {
            hold: DelayedHold::new(bounce.delay)?,
            fraction: bounce.delay_fraction,
            is_plain: bounce.delay_fraction == 0.0 && bounce.actuator == ActuatorParams::default(),
            acting: 0.0,
            impulse: 0.0,
        })
    }

    /// The first `periods` of a bounce, cut where a command begins to act.
    pub fn grid(bounce: &Bounce, periods: usize) -> Result<Grid, InvalidParameter> {
        let period = bounce.period;
        if bounce.delay_fraction == 0.0 {
            return Ok(Grid::even(0.0, period, periods));
        }
        let begins = (0..=periods).map(|i| (i as f64 + bounce.delay_fraction) * period);
        Grid::cut_at(std::iter::once(0.0).chain(begins).collect(), period)
    }

    /// Takes the `command` `[N]` of a sample, tells the renderer what a driver knows of it, moves the device
    /// on by a `period` `[s]`, and returns the mean force on the object `[N]` of the interval of
    /// [`grid`](Self::grid) that ends within the period, or with it.
    #[inline]
    pub fn advance<M: Method<f64>, D: LoopDevice>(
        &mut self,
        in_progress: &mut SampledLoop<'_, M, D>,
        command: f64,
        period: f64,
    ) -> f64 {
        if self.is_plain {
            let held = in_progress.given_force(self.hold.exchange(command));
            in_progress.report_held(held);
            in_progress.advance(held, period);
            return held;
        }
        let sent = in_progress.given_force(command);
        in_progress.report_sent(sent);
        let arriving = self.hold.exchange(sent);
        if self.fraction == 0.0 {
            return in_progress.drive(arriving, period).mean_force;
        }
        // The first interval is a fraction of a period without a force.
        let before = self.fraction * period;
        let of_before = in_progress.drive(self.acting, before).mean_force;
        let mean = of_before * self.fraction + self.impulse / period;
        self.acting = arriving;
        let after = period - before;
        self.impulse = after * in_progress.drive(arriving, after).mean_force;
        mean
    }
}

#[cfg(test)]
mod tests {
    use crate::map::trial::{Course, Judged, height};
    use crate::map::{Bounce, MapParams, Plant, default_settings};
    use palpate_scene::ActuatorParams;
    use palpate_scene::method::MethodName;
    use palpate_sim::closed_loop::Bench;

    /// The bench runs a scene by its own steps, along a timeline of its own.
    #[test]
    fn a_bounce_with_any_delay_lag_and_gain_is_that_of_the_bench() {
        let params = MapParams {
            cells: 5,
            ..MapParams::default()
        };
        let period = params.period;
        for (delay, delay_fraction, lag, gain) in [
            (0, 0.0, 0.0, 1.0),
            (1, 0.0, 0.0, 1.0),
            (0, 0.3, 0.0, 1.0),
            (1, 0.6, 0.0, 1.0),
            (0, 0.0, 0.1 * period, 0.8),
            (0, 0.25, 0.05 * period, 1.1),
        ] {
            let mut compared = 0;
            for (cell, phase) in [(8, 0), (8, 5), (8, 11), (14, 0), (14, 5), (14, 11)] {
                let bounce = Bounce {
                    delay,
                    delay_fraction,
                    actuator: ActuatorParams { gain, lag },
                    ..params.cell(cell).bounce.on(Plant::Undamped)
                };
                for method in [MethodName::Basic, MethodName::Coupled] {
                    let course = Course::new(&bounce, phase, Judged::Force).unwrap();
                    let settings = default_settings(method);
                    let renderer = bounce.renderer(method, settings).unwrap();
                    let outcome = course.run(&bounce, &renderer).unwrap();
                    let scene = bounce.scene(height(phase), course.periods());
                    let run = Bench::new(&scene).unwrap().run(method).unwrap();
                    // The two end their windows within the same period, and not together.
                    if run.held.last().unwrap().force_on_object.abs() > 1e-6 {
                        continue;
                    }
                    compared += 1;
                    let of_bench = run.force.fidelity.unwrap().mean_force_error;
                    let of_bounce = outcome.fidelity.mean_force_error;
                    assert!(
                        (of_bounce - of_bench).abs() < 1e-5 * (1.0 + of_bench),
                        "{delay} + {delay_fraction}, {lag} s, {gain}, {method}: {of_bounce} {of_bench}"
                    );
                }
            }
            assert!(
                compared >= 3,
                "{delay} + {delay_fraction}, {lag} s: {compared}"
            );
        }
    }
}

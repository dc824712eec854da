//! One contact along an axis of the device's frame, in the loop.

use palpate_core::{Actuation, AlongAxis, Hold, Output, ParameterError, Sample};
use palpate_device::{Line, Vector, Wrench};
use palpate_record::recording::{ContactTick, Flags};

use super::renders::{Answer, DeviceSample, DeviceSamples, Renders};
use super::{Parameters, Rendered, Rendering, parameters};
use crate::delivered::Delivered;
use crate::wire::{answered, recorded};

/// One contact along an axis of the device's frame, with its parameters and its energy ledger.
#[derive(Debug)]
pub struct OneContact {
    axis: AlongAxis<f64, 3>,
    rendered: Rendered,
    parameters: Option<Parameters>,
    delivered: Delivered,
    /// Last rendered sample: position of the device and output of the renderer.
    last: Option<(Vector, Output<f64>)>,
    /// Whether the output of the last sample has not been written yet.
    is_new: bool,
    /// End of the last line that was sent, on the object `[N]`.
    line_end: f64,
    said: ContactTick,
}

impl OneContact {
    /// Creates a contact along the first axis of the device.
    pub(crate) fn new(rendering: Rendering) -> Result<Self, ParameterError> {
        let (parameters, rendered) = parameters(rendering)?;
        Ok(Self {
            axis: AlongAxis::new([0.0; 3], [1.0, 0.0, 0.0])?,
            rendered,
            parameters: Some(parameters),
            delivered: Delivered::default(),
            last: None,
            is_new: false,
            line_end: 0.0,
            said: ContactTick::default(),
        })
    }

    /// Sets the axis of the contact.
    pub(crate) fn place_along(&mut self, axis: AlongAxis<f64, 3>) {
        self.axis = axis;
    }

    /// Returns whether the actuator model contains more than a certain delay of whole samples. The renderer then
    /// computes the acting force from the sent one and can estimate the delay; otherwise the held force is the acting
    /// one.
    fn takes_sent_forces(&self) -> bool {
        let messages = &self.rendered.rendering().loop_params;
        let actuation = &messages.actuation;
        let is_certain = actuation.delay_deviation <= 0.0 && actuation.lag_deviation <= 0.0;
        !(is_certain && actuation.is_of_whole_samples(messages.period))
    }

    /// Returns the component of a force along the contact's axis `[N]`.
    fn along_axis(&self, force: Vector) -> f64 {
        dot(force, self.axis.vector(1.0))
    }
}

impl Renders for OneContact {
    fn period(&self) -> f64 {
        self.rendered.rendering().loop_params.period
    }

    fn method(&self) -> &'static str {
        self.rendered.rendering().method()
    }

    fn parameters(&mut self) -> Option<Parameters> {
        self.parameters.take()
    }

    fn take_change(&mut self) -> Option<(u32, Rendering)> {
        let generation = self.rendered.take_change()?;
        Some((generation, *self.rendered.rendering()))
    }

    fn generation(&self) -> u32 {
        self.rendered.generation()
    }

    fn step(&mut self, sample: &DeviceSamples<'_>, asked: &mut [Line]) -> Answer {
        // A loop has at least one device.
        let DeviceSample { position, held, .. } =
            sample.devices.first().copied().unwrap_or_default();
        if let Some(mean) = held
            && !self.takes_sent_forces()
        {
            let held = -self.along_axis(mean.force);
            self.rendered.report_held(held);
        }
        let coordinate = self.axis.coordinate(position);
        let before = *self.rendered.ledger();
        let output = self.rendered.step(Sample {
            elapsed: sample.elapsed,
            ..Sample::at(coordinate)
        });
        let after = self.rendered.ledger();
        self.delivered.close(&before, after, sample.was_off);
        self.last = Some((position, output));
        self.is_new = true;
        if let Some(asked) = asked.first_mut() {
            *asked = Line {
                slope: self.axis.vector(output.slope_on_device),
                ..Wrench::of_force(self.axis.vector(output.force_on_device)).into()
            };
        }
        Answer {
            coordinate,
            fault: output.fault,
            is_crowded: false,
        }
    }

    fn report_written(&mut self, _: usize, held: Line, sent: Option<Line>) {
        let is_new = std::mem::take(&mut self.is_new);
        let holds_lines = self.actuation().hold == Hold::Line;
        // With a measured held force, the sent one gives the ledger the effect of limits.
        if !holds_lines && !is_new && !self.takes_sent_forces() {
            return;
        }
        let sent = sent.unwrap_or(held);
        let force = -self.along_axis(sent.wrench.force);
        if !holds_lines {
            self.rendered.report_sent(force);
        } else if is_new {
            let slope = -self.along_axis(sent.slope);
            self.rendered.report_sent_line(force, slope);
            self.line_end = -self.along_axis(sent.end().force);
        } else if force == 0.0 && self.line_end != 0.0 {
            // Without a new sample the force stays at the end of its line, which is part of the model, or is cut.
            self.rendered.report_sent(0.0);
            self.line_end = 0.0;
        }
    }

    fn account(&mut self, sequence: u64, delivered: Vector) {
        let ledger = self.rendered.ledger();
        let said = match &self.last {
            Some((_, output)) => answered(output, ledger),
            // No sample has been rendered yet.
            None => recorded(
                ContactTick {
                    point: [f64::NAN; 3],
                    normal: [f64::NAN; 3],
                    force: [f64::NAN; 3],
                    ..ContactTick::default()
                },
                ledger,
            ),
        };
        let position = self.last.as_ref().map(|(position, _)| *position);
        self.said = ContactTick {
            sequence,
            device_position: position.map_or(f64::NAN, |at| self.axis.coordinate(at)),
            force_on_device: self.along_axis(delivered),
            outside_work: said.outside_work + self.delivered.withheld,
            held_leak: self.delivered.leak,
            ..said
        };
    }

    fn contacts(&self) -> &[ContactTick] {
        std::slice::from_ref(&self.said)
    }

    fn flags(&self) -> Flags {
        self.said.flags
    }

    fn actuation(&self) -> Actuation<f64> {
        self.rendered.rendering().loop_params.actuation
    }

    fn slew_limit(&self) -> f64 {
        let limit = self.rendered.rendering().loop_params.slew_limit;
        limit.unwrap_or(f64::INFINITY)
    }

    fn checks_timing(&self) -> bool {
        self.rendered.rendering().checks_timing()
    }

    fn learned_lateness(&self) -> f64 {
        self.rendered.learned_lateness()
    }

    fn created_energy(&self) -> f64 {
        self.delivered.created
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

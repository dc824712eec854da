//! The device of a scene, on a real-time or simulated clock.

use std::collections::VecDeque;
use std::time::Duration;

use crate::sim::VirtualDevice;
use palpate_scene::Scene;
use palpate_testbed::InvalidParameter;
use palpate_testbed::hold::DelayedHold;

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Cut, Device, DeviceError, Line, Pose, Wrench, ZeroWriter};

/// Most forces that begin later: those of the longest delay that a scene can state.
const MAX_LATER: usize = DelayedHold::LONGEST_DELAY + 1;

/// A virtual device with its hand, moved by the time that passes on the loop's clock: between two
/// calls it moves under the force that was written last. Its one axis is the contact's.
#[derive(Clone, Debug)]
pub struct SimulatedDevice<C> {
    clock: C,
    capabilities: Capabilities,
    device: VirtualDevice,
    moved_until: Option<Duration>,
    sampled: Option<Duration>,
    /// Line on the device that the motor holds.
    held: Line,
    /// Instant at which that line began.
    begun: Duration,
    /// Lines on their way to the motor, oldest first.
    on_their_way: Vec<Line>,
    /// Time from a write to the beginning of its force, where that is not counted in writes.
    late: Duration,
    /// Lines that begin later, with the instant of each, oldest first.
    later: VecDeque<(Duration, Line)>,
    /// Line on the device that was written last.
    written: Line,
    cut: Cut,
}

impl<C: Clock> SimulatedDevice<C> {
    /// The device and the hand of `scene`. Its delay of whole samples is the device's: what is
    /// written is held after as many further writes. So are its delay in seconds, its lag and its gain;
    /// a fraction of a period and the jitter of commands are not.
    ///
    /// # Errors
    /// A quantity of the device or the hand outside its range.
    pub fn new(scene: &Scene, clock: C) -> Result<Self, InvalidParameter> {
        let linkage = scene.device.pantograph().is_some();
        let name = if linkage {
            "simulated linkage"
        } else {
            "simulated"
        };
        Ok(Self {
            clock,
            capabilities: Capabilities {
                largest_force: scene.device.largest_force(),
                effective_mass: Some(scene.device.mass()),
                encoder_quantum: (!linkage).then_some(scene.device.encoder_quantum()),
                // The motors of a linkage hold torques, and a lag delivers no line.
                holds_lines: !linkage && scene.actuator.lag == 0.0,
                ..Capabilities::unknown(name, 1)
            },
            device: VirtualDevice::new(scene)?,
            moved_until: None,
            sampled: None,
            held: Line::NONE,
            begun: Duration::ZERO,
            on_their_way: vec![Line::NONE; scene.delay.whole_samples()],
            late: Duration::try_from_secs_f64(scene.delay.seconds()).unwrap_or_default(),
            later: VecDeque::with_capacity(MAX_LATER),
            written: Line::NONE,
            cut: Cut::none(),
        })
    }

    /// The virtual device, moved up to the last call.
    #[must_use]
    pub fn device(&self) -> &VirtualDevice {
        &self.device
    }

    /// Moves on to now, and returns that.
    fn move_on(&mut self) -> Duration {
        let now = self.clock.now();
        let mut from = *self.moved_until.get_or_insert(now);
        if let Some(cut) = self.cut.between(from, now) {
            self.hold(from, cut);
            self.held = Line::NONE;
            self.on_their_way.fill(Line::NONE);
            self.later.clear();
            from = cut;
        }
        if now > from {
            self.hold(from, now);
        }
        self.moved_until = Some(now);
        now
    }

    /// Moves under what is held, and under what begins on the way.
    fn hold(&mut self, mut from: Duration, until: Duration) {
        while let Some(&(begins, line)) = self.later.front()
            && begins <= until
        {
            if begins > from {
                self.drive(from, begins);
                from = begins;
            }
            (self.held, self.begun) = (line, begins);
            self.later.pop_front();
        }
        self.drive(from, until);
    }

    /// Moves under the line that the motor holds: to its end, then under its last value.
    fn drive(&mut self, mut from: Duration, until: Duration) {
        let line = self.given(self.held);
        let over = self.begun.saturating_add(line.duration);
        if !line.is_constant() && from < over {
            let ends = until.min(over);
            let middle = ((from + ends) / 2).saturating_sub(self.begun);
            let ([mean, ..], [slope, ..]) = (line.at(middle).force, line.slope);
            self.device
                .hold_line(mean, slope, (ends - from).as_secs_f64());
            from = ends;
            if from == until {
                return;
            }
        }
        let rest = if self.held.is_constant() {
            self.held
        } else {
            line
        };
        let [force, ..] = rest.end().force;
        self.device.hold(force, (until - from).as_secs_f64());
    }

    /// Commands a line, and returns what the motor holds.
    fn command(&mut self, line: Line) -> Line {
        let now = self.move_on();
        self.cut.is_over();
        self.written = line;
        if self.late > Duration::ZERO {
            if self.later.len() == MAX_LATER {
                self.later.pop_front();
            }
            self.later.push_back((now + self.late, line));
            return self.given(self.held);
        }
        (self.held, self.begun) = (line, now);
        if let Some(oldest) = self.on_their_way.first().copied() {
            self.on_their_way.rotate_left(1);
            if let Some(newest) = self.on_their_way.last_mut() {
                *newest = line;
            }
            self.held = oldest;
        }
        self.given(self.held)
    }

    /// Returns what the motor gives of a line.
    fn given(&self, line: Line) -> Line {
        let ([force, ..], [slope, ..]) = (line.wrench.force, line.slope);
        let (force, slope) = self
            .device
            .given_line(force, slope, line.duration.as_secs_f64());
        Line {
            wrench: Wrench::of_force([force, 0.0, 0.0]),
            slope: [slope, 0.0, 0.0],
            duration: line.duration,
        }
    }
}

impl<C: Clock> Device for SimulatedDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let time = self.move_on();
        let elapsed = self.sampled.map_or(Duration::ZERO, |last| time - last);
        self.sampled = Some(time);
        Ok(Pose {
            orientation: None,
            position: [self.device.sample(elapsed.as_secs_f64()), 0.0, 0.0],
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        Ok(self.command(wrench.into()).wrench)
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        Ok(self.command(line))
    }

    fn last_sent(&self) -> Option<Line> {
        Some(self.given(self.written))
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        Some(self.cut.writer(&self.clock))
    }
}

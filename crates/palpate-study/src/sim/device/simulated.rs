//! The device of a scene, on a real-time or simulated clock.

use std::collections::VecDeque;
use std::time::Duration;

use crate::sim::VirtualDevice;
use palpate_scene::Scene;
use palpate_testbed::InvalidParameter;
use palpate_testbed::hold::DelayedHold;

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Cut, Device, DeviceError, Pose, Wrench, ZeroWriter};

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
    /// Force on the device that the motor holds `[N]`.
    held: f64,
    /// Forces on their way to the motor, oldest first.
    on_their_way: Vec<f64>,
    /// Time from a write to the beginning of its force, where that is not counted in writes.
    late: Duration,
    /// Forces that begin later, with the instant of each, oldest first.
    later: VecDeque<(Duration, f64)>,
    /// Force on the device that was written last `[N]`.
    written: f64,
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
                ..Capabilities::unknown(name, 1)
            },
            device: VirtualDevice::new(scene)?,
            moved_until: None,
            sampled: None,
            held: 0.0,
            on_their_way: vec![0.0; scene.delay.whole_samples()],
            late: Duration::try_from_secs_f64(scene.delay.seconds()).unwrap_or_default(),
            later: VecDeque::with_capacity(MAX_LATER),
            written: 0.0,
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
            self.held = 0.0;
            self.on_their_way.fill(0.0);
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
        while let Some(&(begins, force)) = self.later.front()
            && begins <= until
        {
            let before = begins.saturating_sub(from).as_secs_f64();
            if before > 0.0 {
                self.device.hold(self.held, before);
                from = begins;
            }
            self.held = force;
            self.later.pop_front();
        }
        self.device.hold(self.held, (until - from).as_secs_f64());
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
        let now = self.move_on();
        self.cut.is_over();
        let [force, ..] = wrench.force;
        self.written = force;
        if self.late > Duration::ZERO {
            if self.later.len() == MAX_LATER {
                self.later.pop_front();
            }
            self.later.push_back((now + self.late, force));
            return Ok([self.device.given_force(self.held), 0.0, 0.0].into());
        }
        self.held = force;
        if let Some(oldest) = self.on_their_way.first().copied() {
            self.on_their_way.rotate_left(1);
            if let Some(newest) = self.on_their_way.last_mut() {
                *newest = force;
            }
            self.held = oldest;
        }
        Ok([self.device.given_force(self.held), 0.0, 0.0].into())
    }

    fn last_sent(&self) -> Option<Wrench> {
        Some([self.device.given_force(self.written), 0.0, 0.0].into())
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        Some(self.cut.writer(&self.clock))
    }
}

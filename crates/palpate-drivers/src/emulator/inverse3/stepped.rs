//! Emulated Inverse3 as a device in simulated time, without sockets or threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{
    Capabilities, Device as LoopDevice, DeviceError, DeviceErrorKind, Pose, Vector, Wrench,
};
use palpate_testbed::InvalidParameter;

use super::device::{Body, EmulatedDevice};
use super::fault::{Latency, SplitMix64};

/// Emulated Inverse3 as a device on a [`SteppedClock`]: runs are reproducible, independent of the load of the machine.
///
/// The device and the latency are those of the [`Emulator`](super::Emulator). This type replaces driver and service,
/// and exchanges messages with the driver's [`Pace`](crate::inverse3::Pace): a written force is sent at once,
/// or as soon as the previous message is answered, and is repeated after `exchange_every`. Half of the latency passes
/// before the service receives a message and samples the position, the other half afterwards.
#[derive(Debug)]
pub struct SteppedInverse3 {
    clock: SteppedClock,
    capabilities: Capabilities,
    device: EmulatedDevice,
    /// Instant of the clock's origin.
    origin: Instant,
    latency: Latency,
    random: SplitMix64,
    exchange_every: Duration,
    /// Time of the last message, and of its answer.
    sent: Duration,
    answered: Duration,
    /// Pending answer, with its arrival time.
    owed: Option<(Duration, Seen)>,
    /// Written force that is not yet sent, with the time of the sample before it.
    order: Option<(Vector, Duration)>,
    force: Vector,
    /// Last answer that is not yet read, with its arrival time.
    arrived: Option<(Duration, Seen)>,
    /// Sampling time of the last read position.
    seen: Duration,
    delays: Delays,
}

/// Sampled position with its time.
#[derive(Clone, Copy, Debug)]
struct Seen {
    at: Duration,
    position: Vector,
}

/// Delays from the sampling of a position to the force computed from it.
#[derive(Clone, Debug, Default)]
pub struct Delays {
    /// Sum `[ns]`.
    sum: Arc<AtomicU64>,
    count: Arc<AtomicU64>,
}

impl Delays {
    fn add(&self, delay: Duration) {
        let delay = u64::try_from(delay.as_nanos()).unwrap_or(u64::MAX);
        self.sum.fetch_add(delay, Ordering::Relaxed);
        self.count.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns the mean; `None` before the first force.
    #[must_use]
    pub fn mean(&self) -> Option<Duration> {
        let sum = self.sum.load(Ordering::Relaxed);
        let mean = sum.checked_div(self.count.load(Ordering::Relaxed))?;
        Some(Duration::from_nanos(mean))
    }
}

impl SteppedInverse3 {
    /// Creates a device with parameters `body` behind a service with this latency.
    ///
    /// # Errors
    /// A parameter of the body is out of range.
    pub fn new(
        body: &Body,
        latency: Latency,
        exchange_every: Duration,
        clock: SteppedClock,
    ) -> Result<Self, InvalidParameter> {
        let start = clock.now();
        Ok(Self {
            sent: start,
            answered: start,
            clock,
            capabilities: Capabilities::unknown("Haply Inverse3, in simulated time", 3),
            device: EmulatedDevice::new("stepped".to_owned(), body, Duration::from_secs(1))?,
            origin: Instant::now(),
            latency,
            random: SplitMix64(1),
            exchange_every,
            owed: None,
            order: Some(([0.0; 3], start)),
            force: [0.0; 3],
            arrived: None,
            seen: start,
            delays: Delays::default(),
        })
    }

    /// Returns the delays; the returned value is updated further.
    #[must_use]
    pub fn delays(&self) -> Delays {
        self.delays.clone()
    }

    /// Exchanges messages up to now.
    fn exchange(&mut self) {
        let now = self.clock.now();
        loop {
            if let Some((at, seen)) = self.owed {
                if at > now {
                    return;
                }
                self.owed = None;
                self.answered = at;
                self.arrived = Some((at, seen));
                // A waiting order is sent when the answer arrives.
                if self.order.is_some() {
                    self.send(at);
                }
            } else if self.order.is_some() {
                self.send(now);
            } else {
                let due = self.answered.max(self.sent + self.exchange_every);
                if due > now {
                    return;
                }
                self.send(due);
            }
        }
    }

    /// Sends the last order at `time`, or repeats the force.
    fn send(&mut self, time: Duration) {
        let takes = self.latency.draw(&mut self.random);
        self.sent = time;
        let taken = time + takes / 2;
        if let Some((force, seen)) = self.order.take() {
            self.force = force;
            self.delays.add(taken.saturating_sub(seen));
        }
        self.device.command(self.force, self.origin + taken);
        let seen = Seen {
            at: taken,
            position: self.device.position(),
        };
        self.owed = Some((time + takes, seen));
    }
}

impl LoopDevice for SteppedInverse3 {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.exchange();
        let nothing = DeviceError::new(DeviceErrorKind::NothingNew, "no new answer");
        let (time, seen) = self.arrived.take().ok_or(nothing)?;
        self.seen = seen.at;
        Ok(Pose {
            orientation: None,
            position: seen.position,
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.order = Some((wrench.force, self.seen));
        self.exchange();
        Ok(wrench)
    }
}

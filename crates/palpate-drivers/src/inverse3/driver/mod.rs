//! Driver of the Inverse3.

mod address;
mod events;
mod link;
mod open;
mod reader;
mod writer;

use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::thread::{JoinHandle, Thread};
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench, ZeroWriter,
};
use triple_buffer::{Input, Output};

use super::command::Form;

pub use address::ConnectError;
pub use link::Counts;
use link::{Arrival, Link, Order};
pub use open::{Found, OpenError, devices};

/// Default address of the service.
pub const SERVICE: &str = "ws://localhost:10001";

/// Largest commanded force `[N]`.
pub const LARGEST_FORCE: f64 = 10.0;

/// Choice of the device, and communication settings.
#[derive(Clone, Debug)]
pub struct Inverse3Options {
    /// Address of the service's simulation channel: `ws://HOST:PORT`.
    pub service: String,
    /// Address of the events channel, usually on port 10020; `None`: not used. It reports earlier and in more detail
    /// why a device is gone.
    pub events: Option<String>,
    /// Name of the device; `None`: the only one present.
    pub device_id: Option<String>,
    /// Version of the interface; `None`: detected from the first frame.
    pub form: Option<Form>,
    /// Timing of messages.
    pub pace: Pace,
    /// SCHED_FIFO priority of the two threads that communicate with the service, 1 to 99; `None`: normal scheduling.
    /// Choose it below the loop's priority: the loop does not wait for these threads.
    pub priority: Option<u8>,
    /// Time limit for the service's first frame, and for the device to become ready.
    pub patience: Duration,
}

impl Default for Inverse3Options {
    fn default() -> Self {
        Self {
            service: SERVICE.to_owned(),
            events: None,
            device_id: None,
            form: None,
            pace: Pace::default(),
            priority: None,
            patience: Duration::from_secs(1),
        }
    }
}

/// Timing of messages. A written force is sent at once, or as soon as the previous message is answered. Zero force is
/// always sent at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Time after which a message is repeated without a new force. It bounds the age of a sample, and keeps the service
    /// from idling under a slow loop.
    pub exchange_every: Duration,
    /// Time limit for an answer, or three times the median round trip if that is longer. A later answer is not used as
    /// a sample; the service counts as stalled and is commanded zero force.
    pub reply_timeout: Duration,
    /// Duration of a stall after which the device counts as gone.
    pub give_up_after: Duration,
    /// Time for which a written force is held without another write. It must exceed the loop period;
    /// [`for_period`](Self::for_period) ensures that.
    pub hold: Duration,
}

impl Default for Pace {
    /// Half a period of 1 kHz, 10 ms, 1 s, and 0.1 s.
    fn default() -> Self {
        Self {
            exchange_every: Duration::from_micros(500),
            reply_timeout: Duration::from_millis(10),
            give_up_after: Duration::from_secs(1),
            hold: Duration::from_millis(100),
        }
    }
}

impl Pace {
    /// Returns the default timing for a loop of this period; a force is held for at least three periods.
    #[must_use]
    pub fn for_period(period: Duration) -> Self {
        let usual = Self::default();
        Self {
            hold: usual.hold.max(period.saturating_mul(3)),
            ..usual
        }
    }
}

/// A Haply Inverse3 behind its service.
///
/// JSON and WebSocket allocate and block, so two threads of the driver use them. `read` and `write` transfer a sample
/// or a force without waiting, locking or allocating. The time of a sample is the arrival of its frame on the loop's
/// clock, because the service sends no time. A force above 10 N is reduced to 10 N in the same direction.
///
/// **Rates.** A loop faster than the exchange sometimes finds no new sample. One such period has no effect; of two in a
/// row the second is without a force. The period should be at least the [round trip](Self::round_trip); half of it is
/// too short. With a slower loop the exchange continues by itself ([`Pace::exchange_every`]), and `read` returns the
/// latest sample.
///
/// **Zero.** When this is dropped, the last message commands zero force. If the loop stalls, its supervisor's zero
/// writer makes the next message command zero force; without a supervisor [`Pace::hold`] does. If the service stalls,
/// the force is zero from then on. If this program is killed, the service idles the device some time after the last
/// message: it does not latch a force.
#[derive(Debug)]
pub struct Inverse3<C> {
    clock: C,
    capabilities: Capabilities,
    device_id: String,
    form: Form,
    round_trip: Duration,
    opened_at: Vector,
    link: Arc<Link>,
    orders: Input<Order>,
    samples: Output<Arrival>,
    ordered: u64,
    seen: u64,
    writer: Thread,
    threads: Vec<JoinHandle<()>>,
    /// Connection of the events thread.
    events: Option<TcpStream>,
}

/// Access to the connection's state during and after a loop.
#[derive(Clone, Debug)]
pub struct Inspector(Arc<Link>);

impl Inspector {
    /// Returns the counters of the connection.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.0.counted()
    }

    /// Returns the reason why the device is gone, if it is.
    #[must_use]
    pub fn lost(&self) -> Option<&'static str> {
        let error = self.0.error()?;
        (error.kind == DeviceErrorKind::Disconnected).then_some(error.what)
    }
}

impl<C> Inverse3<C> {
    /// Returns the name that addresses the device in commands.
    #[must_use]
    pub fn device_id(&self) -> &str {
        &self.device_id
    }

    /// Returns the version of the interface.
    #[must_use]
    pub fn form(&self) -> Form {
        self.form
    }

    /// Returns the position of the cursor at opening `[m]`.
    #[must_use]
    pub fn opened_at(&self) -> Vector {
        self.opened_at
    }

    /// Returns the median round trip measured at opening.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Returns an inspector of the connection, for use elsewhere.
    #[must_use]
    pub fn inspector(&self) -> Inspector {
        Inspector(Arc::clone(&self.link))
    }
}

/// Returns the capabilities of an Inverse3: force, stiffness and damping from Haply's CHAI3D driver. The workspace of
/// 0.15 m about its centre is not included, because the centre in the service's frame depends on the service's mount.
fn capabilities() -> Capabilities {
    Capabilities {
        largest_force: Some(LARGEST_FORCE),
        largest_stiffness: Some(1000.0),
        largest_damping: Some(6.0),
        ..Capabilities::unknown("Haply Inverse3", 3)
    }
}

impl<C: Clock> Device for Inverse3<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if let Some(error) = self.link.tell() {
            return Err(error);
        }
        let arrival = *self.samples.read();
        if arrival.number == self.seen {
            return Err(DeviceError::new(
                DeviceErrorKind::NothingNew,
                "no new answer from the Inverse Service",
            ));
        }
        self.seen = arrival.number;
        Ok(Pose {
            orientation: None,
            position: arrival.position,
            time: arrival.time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let force = bounded(wrench.force);
        let given = force.unwrap_or_default();
        self.ordered += 1;
        self.orders.write(Order {
            number: self.ordered,
            force: given,
            at: self.clock.now(),
        });
        // After writing the order: until then the cut holds.
        self.link.uncut();
        self.writer.unpark();
        let not_finite = DeviceError::new(DeviceErrorKind::Refused, "the force is not finite");
        match self.link.error() {
            // The device already receives zero force, so a zero order is accepted.
            Some(error) if error.kind != DeviceErrorKind::Refused || given != [0.0; 3] => {
                Err(error)
            }
            _ => force.map(Wrench::of_force).ok_or(not_finite),
        }
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Cut {
            link: Arc<Link>,
            writer: Thread,
        }
        impl ZeroWriter for Cut {
            fn write_zero(&mut self) {
                self.link.cut();
                self.writer.unpark();
            }
        }
        Some(Box::new(Cut {
            link: Arc::clone(&self.link),
            writer: self.writer.clone(),
        }))
    }
}

/// Limits the force to the largest length; returns `None` if it is not finite.
fn bounded(force: Vector) -> Option<Vector> {
    let largest = force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    if !force.iter().all(|f| f.is_finite()) {
        return None;
    }
    if largest == 0.0 {
        return Some(force);
    }
    // Scale first: the square of a large number overflows.
    let square: f64 = force.iter().map(|f| (f / largest).powi(2)).sum();
    let length = largest * square.sqrt();
    let part = (LARGEST_FORCE / length).min(1.0);
    Some(force.map(|f| f * part))
}

/// Returns whether the error is only a timeout of the socket.
fn is_a_pause(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

impl<C> Drop for Inverse3<C> {
    fn drop(&mut self) {
        self.link.end();
        self.writer.unpark();
        if let Some(events) = &self.events {
            let _ = events.shutdown(Shutdown::Both);
        }
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_loops_force_is_held_for_longer_than_its_period() {
        let held = |ms| Pace::for_period(Duration::from_millis(ms)).hold.as_millis();
        assert_eq!([1, 33, 40, 500].map(held), [100, 100, 120, 1500]);
    }

    #[test]
    fn a_force_is_shortened_in_its_direction() {
        assert_eq!(bounded([3.0, -4.0, 0.0]), Some([3.0, -4.0, 0.0]));
        let [x, y, z] = bounded([0.0, -30.0, 40.0]).unwrap();
        assert!(x == 0.0 && (y + 6.0).abs() < 1e-12 && (z - 8.0).abs() < 1e-12);
        let [x, y, z] = bounded([1e308, 1e308, 0.0]).unwrap();
        assert!((x.hypot(y) - 10.0).abs() < 1e-9 && z == 0.0);
        assert_eq!(bounded([0.0, f64::NAN, 0.0]), None);
        assert_eq!(bounded([f64::INFINITY, 0.0, 0.0]), None);
        assert_eq!(bounded([0.0; 3]), Some([0.0; 3]));
    }
}

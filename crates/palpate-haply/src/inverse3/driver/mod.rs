//! The driver: an Inverse3 as a device of a loop.

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

/// Where the service answers if nothing else is said.
pub const SERVICE: &str = "ws://localhost:10001";

/// Largest force that is commanded `[N]`.
pub const LARGEST_FORCE: f64 = 10.0;

/// Which device, and how it is talked to.
#[derive(Clone, Debug)]
pub struct Inverse3Options {
    /// Where the service's simulation channel is: `ws://HOST:PORT`.
    pub service: String,
    /// Where its events channel is, usually on port 10020; `None`: not listened to. It tells sooner,
    /// and in more words, why a device is gone.
    pub events: Option<String>,
    /// The device's name; `None`: the only one there is.
    pub device_id: Option<String>,
    /// The form of the interface; `None`: what the first frame looks like.
    pub form: Option<Form>,
    /// When to send what.
    pub pace: Pace,
    /// Priority under SCHED_FIFO of the two threads that talk to the service, 1 to 99; `None`: with
    /// everybody else. Below the loop's: it does not wait for them.
    pub priority: Option<u8>,
    /// How long to wait for the service's first frame, and for the device to be ready.
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

/// When to send what. A written force goes out at once, or as soon as the answer to the message
/// before has come; no force goes out at once in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// How long after a message the next one goes out though nothing new was written: how old a
    /// sample may become, and what keeps the service from idling under a slow loop.
    pub exchange_every: Duration,
    /// How long an answer may take, or three times the median round trip if that is longer. What
    /// comes later is no sample, and the service counts as standing still: it is commanded no force.
    pub reply_timeout: Duration,
    /// How long the service may stand still before the device counts as gone.
    pub give_up_after: Duration,
    /// How long a written force is held though nothing was written since. Longer than any period:
    /// [`for_period`](Self::for_period) sees to that.
    pub hold: Duration,
}

impl Default for Pace {
    /// Twice a period of 1 kHz, 10 ms, 1 s, and 0.1 s.
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
    /// For a loop of this period: the usual one, but a force is held for three periods at least.
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
/// JSON and WebSocket allocate and wait, so two threads of the driver do that. `read` and `write`
/// hand over a sample or a force, and neither waits, locks or allocates. A sample's time is when its
/// frame came, on the loop's clock: the service sends none. What is asked for beyond 10 N is
/// shortened to 10 N, in the same direction.
///
/// **Rates.** A loop faster than the exchange finds nothing new now and then: one such period in a
/// row costs nothing, of two the second is without a force. So the period should be no less than the
/// [round trip](Self::round_trip), and half of it is too little. In a slower loop the exchange goes
/// on by itself ([`Pace::exchange_every`]), and `read` returns what came last.
///
/// **Zero.** When this is dropped, a message without a force is the last one. When the loop stands
/// still, its supervisor's zero writer has the next message carry none, and without a supervisor
/// [`Pace::hold`] does. When the service stands still, none is the force from then on. When this
/// program is killed, the service idles the device some time after the last message: it does not
/// latch a force.
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
    /// The events' connection, which its thread waits on.
    events: Option<TcpStream>,
}

/// What to look at while, or after, a loop has the device.
#[derive(Clone, Debug)]
pub struct Inspector(Arc<Link>);

impl Inspector {
    /// What went over the connection so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.0.counted()
    }

    /// Why the device is gone, if it is.
    #[must_use]
    pub fn lost(&self) -> Option<&'static str> {
        let error = self.0.error()?;
        (error.kind == DeviceErrorKind::Disconnected).then_some(error.what)
    }
}

impl<C> Inverse3<C> {
    /// The name by which commands address it.
    #[must_use]
    pub fn device_id(&self) -> &str {
        &self.device_id
    }

    /// The form of the interface that is spoken.
    #[must_use]
    pub fn form(&self) -> Form {
        self.form
    }

    /// Where the cursor was when it was opened `[m]`.
    #[must_use]
    pub fn opened_at(&self) -> Vector {
        self.opened_at
    }

    /// How long an exchange took at the median, when it was opened.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Something to look at its connection with from elsewhere.
    #[must_use]
    pub fn inspector(&self) -> Inspector {
        Inspector(Arc::clone(&self.link))
    }
}

/// What an Inverse3 can do: force, stiffness and damping as the author of Haply's CHAI3D driver has
/// them. Its workspace of 0.15 m about its middle is not here: where the middle is in the service's
/// frame depends on the service's mount.
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
                "no answer of the Inverse Service since the last one",
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
        // After the order is there: until then the cut holds.
        self.link.uncut();
        self.writer.unpark();
        let not_finite = DeviceError::new(DeviceErrorKind::Refused, "the force is not finite");
        match self.link.error() {
            // No force is what it is given then, and so it is taken.
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

/// A force no longer than the largest; what is not finite is none.
fn bounded(force: Vector) -> Option<Vector> {
    let largest = force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    if !force.iter().all(|f| f.is_finite()) {
        return None;
    }
    if largest == 0.0 {
        return Some(force);
    }
    // Scaled first: the square of a large number is infinite.
    let square: f64 = force.iter().map(|f| (f / largest).powi(2)).sum();
    let length = largest * square.sqrt();
    let part = (LARGEST_FORCE / length).min(1.0);
    Some(force.map(|f| f * part))
}

/// Nothing came within the socket's time, which says nothing.
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

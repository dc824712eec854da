//! A wrapper that reconnects a lost device.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_device::{
    Capabilities, Connection, Device, DeviceError, DeviceErrorKind, Line, Pose, Wrench, ZeroWriter,
};

/// Interval between attempts to reopen the device.
const EVERY: Duration = Duration::from_millis(250);

/// Maximum time to wait in `drop` until a lost device is closed. It exceeds the time for which any driver retries its
/// zero-torque command.
const CLOSES_WITHIN: Duration = Duration::from_secs(10);

/// Reopens a device, or returns the reason why it cannot. It may block.
pub type Reopen = Box<dyn FnMut() -> Result<Box<dyn Device>, String> + Send>;

/// A device that is reopened after it was lost. Another thread reopens it; meanwhile, reads return no sample. The
/// loop recovers as from any other safety stop, with a soft start.
pub struct Reconnecting {
    device: Option<Box<dyn Device>>,
    /// Statistics of the last connection that was lost.
    before: Option<Connection>,
    capabilities: Capabilities,
    gone: SyncSender<(Box<dyn Device>, DeviceError)>,
    /// Signals that a lost device has been closed. It is awaited from the loss until a new device is open.
    closed: Receiver<()>,
    closing: bool,
    back: Receiver<Box<dyn Device>>,
    zero: Shared,
    /// Whether the device has a zero writer while it is connected.
    has_zero: bool,
    leaving: Arc<AtomicBool>,
}

/// Zero writer of the connected device; `None` while it is lost. The loop never takes the lock, and the supervisor
/// never waits for it.
type Shared = Arc<Mutex<Option<Box<dyn ZeroWriter>>>>;

/// Replaces the zero writer and closes the previous one.
fn put(zero: &Shared, writer: Option<Box<dyn ZeroWriter>>) {
    let mut place = zero.lock().unwrap_or_else(PoisonError::into_inner);
    let before = std::mem::replace(&mut *place, writer);
    // The previous writer may be the last owner of a port, and closing may block: release the lock first.
    drop(place);
    drop(before);
}

impl Reconnecting {
    /// Wraps an open device; `reopen` opens it again after a loss. `tell` is called on another thread: when the
    /// device is lost, when it is back, and with each new reason why it cannot be reopened.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn new(
        mut device: Box<dyn Device>,
        mut reopen: Reopen,
        tell: impl Fn(&str) + Send + 'static,
    ) -> io::Result<Self> {
        let (gone, lost) = sync_channel::<(Box<dyn Device>, DeviceError)>(1);
        let (returns, back) = sync_channel(1);
        let (closes, closed) = sync_channel(1);
        let writer = device.zero_writer();
        let has_zero = writer.is_some();
        let zero: Shared = Arc::new(Mutex::new(writer));
        let leaving = Arc::new(AtomicBool::new(false));
        let (theirs, left) = (Arc::clone(&zero), Arc::clone(&leaving));
        Builder::new()
            .name("palpate reopen".to_owned())
            .spawn(move || {
                while let Ok((device, error)) = lost.recv() {
                    // The writer shares the port with the device. A port that is still open reappears under another
                    // name, or not at all.
                    put(&theirs, None);
                    // Closing may wait for a board that does not respond.
                    drop(device);
                    // The channel has capacity: the previous signal was received.
                    let _ = closes.try_send(());
                    tell(&format!("the device is gone: {error}; waiting for it"));
                    let mut said = String::new();
                    let opened = loop {
                        if left.load(Ordering::Acquire) {
                            return;
                        }
                        std::thread::sleep(EVERY);
                        match reopen() {
                            Ok(device) => break device,
                            Err(why) if why != said => {
                                tell(&why);
                                said = why;
                            }
                            Err(_) => {}
                        }
                    };
                    let mut opened = opened;
                    put(&theirs, opened.zero_writer());
                    tell("the device is back");
                    if returns.send(opened).is_err() {
                        return;
                    }
                }
            })?;
        Ok(Self {
            capabilities: device.capabilities().clone(),
            device: Some(device),
            before: None,
            gone,
            closed,
            closing: false,
            back,
            zero,
            has_zero,
            leaving,
        })
    }

    /// Passes a lost device to the thread that reopens it.
    fn lose(&mut self, error: DeviceError) {
        if let Some(device) = self.device.take() {
            self.before = device.connection().or(self.before);
            // The channel has capacity for the only device.
            self.closing = self.gone.try_send((device, error)).is_ok();
        }
    }
}

impl Reconnecting {
    /// Commands the device, if it is there.
    fn command<W: Default>(
        &mut self,
        write: impl FnOnce(&mut Box<dyn Device>) -> Result<W, DeviceError>,
    ) -> Result<W, DeviceError> {
        let Some(device) = &mut self.device else {
            return Ok(W::default());
        };
        match write(device) {
            Err(error) if error.kind == DeviceErrorKind::Disconnected => {
                self.lose(error);
                Ok(W::default())
            }
            written => written,
        }
    }
}

impl Device for Reconnecting {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.device.is_none()
            && let Ok(device) = self.back.try_recv()
        {
            self.device = Some(device);
            // The lost device was closed before this one was opened; its signal is in the channel.
            self.closing = self.closed.try_recv().is_err();
        }
        let Some(device) = &mut self.device else {
            return Err(DeviceError::new(
                DeviceErrorKind::NothingNew,
                "the device is gone; waiting for it",
            ));
        };
        device.read().map_err(|error| {
            if error.kind != DeviceErrorKind::Disconnected {
                return error;
            }
            self.lose(error);
            DeviceError::new(DeviceErrorKind::NothingNew, error.what)
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.command(|device| device.write(wrench))
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        self.command(|device| device.write_line(line))
    }

    fn last_sent(&self) -> Option<Line> {
        self.device.as_ref()?.last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Shared);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                // The reopening thread holds the lock only while the device is lost or newly opened, before any force
                // is written.
                if let Ok(mut zero) = self.0.try_lock()
                    && let Some(zero) = zero.as_mut()
                {
                    zero.write_zero();
                }
            }
        }
        // Also while the device is lost: a loop that starts meanwhile needs its supervisor later.
        self.has_zero
            .then(|| Box::new(Zero(Arc::clone(&self.zero))) as Box<dyn ZeroWriter>)
    }

    fn was_cut(&mut self) -> bool {
        self.device.as_mut().is_some_and(Device::was_cut)
    }

    fn connection(&self) -> Option<Connection> {
        let device = self.device.as_ref();
        device.map_or(self.before, |device| device.connection())
    }
}

impl Drop for Reconnecting {
    fn drop(&mut self) {
        self.leaving.store(true, Ordering::Release);
        if self.closing {
            // The program may end next. Wait for the driver's zero-torque retries, as in a program without
            // reconnection.
            let _ = self.closed.recv_timeout(CLOSES_WITHIN);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lost device whose closing takes time.
    struct Slow {
        capabilities: Capabilities,
        closed: Arc<AtomicBool>,
    }

    impl Device for Slow {
        fn capabilities(&self) -> &Capabilities {
            &self.capabilities
        }

        fn read(&mut self) -> Result<Pose, DeviceError> {
            let kind = DeviceErrorKind::Disconnected;
            Err(DeviceError::new(kind, "the board does not answer"))
        }

        fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
            Ok(wrench)
        }

        fn connection(&self) -> Option<Connection> {
            Some(Connection {
                lost: 7,
                ..Connection::default()
            })
        }
    }

    impl Drop for Slow {
        fn drop(&mut self) {
            std::thread::sleep(Duration::from_millis(300));
            self.closed.store(true, Ordering::Release);
        }
    }

    fn slow(closed: &Arc<AtomicBool>) -> Box<dyn Device> {
        Box::new(Slow {
            capabilities: Capabilities::unknown("slow", 1),
            closed: Arc::clone(closed),
        })
    }

    #[test]
    fn a_program_does_not_end_before_a_device_that_is_gone_is_closed() {
        let closed = Arc::default();
        let never: Reopen = Box::new(|| Err("not there".to_owned()));
        let mut device = Reconnecting::new(slow(&closed), never, |_| {}).unwrap();
        let error = device.read().unwrap_err();
        assert_eq!(error.kind, DeviceErrorKind::NothingNew);
        // The report contains the lost connection.
        assert_eq!(device.connection().unwrap().lost, 7);
        drop(device);
        assert!(closed.load(Ordering::Acquire));
    }

    #[test]
    fn so_it_is_of_the_second_time() {
        let (first, second) = (Arc::default(), Arc::default());
        let again = Arc::clone(&second);
        let back: Reopen = Box::new(move || Ok(slow(&again)));
        let mut device = Reconnecting::new(slow(&first), back, |_| {}).unwrap();
        // The first device is lost, the second is opened and lost as well.
        let mut lost = 0;
        while lost < 2 {
            lost += usize::from(device.read().unwrap_err().what == "the board does not answer");
            std::thread::sleep(Duration::from_millis(1));
        }
        drop(device);
        assert!(first.load(Ordering::Acquire) && second.load(Ordering::Acquire));
    }
}

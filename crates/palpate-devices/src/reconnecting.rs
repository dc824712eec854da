//! A device that is waited for when it has gone.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};

/// How often it is tried to open it anew.
const EVERY: Duration = Duration::from_millis(250);

/// How long it is waited at the end until a device that is gone has been closed: longer than any
/// board is tried to be told that it holds no torque.
const CLOSES_WITHIN: Duration = Duration::from_secs(10);

/// Opens a device anew, or says why it cannot. It may wait.
pub type Reopen = Box<dyn FnMut() -> Result<Box<dyn Device>, String> + Send>;

/// A device in whose place nothing answers while it is gone. It is opened anew by another thread,
/// and the loop finds it there: it comes back from the trip as from any other, softly.
pub struct Reconnecting {
    device: Option<Box<dyn Device>>,
    capabilities: Capabilities,
    gone: SyncSender<(Box<dyn Device>, DeviceError)>,
    /// Told when a device that is gone has been closed; awaited from when it was lost until another
    /// one is there.
    closed: Receiver<()>,
    closing: bool,
    back: Receiver<Box<dyn Device>>,
    zero: Shared,
    /// Whether the device has a way to no force while it is there.
    has_zero: bool,
    leaving: Arc<AtomicBool>,
}

/// The way to no force of the device that is there; none while it is gone. The loop never takes the
/// lock, and the supervisor never waits for it.
type Shared = Arc<Mutex<Option<Box<dyn ZeroWriter>>>>;

/// Another way to no force, or none; the one before is let go of.
fn put(zero: &Shared, writer: Option<Box<dyn ZeroWriter>>) {
    let mut place = zero.lock().unwrap_or_else(PoisonError::into_inner);
    let before = std::mem::replace(&mut *place, writer);
    // It may be the last that holds a port: closed with nobody kept out.
    drop(place);
    drop(before);
}

impl Reconnecting {
    /// A device that is there, and what to do when it is not. `tell` hears, on another thread, that the device has gone,
    /// why it cannot be opened anew, as often as that changes, and that it is back.
    ///
    /// # Errors
    /// The system gives no thread.
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
                    // It shares the port with the device, and a port that is held open comes back
                    // by another name, or not at all.
                    put(&theirs, None);
                    // Closing may wait for a board that does not answer.
                    drop(device);
                    // There is room: what was told before has been heard.
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
            gone,
            closed,
            closing: false,
            back,
            zero,
            has_zero,
            leaving,
        })
    }

    /// Hands a device that is gone to the thread that waits for it.
    fn lose(&mut self, error: DeviceError) {
        if let Some(device) = self.device.take() {
            // There is room for the one device that there is.
            self.closing = self.gone.try_send((device, error)).is_ok();
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
            // The one before was closed first, and that was told.
            self.closing = self.closed.try_recv().is_err();
        }
        let Some(device) = &mut self.device else {
            return Err(DeviceError::new(
                DeviceErrorKind::NothingNew,
                "the device is gone, and waited for",
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
        let Some(device) = &mut self.device else {
            return Ok(Wrench::NONE);
        };
        match device.write(wrench) {
            Err(error) if error.kind == DeviceErrorKind::Disconnected => {
                self.lose(error);
                Ok(Wrench::NONE)
            }
            written => written,
        }
    }

    fn last_sent(&self) -> Option<Wrench> {
        self.device.as_ref()?.last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Shared);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                // Held for a moment when a device goes, or comes back and nobody has written to it.
                if let Ok(mut zero) = self.0.try_lock()
                    && let Some(zero) = zero.as_mut()
                {
                    zero.write_zero();
                }
            }
        }
        // While the device is gone too: a loop that begins meanwhile needs its supervisor later.
        self.has_zero
            .then(|| Box::new(Zero(Arc::clone(&self.zero))) as Box<dyn ZeroWriter>)
    }

    fn was_cut(&mut self) -> bool {
        self.device.as_mut().is_some_and(Device::was_cut)
    }
}

impl Drop for Reconnecting {
    fn drop(&mut self) {
        self.leaving.store(true, Ordering::Release);
        if self.closing {
            // The program may end next: a board that could not be told that it holds no torque is
            // tried to be told for as long as in a program that does not reconnect.
            let _ = self.closed.recv_timeout(CLOSES_WITHIN);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device that is gone, and takes its time to be closed.
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
        drop(device);
        assert!(closed.load(Ordering::Acquire));
    }

    #[test]
    fn so_it_is_of_the_second_time() {
        let (first, second) = (Arc::default(), Arc::default());
        let again = Arc::clone(&second);
        let back: Reopen = Box::new(move || Ok(slow(&again)));
        let mut device = Reconnecting::new(slow(&first), back, |_| {}).unwrap();
        // The first is lost, the second comes, and is lost as well.
        let mut lost = 0;
        while lost < 2 {
            lost += usize::from(device.read().unwrap_err().what == "the board does not answer");
            std::thread::sleep(Duration::from_millis(1));
        }
        drop(device);
        assert!(first.load(Ordering::Acquire) && second.load(Ordering::Acquire));
    }
}

//! Supervisor of a loop outside `palpate_rt`.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_rt::realtime::Request;
use palpate_rt::safety::{Heartbeat, Supervisor};

/// A supervisor on its own thread, for a device with a second way to command zero force.
#[derive(Debug)]
pub struct Watched {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watched {
    /// Watches the loop of this heartbeat and commands zero force `stall_limit` after its last beat.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start<C: Clock>(
        device: &mut dyn Device,
        heartbeat: &Arc<Heartbeat>,
        clock: &C,
        request: &Request,
        stall_limit: Duration,
    ) -> io::Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        // On a simulated clock, which only sleeping threads advance, no thread is late.
        let zero = device.zero_writer().filter(|_| C::RUNS);
        let start = |zero| {
            let supervisor = Supervisor::new(Arc::clone(heartbeat), zero, stall_limit);
            let request = Request {
                priority: request.priority.map(|priority| (priority + 1).min(99)),
                ..*request
            };
            let (clock, ended) = (clock.clone(), Arc::clone(&ended));
            Builder::new()
                .name("palpate supervisor".to_owned())
                .spawn(move || {
                    // The loop requests the same and reports the refusal.
                    let _ = request.ask();
                    supervisor.watch(&clock, &ended);
                })
        };
        let thread = zero.map(start).transpose()?;
        Ok(Self { ended, thread })
    }

    /// Stops the supervisor and waits for its end.
    pub fn end(self) {
        self.ended.store(true, Ordering::Release);
        if let Some(thread) = self.thread {
            let _ = thread.join();
        }
    }
}

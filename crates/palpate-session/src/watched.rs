//! A supervisor beside a loop that is not `palpate_rt`'s.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_rt::realtime::Request;
use palpate_rt::safety::{Heartbeat, Supervisor};

/// A supervisor on a thread of its own, where the device has a second way to command no force.
#[derive(Debug)]
pub struct Watched {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watched {
    /// Watches the loop of this heartbeat, and commands no force `stall_limit` after its last beat.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start<C: Clock>(
        device: &mut dyn Device,
        heartbeat: &Arc<Heartbeat>,
        clock: &C,
        request: &Request,
        stall_limit: Duration,
    ) -> io::Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        // On a clock that only sleepers move, nobody is late.
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
                    // What is refused here is refused to the loop, which says so.
                    let _ = request.ask();
                    supervisor.watch(&clock, stall_limit / 4, &ended);
                })
        };
        let thread = zero.map(start).transpose()?;
        Ok(Self { ended, thread })
    }

    /// Ends it, and waits until it has ended.
    pub fn end(self) {
        self.ended.store(true, Ordering::Release);
        if let Some(thread) = self.thread {
            let _ = thread.join();
        }
    }
}

//! Messages of a pipe that do not delay its forces.

use std::fmt;
use std::io;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::Builder;
use std::time::Duration;

/// Capacity of the message queue; further messages are dropped.
const MAX_WAITING: usize = 1024;
/// Longest wait at the end for a reader of the messages.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Messages to standard error, written by a separate thread. A program that starts the pipe as a child and does not
/// read its standard error must not stop the forces.
#[derive(Debug)]
pub struct Messages {
    sender: SyncSender<String>,
    written: Receiver<()>,
    left_out: u64,
}

impl Messages {
    /// Starts the thread, which writes each message by `tell`.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn start(tell: impl Fn(String) + Send + 'static) -> io::Result<Self> {
        let (sender, messages) = sync_channel::<String>(MAX_WAITING);
        let (done, written) = channel();
        Builder::new()
            .name("palpate messages".to_owned())
            .spawn(move || {
                for message in messages {
                    tell(message);
                }
                let _ = done.send(());
            })?;
        Ok(Self {
            sender,
            written,
            left_out: 0,
        })
    }

    /// Queues a message, or drops it if the queue is full.
    pub fn tell(&mut self, message: impl fmt::Display) {
        if self.sender.try_send(message.to_string()).is_err() {
            self.left_out += 1;
        }
    }

    /// Queues the last message and waits a limited time until all messages are written.
    pub fn finish(mut self, last: impl fmt::Display) {
        if self.left_out > 0 {
            let left_out = self.left_out;
            self.tell(format_args!(
                "{left_out} messages were dropped: standard error was not read in time"
            ));
        }
        self.tell(last);
        let Self {
            sender, written, ..
        } = self;
        drop(sender);
        let _ = written.recv_timeout(LONGEST_WAIT);
    }
}

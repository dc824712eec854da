//! What is said while a motor is held.

use std::fmt;
use std::io;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::Builder;
use std::time::Duration;

/// Messages that wait to be written; more are left out.
const MOST_WAITING: usize = 1024;
/// How long the end waits for messages that nobody takes.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Messages to standard error, written by a thread of their own: a program that starts the pipe as
/// a child and does not read its standard error must not stop the forces.
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
    /// The system gives no thread.
    pub fn start(tell: impl Fn(String) + Send + 'static) -> io::Result<Self> {
        let (sender, messages) = sync_channel::<String>(MOST_WAITING);
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

    /// Says something, unless too much already waits to be written.
    pub fn tell(&mut self, message: impl fmt::Display) {
        if self.sender.try_send(message.to_string()).is_err() {
            self.left_out += 1;
        }
    }

    /// Says the last thing and waits until all is written, but not for ever.
    pub fn finish(mut self, last: impl fmt::Display) {
        if self.left_out > 0 {
            let left_out = self.left_out;
            self.tell(format_args!(
                "{left_out} messages are left out: nobody read standard error in time"
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

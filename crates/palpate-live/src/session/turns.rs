//! The turns of a session: it does what clients ask for, listens to its loops, and shows what they do.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use palpate_rt::StopFlag;
use palpate_rt::realtime::Answer;

use super::Command;

/// Longest idle time of the session without requests.
const REST: Duration = Duration::from_millis(4);
/// Time limit for executing requests before ticks are read and shown again; the last request may take longer.
const TURN: Duration = Duration::from_millis(4);
/// Frames are sent this often.
const FRAME_EVERY: Duration = Duration::from_nanos(1_000_000_000 / 60);
/// Interval of status messages.
const STATUS_EVERY: Duration = Duration::from_millis(500);

/// Operations of a session in its main loop.
pub(crate) trait Turns {
    /// Result of the session.
    type End;

    /// Returns the scheduling that the system granted to the first loop.
    fn answers(&self) -> Vec<Answer>;
    /// Does what a client asks for.
    fn obey(&mut self, command: Command);
    /// Returns the number of starts of the loops.
    fn runs(&self) -> u32;
    /// Processes the messages of the loops.
    fn listen(&mut self);
    /// Sends clients a frame.
    fn show(&mut self);
    /// Tells clients how the loops are.
    fn tell_status(&mut self);
    /// Returns whether the loops had a limited duration and have ended. Otherwise they can be restarted.
    fn is_over(&self) -> bool;
    /// Stops the loops and returns their results.
    fn finish(self) -> Self::End;
}

/// Takes turns until `stop` is raised or the session is over.
pub(super) fn take_turns<T: Turns>(
    mut session: T,
    commands: &Receiver<Command>,
    stop: &StopFlag,
) -> T::End {
    let mut next_frame = Instant::now();
    let mut next_status = Instant::now();
    loop {
        let now = Instant::now();
        let rest = next_frame.saturating_duration_since(now).min(REST);
        take_commands(&mut session, commands, stop, rest);
        if stop.is_raised() {
            return session.finish();
        }
        session.listen();
        let now = Instant::now();
        if now >= next_frame {
            session.show();
            // A frame that is late is not made up for.
            next_frame = (next_frame + FRAME_EVERY).max(now);
        }
        if now >= next_status {
            session.tell_status();
            next_status = now + STATUS_EVERY;
        }
        if session.is_over() {
            return session.finish();
        }
    }
}

/// Waits for commands and executes the pending ones, for one turn at most and with at most one restart, so that other
/// clients are served in between.
fn take_commands<T: Turns>(
    session: &mut T,
    commands: &Receiver<Command>,
    stop: &StopFlag,
    rest: Duration,
) {
    let mut next = match commands.recv_timeout(rest) {
        Ok(command) => Some(command),
        Err(RecvTimeoutError::Timeout) => None,
        // The server has ended; the loops continue.
        Err(RecvTimeoutError::Disconnected) => {
            std::thread::sleep(rest);
            None
        }
    };
    let (begun, runs) = (Instant::now(), session.runs());
    while let Some(command) = next.take_if(|_| !stop.is_raised()) {
        session.obey(command);
        if session.runs() == runs && begun.elapsed() < TURN {
            next = commands.try_recv().ok();
        }
    }
}

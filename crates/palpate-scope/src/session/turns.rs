//! The turns of a session: it does what clients ask for, listens to its loops, and shows what they do.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use palpate_rt::StopFlag;
use palpate_rt::realtime::Answer;

use super::Command;

/// How long the session rests at most when nobody asks for anything.
const REST: Duration = Duration::from_millis(4);
/// How long requests are done before it is listened and shown again; the last may take longer.
const TURN: Duration = Duration::from_millis(4);
/// Frames are sent this often.
const FRAME_EVERY: Duration = Duration::from_nanos(1_000_000_000 / 60);
/// The status is told this often.
const STATUS_EVERY: Duration = Duration::from_millis(500);

/// What a session does in its turns.
pub(crate) trait Turns {
    /// How it ends.
    type End;

    /// What the machine granted the first loop.
    fn answers(&self) -> Vec<Answer>;
    /// Does what a client asks for.
    fn obey(&mut self, command: Command);
    /// How often the loops have begun.
    fn runs(&self) -> u32;
    /// Hears what the loops say.
    fn listen(&mut self);
    /// Sends clients a frame.
    fn show(&mut self);
    /// Tells clients how the loops are.
    fn tell_status(&mut self);
    /// Whether its loops were to last for so long, and have ended. Else they can be begun anew.
    fn is_over(&self) -> bool;
    /// Stops the loops, and says how they ended.
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

/// Waits for commands, and does those that are there: for one turn at most, and only the first
/// that begins the loops anew, since others want to be heard and shown something as well.
fn take_commands<T: Turns>(
    session: &mut T,
    commands: &Receiver<Command>,
    stop: &StopFlag,
    rest: Duration,
) {
    let mut next = match commands.recv_timeout(rest) {
        Ok(command) => Some(command),
        Err(RecvTimeoutError::Timeout) => None,
        // Nobody serves any more; the loops go on.
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

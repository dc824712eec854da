//! The watchdog process.

use std::io::{self, ErrorKind, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

use rustix::process::{chdir, setsid};
use rustix::stdio::{dup2_stdin, dup2_stdout};

use super::watch::{Outcome, Watch};
use super::{Orders, PRIORITY, READY};
use crate::realtime::Request;
use crate::stop::StopFlag;

/// Supervises a loop from a separate process. Parameters and messages of the driver arrive on standard input,
/// standard output is the port, and messages for the user go to standard error. Returns after the driver's dismissal,
/// or after the end of the loop and the zero command to the board.
///
/// The process runs in its own session, so signals that a terminal sends to the loop (ctrl-C, ctrl-Z, hang-up) do not
/// reach it. It ignores all signals that a program can catch.
///
/// # Errors
/// Standard input is not the socket of a driver.
pub fn serve() -> io::Result<()> {
    // The handlers replace the default actions; the flag is unused.
    let _ignored = StopFlag::on_signals();
    // Set the priority before setsid. On Linux, setsid moves a process into a new scheduling group (autogroup), and
    // beside busy programs such a process did not run for up to a minute. A SCHED_FIFO process belongs to no such
    // group.
    let answers = Request {
        priority: Some(PRIORITY),
        lock_memory: true,
        processor: None,
    }
    .ask();
    // setsid fails for the leader of a process group, which does not receive the loop's signals anyway.
    let _ = setsid();
    // Allow the initial working directory to be unmounted.
    let _ = chdir("/");
    let mut socket = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    socket
        .peer_addr()
        .map_err(|_| io::Error::other("standard input is not the socket of a loop"))?;
    let port = io::stdout().as_fd().try_clone_to_owned()?;
    let null = std::fs::File::options()
        .read(true)
        .write(true)
        .open("/dev/null")?;
    dup2_stdin(&null)?;
    dup2_stdout(&null)?;
    let orders = match Orders::read(&mut socket) {
        Ok(orders) => orders,
        // The loop ended before any force was on.
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(()),
        Err(error) => return Err(error),
    };
    // Make this the last process killed when memory runs out; most users lack this permission.
    let _ = std::fs::write("/proc/self/oom_score_adj", "-1000");
    let is_first = answers.first().is_some_and(|answer| answer.is_granted());
    match socket.write_all(&[READY, u8::from(is_first)]) {
        // As above: the waiting driver has ended meanwhile.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => return Ok(()),
        said => said?,
    }
    let outcome = Watch::new(socket, port, orders)?.run();
    if let Some(words) = outcome_in_words(outcome) {
        // Standard error may be closed.
        let _ = writeln!(io::stderr(), "{words}");
    }
    Ok(())
}

fn outcome_in_words(outcome: Outcome) -> Option<&'static str> {
    match outcome {
        Outcome::Dismissed | Outcome::PortGone => None,
        Outcome::Released { was_on: false, .. } => None,
        Outcome::Released {
            is_confirmed: true, ..
        } => Some(
            "watchdog: the loop ended with a force on; the force is now 0, confirmed by the board",
        ),
        Outcome::Released { .. } => Some(
            "watchdog: the loop ended with a force on; the board does not answer and may \
             hold it: switch the motors off",
        ),
    }
}

//! The process in which a guardian watches.

use std::io::{self, ErrorKind, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

use rustix::process::{chdir, setsid};
use rustix::stdio::{dup2_stdin, dup2_stdout};

use super::watch::{Outcome, Watch};
use super::{Orders, PRIORITY, READY};
use crate::realtime::Request;
use crate::stop::StopFlag;

/// Watches a loop, from its own process: its orders and the driver's words come from standard input,
/// and standard output is the port. What it has to say to a person goes to standard error. Returns
/// when the driver has dismissed it, or when the loop is gone and the board has been told.
///
/// A session of its own keeps it out of reach of what a terminal sends to the loop (ctrl-C, ctrl-Z,
/// the end of the terminal), and it takes no notice of any signal that a program can catch.
///
/// # Errors
/// Standard input is not the socket of a driver.
pub fn serve() -> io::Result<()> {
    // The flag that they raise is nobody's.
    let _ignored = StopFlag::on_signals();
    // The priority comes before setsid. On Linux setsid moves a process into a scheduling group of its own (autogroup), and
    // beside busy programs such a process did not run for up to a minute. A process of SCHED_FIFO is in no such group.
    let answers = Request {
        priority: Some(PRIORITY),
        lock_memory: true,
        processor: None,
    }
    .ask();
    // Refused to the leader of a group, who is out of reach already.
    let _ = setsid();
    // Whatever it was started in can be unmounted.
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
        // The loop was gone before any force was on.
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(()),
        Err(error) => return Err(error),
    };
    // The last to be ended where memory runs out; a right that most users do not have.
    let _ = std::fs::write("/proc/self/oom_score_adj", "-1000");
    let is_first = answers.first().is_some_and(|answer| answer.is_granted());
    match socket.write_all(&[READY, u8::from(is_first)]) {
        // As above: whoever waited for it has gone meanwhile.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => return Ok(()),
        said => said?,
    }
    let outcome = Watch::new(socket, port, orders)?.run();
    if let Some(words) = outcome_in_words(outcome) {
        // Nobody may be listening any more.
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
            "guardian: the loop is gone and had left a force on; the force is off, the board has answered",
        ),
        Outcome::Released { .. } => Some(
            "guardian: the loop is gone and had left a force on; the board does not answer and may \
             hold it: switch the motors off",
        ),
    }
}

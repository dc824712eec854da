//! Serving of a session's page: its address and its end.

use std::path::Path;
use std::time::Duration;

use palpate_live::{Home, ListenError, Listening, Server, Session, SessionError};
use palpate_rt::{SetupError, StopFlag};

use super::LiveArguments;
use crate::failure::{Failure, tell};
use crate::results::print;

/// Polling interval of the session's end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Starts a session with the contents of the file at `path`, serves `home` until the session ends, and returns its
/// outcome.
pub fn serve<End: Send + 'static>(
    listening: Listening,
    home: Home,
    path: &Path,
    begin: impl FnOnce(&StopFlag) -> Result<Session<End>, SessionError>,
) -> Result<End, Failure> {
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    // Declared first and therefore dropped last: after any failure below, the force is off before clients get a
    // goodbye.
    let server;
    let session = begin(&stop).map_err(|error| match error {
        SessionError::Setup(SetupError::Safety(error)) => Failure::Arguments(error.to_string()),
        SessionError::Setup(error) => Failure::input(format_args!("{}: {error}", path.display())),
        SessionError::Other(text) => Failure::System(text),
    })?;
    let where_it_is = where_it_is(&listening);
    server = Server::start(listening, session.hub(), session.commands(), home)
        .map_err(|error| Failure::System(error.to_string()))?;
    print(&format!("{where_it_is}ctrl-C ends it\n"))?;
    for answer in session
        .answers()
        .iter()
        .filter(|answer| !answer.is_granted())
    {
        tell(format_args!("warning: {answer}"));
    }
    while !session.has_ended() {
        std::thread::sleep(LOOK_EVERY);
    }
    let end = session.join();
    drop(server);
    Ok(end)
}

/// Listens on the addresses in `arguments`.
pub fn listen(arguments: &LiveArguments) -> Result<Listening, Failure> {
    Listening::on(arguments.listen, arguments.allow_host.clone()).map_err(|error| match error {
        ListenError::Address { address, source }
            if source.kind() == std::io::ErrorKind::AddrInUse =>
        {
            Failure::System(format!(
                "{address} is in use, possibly by another palpate live; --listen {}:0 selects a free port",
                address.ip()
            ))
        }
        other => Failure::System(other.to_string()),
    })
}

/// Returns the addresses to open, one per line.
fn where_it_is(listening: &Listening) -> String {
    let here = listening.url();
    if !listening.address().ip().is_unspecified() {
        return format!("{here}\n");
    }
    match listening.url_on_the_network() {
        Some(there) => format!("{here}\nfrom another machine: {there}\n"),
        None => format!(
            "{here}\nfrom another machine: the same, with an address of this machine instead of {}\n",
            if listening.address().is_ipv4() {
                "127.0.0.1"
            } else {
                "[::1]"
            }
        ),
    }
}

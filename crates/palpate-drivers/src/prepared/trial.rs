//! Latency test of a watchdog process on this machine, on a socket in place of a port.

use std::io::{self, ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_rt::watchdog::{Orders, Watchdog, WatchdogAccount};

/// Result of a latency test of a watchdog process.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Whether the watchdog process has real-time priority.
    pub is_first: bool,
    /// Times from the driver's last message to the zero-force command, minus the limit; sorted.
    pub late: Vec<Duration>,
}

/// Maximum time to wait for the response of a watchdog process.
const PATIENCE: Duration = Duration::from_secs(10);

/// Starts the watchdog process of `command` and, `rounds` times, sends it no messages for longer than `limit`.
///
/// # Errors
/// The watchdog process cannot be started, ended early, or did not respond.
pub fn try_out(command: Command, limit: Duration, rounds: usize) -> Result<Tried, String> {
    let said = |error: io::Error| error.to_string();
    let (port, mut board) = UnixStream::pair().map_err(said)?;
    port.set_nonblocking(true).map_err(said)?;
    board.set_read_timeout(Some(PATIENCE)).map_err(said)?;
    let orders = Orders {
        limit,
        release: vec![0],
        probe: vec![0],
        answer: 0,
    };
    let account = Arc::new(WatchdogAccount::default());
    let watchdog = Watchdog::start(command, port.as_fd(), &orders, Arc::clone(&account))
        .map_err(|error| error.to_string())?;
    let gone = |_| "the process ended unexpectedly".to_owned();
    let mut late = Vec::with_capacity(rounds);
    for _ in 0..rounds {
        watchdog.force().map_err(gone)?;
        let spoken = Instant::now();
        match board.read(&mut [0; 1]) {
            Ok(1) => late.push(spoken.elapsed().saturating_sub(limit)),
            Ok(_) => return Err("the process ended unexpectedly".to_owned()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                return Err(format!(
                    "no zero-force command within {} s",
                    PATIENCE.as_secs()
                ));
            }
            Err(error) => return Err(error.to_string()),
        }
        watchdog.none().map_err(gone)?;
        let _ = watchdog.has_cut();
        // Discard further zero-force commands that it may have sent meanwhile.
        std::thread::sleep(limit);
        board.set_nonblocking(true).map_err(said)?;
        while board.read(&mut [0; 64]).is_ok_and(|read| read > 0) {}
        board.set_nonblocking(false).map_err(said)?;
    }
    watchdog.dismiss();
    late.sort();
    Ok(Tried {
        is_first: account.is_first(),
        late,
    })
}

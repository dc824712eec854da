//! How a guardian does on this machine, tried out on a port on which nobody is.

use std::io::{self, ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_rt::guardian::{Guardian, GuardianAccount, Orders};

/// How a guardian did on a port on which nobody is.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Whether the machine serves it before everybody else.
    pub is_first: bool,
    /// From the driver's last word to no force, less the limit; sorted.
    pub late: Vec<Duration>,
}

/// For how long a guardian is waited for that does not do what it should.
const PATIENCE: Duration = Duration::from_secs(10);

/// Starts the guardian of `command` and falls silent for longer than `limit`, `rounds` times.
///
/// # Errors
/// The guardian cannot be started, ended, or did nothing.
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
    let account = Arc::new(GuardianAccount::default());
    let guardian = Guardian::start(command, port.as_fd(), &orders, Arc::clone(&account))
        .map_err(|error| error.to_string())?;
    let gone = |_| "it ended by itself".to_owned();
    let mut late = Vec::with_capacity(rounds);
    for _ in 0..rounds {
        guardian.force().map_err(gone)?;
        let spoken = Instant::now();
        match board.read(&mut [0; 1]) {
            Ok(1) => late.push(spoken.elapsed().saturating_sub(limit)),
            Ok(_) => return Err("it ended by itself".to_owned()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                return Err(format!("it did nothing for {} s", PATIENCE.as_secs()));
            }
            Err(error) => return Err(error.to_string()),
        }
        guardian.none().map_err(gone)?;
        let _ = guardian.has_cut();
        // It may have commanded none once more meanwhile.
        std::thread::sleep(limit);
        board.set_nonblocking(true).map_err(said)?;
        while board.read(&mut [0; 64]).is_ok_and(|read| read > 0) {}
        board.set_nonblocking(false).map_err(said)?;
    }
    guardian.dismiss();
    late.sort();
    Ok(Tried {
        is_first: account.is_first(),
        late,
    })
}

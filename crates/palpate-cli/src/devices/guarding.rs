//! Guardians of devices that hold their last force.

use std::time::Duration;

use palpate_device::Capabilities;
#[cfg(unix)]
use palpate_rt::guardian::Unguarded;
use serde::Serialize;

use super::DeviceArguments;

#[cfg(unix)]
pub use on_unix::{command, try_out};

/// How the devices of a session are guarded.
#[derive(Clone, Debug)]
pub struct Guarding {
    /// How long the loop may be silent while a force is on.
    pub limit: Duration,
    /// What the guardians have done.
    #[cfg(unix)]
    pub account: std::sync::Arc<palpate_rt::guardian::GuardianAccount>,
}

/// The guardian of a run, for reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct GuardianReport {
    /// Whether there was one.
    on: bool,
    /// How long the loop might be silent `[s]`.
    silence_s: Option<f64>,
    /// Whether the machine served the guardian before everybody else.
    first: Option<bool>,
    /// How often it commanded no force.
    cuts: u64,
    /// Whether it was lost before the device was closed.
    gone: bool,
    /// How: `ended` or `not-listening`.
    lost: Option<&'static str>,
    #[serde(skip)]
    lost_in_words: Option<&'static str>,
}

impl Guarding {
    /// Guardians that command no force after `limit` of silence.
    pub fn new(limit: Duration) -> Self {
        Self {
            limit,
            #[cfg(unix)]
            account: std::sync::Arc::default(),
        }
    }

    /// How a guardian was lost before its device was closed, if one was: a key and a sentence.
    pub fn lost(&self) -> Option<(&'static str, &'static str)> {
        #[cfg(unix)]
        let lost = self.account.lost().map(|how| match how {
            Unguarded::Ended => ("ended", "the guardian ended"),
            Unguarded::NotListening => (
                "not-listening",
                "the guardian is there and does not listen, as if it were stopped",
            ),
        });
        #[cfg(not(unix))]
        let lost = None;
        lost
    }

    /// How a device was guarded; `None`: it holds no force by itself.
    pub fn report(
        &self,
        arguments: &DeviceArguments,
        device: &Capabilities,
    ) -> Option<GuardianReport> {
        if !device.holds_last_force {
            return None;
        }
        let on = arguments.is_guarded();
        #[cfg(unix)]
        let (first, cuts) = (self.account.is_first(), self.account.cuts());
        #[cfg(not(unix))]
        let (first, cuts) = (false, 0);
        let lost = self.lost();
        Some(GuardianReport {
            on,
            silence_s: on.then_some(self.limit.as_secs_f64()),
            first: on.then_some(first),
            cuts,
            gone: lost.is_some(),
            lost: lost.map(|(key, _)| key),
            lost_in_words: lost.map(|(_, words)| words),
        })
    }
}

impl std::fmt::Display for GuardianReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(silence) = self.silence_s else {
            return write!(
                f,
                "guardian: off, as asked for; the device holds its last force if this program is killed"
            );
        };
        write!(
            f,
            "guardian: commands no force after {} ms of silence; SCHED_FIFO, priority 99: {}",
            palpate_study::text::digits(1e3 * silence),
            if self.first == Some(true) {
                "granted"
            } else {
                "refused"
            }
        )?;
        if self.cuts > 0 {
            let times = palpate_study::text::counted(self.cuts, "time");
            write!(f, "\nthe guardian commanded no force {times}")?;
        }
        if let Some(lost) = self.lost_in_words {
            write!(f, "\n{lost}; the loop commanded no force from then on")?;
        }
        Ok(())
    }
}

#[cfg(unix)]
mod on_unix {
    use std::io::{self, ErrorKind, Read};
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixStream;
    use std::os::unix::process::CommandExt;
    use std::process::Command;
    use std::sync::Arc;
    use std::time::{Duration, Instant};

    use palpate_rt::guardian::{Guardian, GuardianAccount, Orders};

    /// This program once more, as a guardian.
    pub fn command() -> io::Result<Command> {
        // On Linux by a name that stays right when the file is replaced by a newer one.
        let program = if cfg!(target_os = "linux") {
            "/proc/self/exe".into()
        } else {
            std::env::current_exe()?
        };
        let mut command = Command::new(program);
        command.arg0("palpate").arg("guardian");
        Ok(command)
    }

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

    /// Starts a guardian and falls silent, `rounds` times.
    pub fn try_out(limit: Duration, rounds: usize) -> Result<Tried, String> {
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
        let command = command().map_err(said)?;
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
}

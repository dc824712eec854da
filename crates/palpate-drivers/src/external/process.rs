//! Program of a device, whose standard input and output are a socket.

use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process_group};

use super::channel::Channel;

/// Time for ending by itself after the end of its input.
const ENDS_WITHIN: Duration = Duration::from_secs(2);
const LOOKS_EVERY: Duration = Duration::from_millis(1);

/// A running program of a device.
#[derive(Debug)]
pub struct Program(Option<Child>);

impl Program {
    /// Starts the program. Its standard error is that of this program.
    ///
    /// # Errors
    /// The program is missing, or the system refuses.
    pub fn start(words: &[String]) -> io::Result<(Self, Channel)> {
        let [program, arguments @ ..] = words else {
            return Err(io::Error::other("no program is named"));
        };
        let (ours, theirs) = UnixStream::pair()?;
        ours.set_nonblocking(true)?;
        let output: OwnedFd = theirs.try_clone()?.into();
        let mut command = Command::new(program);
        command
            .args(arguments)
            .stdin(Stdio::from(OwnedFd::from(theirs)))
            .stdout(Stdio::from(output))
            // ctrl-C ends the loop first, which commands zero.
            .process_group(0);
        let child = command.spawn()?;
        // Closes this program's copies of the other end, so that the end of the device is noticed.
        drop(command);
        Ok((Self(Some(child)), Channel::Stream(ours)))
    }

    /// Waits for the program's own end, whose input has ended, and kills it after 2 s. Returns how it failed, if it did.
    pub fn end(mut self) -> Option<String> {
        let mut child = self.0.take()?;
        let mut waited = Duration::ZERO;
        while waited < ENDS_WITHIN {
            match child.try_wait() {
                Ok(None) => sleep(LOOKS_EVERY),
                Ok(Some(status)) => return Some(in_words(status)),
                Err(_) => return None,
            }
            waited += LOOKS_EVERY;
        }
        kill(&mut child);
        None
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            kill(child);
        }
    }
}

/// Kills the program and its children, which are a process group.
fn kill(child: &mut Child) {
    let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
    let _ = child.kill();
    let _ = child.wait();
}

fn in_words(status: ExitStatus) -> String {
    status.to_string()
}

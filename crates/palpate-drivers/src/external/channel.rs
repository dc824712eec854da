//! Channel to a device of another program: the standard input and output of its process, or UDP packets. Sending and
//! receiving do not wait.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
#[cfg(unix)]
use std::os::fd::{AsFd, BorrowedFd};
#[cfg(unix)]
use std::os::unix::net::UnixStream;
use std::time::Duration;

use super::protocol;

/// The other end is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Closed;

/// A channel. Its handles share it.
#[derive(Debug)]
pub enum Channel {
    /// A socket that is the standard input and output of a process.
    #[cfg(unix)]
    Stream(UnixStream),
    /// A socket that receives packets of one address only.
    Packets(UdpSocket),
}

impl Channel {
    /// Opens a socket for the device at `address`.
    ///
    /// # Errors
    /// The system refuses.
    pub fn to(address: SocketAddr) -> io::Result<Self> {
        let any: SocketAddr = if address.is_ipv4() {
            (Ipv4Addr::UNSPECIFIED, 0).into()
        } else {
            (Ipv6Addr::UNSPECIFIED, 0).into()
        };
        let socket = UdpSocket::bind(any)?;
        // From now on the system drops the packets of other addresses.
        socket.connect(address)?;
        socket.set_nonblocking(true)?;
        Ok(Self::Packets(socket))
    }

    /// Returns a second handle.
    ///
    /// # Errors
    /// The system refuses.
    pub fn try_clone(&self) -> io::Result<Self> {
        match self {
            #[cfg(unix)]
            Self::Stream(stream) => stream.try_clone().map(Self::Stream),
            Self::Packets(socket) => socket.try_clone().map(Self::Packets),
        }
    }

    /// Whether each read returns a complete message.
    pub fn has_packets(&self) -> bool {
        matches!(self, Self::Packets(_))
    }

    /// Returns the bytes that remove the force. A packet is one line.
    pub fn zero(&self) -> &'static [u8] {
        if self.has_packets() {
            protocol::ZERO
        } else {
            protocol::ZERO_IN_A_STREAM
        }
    }

    /// Sends a line; returns the number of bytes that found room, 0 if none. A packet is sent completely or not at all.
    ///
    /// # Errors
    /// The device is gone.
    pub fn send(&self, line: &[u8]) -> Result<usize, Closed> {
        let sent = match self {
            #[cfg(unix)]
            Self::Stream(stream) => (&mut &*stream).write(line),
            // A refusal is the answer to an earlier packet, and this one was not sent.
            Self::Packets(socket) => socket.send(line).or_else(|error| {
                if is_a_pause(&error) {
                    Err(error)
                } else {
                    socket.send(line)
                }
            }),
        };
        match sent {
            Ok(sent) => Ok(sent),
            // No program listens. Its silence ends the session.
            Err(error) if is_a_pause(&error) || self.has_packets() => Ok(0),
            Err(_) => Err(Closed),
        }
    }

    /// Whether a packet was refused since the last call of this, `send` or `receive`: no program listens.
    pub fn is_refused(&self) -> bool {
        let error = match self {
            #[cfg(unix)]
            Self::Stream(_) => return false,
            Self::Packets(socket) => socket.take_error(),
        };
        let kind = error.ok().flatten().map(|error| error.kind());
        kind == Some(ErrorKind::ConnectionRefused)
    }

    /// Reads what has arrived; returns the number of bytes, 0 if nothing has.
    ///
    /// # Errors
    /// The device is gone.
    pub fn receive(&self, into: &mut [u8]) -> Result<usize, Closed> {
        let read = match self {
            #[cfg(unix)]
            Self::Stream(stream) => match (&mut &*stream).read(into) {
                Ok(0) => return Err(Closed),
                read => read,
            },
            Self::Packets(socket) => socket.recv(into),
        };
        match read {
            Ok(read) => Ok(read),
            Err(error) if is_a_pause(&error) || self.has_packets() => Ok(0),
            Err(_) => Err(Closed),
        }
    }

    /// Waits until something has arrived, at most `limit`.
    #[cfg(unix)]
    pub fn wait(&self, limit: Duration) {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        let limit = Timespec {
            tv_sec: limit.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        // An interrupted wait is only shorter.
        let _ = poll(&mut [PollFd::new(self, PollFlags::IN)], Some(&limit));
    }

    /// Waits until something has arrived, at most `limit`.
    #[cfg(not(unix))]
    pub fn wait(&self, limit: Duration) {
        let Self::Packets(socket) = self;
        let begun = std::time::Instant::now();
        while begun.elapsed() < limit
            && socket.peek(&mut [0]).is_err_and(|error| is_a_pause(&error))
        {
            std::thread::yield_now();
        }
    }

    /// Ends the messages to the device: its standard input ends.
    pub fn shut(&self) {
        #[cfg(unix)]
        if let Self::Stream(stream) = self {
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
    }
}

#[cfg(unix)]
impl AsFd for Channel {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Stream(stream) => stream.as_fd(),
            Self::Packets(socket) => socket.as_fd(),
        }
    }
}

/// Whether a later attempt may succeed.
fn is_a_pause(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

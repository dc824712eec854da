//! Address of the service, and the WebSocket connection to it.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tungstenite::handshake::HandshakeError;
use tungstenite::http::Uri;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{ClientHandshake, Error, WebSocket};

/// Port of the simulation channel.
const PORT: u16 = 10001;

/// Maximum length of a received message `[bytes]`; frames of many devices have a few thousand bytes.
const LONGEST: usize = 1 << 20;

/// Address of a WebSocket of the service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Address {
    url: String,
    host: String,
    port: u16,
}

/// Reason why the WebSocket connection failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConnectError {
    /// The address is invalid.
    #[error("{given}: {what}; allowed: ws://HOST:PORT, such as ws://localhost:10001")]
    Address {
        /// Given address.
        given: String,
        /// Description of the error.
        what: String,
    },
    /// No server answers at the address.
    #[error(
        "no answer from {url}: {error}; start Haply's Inverse Service, or \
         `palpate devices emulate inverse3` to try without a device"
    )]
    Nobody {
        /// Address.
        url: String,
        /// Error of the operating system.
        error: io::Error,
    },
    /// A server answers, but it is not the Inverse Service.
    #[error("{url} answers, but is not an Inverse Service: {what}")]
    NoService {
        /// Address.
        url: String,
        /// Description of its answer.
        what: String,
    },
}

impl Address {
    /// Parses `ws://HOST:PORT`; the scheme and the port are optional.
    pub fn parse(given: &str) -> Result<Self, ConnectError> {
        let wrong = |what: &str| ConnectError::Address {
            given: given.to_owned(),
            what: what.to_owned(),
        };
        let url = if given.contains("://") {
            given.to_owned()
        } else {
            format!("ws://{given}")
        };
        let uri: Uri = url.parse().map_err(|_| wrong("not an address"))?;
        if uri.scheme_str() != Some("ws") {
            return Err(wrong("only ws:// is supported"));
        }
        let host = uri.host().filter(|host| !host.is_empty());
        let host = host.ok_or_else(|| wrong("no host"))?;
        let authority = uri.authority().map_or("", |authority| authority.as_str());
        let port = match uri.port_u16() {
            Some(0) => return Err(wrong("port 0 is invalid")),
            Some(port) => port,
            None if authority == host => PORT,
            None => return Err(wrong("not a valid port")),
        };
        let path = uri.path_and_query().map_or("/", |path| path.as_str());
        Ok(Self {
            url: format!("ws://{host}:{port}{path}"),
            host: host.trim_matches(['[', ']']).to_owned(),
            port,
        })
    }

    /// Opens a WebSocket, and a second half through which another thread writes. Tries each IPv6 and IPv4 address of
    /// the host in turn.
    pub fn connect(&self, patience: Duration) -> Result<(WebSocket<Half>, Half), ConnectError> {
        let nobody = |error| ConnectError::Nobody {
            url: self.url.clone(),
            error,
        };
        let stream = self.stream(patience).map_err(nobody)?;
        let prepare = || {
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(patience))?;
            stream.set_write_timeout(Some(patience))?;
            stream.try_clone()
        };
        let writing = Arc::default();
        let other = Half {
            stream: prepare().map_err(nobody)?,
            writing: Arc::clone(&writing),
        };
        let config = Some(config());
        let request =
            tungstenite::client::IntoClientRequest::into_client_request(self.url.as_str());
        let no_service = |what: String| ConnectError::NoService {
            url: self.url.clone(),
            what,
        };
        let request = request.map_err(|error| no_service(error.to_string()))?;
        let half = Half { stream, writing };
        let handshake = ClientHandshake::start(half, request, config)
            .map_err(HandshakeError::Failure)
            .and_then(tungstenite::handshake::MidHandshake::handshake);
        match handshake {
            Ok((socket, _)) => Ok((socket, other)),
            Err(HandshakeError::Interrupted(_)) => Err(no_service(format!(
                "no answer within {} s",
                patience.as_secs_f64()
            ))),
            Err(HandshakeError::Failure(Error::Io(error))) => Err(nobody(error)),
            Err(HandshakeError::Failure(error)) => Err(no_service(error.to_string())),
        }
    }

    fn stream(&self, patience: Duration) -> io::Result<TcpStream> {
        let mut refused = io::Error::other("the host has no address");
        for address in (self.host.as_str(), self.port).to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, patience) {
                Ok(stream) => return Ok(stream),
                Err(error) => refused = error,
            }
        }
        Err(refused)
    }

    /// Returns the address as a URL.
    pub fn url(&self) -> &str {
        &self.url
    }
}

/// Returns a configuration without write buffering; the length limits apply to messages of the service.
fn config() -> WebSocketConfig {
    WebSocketConfig::default()
        .read_buffer_size(1 << 14)
        .write_buffer_size(0)
        .max_message_size(Some(LONGEST))
        .max_frame_size(Some(LONGEST))
}

/// One of two ends of a connection that is shared by two threads: one reads, and answers pings and closing; the other
/// writes. A mutex keeps each write in one piece.
#[derive(Debug)]
pub(super) struct Half {
    stream: TcpStream,
    writing: Arc<Mutex<()>>,
}

impl Half {
    /// Creates a WebSocket to write through.
    pub fn into_writer(self) -> WebSocket<Self> {
        WebSocket::from_raw_socket(self, Role::Client, Some(config()))
    }

    /// Returns the connection itself.
    pub fn stream(&self) -> &TcpStream {
        &self.stream
    }
}

impl Read for Half {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.stream.read(buffer) {
                // The kernel interrupts a read with a timeout when a stopped program continues (ctrl-Z, fg).
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => return read,
            }
        }
    }
}

impl Write for Half {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let _writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        self.stream.write_all(buffer)?;
        Ok(buffer.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scheme_and_port_may_be_left_away() {
        let url = |given: &str| Address::parse(given).unwrap().url;
        assert_eq!(url("ws://127.0.0.1:10001"), "ws://127.0.0.1:10001/");
        assert_eq!(url("localhost"), "ws://localhost:10001/");
        assert_eq!(url("[::1]:7"), "ws://[::1]:7/");
        assert_eq!(url("ws://a.example:1/3.0/x?y"), "ws://a.example:1/3.0/x?y");
        assert_eq!(Address::parse("[::1]").unwrap().host, "::1");
    }

    #[test]
    fn what_is_no_address_is_refused() {
        for (given, words) in [
            ("wss://localhost:1", "only ws://"),
            ("http://localhost", "only ws://"),
            ("ws://", "not an address"),
            ("localhost:port", "no"),
            ("localhost:70000", "no"),
            ("localhost:0", "port 0"),
            ("", "not an address"),
        ] {
            let said = Address::parse(given).unwrap_err().to_string();
            assert!(said.contains(words) && said.contains("allowed"), "{said}");
        }
    }
}

//! One client: its incoming and outgoing messages.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use tokio::time::{Instant, sleep_until, timeout};
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Bytes, Error, Message};

use crate::hub::{Hub, Outgoing, Seat};
use crate::message::{ClientMessage, ServerMessage, parse};
use crate::session::Command;

use super::upgrade::WebSocket;

/// Longest message of a client [bytes].
pub const LONGEST: usize = 4096;
/// A client that takes nothing for this long is gone.
const PATIENCE: Duration = Duration::from_secs(10);
/// Interval of pings that check whether a client is still connected.
const PING_EVERY: Duration = Duration::from_secs(2);
/// A client that sends nothing for this long is dropped even if its connection seems alive, so that it cannot keep the
/// hand.
const SILENCE: Duration = Duration::from_secs(10);
/// Time limit for the closing handshake of a disconnected client.
const GOODBYE: Duration = Duration::from_secs(1);
/// Rate limit of a client's messages: burst size, and rate per second; more than a person needs.
const AT_ONCE: f64 = 200.0;
const PER_SECOND: f64 = 200.0;

/// Close frame for a client that exceeds a limit of the server.
type SentAway = CloseFrame;

/// Serves a client until it leaves or is disconnected.
pub async fn serve(mut socket: WebSocket, hub: Arc<Hub>, commands: SyncSender<Command>) {
    let mut seat = hub.join();
    let id = seat.id;
    let why = converse(&mut socket, &mut seat, &hub, &commands).await;
    hub.leave(id);
    // The client may hold the hand, which must then be released. If the session has ended, the hand no longer exists.
    let mut gone = Command::Gone(id);
    while let Err(std::sync::mpsc::TrySendError::Full(again)) = commands.try_send(gone) {
        gone = again;
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    if let Some(frame) = why {
        let goodbye = async {
            socket.send(Message::Close(Some(frame))).await?;
            while let Some(Ok(_)) = socket.next().await {}
            Ok::<(), Error>(())
        };
        // Close the connection even if the client does not answer.
        let _ = timeout(GOODBYE, goodbye).await;
    }
}

async fn converse(
    socket: &mut WebSocket,
    seat: &mut Seat,
    hub: &Hub,
    commands: &SyncSender<Command>,
) -> Option<SentAway> {
    let mut allowance = Allowance::new();
    let mut heard = Instant::now();
    let mut next_ping = heard + PING_EVERY;
    loop {
        let listens_from = allowance.from();
        tokio::select! {
            () = sleep_until(next_ping) => {
                next_ping = Instant::now() + PING_EVERY;
                if heard.elapsed() >= SILENCE {
                    return None;
                }
                let ping = socket.send(Message::Ping(Bytes::new()));
                if !matches!(timeout(PATIENCE, ping).await, Ok(Ok(()))) {
                    return None;
                }
            }
            next = seat.queue.recv() => {
                if seat.is_given_up.load(Ordering::Acquire) {
                    return Some(away(CloseCode::Again, "the client reads too slowly"));
                }
                let Some(outgoing) = next else {
                    return Some(away(CloseCode::Away, "palpate live has ended"));
                };
                let message = match outgoing {
                    Outgoing::Text(text) => Message::Text(text),
                    Outgoing::Samples(number, frame) => {
                        Message::Binary(frame.numbered(number).into())
                    }
                };
                match timeout(PATIENCE, socket.send(message)).await {
                    Ok(Ok(())) => {}
                    // The client has disconnected or does not respond.
                    Ok(Err(_)) | Err(_) => return None,
                }
            }
            said = async { sleep_until(listens_from).await; socket.next().await } => {
                allowance.take();
                heard = Instant::now();
                let text = match said? {
                    Ok(Message::Text(text)) if text.len() <= LONGEST => text,
                    Ok(Message::Text(_)) => return Some(too_long()),
                    Ok(Message::Binary(_)) => {
                        return Some(away(CloseCode::Unsupported, "binary messages are not allowed"));
                    }
                    Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => continue,
                    Ok(Message::Close(_)) => return None,
                    Err(error) => return wrong(&error),
                };
                let refused = match parse(&text) {
                    ClientMessage::Request(request) => commands
                        .try_send(Command::Request(seat.id, request))
                        .err()
                        .map(|_| ("", "too many requests at once; send this one again".to_owned())),
                    ClientMessage::Refused(about, text) => Some((about, text)),
                    ClientMessage::Unknown(why) => return Some(away(CloseCode::Invalid, why)),
                };
                if let Some((about, text)) = refused {
                    hub.tell(seat.id, ServerMessage::Refused { about, text: &text }.text());
                }
            }
        }
    }
}

fn away(code: CloseCode, reason: &'static str) -> SentAway {
    CloseFrame {
        code,
        reason: reason.into(),
    }
}

fn too_long() -> SentAway {
    away(CloseCode::Size, "a message may have at most 4096 bytes")
}

/// Returns the close frame for an unreadable message, if its sender is still connected.
fn wrong(error: &Error) -> Option<SentAway> {
    match error {
        Error::Capacity(_) => Some(too_long()),
        Error::Utf8(_) => Some(away(CloseCode::Invalid, "text must be UTF-8")),
        _ => None,
    }
}

/// Remaining message allowance of a client.
struct Allowance {
    left: f64,
    counted: Instant,
}

impl Allowance {
    fn new() -> Self {
        Self {
            left: AT_ONCE,
            counted: Instant::now(),
        }
    }

    fn take(&mut self) {
        let now = Instant::now();
        let earned = PER_SECOND * (now - self.counted).as_secs_f64();
        self.left = (self.left + earned).min(AT_ONCE) - 1.0;
        self.counted = now;
    }

    /// Returns the time at which the next message may be read.
    fn from(&self) -> Instant {
        if self.left >= 1.0 {
            self.counted
        } else {
            self.counted + Duration::from_secs_f64((1.0 - self.left) / PER_SECOND)
        }
    }
}

//! Events channel: a WebSocket on which only the service sends.

use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;

use serde_json::{Value, json};
use tungstenite::Message;

use super::{LOOK, lock};

/// Clients of the events channel.
#[derive(Debug, Default)]
pub(super) struct Audience(Mutex<Vec<Sender<String>>>);

impl Audience {
    /// Sends an event to every client.
    pub fn tell(&self, event: &Value) {
        let text = event.to_string();
        lock(&self.0).retain(|listener| listener.send(text.clone()).is_ok());
    }

    fn join(&self) -> Receiver<String> {
        let (sender, receiver) = channel();
        lock(&self.0).push(sender);
        receiver
    }
}

/// Returns an event in the service's format.
pub(super) fn event(name: &str, category: &str, level: &str, data: &Value) -> Value {
    json!({ "name": name, "category": category, "level": level, "data": data, "message": "" })
}

/// Accepts clients until `ended`.
pub(super) fn listen(listener: &TcpListener, audience: &Arc<Audience>, ended: &Arc<AtomicBool>) {
    let mut speakers = Vec::new();
    while !ended.load(Ordering::Acquire) {
        if let Ok((stream, _)) = listener.accept() {
            let (audience, ended) = (Arc::clone(audience), Arc::clone(ended));
            speakers.push(thread::spawn(move || speak(stream, &audience, &ended)));
        } else {
            thread::sleep(LOOK);
        }
    }
    for speaker in speakers {
        let _ = speaker.join();
    }
}

fn speak(stream: TcpStream, audience: &Audience, ended: &AtomicBool) {
    // Register before answering the handshake, so that a connected client misses no event.
    let events = audience.join();
    let ready = stream.set_nonblocking(false).is_ok()
        && stream
            .set_read_timeout(Some(std::time::Duration::from_secs(1)))
            .is_ok();
    let Some(mut socket) = ready.then(|| tungstenite::accept(stream).ok()).flatten() else {
        return;
    };
    while !ended.load(Ordering::Acquire) {
        match events.recv_timeout(LOOK) {
            Ok(text) => {
                if socket.send(Message::text(text)).is_err() {
                    return;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

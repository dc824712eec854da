//! The events channel: a WebSocket on which the service only speaks.

use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;

use serde_json::{Value, json};
use tungstenite::Message;

use super::{LOOK, lock};

/// Whoever listens.
#[derive(Debug, Default)]
pub(super) struct Audience(Mutex<Vec<Sender<String>>>);

impl Audience {
    /// Tells an event to everybody who listens.
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

/// An event as the service words it.
pub(super) fn event(name: &str, category: &str, level: &str, data: &Value) -> Value {
    json!({ "name": name, "category": category, "level": level, "data": data, "message": "" })
}

/// Takes listeners until `ended`.
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
    // Before the handshake is answered: whoever has connected misses nothing.
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

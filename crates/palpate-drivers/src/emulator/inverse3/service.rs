//! Connection to the emulated service.

use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use palpate_device::Vector;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use super::events::event;
use super::fault::Fault;
use super::{Received, Shared, frames, http, lock};
use crate::inverse3::Form;

/// Serves a client: an HTTP request, or a WebSocket until it closes.
pub(super) fn serve(mut stream: TcpStream, shared: &Arc<Shared>) {
    let patience = Some(Duration::from_secs(1));
    let prepared = stream.set_nonblocking(false).is_ok()
        && stream.set_read_timeout(patience).is_ok()
        && stream.set_write_timeout(patience).is_ok()
        && stream.set_nodelay(true).is_ok();
    let Some(head) = prepared.then(|| http::peek_head(&stream).ok()).flatten() else {
        return;
    };
    if !http::is_upgrade(&head) {
        let full = frames::full(&lock(&shared.state).devices, shared.form, 0);
        let _ = http::answer(&mut stream, &head, &full);
        return;
    }
    let Ok(socket) = tungstenite::accept(stream) else {
        return;
    };
    let session = {
        let mut state = lock(&shared.state);
        state.clients += 1;
        state.sessions += 1;
        state.sessions
    };
    Session {
        socket,
        session,
        held_back: None,
        shared,
    }
    .run();
    lock(&shared.state).clients -= 1;
}

struct Session<'a> {
    socket: WebSocket<TcpStream>,
    session: u64,
    /// A delayed reply.
    held_back: Option<String>,
    shared: &'a Shared,
}

impl Session<'_> {
    fn run(&mut self) {
        let full = {
            let mut state = lock(&self.shared.state);
            let now = Instant::now();
            state
                .devices
                .iter_mut()
                .for_each(|device| device.move_on(now));
            frames::full(&state.devices, self.shared.form, self.session).to_string()
        };
        if self.socket.send(Message::text(full)).is_err() {
            return;
        }
        let look = Some(super::LOOK);
        if self.socket.get_ref().set_read_timeout(look).is_err() {
            return;
        }
        while !self.shared.ended.load(Ordering::Acquire) {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    if !self.exchange(&text) {
                        return;
                    }
                }
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if is_a_pause(&error) => {}
                Err(_) => return,
            }
        }
    }

    /// Handles a message and answers it; returns whether the connection continues.
    fn exchange(&mut self, text: &str) -> bool {
        let (latency, fault) = {
            let mut state = lock(&self.shared.state);
            let latency = state.latency;
            (latency.draw(&mut state.random), state.faults.next())
        };
        pause(latency / 2);
        if let Some(Fault::Stall(duration)) = fault {
            thread::sleep(duration);
        }
        let reply = self.take(text);
        pause(latency / 2);
        self.answer(reply, fault)
    }

    /// Executes a message and returns the state frame.
    fn take(&mut self, text: &str) -> String {
        let now = Instant::now();
        let mut state = lock(&self.shared.state);
        let message: Value = match serde_json::from_str(text) {
            Ok(message) => message,
            Err(error) => {
                let data = json!({ "received_data": text.chars().take(200).collect::<String>() });
                let mut event = event("invalid-io-channel", "input", "error", &data);
                event["message"] = json!(error.to_string());
                self.shared.audience.tell(&event);
                Value::Null
            }
        };
        state.messages += 1;
        if message.pointer("/session/configure").is_some() {
            state.configured += 1;
        }
        let entries = message["inverse3"].as_array().cloned().unwrap_or_default();
        let mut received = Received {
            at: now,
            session: self.session,
            device_id: None,
            force: None,
        };
        for entry in entries {
            let id = entry["device_id"].as_str().unwrap_or("");
            received.device_id = Some(id.to_owned());
            let command = &entry["commands"]["set_cursor_force"];
            let force = self.force(command);
            received.force = force;
            let device = state
                .devices
                .iter_mut()
                .find(|device| device.present && device.id == id);
            match (device, force) {
                (Some(device), Some(force)) => device.command(force, now),
                (None, _) => self.invalid("device_id", "no such device", id),
                (Some(_), None) if command.is_null() => {}
                (Some(_), None) => {
                    self.invalid("set_cursor_force", "no force", &command.to_string());
                }
            }
        }
        state.remember(received);
        state
            .devices
            .iter_mut()
            .for_each(|device| device.move_on(now));
        let full = message
            .pointer("/session/force_render_full_state")
            .is_some();
        let render = if full { frames::full } else { frames::state };
        render(&state.devices, self.shared.form, self.session).to_string()
    }

    fn force(&self, command: &Value) -> Option<Vector> {
        let old = command.get("values");
        let vector = match self.shared.form {
            Form::V31 => old,
            Form::V35 => command.get("vector").or(old),
        }?;
        if command.get("execute").and_then(Value::as_bool) == Some(false) {
            return None;
        }
        Some([
            vector["x"].as_f64()?,
            vector["y"].as_f64()?,
            vector["z"].as_f64()?,
        ])
    }

    fn invalid(&self, field: &str, reason: &str, context: &str) {
        let data = json!({ "field": field, "reason": reason, "context": context });
        self.shared
            .audience
            .tell(&event("invalid-value", "input", "warning", &data));
    }

    fn answer(&mut self, reply: String, fault: Option<Fault>) -> bool {
        let half = |text: &str| {
            let mut middle = text.len() / 2;
            while !text.is_char_boundary(middle) {
                middle -= 1;
            }
            text[..middle].to_owned()
        };
        let mut replies: Vec<String> = self.held_back.take().into_iter().collect();
        match fault {
            None | Some(Fault::Stall(_)) => replies.push(reply),
            Some(Fault::Dropped) => {}
            Some(Fault::Twice) => replies.extend([reply.clone(), reply]),
            Some(Fault::Late) => self.held_back = Some(reply),
            Some(Fault::Garbage) => replies.push("\u{1}no JSON, {{{ [1e999".to_owned()),
            Some(Fault::HalfFrame) => replies.push(half(&reply)),
            Some(Fault::HalfBytes) => {
                let mut frame = vec![0x81, 126];
                let length = u16::try_from(reply.len()).unwrap_or(u16::MAX);
                frame.extend(length.to_be_bytes());
                frame.extend(half(&reply).bytes());
                let stream = self.socket.get_mut();
                let _ = stream.write_all(&frame);
                let _ = stream.shutdown(Shutdown::Both);
                return false;
            }
            Some(Fault::Disconnect) => {
                let _ = self.socket.get_ref().shutdown(Shutdown::Both);
                return false;
            }
            Some(Fault::Close) => {
                let _ = self.socket.close(None);
                let _ = self.socket.flush();
                return false;
            }
        }
        lock(&self.shared.state).replies += replies.len() as u64;
        replies
            .into_iter()
            .all(|reply| self.socket.send(Message::text(reply)).is_ok())
    }
}

fn pause(duration: Duration) {
    if !duration.is_zero() {
        thread::sleep(duration);
    }
}

/// Returns whether the error is only a timeout of the socket.
fn is_a_pause(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

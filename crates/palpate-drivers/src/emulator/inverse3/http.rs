//! HTTP answers of the service, limited to the requests of a connecting client.

use std::io::{self, Read, Write};
use std::net::TcpStream;

use serde_json::{Value, json};

/// Maximum length of a request head `[bytes]`.
const LONGEST_HEAD: usize = 8192;

/// Returns the head of the request in `stream` without consuming it.
///
/// # Errors
/// No head arrives within the stream's timeout, or it is too long or not text.
pub(super) fn peek_head(stream: &TcpStream) -> io::Result<String> {
    let mut buffer = vec![0; LONGEST_HEAD];
    let mut seen = 0;
    loop {
        let length = stream.peek(&mut buffer)?;
        let head = &buffer[..length];
        if let Some(end) = head.windows(4).position(|four| four == b"\r\n\r\n") {
            return String::from_utf8(head[..end].to_vec()).map_err(io::Error::other);
        }
        if length == 0 || length == LONGEST_HEAD {
            return Err(io::Error::other("no request"));
        }
        if length == seen {
            // Peeking does not wait for more bytes.
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        seen = length;
    }
}

/// Returns whether the request asks for a WebSocket.
pub(super) fn is_upgrade(head: &str) -> bool {
    head.lines().any(|line| {
        let line = line.to_ascii_lowercase();
        line.starts_with("upgrade:") && line.contains("websocket")
    })
}

/// Answers one request and closes; `devices` is the full frame.
pub(super) fn answer(stream: &mut TcpStream, head: &str, devices: &Value) -> io::Result<()> {
    let mut words = head.split_ascii_whitespace();
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let path = target.split('?').next().unwrap_or("");
    let (status, body) = match (method, path) {
        ("GET", "/version") => ("200 OK", version()),
        ("GET", "/devices") => ("200 OK", devices.clone()),
        ("GET", _) => ("404 Not Found", refused("not emulated")),
        _ => (
            "405 Method Not Allowed",
            refused("only GET /version and GET /devices are emulated"),
        ),
    };
    // Consume the peeked bytes: otherwise closing would reset the connection before the client reads the answer.
    let mut taken = vec![0; head.len() + 4];
    stream.read_exact(&mut taken)?;
    let body = body.to_string();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\
         Connection: close\r\n\r\n{body}",
        body.len(),
    )?;
    stream.flush()
}

fn version() -> Value {
    json!({
        "project_name": "palpate's emulator of the Inverse Service",
        "project_version": env!("CARGO_PKG_VERSION"),
        "build_time": "", "git_branch": "", "git_describe": "", "git_hash": "", "git_tag": "",
    })
}

fn refused(why: &str) -> Value {
    json!({ "ok": false, "error": why })
}

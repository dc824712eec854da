//! Who means no good, or cannot help it, harms neither the loop nor the others.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::common::{Client, PATIENCE, Play, Stage};
use tungstenite::Message;

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or("nothing")
}

#[test]
fn the_page_comes_with_what_keeps_it_safe() {
    let stage = Stage::new(Play::default());
    let answer = stage.get("/");
    assert_eq!(status(&answer), "200", "{answer}");
    let answer = answer.to_lowercase();
    for header in [
        "content-type: text/html; charset=utf-8",
        "cache-control: no-cache",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "frame-ancestors 'none'",
        "default-src 'self'",
    ] {
        assert!(answer.contains(header), "{header}\n{answer}");
    }
    let own = format!("connect-src 'self' ws://{}", stage.address);
    assert!(answer.contains(&own), "{answer}");
    assert_eq!(status(&stage.get("/../Cargo.toml")), "404");
    assert_eq!(status(&stage.get("/live")), "400");
    let address = stage.address;
    let post = format!("POST / HTTP/1.1\r\nHost: {address}\r\nContent-Length: 0\r\n\r\n");
    let refused = stage.ask(&post).to_lowercase();
    assert_eq!(status(&refused), "405");
    assert!(refused.contains("\r\nallow: get\r\n"), "{refused}");
}

/// A foreign page in the same browser, and a foreign name that resolves to this server.
#[test]
fn a_foreign_page_and_a_foreign_name_are_refused() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let open = |headers: &[(&'static str, &str)]| {
        Client::at(stage.address, "/live", headers).map(drop).err()
    };
    let port = stage.address.port();
    assert_eq!(open(&[("Origin", "http://evil.example")]), Some(403));
    assert_eq!(open(&[("Origin", "null")]), Some(403));
    let other_port = format!("http://127.0.0.1:{}", port ^ 1);
    assert_eq!(open(&[("Origin", &other_port)]), Some(403));
    let own = format!("http://127.0.0.1:{port}");
    assert_eq!(open(&[("Origin", &own)]), None);
    let rebound = format!("evil.example:{port}");
    let as_rebound = format!("http://{rebound}");
    assert_eq!(open(&[("Host", &rebound)]), Some(421));
    let both = [("Host", rebound.as_str()), ("Origin", &as_rebound)];
    assert_eq!(open(&both), Some(421));
    let named = format!("localhost:{port}");
    assert_eq!(open(&[("Host", &named)]), None);
    for path in ["/", "/style.css"] {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {rebound}\r\n\r\n");
        assert_eq!(status(&stage.ask(&request)), "421", "{path}");
    }
    assert_eq!(status(&stage.ask("GET / HTTP/1.0\r\n\r\n")), "421");
    witness.is_well();
}

#[test]
fn public_listener_rejects_requests_without_the_token() {
    let stage = Stage::new(Play {
        listen: "0.0.0.0:0",
        ..Play::default()
    });
    let token = stage.url.split("token=").nth(1).unwrap();
    let open = |query: &str| {
        Client::at(stage.address, &format!("/live{query}"), &[])
            .map(drop)
            .err()
    };
    let wrong: String = token
        .chars()
        .map(|digit| if digit == '0' { '1' } else { '0' })
        .collect();
    for query in [
        String::new(),
        "?token=".to_owned(),
        format!("?token={wrong}"),
        format!("?token={}", &token[..31]),
    ] {
        assert_eq!(open(&query), Some(401), "{query}");
        assert_eq!(status(&stage.get(&format!("/{query}"))), "401", "{query}");
    }
    let right = format!("?token={token}");
    assert_eq!(open(&right), None);
    assert_eq!(status(&stage.get(&format!("/{right}"))), "200");
    // The token does not open the door to a foreign page.
    let foreign = [("Origin", "http://evil.example")];
    let opened = Client::at(stage.address, &format!("/live{right}"), &foreign);
    assert_eq!(opened.map(drop).err(), Some(403));
}

#[test]
fn who_says_what_nobody_understands_is_sent_away_alone() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let long = format!(r#"{{"type":"restart","x":"{}"}}"#, "x".repeat(4096));
    for (message, code) in [
        (Message::text("{"), 1007),
        (Message::text("[1,2]"), 1007),
        (Message::text(r#"{"type":"shutdown"}"#), 1007),
        (Message::text("[".repeat(4000)), 1007),
        (Message::binary(vec![0, 1, 2]), 1003),
        (Message::text(long), 1009),
        (Message::text("x".repeat(9000)), 1009),
    ] {
        let mut client = stage.client();
        client.socket.send(message.clone()).unwrap();
        let goodbye = client.goodbye();
        let (messages, reason) = goodbye.unwrap_or_else(|| panic!("no goodbye for {code}"));
        assert_eq!(messages, code, "{reason}");
        assert!(!reason.is_empty());
    }
    // Exactly as long as a message may be.
    let mut client = stage.client();
    let padding = 4096 - r#"{"type":"rearm","lane":9}"#.len();
    client.say(&format!(
        r#"{{"type":"rearm",{}"lane":9}}"#,
        " ".repeat(padding)
    ));
    client.text("refused");
    witness.is_well();
}

#[test]
fn ten_megabytes_are_not_taken() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let mut client = stage.client();
    // Whether it can be written to its end depends on when it is sent away.
    let _ = client.socket.send(Message::text("x".repeat(10 << 20)));
    let messages = client.goodbye().map(|(code, _)| code);
    assert!(matches!(messages, None | Some(1009)), "{messages:?}");
    witness.until("status", |status| status["clients"] == 1);
    witness.is_well();
}

/// A thousand connections are two thousand descriptors here, where both ends are; many systems begin
/// with a limit of 1024 that a program may raise.
#[cfg(unix)]
fn allow_many_connections() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limit.maximum,
        ..limit
    };
    setrlimit(Resource::Nofile, raised).unwrap();
}

#[cfg(not(unix))]
fn allow_many_connections() {}

#[test]
fn a_thousand_connections_that_say_nothing_keep_nobody_out() {
    allow_many_connections();
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let mut idle = Vec::new();
    for number in 0..1000 {
        let mut stream = TcpStream::connect(stage.address).unwrap();
        if number % 2 == 0 {
            stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
        }
        idle.push(stream);
        if number % 100 == 99 {
            let begun = Instant::now();
            assert_eq!(status(&stage.get("/")), "200", "after {number}");
            let took = begun.elapsed();
            assert!(took < Duration::from_secs(2), "after {number}: {took:?}");
        }
    }
    witness.is_well();
    let mut late = stage.client();
    late.text("hello");
    late.is_well();
    // Most of them are already closed.
    let mut open = 0;
    for stream in &mut idle {
        stream.set_nonblocking(true).unwrap();
        let read = stream.read(&mut [0; 64]);
        open +=
            usize::from(read.is_err_and(|error| error.kind() == std::io::ErrorKind::WouldBlock));
    }
    assert!(open <= 128, "{open} are open");
}

#[test]
fn who_asks_a_byte_at_a_time_is_not_waited_for() {
    let stage = Stage::new(Play::default());
    let mut slow = TcpStream::connect(stage.address).unwrap();
    slow.set_read_timeout(Some(Duration::from_millis(200)))
        .unwrap();
    let begun = Instant::now();
    let request = format!("GET / HTTP/1.1\r\nHost: {}\r\nX: ", stage.address);
    slow.write_all(request.as_bytes()).unwrap();
    let closed = loop {
        if slow.write_all(b"x").is_err() {
            break true;
        }
        match slow.read(&mut [0; 512]) {
            // An answer that says so, or none.
            Ok(_) => break true,
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
            Err(_) => break true,
        }
        if begun.elapsed() > PATIENCE {
            break false;
        }
    };
    assert!(closed);
    assert!(begun.elapsed() < Duration::from_secs(15));
    assert_eq!(status(&stage.get("/")), "200");
}

#[test]
fn the_sixty_fifth_client_is_refused_until_one_goes() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let mut clients: Vec<Client> = (0..63).map(|_| stage.client()).collect();
    let opened = Client::at(stage.address, "/live", &[]);
    assert_eq!(opened.map(drop).err(), Some(503));
    clients.pop();
    witness.until("status", |status| status["clients"] == 63);
    let begun = Instant::now();
    while Client::at(stage.address, "/live", &[]).is_err() {
        assert!(begun.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(clients);
    witness.is_well();
}

/// The client receives fewer frames, then none, and is then disconnected; the others miss no frame.
#[test]
fn a_client_that_stops_reading_slows_nobody_and_is_dropped() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let stopped = stage.client();
    witness.until("status", |status| status["clients"] == 2);
    let mut last = witness.frame(|_| true).number;
    let begun = Instant::now();
    loop {
        match witness.next() {
            crate::common::Received::Samples(samples) => {
                assert_eq!(samples.number, last + 1, "the witness missed a frame");
                last = samples.number;
            }
            crate::common::Received::Text(text) if text["type"] == "status" => {
                assert_eq!(text["lanes"][0]["unsent"], 0);
                if text["clients"] == 1 {
                    break;
                }
            }
            crate::common::Received::Text(_) => {}
        }
        assert!(begun.elapsed() < 2 * PATIENCE, "it is still there");
    }
    drop(stopped);
    witness.is_well();
}

/// A client that sends without pause is processed at the rate limit, and the others as before.
#[test]
fn who_talks_without_end_is_listened_to_slowly() {
    let stage = Stage::new(Play::default());
    let mut witness = stage.client();
    let mut talker = stage.client();
    let begun = Instant::now();
    for _ in 0..600 {
        talker.say(r#"{"type":"rearm","lane":7}"#);
    }
    for _ in 0..600 {
        talker.text("refused");
    }
    // 200 at once, then 200 each second.
    let took = begun.elapsed();
    assert!(took > Duration::from_millis(1900), "{took:?}");
    witness.is_well();
}

/// Its connection stands, and takes what it is sent for minutes.
#[test]
fn frozen_client_releases_hand() {
    let stage = Stage::new(Play::default());
    let mut frozen = stage.client();
    frozen.say(r#"{"type":"hand","position_m":0.01}"#);
    let mut other = stage.client();
    other.until("state", |state| state["hand_m"] == 0.01);
    other.until("state", |state| state["hand_m"].is_null());
    other.until("status", |status| status["clients"] == 1);
    other.is_well();
    drop(frozen);
}

/// Restarts and recordings are rate-limited, and their messages disconnect no client.
#[test]
fn who_begins_recordings_and_restarts_without_end_is_refused_and_sends_nobody_away() {
    let stage = Stage::new(Play::default());
    let (mut busy, mut other) = (stage.client(), stage.client());
    for _ in 0..60 {
        busy.say(r#"{"type":"record","on":true}"#);
        busy.say(r#"{"type":"record","on":false}"#);
    }
    let refused = busy.text("refused");
    assert_eq!(refused["about"], "record", "{refused}");
    assert!(refused["text"].as_str().unwrap().contains("4 per second"));
    for _ in 0..30 {
        busy.say(r#"{"type":"restart"}"#);
    }
    let refused = busy.until("refused", |refused| refused["about"] == "restart");
    assert!(refused["text"].as_str().unwrap().contains("too frequent"));
    other.is_well();
    let files = std::fs::read_dir(stage.folder.path()).unwrap().count();
    assert!((8..40).contains(&files), "{files}");
}

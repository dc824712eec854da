//! Watchdog process at work: packets, times and endings.

#![cfg(unix)]
#![allow(clippy::print_stdout)] // tests show what they measured
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "the test is driver and board: it waits, and looks at the time"
)]

use std::io::{ErrorKind, Read, Write};
use std::net::UdpSocket;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use palpate_rt::watchdog::{Orders, Outcome, Unguarded, Watch, Watchdog, WatchdogAccount};

const RELEASE: &[u8] = b"release";
const PROBE: &[u8] = b"probe";
const ANSWER: &[u8] = b"answer";

/// A watchdog on a thread, its driver, and the board at its port.
struct Guarded {
    watchdog: Watchdog,
    account: Arc<WatchdogAccount>,
    board: UnixStream,
    watch: JoinHandle<Outcome>,
    /// Messages that the watchdog reads.
    words: UnixStream,
}

fn guarded(limit: Duration) -> Guarded {
    let (driver, socket) = UnixStream::pair().unwrap();
    let (board, port) = UnixStream::pair().unwrap();
    port.set_nonblocking(true).unwrap();
    board
        .set_read_timeout(Some(Duration::from_millis(50)))
        .unwrap();
    let orders = Orders {
        limit,
        release: RELEASE.to_vec(),
        probe: PROBE.to_vec(),
        answer: ANSWER.len(),
    };
    let words = socket.try_clone().unwrap();
    let watch = Watch::new(socket, OwnedFd::from(port), orders).unwrap();
    let account = Arc::new(WatchdogAccount::default());
    Guarded {
        words,
        watchdog: Watchdog::beside(driver, Arc::clone(&account)).unwrap(),
        account,
        board,
        watch: spawn(move || watch.run()),
    }
}

const LIMIT: Duration = Duration::from_millis(60);

/// Returns the bytes received by the board within `patience`, or all bytes if the stream ends before.
fn comes(board: &mut UnixStream, length: usize, patience: Duration) -> Vec<u8> {
    let begun = Instant::now();
    let mut all = Vec::new();
    let mut bytes = [0; 64];
    while all.len() < length && begun.elapsed() < patience {
        match board.read(&mut bytes) {
            Ok(0) => break,
            Ok(read) => all.extend(&bytes[..read]),
            Err(error) => assert!(
                matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
                "{error}"
            ),
        }
    }
    all
}

const LONG: Duration = Duration::from_secs(20);

#[test]
fn watchdog_zeroes_force_after_silence_and_notifies_driver() {
    let mut guarded = guarded(LIMIT);
    guarded.watchdog.force().unwrap();
    let spoken = Instant::now();
    let came = comes(&mut guarded.board, RELEASE.len(), LONG);
    println!("{:?} of a silence of {LIMIT:?}", spoken.elapsed());
    assert_eq!(came, RELEASE);
    assert!(spoken.elapsed() >= LIMIT.mul_f64(0.9));
    assert_eq!(guarded.watchdog.has_cut(), Ok(true));
    // The cut is reported once per silence of any length; the zero command is repeated.
    guarded.board.write_all(ANSWER).unwrap();
    assert_eq!(comes(&mut guarded.board, RELEASE.len(), LONG), RELEASE);
    assert_eq!(guarded.watchdog.has_cut(), Ok(false));
    assert_eq!(guarded.account.cuts(), 1);
    // The driver returns and closes in order.
    guarded.watchdog.none().unwrap();
    guarded.watchdog.dismiss();
    assert_eq!(guarded.watch.join().unwrap(), Outcome::Dismissed);
}

#[test]
fn a_driver_that_speaks_in_time_or_has_no_force_on_is_left_alone() {
    let mut guarded = guarded(Duration::from_secs(2));
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        guarded.watchdog.force().unwrap();
        sleep(Duration::from_millis(20));
    }
    guarded.watchdog.none().unwrap();
    sleep(Duration::from_secs(3));
    assert_eq!(guarded.watchdog.has_cut(), Ok(false));
    guarded.watchdog.dismiss();
    assert_eq!(guarded.watch.join().unwrap(), Outcome::Dismissed);
    assert_eq!(comes(&mut guarded.board, 1, LONG), b"");
}

/// The message buffer is limited. At 4 kHz it is full after 35 ms.
#[test]
fn a_watchdog_with_a_long_limit_listens_before_its_room_is_full() {
    let guarded = guarded(Duration::from_secs(3600));
    for _ in 0..20 {
        for _ in 0..100 {
            guarded.watchdog.force().unwrap();
        }
        let said = Instant::now();
        while rustix::io::ioctl_fionread(&guarded.words).unwrap() > 0 {
            assert!(said.elapsed() < LONG, "nobody listens");
            sleep(Duration::from_millis(1));
        }
    }
    guarded.watchdog.dismiss();
    assert_eq!(guarded.watch.join().unwrap(), Outcome::Dismissed);
}

#[test]
fn a_driver_that_is_gone_leaves_no_force_and_the_board_is_asked() {
    for was_on in [true, false] {
        // The release does not wait for the limit.
        let mut guarded = guarded(Duration::from_secs(3600));
        if was_on {
            guarded.watchdog.force().unwrap();
        }
        drop(guarded.watchdog);
        assert_eq!(comes(&mut guarded.board, RELEASE.len(), LONG), RELEASE);
        // Earlier bytes of the board arrive first.
        guarded.board.write_all(b"of the loop").unwrap();
        assert_eq!(comes(&mut guarded.board, PROBE.len(), LONG), PROBE);
        guarded.board.write_all(ANSWER).unwrap();
        let mut outcome = None;
        let mut watch = Some(guarded.watch);
        while outcome.is_none() {
            if watch.as_ref().is_some_and(JoinHandle::is_finished) {
                outcome = watch.take().map(|watch| watch.join().unwrap());
            }
            // A probe with a late answer is repeated.
            if !comes(&mut guarded.board, 1, Duration::from_millis(1)).is_empty() {
                guarded.board.write_all(ANSWER).unwrap();
            }
        }
        let expected = Outcome::Released {
            was_on,
            is_confirmed: true,
        };
        assert_eq!(outcome, Some(expected));
    }
}

#[test]
fn watchdog_reports_port_gone_after_port_disappears() {
    let guarded = guarded(LIMIT);
    guarded.watchdog.force().unwrap();
    drop(guarded.board);
    // The end of the watchdog tells a driver that does not notice the loss within the limit.
    sleep(3 * LIMIT);
    assert!(guarded.watchdog.none().is_ok());
    assert!(guarded.watchdog.force().is_ok());
    assert_eq!(guarded.watch.join().unwrap(), Outcome::PortGone);
    drop(guarded.words);
    assert_eq!(guarded.watchdog.force(), Err(Unguarded::Ended));
    assert_eq!(guarded.account.lost(), Some(Unguarded::Ended));
}

/// A microcontroller restarts: its system refuses a packet. The socket of the watchdog must outlive that.
#[test]
fn a_refused_packet_is_no_lost_port() {
    let board = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = board.local_addr().unwrap();
    let port = UdpSocket::bind("127.0.0.1:0").unwrap();
    port.connect(address).unwrap();
    port.set_nonblocking(true).unwrap();
    let (driver, socket) = UnixStream::pair().unwrap();
    let orders = Orders {
        limit: LIMIT,
        release: RELEASE.to_vec(),
        probe: PROBE.to_vec(),
        answer: ANSWER.len(),
    };
    let theirs = OwnedFd::from(port.try_clone().unwrap());
    let watch = Watch::new(socket, theirs, orders).unwrap();
    let watch = spawn(move || watch.run());
    let watchdog = Watchdog::beside(driver, Arc::default()).unwrap();
    drop(board);
    watchdog.force().unwrap();
    // The watchdog's packets are refused, and the driver's.
    let begun = Instant::now();
    while watchdog.has_cut() != Ok(true) {
        assert!(begun.elapsed() < LONG, "the watchdog does not guard");
        let _ = port.send(b"wrench");
        sleep(Duration::from_millis(1));
    }
    let board = UdpSocket::bind(address).unwrap();
    board.set_read_timeout(Some(LONG)).unwrap();
    let mut bytes = [0; 64];
    let length = board.recv(&mut bytes).unwrap();
    assert_eq!(&bytes[..length], RELEASE);
    // The next force is guarded, too.
    watchdog.force().unwrap();
    let length = board.recv(&mut bytes).unwrap();
    assert_eq!(&bytes[..length], RELEASE);
    watchdog.dismiss();
    assert_eq!(watch.join().unwrap(), Outcome::Dismissed);
}

#[test]
fn a_port_that_takes_nothing_gets_no_force_when_it_takes_some() {
    let (driver, socket) = UnixStream::pair().unwrap();
    let (mut board, mut port) = UnixStream::pair().unwrap();
    port.set_nonblocking(true).unwrap();
    let mut stuffed = 0;
    while let Ok(written) = port.write(&[b'x'; 4096]) {
        stuffed += written;
    }
    let orders = Orders {
        limit: Duration::from_millis(5),
        release: RELEASE.to_vec(),
        probe: PROBE.to_vec(),
        answer: ANSWER.len(),
    };
    let watch = Watch::new(socket, OwnedFd::from(port), orders).unwrap();
    let watch = spawn(move || watch.run());
    let watchdog = Watchdog::beside(driver, Arc::default()).unwrap();
    watchdog.force().unwrap();
    sleep(Duration::from_millis(100));
    board.set_read_timeout(Some(LONG)).unwrap();
    let mut all = vec![0; stuffed];
    board.read_exact(&mut all).unwrap();
    let mut release = vec![0; RELEASE.len()];
    board.read_exact(&mut release).unwrap();
    assert_eq!(release, RELEASE);
    watchdog.dismiss();
    assert_eq!(watch.join().unwrap(), Outcome::Dismissed);
}

#[test]
fn a_watchdog_that_is_gone_or_does_not_listen_is_noticed() {
    let (driver, socket) = UnixStream::pair().unwrap();
    let account = Arc::new(WatchdogAccount::default());
    let watchdog = Watchdog::beside(driver, Arc::clone(&account)).unwrap();
    assert_eq!(watchdog.has_cut(), Ok(false));
    let mut words = 0;
    while watchdog.force().is_ok() {
        words += 1;
        assert!(words < 1_000_000, "somebody listens");
    }
    println!("{words} words are not listened to before that is noticed");
    assert!(words > 20, "a watchdog may be late for a few periods");
    assert_eq!(account.lost(), Some(Unguarded::NotListening));
    assert_eq!(watchdog.force(), Err(Unguarded::NotListening));
    drop(socket);
    assert_eq!(watchdog.has_cut(), Err(Unguarded::Ended));
    assert_eq!(watchdog.force(), Err(Unguarded::Ended));
    // The first loss is kept.
    assert_eq!(account.lost(), Some(Unguarded::NotListening));
}

/// Starting fails if the program is missing or ends without a message.
#[test]
fn a_watchdog_that_cannot_be_started_is_an_error_that_says_so() {
    use std::os::fd::AsFd;
    let (port, _board) = UnixStream::pair().unwrap();
    let orders = Orders {
        limit: LIMIT,
        release: RELEASE.to_vec(),
        probe: PROBE.to_vec(),
        answer: ANSWER.len(),
    };
    for (program, words) in [
        ("/there/is/no/watchdog", "cannot be started"),
        ("true", "has started but does not answer"),
    ] {
        let account = Arc::new(WatchdogAccount::default());
        let command = std::process::Command::new(program);
        let error = Watchdog::start(command, port.as_fd(), &orders, account).unwrap_err();
        assert!(error.to_string().contains(words), "{program}: {error}");
    }
}

//! Transmission with a full port, and with two threads that send at the same time.

use super::*;
use crate::emulator::port::Pty;
use crate::two_diy::Generation;

/// Time limit for expected events on a busy machine.
const LIMIT: Duration = Duration::from_secs(30);

/// A line, and the board's end of its pseudo-terminal.
fn line() -> (Pty, Line) {
    let pty = Pty::open(None).unwrap();
    let serial = Serial::open(pty.path()).unwrap();
    let line = Line::new(serial, Generation::Three.layout()).unwrap();
    (pty, line)
}

/// Returns the torque on port 1 of each received packet; all packets must be complete.
fn packets(bytes: &[u8]) -> Vec<f32> {
    assert_eq!(bytes.len() % STATE_LENGTH, 0);
    let torque = |packet: &[u8]| {
        assert_eq!(packet[..2], [2, 5], "{packet:?}");
        f32::from_le_bytes([packet[2], packet[3], packet[4], packet[5]])
    };
    bytes.chunks(STATE_LENGTH).map(torque).collect()
}

/// Number of bytes that a Linux terminal buffers for its reader before the writer is blocked `[bytes]`.
const KEPT: u64 = 4095;

/// Sends until the port stays full. The kernel moves sent bytes to the reader with a delay, which makes space again.
/// The port is full for good when the reader's buffer is full and the port still refuses.
fn fill(pty: &Pty, line: &Line) {
    let begun = Instant::now();
    loop {
        let is_full = pty.arrived().unwrap() >= KEPT;
        let is_refused = line.command([0.1, 0.1]) == Err(Unsent::Full);
        if is_full && is_refused {
            return;
        }
        assert!(
            begun.elapsed() < LIMIT,
            "{} arrived",
            pty.arrived().unwrap()
        );
        if is_refused {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Reads packets from the line until they are complete and satisfy `enough`.
fn take(pty: &Pty, mut enough: impl FnMut(&[f32]) -> bool) -> Vec<f32> {
    let begun = Instant::now();
    let mut bytes = Vec::new();
    loop {
        pty.read(&mut bytes);
        if bytes.len() % STATE_LENGTH == 0 && enough(&packets(&bytes)) {
            return packets(&bytes);
        }
        assert!(begun.elapsed() < LIMIT, "{} bytes", bytes.len());
        pty.wait(Duration::from_millis(1));
    }
}

#[test]
fn a_port_that_takes_nothing_gets_no_force_as_soon_as_it_takes_some() {
    let (pty, line) = line();
    fill(&pty, &line);
    assert_eq!(line.command([0.1, 0.1]), Err(Unsent::Full));
    // No bytes are read before the cut returns: a cut that waited for space would never return.
    let (done, is_done) = std::sync::mpsc::channel();
    let cutter = line.cutter();
    std::thread::spawn(move || {
        cutter.cut();
        let _ = done.send(());
    });
    is_done.recv_timeout(LIMIT).expect("it waits for room");
    // A packet is counted after it is sent, so it may arrive before it is counted.
    take(&pty, |torques| {
        torques.last() == Some(&0.0) && torques.len() as u64 == line.requests()
    });
    // The repeated torque is now zero.
    line.ask().unwrap();
    assert_eq!(take(&pty, |torques| !torques.is_empty()), [0.0]);
}

#[test]
fn a_line_that_is_closed_while_its_port_is_full_waits_for_room() {
    let (pty, line) = line();
    fill(&pty, &line);
    line.cutter().cut();
    let closing = std::thread::spawn(move || drop(line));
    // Longer than any wait except the last try.
    std::thread::sleep(4 * WAIT);
    let torques = take(&pty, |torques| torques.last() == Some(&0.0));
    closing.join().unwrap();
    assert!(torques.len() > 1);
}

#[test]
fn a_line_that_is_closed_while_its_port_stays_full_gives_up_in_the_end() {
    let (pty, line) = line();
    fill(&pty, &line);
    line.cutter().cut();
    let begun = Instant::now();
    drop(line);
    assert!(begun.elapsed() >= LAST_TRY, "{:?}", begun.elapsed());
}

#[test]
fn packets_of_two_threads_stay_whole() {
    let (pty, line) = line();
    let ending = AtomicBool::new(false);
    let torques = std::thread::scope(|scope| {
        let cutter = line.cutter();
        scope.spawn(|| {
            while !ending.load(Ordering::Acquire) {
                let _ = line.command([0.1, 0.1]);
                let _ = line.ask();
            }
        });
        scope.spawn(|| {
            let cutter = cutter;
            while !ending.load(Ordering::Acquire) {
                cutter.cut();
            }
        });
        // Slow reading, so that the port is sometimes full.
        let mut torques = take(&pty, |torques| {
            std::thread::sleep(Duration::from_micros(300));
            torques.len() > 3000 && torques.contains(&0.1) && torques.contains(&0.0)
        });
        ending.store(true, Ordering::Release);
        // The threads may still send; reading their bytes lets them end.
        torques.extend(take(&pty, |_| true));
        torques
    });
    let mut count = torques.len() as u64;
    line.cutter().cut();
    let rest = take(&pty, |rest| {
        !line.cutter().is_wanted() && count + rest.len() as u64 == line.requests()
    });
    count += rest.len() as u64;
    assert_eq!(count, line.requests());
    assert_eq!(rest.last(), Some(&0.0));
}

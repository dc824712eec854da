//! The way out under a port that is full, and under two threads that send at once.

use super::*;
use crate::two_diy::Generation;
use palpate_haply_emulator::two_diy::Pty;

/// How long anything that has to happen may take on a busy machine.
const LIMIT: Duration = Duration::from_secs(30);

/// A line, and the board's end of its pseudo-terminal.
fn line() -> (Pty, Line) {
    let pty = Pty::open(None).unwrap();
    let serial = Serial::open(pty.path()).unwrap();
    let line = Line::new(serial, Generation::Three.layout()).unwrap();
    (pty, line)
}

/// Every packet that came, as its torque on port 1; none may be cut.
fn packets(bytes: &[u8]) -> Vec<f32> {
    assert_eq!(bytes.len() % STATE_LENGTH, 0);
    let torque = |packet: &[u8]| {
        assert_eq!(packet[..2], [2, 5], "{packet:?}");
        f32::from_le_bytes([packet[2], packet[3], packet[4], packet[5]])
    };
    bytes.chunks(STATE_LENGTH).map(torque).collect()
}

/// What a Linux terminal keeps for its reader before it takes no more from behind it `[bytes]`.
const KEPT: u64 = 4095;

/// Sends until the port stays full. The kernel moves what was sent on to the reader in its own time,
/// which makes room: the port is full for good when the reader's end is, and it still refuses.
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

/// Takes packets off the line until they are whole and satisfy `enough`.
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
    // Nobody makes room before the cut is back: if it waited for room, it would not come back.
    let (done, is_done) = std::sync::mpsc::channel();
    let cutter = line.cutter();
    std::thread::spawn(move || {
        cutter.cut();
        let _ = done.send(());
    });
    is_done.recv_timeout(LIMIT).expect("it waits for room");
    // A packet is counted after it has been sent, so it can be here before it counts.
    take(&pty, |torques| {
        torques.last() == Some(&0.0) && torques.len() as u64 == line.requests()
    });
    // What is repeated from now on is no force.
    line.ask().unwrap();
    assert_eq!(take(&pty, |torques| !torques.is_empty()), [0.0]);
}

#[test]
fn a_line_that_is_closed_while_its_port_is_full_waits_for_room() {
    let (pty, line) = line();
    fill(&pty, &line);
    line.cutter().cut();
    let closing = std::thread::spawn(move || drop(line));
    // Longer than anything but the last try waits.
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
        // Slowly, so that the port is full now and then.
        let mut torques = take(&pty, |torques| {
            std::thread::sleep(Duration::from_micros(300));
            torques.len() > 3000 && torques.contains(&0.1) && torques.contains(&0.0)
        });
        ending.store(true, Ordering::Release);
        // The threads may be at work yet: what they still send is read, so that they can end.
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

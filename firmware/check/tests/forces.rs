//! A microcontroller computes the forces of the desktop to the last bit: every tick of the committed trace, by both
//! methods, on a block and on a wall; from Rust, and from C through the firmware library.
#![allow(clippy::print_stdout)] // tests show what they measured

use palpate_firmware_check::qemu::{Time, cores};
use palpate_firmware_trace::{FAULTS, Seen, replay_all};

fn desktop() -> (String, [Seen; 4]) {
    let mut lines = String::new();
    let seen = replay_all(&mut lines).unwrap();
    (lines, seen)
}

#[test]
fn every_core_gives_the_forces_of_the_desktop_to_the_last_bit() {
    compared_with_the_desktop("replay");
}

#[test]
fn firmware_in_c_gives_the_forces_of_the_desktop_to_the_last_bit() {
    compared_with_the_desktop("replay-in-c");
}

fn compared_with_the_desktop(program: &str) {
    let (desktop, _) = desktop();
    for core in cores() {
        let board = core.run(program, Time::Free, &[]).unwrap();
        assert_eq!(board.lines().count(), 4 * 801, "{}", core.name);
        for (board, desktop) in board.lines().zip(desktop.lines()) {
            assert_eq!(board, desktop, "{}", core.name);
        }
        println!("{}: {} lines are equal", core.name, board.lines().count());
    }
}

#[test]
fn the_trace_leaves_no_phase_fault_or_limit_out() {
    let (_, seen) = desktop();
    for (name, seen) in ["hfcr block", "hfcr wall", "coupled block", "coupled wall"]
        .into_iter()
        .zip(seen)
    {
        println!("{name}: {seen:?}");
        let contact = seen.phases[1] + seen.phases[2] + seen.phases[3];
        assert!(contact >= 200, "{name}: {contact} ticks of contact");
        assert!(seen.phases.iter().all(|ticks| *ticks > 0), "{name}");
    }
    for (index, fault) in FAULTS.into_iter().enumerate() {
        assert!(seen.iter().any(|seen| seen.faults[index] > 0), "{fault:?}");
    }
    for (index, limit) in ["pull", "force", "slew", "guard"].into_iter().enumerate() {
        assert!(seen.iter().any(|seen| seen.limits[index] > 0), "{limit}");
    }
}

#[test]
fn the_committed_trace_is_the_recorded_one() {
    let committed = include_str!("../../trace/trace.csv");
    assert_eq!(
        committed,
        palpate_firmware_check::trace::recorded().unwrap()
    );
}

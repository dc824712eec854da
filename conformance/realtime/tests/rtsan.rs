//! RealtimeSanitizer finds no call that may block in a tick, and finds those put there.
//!
//! A finding ends the program with a report, so each misdeed has a program of its own.

use std::process::Command;

use palpate_conformance_realtime::misdeeds::Misdeed;
use palpate_conformance_realtime::rtsan::watched;
use palpate_conformance_realtime::situations::{MONOTONIC, STEPPED};

#[test]
fn a_tick_makes_no_call_that_may_block() {
    for (name, situation) in STEPPED.into_iter().chain(MONOTONIC) {
        println!("{name}");
        situation(&mut watched);
    }
}

/// Which call each misdeed is found by. What is not found is what docs/realtime.md says is not: a
/// lock that is free takes no call of the C library, and the sleep of `std` and that of the loop's
/// clock are calls that the sanitizer does not know.
#[test]
fn it_finds_what_the_documents_say_it_finds() {
    let found_by = |misdeed| match misdeed {
        Misdeed::Allocate | Misdeed::Print => Some("`malloc`"),
        Misdeed::LockHeld => Some("`syscall`"),
        Misdeed::Open => Some("`open64`"),
        Misdeed::Nothing | Misdeed::LockFree | Misdeed::Sleep | Misdeed::SleepRaw => None,
    };
    for misdeed in Misdeed::ALL {
        let run = Command::new(env!("CARGO_BIN_EXE_misdeed"))
            .arg(format!("{misdeed:?}"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        let first = said.lines().take(2).collect::<Vec<_>>().join(" ");
        println!("{misdeed:?}: {}: {first}", run.status);
        match found_by(misdeed) {
            None => assert!(run.status.success(), "{misdeed:?}: {said}"),
            Some(call) => {
                assert!(!run.status.success(), "{misdeed:?} is not found");
                assert!(first.contains("unsafe-library-call"), "{said}");
                assert!(first.contains(call), "{said}");
            }
        }
    }
}

//! RealtimeSanitizer finds no blocking call in a tick, and finds deliberate ones.
//!
//! A finding ends the program with a report, so each misdeed has a separate program.

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

/// The call by which each misdeed is detected. docs/realtime-design.md lists the undetected ones: a free lock makes no
/// call of the C library, and the sanitizer does not intercept the sleep calls of `std` and of the loop's clock.
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

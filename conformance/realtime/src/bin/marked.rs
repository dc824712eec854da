//! Makes a unique system call before and after each tick, for strace.
//!
//! ```text
//! marked stepped|monotonic|MISDEED
//! ```

use palpate_conformance_realtime::misdeeds::commit;
use palpate_conformance_realtime::situations::{MONOTONIC, STEPPED, Situation};

fn watched(tick: &mut dyn FnMut()) {
    let mark = || {
        let _ = rustix::process::getppid();
    };
    mark();
    tick();
    mark();
}

fn all(situations: &[Situation]) {
    for (_, situation) in situations {
        situation(&mut watched);
    }
}

fn main() {
    let what = std::env::args().nth(1).expect("what is to be marked?");
    match what.as_str() {
        "stepped" => all(&STEPPED),
        "monotonic" => all(&MONOTONIC),
        misdeed => commit(misdeed.parse().unwrap(), &mut watched),
    }
}

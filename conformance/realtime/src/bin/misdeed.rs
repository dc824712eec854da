//! Commits one misdeed in its ticks, monitored by RealtimeSanitizer.

use palpate_conformance_realtime::misdeeds::commit;
use palpate_conformance_realtime::rtsan::watched;

fn main() {
    let name = std::env::args().nth(1).expect("which misdeed?");
    commit(name.parse().unwrap(), &mut watched);
    println!("the program has ended as if nothing were wrong");
}

//! A committed recording: `palpate run experiments/experiment1.toml --record experiment1.mcap --duration 1.5 --fast`,
//! and the output of `palpate convert`.

use crate::common::{Folder, parse};

const RECORDING: &[u8] = include_bytes!("recordings/experiment1.mcap");
const TABLE: &str = include_str!("recordings/experiment1.csv");

#[test]
fn its_table_is_what_it_was_byte_for_byte() {
    let folder = Folder::new();
    folder.write("experiment1.mcap", RECORDING);
    folder.succeed("convert experiment1.mcap");
    assert!(folder.read("experiment1.csv") == TABLE);
    let info = parse(&folder.succeed("info experiment1.mcap --json"));
    assert_eq!(
        (&info["complete"], &info["ticks"]),
        (&true.into(), &75.into())
    );
}

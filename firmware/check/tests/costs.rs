//! Bounds of the cost of a tick.
#![allow(clippy::print_stdout)] // tests show what they measured

use palpate_firmware_check::counted::{code_size, counted};
use palpate_firmware_check::qemu::{Core, M3, cores};

/// Cycles per period at 4 kHz of a core with 168 MHz.
const CYCLES: u32 = 42_000;

/// Returns the cores with a floating-point unit.
fn with_a_unit() -> Vec<Core> {
    let cores: Vec<Core> = cores().into_iter().filter(|core| *core != M3).collect();
    assert!(!cores.is_empty());
    cores
}

#[test]
fn coupled_rendering_at_4_khz_leaves_a_third_of_the_time_of_a_168_mhz_m4f() {
    for core in with_a_unit() {
        for ticks in counted(core, "count").unwrap() {
            println!("{}: {ticks:?}", core.name);
            assert!(ticks.largest < CYCLES * 2 / 3, "{}: {ticks:?}", core.name);
            assert!(ticks.median > 100 && ticks.stack < 4096, "{ticks:?}");
        }
    }
}

#[test]
fn a_tick_from_firmware_in_c_costs_little_more() {
    for core in with_a_unit() {
        let from_rust = counted(core, "count").unwrap();
        let from_c = counted(core, "count-in-c").unwrap();
        assert_eq!(from_c.len(), 4);
        for (in_c, in_rust) in from_c.into_iter().zip(from_rust) {
            println!("{}: {in_c:?}, from Rust {}", core.name, in_rust.median);
            assert_eq!(in_c.name, in_rust.name);
            assert!(in_c.largest < CYCLES * 2 / 3, "{in_c:?}");
            let more = in_c.median.saturating_sub(in_rust.median);
            assert!(more < 400, "{}: {more} instructions more", in_c.name);
        }
    }
}

#[test]
fn a_method_is_less_than_64_kib_of_code() {
    for core in cores() {
        let nothing = code_size(core, "size").unwrap();
        for method in ["hfcr", "coupled"] {
            let code = code_size(core, &format!("size-{method}")).unwrap() - nothing;
            println!("{}, {method}: {code} bytes", core.name);
            assert!((2_000..65_536).contains(&code), "{}: {code}", core.name);
        }
    }
}

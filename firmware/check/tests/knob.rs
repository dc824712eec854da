//! The knob on its board, against its emulated motor and hand, on a Cortex-M4F.
#![allow(clippy::print_stdout)] // tests show what they measured

use palpate_firmware_check::qemu::{M3, M4F, cores};
use palpate_firmware_check::ran::{Entry, Phases, Ran, Scene, ran, status};

const PERIOD: f64 = 0.000_25;

fn run(scene: Scene) -> Ran {
    run_in(scene, Phases::default())
}

fn run_in(scene: Scene, phases: Phases) -> Ran {
    let ran = ran(M4F, scene, phases).unwrap();
    assert_eq!(ran.entries.len(), 4800);
    assert_eq!(ran.overruns, 0);
    ran
}

/// Checks the continuity of the force: no step exceeds the largest step of the wall in normal operation, 1.5 N here,
/// except for a drop to 0.
fn has_no_jump<'a>(entries: impl Iterator<Item = &'a Entry>) {
    let mut before = None;
    for entry in entries {
        let step = (entry.motor - before.unwrap_or(entry.motor)).abs();
        assert!(step < 1.5 || entry.motor == 0.0, "{step} N at {entry:?}");
        before = Some(entry.motor);
    }
}

/// Kinetic energy plus the potential energy of the constant force of 1 N, relative to the wall [J].
fn energy(entry: &Entry) -> f64 {
    0.5 * 0.05 * entry.velocity.powi(2) - entry.position
}

/// Largest energy of the free rim, relative to its initial energy.
fn energy_growth(ran: &Ran) -> f64 {
    let first = energy(&ran.entries[0]);
    let free = ran.entries.iter().filter(|entry| entry.position < 0.0);
    free.map(energy).fold(0.0, f64::max) / first
}

#[test]
fn the_wall_is_felt_at_4_khz_and_energy_does_not_grow() {
    let coupled = run(Scene::Wall);
    assert_eq!(coupled.ticks, 4800);
    let rebounds = coupled.rebounds();
    let growth = energy_growth(&coupled);
    let longest = 1e6 * coupled.longest;
    println!("rebounds {rebounds:?}, energy {growth:.4} of the first, longest tick {longest} us");
    assert!(rebounds.len() > 15);
    let deepest = coupled.entries.iter().map(|entry| entry.position);
    let deepest = deepest.fold(0.0, f64::max);
    // v sqrt(m / K) = 1.41 mm for a wall without error.
    assert!((0.0013..0.0017).contains(&deepest), "{deepest}");
    assert!(growth < 1.05, "{growth}");
    // Control: without energy-consistent rendering the rim rebounds ever faster.
    let basic = energy_growth(&run(Scene::WallByBasic));
    println!("energy of the plain spring: {basic:.1} of the first");
    assert!(basic > 5.0, "{basic}");
    // HFCR assumes a force that acts at once; here it acts a period later.
    let hfcr = energy_growth(&run(Scene::WallByHfcr));
    println!("energy of HFCR: {hfcr:.1} of the first");
    assert!(hfcr > 2.0, "{hfcr}");
}

#[test]
fn the_same_run_gives_the_same_bits_and_an_m7_the_same_wall() {
    let once = run(Scene::Wall);
    // The M4F again, and an M7 if selected. An M3 is too slow for this loop.
    let with_a_unit = cores().into_iter().filter(|core| *core != M3);
    let again: Vec<Ran> = with_a_unit
        .map(|core| ran(core, Scene::Wall, Phases::default()).unwrap())
        .collect();
    assert!(!again.is_empty());
    for again in again {
        assert_eq!(once.entries, again.entries);
    }
}

#[test]
fn a_silent_host_does_not_stop_a_loop_that_needs_none() {
    let ran = run(Scene::SilentHost);
    let felt = ran.between(0.4, 0.8).filter(|entry| entry.motor < -2.0);
    assert!(felt.count() > 100);
    assert!(
        ran.between(0.06, 1.2)
            .all(|entry| entry.status == status::RENDERING)
    );
    has_no_jump(ran.entries.iter());
}

#[test]
fn a_silent_host_lets_the_knob_go_where_that_is_configured() {
    let ran = run(Scene::SilentHostLetsGo);
    assert!(ran.between(0.1, 0.4).any(|entry| entry.motor < -2.0));
    // The host sends messages every 4 ms until 0.4 s, and is missed after 20 ms.
    assert!(
        ran.between(0.4, 0.411)
            .all(|entry| entry.status == status::RENDERING)
    );
    let gone: Vec<_> = ran.between(0.4205, 0.8).collect();
    assert!(gone.iter().all(|entry| entry.motor == 0.0));
    assert!(gone.iter().all(|entry| entry.status == status::HOST_SILENT));
    // The host has returned, and so has the wall.
    assert!(ran.between(0.8, 1.2).any(|entry| entry.motor < -2.0));
    has_no_jump(ran.entries.iter());
}

/// Checks a loop that stalls in the wall: the force is off `within` [s], the chip restarts, and the wall returns once
/// the rim has been outside.
///
/// The bound has to hold for every compiler, and code of different length shifts the interrupts relative to each other.
/// Therefore several phases between world, loop and supervisor are tested.
fn is_safe_when_stalled(scene: Scene, within: f64) {
    // Counts of 25 MHz: a period of the loop has 6250, one of the supervisor 12500.
    for (of_loop, of_supervisor) in [(0, 0), (1500, 1400), (4000, 6200), (6000, 5500)] {
        let phases = Phases {
            of_loop,
            of_supervisor,
        };
        is_safe_when_stalled_in(scene, phases, within);
    }
}

fn is_safe_when_stalled_in(scene: Scene, phases: Phases, within: f64) {
    let ran = run_in(scene, phases);
    let event = ran.event.expect("the loop stalls");
    let before = ran.between(event - 0.01, event).last().unwrap();
    assert!(before.motor < -1.5, "{before:?}");
    let off = ran.off_after(event).unwrap();
    println!(
        "{scene:?}, {phases:?}: force off after {:.2} ms",
        1e3 * (off - event)
    );
    // The event stalls the next tick of the loop, up to a period later, and an entry is written once per period.
    let largest = within + 2.0 * PERIOD;
    assert!(off - event <= largest, "{phases:?}: {}", off - event);
    let restart = ran.entries.iter().find(|entry| entry.starts == 2).unwrap();
    assert!(restart.time - event < 0.01, "{restart:?}");
    let inside = ran
        .between(off, 1.2)
        .take_while(|entry| entry.position > 0.0);
    let mut entries = 0;
    for entry in inside {
        assert_eq!(entry.motor, 0.0, "{entry:?}");
        entries += 1;
    }
    assert!(
        entries > 100,
        "the hand was in the wall for {entries} entries"
    );
    assert!(ran.between(0.6, 1.2).any(|entry| entry.motor < -2.0));
    assert_eq!(ran.entries.last().unwrap().starts, 2);
    has_no_jump(ran.entries.iter());
}

#[test]
fn a_stalled_loop_has_no_force_after_a_millisecond() {
    // The supervisor checks every 0.5 ms, and detects the stall by the second tick.
    is_safe_when_stalled(Scene::Stall, 0.001);
}

#[test]
fn a_loop_that_holds_up_its_supervisor_has_no_force_after_the_watchdog() {
    is_safe_when_stalled(Scene::StallOfAll, 0.002);
}

#[test]
fn a_sensor_that_jumps_has_no_force_at_the_next_tick_and_none_that_jumps_later() {
    let ran = run(Scene::Glitch);
    let event = ran.event.expect("the sensor jumps");
    let before = ran.between(event - 0.01, event).last().unwrap();
    assert!(before.motor < -1.5, "{before:?}");
    let off = ran.off_after(event).unwrap();
    assert!(off - event <= 3.0 * PERIOD, "{}", off - event);
    let inside = ran
        .between(off, 1.2)
        .take_while(|entry| entry.position > 0.0);
    assert!(inside.into_iter().all(|entry| entry.motor == 0.0));
    // 3000 counts are 15 mm: 75 N of this wall.
    has_no_jump(ran.entries.iter());
    assert!(ran.between(0.6, 1.2).any(|entry| entry.motor < -2.0));
    assert_eq!(ran.entries.last().unwrap().starts, 1);
}

#[test]
fn a_board_that_starts_inside_the_wall_pushes_nobody_out() {
    let ran = run(Scene::StartInside);
    assert!(ran.entries[0].position > 0.001);
    let inside = ran.entries.iter().take_while(|entry| entry.position > 0.0);
    assert!(inside.clone().all(|entry| entry.motor == 0.0));
    assert!(inside.count() > 50);
    assert!(ran.between(0.2, 1.2).any(|entry| entry.motor < -2.0));
    has_no_jump(ran.entries.iter());
}

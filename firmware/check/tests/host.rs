//! The knob on its board, with a wall that a host renders at 100 to 1000 Hz, on a Cortex-M4F.
#![allow(clippy::print_stdout)] // tests show what they measured

use palpate_firmware_check::qemu::M4F;
use palpate_firmware_check::ran::{Entry, HOST_TICKS, Phases, Ran, Scene, ran_by_host};

const PERIOD: f64 = 0.000_25;
const MASS: f64 = 0.05;
/// K T^2/m of the host's wall.
const KAPPA: f64 = 0.2;
/// Force of a count of duty [N].
const DUTY: f64 = 0.02;
fn run(scene: Scene, ticks: u32) -> Ran {
    let ran = ran_by_host(M4F, scene, Phases::default(), ticks).unwrap();
    assert_eq!((ran.entries.len(), ran.overruns), (4800, 0));
    ran
}

/// Returns the stiffness of the host's wall [N/m].
fn stiffness(ticks: u32) -> f64 {
    let period = f64::from(ticks) * PERIOD;
    KAPPA * MASS / (period * period)
}

/// Mean force of the motor in each period of the loop from `first` on [N], from the momentum of the rim.
fn felt(entries: &[Entry]) -> Vec<f64> {
    let pairs = entries.windows(2);
    pairs
        .map(|pair| MASS * (pair[1].velocity - pair[0].velocity) / PERIOD - 1.0)
        .collect()
}

/// Mean force of the wall in continuous time in each of these periods [N], up to the end of collision `collisions`.
fn ideal(start: &Entry, stiffness: f64, collisions: usize) -> Vec<f64> {
    const STEPS: u32 = 500;
    let dt = PERIOD / f64::from(STEPS);
    let (mut position, mut velocity) = (start.position, start.velocity);
    let (mut means, mut over, mut was_in) = (Vec::new(), 0, false);
    while over < collisions {
        let before = velocity;
        for _ in 0..STEPS {
            // Leapfrog.
            position += 0.5 * dt * velocity;
            velocity += dt * (1.0 - stiffness * position.max(0.0)) / MASS;
            position += 0.5 * dt * velocity;
        }
        means.push(MASS * (velocity - before) / PERIOD - 1.0);
        over += usize::from(was_in && position <= 0.0);
        was_in = position > 0.0;
    }
    means
}

/// Force rendering error of the means over the periods of the loop, of one collision [%]: the median of five collisions
/// after the third rebound. A host of 100 Hz has three samples from the begin of the hand's force to the first one.
fn error(ran: &Ran, ticks: u32) -> f64 {
    let pairs = ran.entries.windows(2).enumerate();
    let rebounds = pairs.filter(|(_, pair)| pair[0].position > 0.0 && pair[1].position <= 0.0);
    let places = rebounds.map(|(place, _)| place + 2).skip(2).take(5);
    let mut errors: Vec<f64> = places
        .map(|first| {
            let ideal = ideal(&ran.entries[first], stiffness(ticks), 1);
            let felt = felt(&ran.entries[first..]);
            let square = |values: &mut dyn Iterator<Item = f64>| {
                values.map(|value| value * value).sum::<f64>()
            };
            let off = square(&mut felt.iter().zip(&ideal).map(|(felt, ideal)| felt - ideal));
            100.0 * (off / square(&mut ideal.iter().copied())).sqrt()
        })
        .collect();
    println!("{errors:.1?}");
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

/// Whether these three forces are of a line, up to the quantum of the duty.
fn are_straight(forces: [f64; 3]) -> bool {
    (forces[0] - 2.0 * forces[1] + forces[2]).abs() <= 2.0 * DUTY
}

#[test]
fn a_board_holds_lines_of_hosts_from_100_to_1000_hz() {
    let mut errors = Vec::new();
    for ticks in [40, 16, 8, 4] {
        let [constant, line] = [Scene::HostConstants, Scene::HostLines].map(|scene| {
            let ran = run(scene, ticks);
            assert!(ran.rebounds().len() >= 3);
            error(&ran, ticks)
        });
        println!(
            "host of {} Hz: FRE {constant:.1} % with constants, {line:.1} % with lines",
            4000 / ticks
        );
        errors.push([constant, line]);
    }
    for [constant, line] in errors {
        assert!(line < 0.5 * constant, "{line} {constant}");
    }
}

#[test]
fn forces_between_two_samples_of_the_host_are_straight() {
    let ran = run(Scene::HostLines, HOST_TICKS);
    let entries: Vec<&Entry> = ran.between(0.12, 0.6).collect();
    // The begin of a line differs from the end of the last one; every other change is that of a line.
    let (mut straight, mut sloped, mut begins) = (0, 0, vec![0; HOST_TICKS as usize]);
    for (place, three) in entries.windows(3).enumerate() {
        let forces = [0, 1, 2].map(|at| three[at].motor);
        if are_straight(forces) {
            straight += 1;
            sloped += u32::from((forces[1] - forces[0]).abs() > 2.0 * DUTY);
        } else {
            begins[place % HOST_TICKS as usize] += 1;
        }
    }
    println!(
        "{straight} straight, {sloped} sloped, breaks by tick of the host's period {begins:?}"
    );
    assert!(sloped > 100);
    // Two windows of three touch the begin of a line.
    assert!(
        begins.iter().filter(|breaks| **breaks > 0).count() <= 2,
        "{begins:?}"
    );
}

#[test]
fn a_late_line_leaves_the_end_of_the_last_one() {
    let ran = run(Scene::HostLineLate, HOST_TICKS);
    let event = ran.event.expect("a line comes late");
    let period = f64::from(HOST_TICKS) * PERIOD;
    let entries: Vec<&Entry> = ran.between(event, event + 4.0 * period).collect();
    let mut longest: &[&Entry] = &[];
    for same in entries.chunk_by(|a, b| a.motor == b.motor) {
        if same[0].motor < -1.0 && same.len() > longest.len() {
            longest = same;
        }
    }
    let ticks = longest.len();
    println!(
        "{} N held for {ticks} ticks, {:.2} ms after the event",
        longest[0].motor,
        1e3 * (longest[0].time - event)
    );
    // The message of one period is missing, and that of the next one; the line that comes a period and a half late
    // begins in the middle of its place.
    assert!(
        ticks >= HOST_TICKS as usize && ticks <= 2 * HOST_TICKS as usize,
        "{ticks}"
    );
    // A line that ran on would have changed by as much as in its own period.
    let before: Vec<&Entry> = ran
        .between(longest[0].time - period, longest[0].time)
        .collect();
    let change = (longest[0].motor - before[1].motor).abs();
    assert!(change > 0.2, "{change}");
    assert_eq!(ran.entries.last().unwrap().starts, 1);
}

#[test]
fn a_silent_host_has_no_force_after_20_ms_and_returns_softly() {
    let ran = run(Scene::HostLinesSilent, HOST_TICKS);
    assert!(ran.between(0.1, 0.4).any(|entry| entry.motor < -1.0));
    let gone = 0.4 + 2.0 * f64::from(HOST_TICKS) * PERIOD + 0.021;
    assert!(ran.between(gone, 0.8).all(|entry| entry.motor == 0.0));
    let mut before = 0.0;
    for entry in ran.between(0.8, 0.84) {
        // A soft start of 50 ms to at most 20 N.
        assert!(entry.motor.abs() <= 20.0 * (entry.time - 0.8 + 0.001) / 0.05 + DUTY);
        before = entry.motor;
    }
    assert!(before.is_finite());
}

//! Messages of a page and their effects, without a browser.

use palpate_live::rows::columns;
use palpate_wasm::{Playground, Space};

const LIVE: &str = include_str!("../../../experiments/live.toml");
const PINCH: &str = include_str!("../../../experiments/worlds/pinch.toml");

/// Returns the values of a column of a frame of samples.
fn column(frame: &[u8], name: &str) -> Vec<f32> {
    let rows = u32::from_le_bytes(frame[4..8].try_into().unwrap()) as usize;
    let column = columns().position(|column| column.name == name).unwrap();
    let float = |index: usize| {
        let at = 24 + 4 * index;
        f32::from_le_bytes(frame[at..at + 4].try_into().unwrap())
    };
    (0..rows)
        .map(|row| float(rows * (1 + column) + row))
        .collect()
}

#[test]
fn a_light_cube_at_50_hz_is_given_energy_by_the_plain_spring_only() {
    let mut playground = Playground::open(LIVE).unwrap();
    let set = r#"{"type":"set","mass_kg":0.05,"virtual_force_n":-0.4905,"stiffness_n_per_m":200,"period_s":0.02,
        "lanes":[{"method":"basic"},{"method":"coupled"}]}"#;
    playground.hear(set).unwrap();
    playground.hear(r#"{"type":"restart"}"#).unwrap();
    assert_eq!(playground.advance(5.0), 2 * 251);
    let created = [0, 1].map(|lane| {
        let frame = playground.frame(lane).unwrap();
        *column(&frame, "leak_held_j").last().unwrap()
    });
    assert!(created[0] > 0.05 && created[1] < 1e-3, "{created:?}");
    assert!(playground.frame(0).is_none(), "a row is given once");
}

#[test]
fn one_call_makes_so_many_ticks_and_the_next_one_goes_on() {
    let mut playground = Playground::open(LIVE).unwrap();
    playground
        .hear(r#"{"type":"set","period_s":0.001}"#)
        .unwrap();
    let made = playground.advance(1e6);
    assert!((2..=10_000).contains(&made), "{made}");
    assert!(playground.time() < 10.0);
    let before = playground.time();
    playground.advance(1e6);
    assert!(playground.time() > before);
}

#[test]
fn whatever_the_hand_does_the_force_has_its_limit_and_is_a_number() {
    let mut playground = Playground::open(LIVE).unwrap();
    playground
        .hear(r#"{"type":"set","mass_kg":null,"stiffness_n_per_m":10000,"period_s":0.02}"#)
        .unwrap();
    for step in 1..200 {
        // Below the speed that the safety layer takes for a sensor fault: the wall is at 30 mm.
        let to = if step % 2 == 0 { 0.0 } else { 0.08 };
        playground
            .hear(&format!(r#"{{"type":"hand","position_m":{to}}}"#))
            .unwrap();
        playground.advance(0.1 * f64::from(step));
    }
    for lane in [0, 1] {
        let frame = playground.frame(lane).unwrap();
        let forces = column(&frame, "force_on_device_n");
        assert!(forces.len() > 900);
        assert!(forces.iter().all(|force| force.abs() <= 20.0));
        assert!(forces.iter().any(|force| force.abs() > 1.0));
    }
}

#[test]
fn what_is_refused_changes_nothing_and_says_what_is_allowed() {
    let mut playground = Playground::open(LIVE).unwrap();
    let before = playground.state();
    for (message, about, words) in [
        (
            r#"{"type":"hand","position_m":2}"#,
            "hand",
            "allowed: -1 to 1",
        ),
        (
            r#"{"type":"set","mass_kg":0}"#,
            "set",
            "allowed: 0.005 to 5",
        ),
        (
            r#"{"type":"device","mass_kg":0,"delay_s":0,"cut_off":false}"#,
            "device",
            "allowed: 0.01 to 5",
        ),
        (
            r#"{"type":"device","mass_kg":1,"delay_s":0.05,"cut_off":false}"#,
            "device",
            "allowed: 0 to 0.02",
        ),
        (
            r#"{"type":"device","mass_kg":1,"delay_s":0,"colour":1}"#,
            "device",
            "colour",
        ),
        (
            r#"{"type":"record","on":true}"#,
            "record",
            "records nothing",
        ),
        (r#"{"type":"rearm","lane":7}"#, "rearm", "allowed: 0 to 1"),
        (r#"{"type":"nonsense"}"#, "unknown", "unknown type; allowed"),
        ("{", "unknown", "JSON"),
    ] {
        let refused = playground.hear(message).unwrap_err();
        assert_eq!(refused.about, about, "{message}");
        assert!(refused.why.contains(words), "{message}: {}", refused.why);
        assert_eq!(playground.state(), before, "{message}");
    }
}

#[test]
fn a_fault_in_a_scene_is_said_with_its_line() {
    let Err(error) = Playground::open(&LIVE.replace("mass_kg = 0.1", "mass_kg = -1")) else {
        panic!("a mass below 0 was taken");
    };
    assert!(error.starts_with("scene:21:"), "{error}");
    assert!(error.contains("mass_kg"), "{error}");
}

#[test]
fn a_hand_leads_a_tool_of_a_world_as_far_as_it_is_let() {
    let mut space = Space::open(PINCH, &["basic", "coupled"]).unwrap();
    space.lead(0, [-0.015, 0.0005, 0.016]).unwrap();
    space.advance(0.4);
    let now = space.now();
    assert!(
        now.contains(r#""refused":0"#) && !now.contains("null"),
        "{now}"
    );
    for (device, to, words) in [
        (2, [0.0; 3], "allowed: 0 to 1"),
        (0, [f64::NAN, 0.0, 0.0], "x is NaN m; allowed:"),
        (0, [0.0, 0.0, 9.0], "z is 9 m; allowed:"),
    ] {
        let error = space.lead(device, to).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_world_that_this_hand_cannot_lead_is_refused() {
    let refused = |source: &str, methods: &[&str]| match Space::open(source, methods) {
        Ok(_) => panic!("taken"),
        Err(error) => error,
    };
    for (key, words) in [
        ("delay_s = 0.002", "without delay, lag, jitter and drops"),
        ("jitter_s = 0.0002", "without delay, lag, jitter and drops"),
        ("hold = \"line\"", "loop.hold is \"line\""),
    ] {
        let other = PINCH.replace("period_s = 0.001", &format!("period_s = 0.001\n{key}"));
        let error = refused(&other, &["coupled"]);
        assert!(error.contains(words), "{error}");
    }
    assert!(refused(PINCH, &["nothing"]).contains("basic"));
    assert!(refused(PINCH, &["basic"; 3]).contains("1 or 2"));
    assert!(refused("format = 2", &["basic"]).contains("missing"));
}

//! Messages to the service.

use palpate_drivers::inverse3::{Commands, Form};
use serde_json::{Value, json};

fn sent(message: &str) -> Value {
    serde_json::from_str(message).unwrap()
}

#[test]
fn a_force_goes_to_one_device_in_either_form() {
    let mut old = Commands::new("04BA", Form::V31);
    assert_eq!(
        sent(&old.force([0.0, -1.5, 0.25]).unwrap()),
        json!({ "inverse3": [{ "device_id": "04BA", "commands": {
            "set_cursor_force": { "values": { "x": 0.0, "y": -1.5, "z": 0.25 } } } }] })
    );
    let mut new = Commands::new("049D", Form::V35);
    new.probe();
    assert_eq!(
        sent(&new.force([0.0, -1.5, 0.25]).unwrap()),
        json!({ "inverse3": [{ "device_id": "049D", "commands": {
            "set_cursor_force": { "vector": { "x": 0.0, "y": -1.5, "z": 0.25 }, "execute": true } } }] })
    );
    assert_eq!(
        sent(&new.probe()),
        json!({ "inverse3": [{ "device_id": "049D", "commands": { "probe_position": {} } }] })
    );
}

#[test]
fn the_session_is_configured_once() {
    let mut new = Commands::new("049D", Form::V35);
    let first = sent(&new.force([0.0; 3]).unwrap());
    assert!(first["session"]["configure"]["profile"]["name"].is_string());
    assert!(first["inverse3"][0]["commands"]["set_cursor_force"].is_object());
    for _ in 0..3 {
        assert!(sent(&new.force([1.0; 3]).unwrap()).get("session").is_none());
        assert!(sent(&new.probe()).get("session").is_none());
    }
    // 3.1 has no profiles.
    let mut old = Commands::new("04BA", Form::V31);
    assert!(sent(&old.probe()).get("session").is_none());
}

#[test]
fn a_force_that_is_no_number_is_not_sent() {
    let mut commands = Commands::new("049D", Form::V35);
    for (force, axis) in [
        ([f64::NAN, 0.0, 0.0], 'x'),
        ([0.0, f64::INFINITY, 0.0], 'y'),
        ([0.0, 0.0, f64::NEG_INFINITY], 'z'),
    ] {
        assert_eq!(commands.force(force).unwrap_err().axis, axis);
    }
    // A rejected force does not use up the session's configuration.
    assert!(commands.probe().contains("configure"));
}

#[test]
fn a_name_cannot_break_out_of_its_quotes() {
    let name = "a\"}], \"inverse3\": [{\"device_id\": \"b";
    let message = sent(&Commands::new(name, Form::V31).force([1.0; 3]).unwrap());
    assert_eq!(message["inverse3"].as_array().unwrap().len(), 1);
    assert_eq!(message["inverse3"][0]["device_id"], name);
}

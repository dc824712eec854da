//! Parsing of frames: accepted and rejected values.

use palpate_drivers::inverse3::{Frame, FrameError, Model, Status, Unfit};
use serde_json::{Value, json};

use crate::inverse3::samples::{full_3_1, full_3_5};

fn parse(frame: &Value) -> Result<Frame, FrameError> {
    Frame::parse(&frame.to_string())
}

#[test]
fn a_full_frame_is_read_in_both_forms() {
    let frame = parse(&full_3_5()).unwrap();
    assert_eq!(frame.session_id, Some(7));
    let device = frame.device("049D").unwrap();
    assert!(device.is_of_3_5());
    assert_eq!(device.model(), Some(&Model::Inverse3));
    let sample = device.sample().unwrap();
    assert_eq!(sample.position, [0.0205, -0.0276, 0.1994]);
    assert_eq!(sample.velocity, Some([0.0, -0.001, 0.002]));
    assert_eq!(sample.force, Some([0.0, 0.5, 0.0]));
    assert_eq!(Unfit::at_first(device), None);

    let frame = parse(&full_3_1()).unwrap();
    let device = frame.device("04BA").unwrap();
    assert!(!device.is_of_3_5());
    assert_eq!(device.model(), Some(&Model::Inverse3));
    assert_eq!(device.sample().unwrap().position, [0.12, 0.038, -0.05]);
    assert_eq!(device.state.mode.as_deref(), Some("idle"));
    assert!(frame.device("049D").is_none());
}

#[test]
fn a_state_frame_has_no_configuration_and_may_have_less() {
    let mut frame = full_3_5();
    frame["inverse3"][0]
        .as_object_mut()
        .unwrap()
        .remove("config");
    let device = &parse(&frame).unwrap().devices()[0].clone();
    assert!(device.config.is_none() && device.is_of_3_5());
    assert!(device.sample().is_ok());

    let bare = parse(&json!({ "inverse3": [{ "device_id": "a", "state": {
        "cursor_position": { "x": 0, "y": 0, "z": 0 }, "new_in_4": [1, 2] } }] }));
    let device = &bare.unwrap().devices()[0].clone();
    assert_eq!(device.status, Status::default());
    assert_eq!(device.sample().unwrap().velocity, None);
    for none in [
        json!({}),
        json!({ "inverse3": null }),
        json!({ "inverse3": [] }),
    ] {
        assert!(parse(&none).unwrap().devices().is_empty());
    }
}

#[test]
fn a_device_type_is_a_name_or_a_number() {
    let model = |kind: Value| {
        let mut frame = full_3_5();
        frame["inverse3"][0]["config"] = json!({ "device_info": { "device_type": kind } });
        let device = parse(&frame).unwrap().devices()[0].clone();
        (
            device.model().unwrap().to_string(),
            Unfit::at_first(&device),
        )
    };
    assert_eq!(model(json!(4)), ("inverse3".into(), None));
    assert_eq!(model(json!("inverse3x")), ("inverse3x".into(), None));
    let other = Some(Unfit::OtherModel);
    assert_eq!(model(json!(6)), ("minverse".into(), other));
    assert_eq!(model(json!("minverse")), ("minverse".into(), other));
    assert_eq!(model(json!(11)), ("type 11".into(), other));
    assert_eq!(model(json!("ruko")), ("ruko".into(), other));
}

#[test]
fn what_is_wrong_is_named() {
    let wrong = |pointer: &str, value: Value| {
        let mut frame = full_3_5();
        *frame.pointer_mut(pointer).unwrap() = value;
        let parsed = parse(&frame);
        parsed
            .and_then(|frame| frame.devices()[0].sample())
            .unwrap_err()
            .to_string()
    };
    let state = "/inverse3/0/state";
    for (pointer, value, words) in [
        (
            "/cursor_position/y",
            json!("a"),
            "inverse3[0].state.cursor_position.y: invalid type: string",
        ),
        (
            "/cursor_position/y",
            json!(null),
            "inverse3[0].state.cursor_position.y: invalid type: null",
        ),
        (
            "/cursor_position",
            json!({ "x": 1 }),
            "inverse3[0].state.cursor_position: missing field `y`",
        ),
        (
            "/cursor_position",
            json!(null),
            "device 049D: state.cursor_position is missing",
        ),
        (
            "/cursor_position/z",
            json!(2.1),
            "device 049D: state.cursor_position is 2.1; allowed: within 2 m",
        ),
        (
            "/cursor_velocity/x",
            json!(-51),
            "device 049D: state.cursor_velocity is -51; allowed: within 50 m/s",
        ),
        (
            "/control_mode",
            json!(3),
            "inverse3[0].state.control_mode: invalid type: integer",
        ),
    ] {
        let said = wrong(&format!("{state}{pointer}"), value);
        assert!(said.starts_with(words), "{said}\n{words}");
    }
    let said = wrong("/inverse3/0/status/ready", json!("yes"));
    assert!(
        said.starts_with("inverse3[0].status.ready: invalid type"),
        "{said}"
    );
    let said = wrong("/inverse3", json!({ "049D": {} }));
    assert!(
        said.contains("interface 3.0") && said.contains("10001"),
        "{said}"
    );
}

#[test]
fn numbers_that_are_none_are_refused() {
    // JSON cannot represent these values: some writers emit null, some a number beyond the range of `f64`, some the
    // word itself.
    for number in ["1e999", "-1e999", "NaN", "Infinity", "null"] {
        let text = full_3_5().to_string().replace("0.1994", number);
        let result = Frame::parse(&text).and_then(|frame| frame.devices()[0].sample());
        assert!(result.is_err(), "{number}: {result:?}");
    }
}

#[test]
fn two_devices_of_one_name_are_refused() {
    let mut frame = full_3_5();
    let device = frame["inverse3"][0].clone();
    frame["inverse3"].as_array_mut().unwrap().push(device);
    assert_eq!(parse(&frame), Err(FrameError::Twice("049D".into())));
    frame["inverse3"][1]["device_id"] = json!("049E");
    assert_eq!(parse(&frame).unwrap().devices().len(), 2);
}

#[test]
fn a_device_that_cannot_be_used_is_refused_with_what_to_do() {
    let unfit = |field: &str, value: bool| {
        let mut frame = full_3_5();
        frame["inverse3"][0]["status"][field] = json!(value);
        let device = parse(&frame).unwrap().devices()[0].clone();
        (Unfit::at_first(&device), Unfit::new(&device.status))
    };
    for (field, value, expected, words) in [
        ("power_supply", false, Unfit::NoPower, "power supply"),
        ("started", false, Unfit::NotStarted, "plug it in again"),
        (
            "calibrated",
            false,
            Unfit::NotCalibrated,
            "calibration pose",
        ),
        ("ready", false, Unfit::NotReady, "wait"),
    ] {
        assert_eq!(unfit(field, value), (Some(expected), Some(expected)));
        assert!(expected.to_string().contains(words));
    }
    // Later frames show this program's own use.
    assert_eq!(unfit("in_use", true), (Some(Unfit::InUse), None));
}

//! Frames in the service's format. They are independent of the parser, which is tested with them.

use palpate_device::Vector;
use serde_json::{Map, Value, json};

use super::device::EmulatedDevice;
use crate::inverse3::Form;

/// Returns the full frame, as on connection.
pub(super) fn full(devices: &[EmulatedDevice], form: Form, session: u64) -> Value {
    frame(devices, form, session, true)
}

/// Returns the state frame, as in every reply.
pub(super) fn state(devices: &[EmulatedDevice], form: Form, session: u64) -> Value {
    frame(devices, form, session, false)
}

fn frame(devices: &[EmulatedDevice], form: Form, session: u64, with_config: bool) -> Value {
    let devices: Vec<Value> = devices
        .iter()
        .filter(|device| device.present)
        .map(|device| {
            let mut entry = json!({
                "device_id": device.id,
                "state": state_of(device, form),
                "status": {
                    "calibrated": device.status.calibrated,
                    "in_use": device.status.in_use,
                    "power_supply": device.status.power_supply,
                    "ready": device.status.ready,
                    "started": device.status.started,
                },
            });
            if with_config {
                entry["config"] = config_of(device, form);
            }
            entry
        })
        .collect();
    let mut frame = json!({ "session_id": session, "inverse3": devices });
    // There are no grips; a service of 3.1 omits their lists.
    if form == Form::V35 {
        frame["verse_grip"] = json!([]);
        frame["wireless_verse_grip"] = json!([]);
        frame["custom_verse_grip"] = json!([]);
    }
    frame
}

fn state_of(device: &EmulatedDevice, form: Form) -> Value {
    let commanded = device.is_commanded();
    let mut state = Map::new();
    state.insert("cursor_position".into(), xyz(device.position()));
    state.insert("cursor_velocity".into(), xyz(device.velocity()));
    state.insert("body_orientation".into(), upright());
    state.insert("mode".into(), json!("idle"));
    if form == Form::V35 {
        let (domain, mode) = if commanded {
            ("cartesian", "force")
        } else {
            ("undefined", "idle")
        };
        state.insert("control_domain".into(), json!(domain));
        state.insert("control_mode".into(), json!(mode));
        state.insert("current_cursor_force".into(), xyz(device.force()));
        state.insert("transform".into(), json!({}));
        state.insert("transform_velocity".into(), json!({}));
    }
    Value::Object(state)
}

fn config_of(device: &EmulatedDevice, form: Form) -> Value {
    let mut config = json!({
        "type": "inverse3",
        "port": "emulated",
        "device_info": {
            "id": device.id, "uuid": device.id,
            "major_version": 7, "minor_version": 4, "device_type": 4,
        },
        "extended_device_id": device.id,
        "extended_firmware_version": "emulated",
        "gravity_compensation": { "enabled": true, "scaling_factor": 1.0 },
        "handedness": "right",
        "streaming_mode": "USB",
        "torque_scaling": { "enabled": true },
    });
    match form {
        Form::V31 => config["coordinate_system"] = json!({ "permutation": "XYZ" }),
        Form::V35 => {
            config["basis"] = json!({ "permutation": "XYZ" });
            config["mount"] = json!({});
            config["preset"] = json!("defaults");
            config["home_return"] = json!({ "enabled": false });
            config["filters"] =
                json!({ "force_gate": { "gain": 0.0 }, "damping": { "scalar": 0.0 } });
        }
    }
    config
}

fn xyz([x, y, z]: Vector) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

fn upright() -> Value {
    json!({ "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 })
}

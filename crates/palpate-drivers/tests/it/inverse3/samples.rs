//! Frames of the service in both interface versions, written from the vendor's documentation.

use serde_json::{Value, json};

/// Full frame of a service with interface 3.5.
pub(crate) fn full_3_5() -> Value {
    json!({
        "session_id": 7,
        "session": { "session_id": 7, "config": { "profile": { "name": "x" } }, "state": {}, "status": {} },
        "inverse3": [{
            "device_id": "049D",
            "config": {
                "type": "inverse3", "port": "COM12",
                "device_info": {
                    "major_version": 7, "minor_version": 4, "id": "049D",
                    "device_type": 4, "uuid": "2D35F80DD9005F599B68F49944CB049D",
                },
                "extended_device_id": "2D35", "extended_firmware_version": "DC35",
                "gravity_compensation": { "enabled": true, "scaling_factor": 1.0 },
                "handedness": "right", "streaming_mode": "USB",
                "torque_scaling": { "enabled": true }, "home_return": { "enabled": false },
                "preset": "defaults", "basis": { "permutation": "XYZ" }, "mount": {},
                "filters": { "force_gate": { "gain": 0.3 }, "damping": { "scalar": 0.0 } },
            },
            "state": {
                "cursor_position": { "x": 0.0205, "y": -0.0276, "z": 0.1994 },
                "cursor_velocity": { "x": 0, "y": -0.001, "z": 2e-3 },
                "angular_position": { "a0": 0, "a1": 1.5, "a2": -22.7 },
                "body_orientation": { "w": 0.7, "x": 0.02, "y": 0.7, "z": 0 },
                "mode": "idle", "control_domain": "undefined", "control_mode": "idle",
                "transform": {}, "transform_velocity": {},
                "current_cursor_force": { "x": 0, "y": 0.5, "z": 0 },
            },
            "status": {
                "calibrated": true, "in_use": false, "power_supply": true,
                "ready": true, "started": true,
            },
        }],
        "verse_grip": [], "wireless_verse_grip": [], "custom_verse_grip": [],
    })
}

/// Full frame of a service with interface 3.1: other names, and missing arrays.
pub(crate) fn full_3_1() -> Value {
    json!({
        "session_id": 16,
        "inverse3": [{
            "device_id": "04BA",
            "config": {
                "type": "inverse3", "port": "COM18",
                "device_info": { "id": "04BA", "model": "inverse3" },
                "coordinate_system": { "permutation": "XYZ" },
            },
            "state": {
                "cursor_position": { "x": 0.12, "y": 0.038, "z": -0.05 },
                "cursor_velocity": { "x": 0, "y": 0, "z": 0 },
                "mode": "idle",
            },
            "status": {
                "calibrated": true, "in_use": false, "power_supply": true,
                "ready": true, "started": true,
            },
        }],
    })
}

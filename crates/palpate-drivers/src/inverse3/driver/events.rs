//! Events of the service beside the frames: the reason why a device is gone, or an action of its safety system.

use std::sync::Arc;

use serde::Deserialize;
use tungstenite::{Message, WebSocket};

use super::address::Half;
use super::link::{Cause, Link};

/// An event, reduced to the fields used here.
#[derive(Debug, Deserialize)]
struct Event {
    name: String,
    #[serde(default)]
    data: Data,
}

#[derive(Debug, Default, Deserialize)]
struct Data {
    #[serde(default)]
    device_id: Option<String>,
    #[serde(default)]
    safety_type: Option<String>,
}

/// Returns the meaning of an event for the device with this name; most events have none.
fn meaning(text: &str, id: &str) -> Option<Cause> {
    let event: Event = serde_json::from_str(text).ok()?;
    if event.data.device_id.as_deref() != Some(id) {
        return None;
    }
    match (event.name.as_str(), event.data.safety_type.as_deref()) {
        ("device-disconnected", _) => Some(Cause::Unplugged),
        ("device-calibration-failed", _) => Some(Cause::NotCalibrated),
        // The event at the beginning was already reported.
        ("device-safety-triggered", Some("ebrake_released")) => None,
        ("device-safety-triggered", _) => Some(Cause::Safety),
        _ => None,
    }
}

/// Reads events until the connection ends. The end of the connection is not an error, because the frames show the same
/// conditions later and in less detail.
pub(super) fn listen(mut socket: WebSocket<Half>, id: &str, link: &Arc<Link>) {
    while !link.is_ending() {
        match socket.read() {
            Ok(Message::Text(text)) => match meaning(&text, id) {
                Some(Cause::Unplugged) => link.lose(Cause::Unplugged),
                Some(cause) => link.was_unfit(cause),
                None => {}
            },
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if super::is_a_pause(&error) => {}
            Err(_) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_about_the_device_means_something() {
        let event = |name: &str, id: &str, kind: &str| {
            format!(
                r#"{{"name":"{name}","category":"device","level":"notice","message":"",
                "data":{{"device_family":"inverse3","device_id":"{id}","safety_type":"{kind}"}}}}"#
            )
        };
        let safety = "device-safety-triggered";
        for (text, expected) in [
            (
                event("device-disconnected", "a", ""),
                Some(Cause::Unplugged),
            ),
            (event("device-disconnected", "b", ""), None),
            (event(safety, "a", "ebrake_triggered"), Some(Cause::Safety)),
            (event(safety, "a", "new in 4"), Some(Cause::Safety)),
            (event(safety, "a", "ebrake_released"), None),
            (event("device-connected", "a", ""), None),
            (
                event("device-calibration-failed", "a", ""),
                Some(Cause::NotCalibrated),
            ),
            (
                r#"{"name":"system-rate-report","data":{"min_frequency":1}}"#.into(),
                None,
            ),
            (r#"{"name":"device-disconnected"}"#.into(), None),
            ("no JSON".into(), None),
        ] {
            assert_eq!(meaning(&text, "a"), expected, "{text}");
        }
    }
}

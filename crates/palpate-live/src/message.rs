//! Text messages between page and server; `docs/reference/live-protocol.md` describes every field.

use palpate_scene::method::{MethodName, SettingKey, deserialize_method};
use palpate_scene::{Scene, in_plain_words};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

use crate::rows::columns;

/// Request of a client.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientRequest {
    /// Target of the pointer's hand `[m]`; `None` releases the device.
    Hand(Option<f64>),
    /// Target position of the hand of a device in a world.
    Tool {
        /// Number of the device, in the order of the world's tools; 0 if it is not given.
        device: usize,
        /// The position `[m]`; `None` releases the device.
        position: Option<[f64; 3]>,
    },
    /// Target orientation of the hand of a device in a world.
    Turn {
        /// Number of the device, in the order of the world's tools; 0 if it is not given.
        device: usize,
        /// A unit quaternion `[w, x, y, z]`; none is as it began.
        orientation: Option<[f64; 4]>,
    },
    /// Changes the settings.
    Set(Set),
    /// Loops, devices and objects begin again.
    Restart,
    /// Ends a trip that stays.
    Rearm(usize),
    /// Begins or ends a recording.
    Record(bool),
}

/// Settings to change; missing fields stay unchanged.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Set {
    /// Stiffness `[N/m]`.
    pub stiffness_n_per_m: Option<f64>,
    /// Mass `[kg]`; null is a wall.
    #[serde(default, deserialize_with = "given")]
    pub mass_kg: Option<Option<f64>>,
    /// Virtual force on the object `[N]`.
    pub virtual_force_n: Option<f64>,
    /// Period `[s]`.
    pub period_s: Option<f64>,
    /// Model value of the device mass `[kg]`.
    pub model_device_mass_kg: Option<f64>,
    /// Model value of the delay `[s]`.
    pub model_delay_s: Option<f64>,
    /// Model value of the lag `[s]`.
    pub model_lag_s: Option<f64>,
    /// Model value of the gain.
    pub model_gain: Option<f64>,
    /// Methods, one for each rendering.
    pub lanes: Option<Vec<LaneChoice>>,
}

/// Method of a rendering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaneChoice {
    /// The method.
    #[serde(serialize_with = "by_name", deserialize_with = "deserialize_method")]
    pub method: MethodName,
    /// Its damping `[N s/m]`; none is the method's own default.
    #[serde(default)]
    pub damping_n_s_per_m: Option<f64>,
}

fn by_name<S: Serializer>(method: &MethodName, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(method.name())
}

/// Distinguishes `null` from a missing value.
fn given<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// Result of reading a text.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientMessage {
    /// Valid request.
    Request(ClientRequest),
    /// A request with invalid values: its type, and the error.
    Refused(&'static str, String),
    /// Unknown type of request.
    Unknown(&'static str),
}

/// The types that are known.
const TYPES: [&str; 7] = ["hand", "tool", "turn", "set", "restart", "rearm", "record"];

/// Understands a text.
#[must_use]
pub fn parse(text: &str) -> ClientMessage {
    let Ok(Value::Object(mut fields)) = serde_json::from_str(text) else {
        return ClientMessage::Unknown("expected a JSON object");
    };
    let given = fields.remove("type");
    let Some(kind) = TYPES
        .into_iter()
        .find(|kind| given.as_ref().and_then(Value::as_str) == Some(kind))
    else {
        return ClientMessage::Unknown(
            "unknown type; allowed: hand, tool, turn, set, restart, rearm, record",
        );
    };
    match request(kind, fields) {
        Ok(request) => ClientMessage::Request(request),
        Err(text) => ClientMessage::Refused(kind, text),
    }
}

fn request(kind: &str, fields: Map<String, Value>) -> Result<ClientRequest, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Hand {
        #[serde(deserialize_with = "Option::deserialize")]
        position_m: Option<f64>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Tool {
        #[serde(default)]
        device: usize,
        #[serde(deserialize_with = "Option::deserialize")]
        position_m: Option<[f64; 3]>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Turn {
        #[serde(default)]
        device: usize,
        #[serde(deserialize_with = "Option::deserialize")]
        orientation: Option<[f64; 4]>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Nothing {}
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Rearm {
        lane: usize,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Record {
        on: bool,
    }
    fn read<T: serde::de::DeserializeOwned>(fields: Map<String, Value>) -> Result<T, String> {
        serde_json::from_value(Value::Object(fields))
            .map_err(|error| in_plain_words(&error.to_string()))
    }
    Ok(match kind {
        "hand" => ClientRequest::Hand(read::<Hand>(fields)?.position_m),
        "tool" => {
            let Tool { device, position_m } = read(fields)?;
            let position = position_m;
            ClientRequest::Tool { device, position }
        }
        "turn" => {
            let Turn {
                device,
                orientation,
            } = read(fields)?;
            ClientRequest::Turn {
                device,
                orientation,
            }
        }
        "set" => ClientRequest::Set(read(fields)?),
        "rearm" => ClientRequest::Rearm(read::<Rearm>(fields)?.lane),
        "record" => ClientRequest::Record(read::<Record>(fields)?.on),
        _ => {
            read::<Nothing>(fields)?;
            ClientRequest::Restart
        }
    })
}

/// Message of the server.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ServerMessage<'a> {
    /// First of all.
    Hello {
        /// Version of this protocol.
        protocol: u32,
        /// Version of palpate.
        version: &'a str,
        /// Title of the scene.
        title: &'a str,
        /// Columns of the samples.
        columns: Vec<ColumnMessage>,
        /// Methods there are.
        methods: Vec<Method>,
        /// Limits of the settings.
        limits: crate::settings::Limits,
        /// The device.
        device: DeviceSaid<'a>,
        /// 1 if the object lies at greater positions than the device, else -1.
        side: i8,
        /// Initially visible range of the axis `[m]`.
        view_m: [f64; 2],
    },
    /// After the greeting, and whenever it changes.
    State {
        /// Stiffness `[N/m]`.
        stiffness_n_per_m: f64,
        /// Mass `[kg]`; none is a wall.
        mass_kg: Option<f64>,
        /// Virtual force on the object `[N]`.
        virtual_force_n: f64,
        /// Period `[s]`.
        period_s: f64,
        /// Model values of the device.
        #[serde(flatten)]
        model: ModelState,
        /// The lanes.
        lanes: Vec<LaneState>,
        /// The recording that is being made.
        recording: Option<RecordingState>,
        /// Target of the hand `[m]`.
        hand_m: Option<f64>,
    },
    /// Twice a second.
    Status {
        /// Number of clients.
        clients: usize,
        /// The lanes.
        lanes: Vec<LaneStatus>,
        /// The recording that is being made.
        recording: Option<RecordingStatus>,
    },
    /// An event.
    Note {
        /// Lane, from 0.
        lane: usize,
        /// Time `[s]`.
        t_s: f64,
        /// Kind of the event.
        kind: &'a str,
        /// What.
        text: &'a str,
    },
    /// Error in a message.
    Refused {
        /// Its type.
        about: &'a str,
        /// The error and the allowed values.
        text: &'a str,
    },
    /// The loop is over.
    Ended {
        /// Why.
        text: &'a str,
    },
}

impl<'a> ServerMessage<'a> {
    /// Creates the greeting: `scene` on a device, and the limits of the settings.
    #[must_use]
    pub fn hello(
        scene: &'a Scene,
        limits: crate::settings::Limits,
        device: DeviceSaid<'a>,
    ) -> Self {
        let (object, from) = (scene.object.position, scene.device.position());
        let (low, high) = (object.min(from), object.max(from));
        let margin = (0.75 * (high - low)).max(0.05);
        Self::Hello {
            protocol: 1,
            version: env!("CARGO_PKG_VERSION"),
            title: &scene.title,
            columns: columns().map(ColumnMessage::from).collect(),
            methods: MethodName::ALL
                .into_iter()
                .map(|method| Method {
                    name: method.name(),
                    title: method.summary(),
                    damping: method.uses(SettingKey::DAMPING),
                })
                .collect(),
            limits,
            device,
            side: match scene.contact.side {
                palpate_core::Side::Positive => 1,
                palpate_core::Side::Negative => -1,
            },
            view_m: [low - margin, high + margin],
        }
    }

    /// Returns the message as JSON text.
    #[must_use]
    pub fn text(&self) -> String {
        // Keys are strings and nothing else can fail.
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A column of the samples.
#[derive(Clone, Debug, Serialize)]
pub struct ColumnMessage {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

impl From<&palpate_record::recording::Column> for ColumnMessage {
    fn from(column: &palpate_record::recording::Column) -> Self {
        Self {
            name: column.name,
            // A column without a unit has an empty text as its unit.
            unit: if column.unit == "1" { "" } else { column.unit },
        }
    }
}

/// A method that can be chosen.
#[derive(Clone, Debug, Serialize)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Title of the column.
    pub title: &'static str,
    /// Whether it takes a damping.
    pub damping: bool,
}

/// The device.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceSaid<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its axes.
    pub axes: usize,
    /// Whether the page leads it.
    pub pointer: bool,
    /// Largest force `[N]`, if known.
    pub largest_force_n: Option<f64>,
    /// Largest number of renderings.
    pub lanes: usize,
}

/// Model values of the device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelState {
    /// Mass of the device `[kg]`.
    pub model_device_mass_kg: f64,
    /// Time from a sample to the beginning of its force `[s]`.
    pub model_delay_s: f64,
    /// Time constant of the actuator `[s]`.
    pub model_lag_s: f64,
    /// Delivered over commanded force.
    pub model_gain: f64,
}

/// State of a rendering.
#[derive(Clone, Debug, Serialize)]
pub struct LaneState {
    /// Its method and settings.
    #[serde(flatten)]
    pub choice: LaneChoice,
    /// Whether its loop runs.
    pub running: bool,
    /// Reason for a zero force, after a safety stop.
    pub safety_stop: Option<String>,
    /// The method whose held forces are the reason for that, if a method's are: it may not be the one
    /// that renders now.
    pub safety_stop_method: Option<&'static str>,
}

/// The recording of the state.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingState {
    /// Names of its files, one for each rendering.
    pub files: Vec<String>,
    /// Time of the run at which it began `[s]`.
    pub since_s: f64,
}

/// Status of a rendering.
#[derive(Clone, Debug, Serialize)]
pub struct LaneStatus {
    /// Time of the newest received tick `[s]`.
    pub t_s: f64,
    /// Number of received ticks.
    pub ticks: u64,
    /// Deadlines that were missed.
    pub missed_deadlines: u64,
    /// Ticks without a fresh sample.
    pub without_sample: u64,
    /// Number of zero-force commands of the supervisor.
    pub supervisor_cuts: u64,
    /// Delays of the tick starts.
    pub lateness_s: Spread,
    /// Durations of the ticks.
    pub tick_s: Spread,
    /// Ticks that found no room on their way here.
    pub unsent: u64,
}

/// Distribution of durations `[s]`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spread {
    /// Half do not exceed it.
    pub median: f64,
    /// 99 of 100 do not.
    pub p99: f64,
    /// None does.
    pub longest: f64,
}

/// The recording of the status.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RecordingStatus {
    /// Ticks of all lanes.
    pub ticks: u64,
    /// Ticks that are missing in it, by number.
    pub lost: u64,
    /// Size of its files.
    pub bytes: u64,
    /// Reason why the recording has stopped, if it has.
    pub failed: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_understood() {
        let request = |text: &str| match parse(text) {
            ClientMessage::Request(request) => request,
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(
            request(r#"{"type":"hand","position_m":0.5}"#),
            ClientRequest::Hand(Some(0.5))
        );
        assert_eq!(
            request(r#"{"position_m":null,"type":"hand"}"#),
            ClientRequest::Hand(None)
        );
        assert_eq!(
            request(r#"{"type":"tool","position_m":[0.5,0,-1e-3]}"#),
            ClientRequest::Tool {
                device: 0,
                position: Some([0.5, 0.0, -1e-3])
            }
        );
        assert_eq!(
            request(r#"{"type":"tool","device":1,"position_m":null}"#),
            ClientRequest::Tool {
                device: 1,
                position: None
            }
        );
        assert_eq!(
            request(r#"{"type":"turn","orientation":[0.6,0,0.8,0]}"#),
            ClientRequest::Turn {
                device: 0,
                orientation: Some([0.6, 0.0, 0.8, 0.0])
            }
        );
        assert_eq!(
            request(r#"{"type":"turn","orientation":null,"device":2}"#),
            ClientRequest::Turn {
                device: 2,
                orientation: None
            }
        );
        assert_eq!(request(r#"{"type":"restart"}"#), ClientRequest::Restart);
        assert_eq!(
            request(r#"{"type":"rearm","lane":1}"#),
            ClientRequest::Rearm(1)
        );
        assert_eq!(
            request(r#"{"type":"record","on":true}"#),
            ClientRequest::Record(true)
        );
        let set =
            r#"{"type":"set","mass_kg":null,"lanes":[{"method":"hfcr","damping_n_s_per_m":null}]}"#;
        assert_eq!(
            request(set),
            ClientRequest::Set(Set {
                mass_kg: Some(None),
                lanes: Some(vec![LaneChoice {
                    method: MethodName::Hfcr,
                    damping_n_s_per_m: None,
                }]),
                ..Set::default()
            })
        );
        assert_eq!(
            request(r#"{"type":"set"}"#),
            ClientRequest::Set(Set::default())
        );
    }

    #[test]
    fn wrong_values_are_refused_and_the_rest_is_unknown() {
        for (text, about, words) in [
            (
                r#"{"type":"hand"}"#,
                "hand",
                "the key position_m is missing",
            ),
            (
                r#"{"type":"hand","position_m":"left"}"#,
                "hand",
                "\"left\", expected a number",
            ),
            (
                r#"{"type":"tool","position_m":[0,1,null]}"#,
                "tool",
                "null, expected a number",
            ),
            (r#"{"type":"tool","position_m":[0,1]}"#, "tool", "length"),
            (
                r#"{"type":"tool","position_m":null,"device":-1}"#,
                "tool",
                "-1`, expected a whole number from 0 up",
            ),
            (r#"{"type":"set","mass":1}"#, "set", "unknown key mass"),
            (
                r#"{"type":"set","lanes":[{"method":"hfc"}]}"#,
                "set",
                "did you mean",
            ),
            (
                r#"{"type":"rearm","lane":-1}"#,
                "rearm",
                "expected a whole number from 0 up",
            ),
            (r#"{"type":"restart","now":1}"#, "restart", "now"),
        ] {
            match parse(text) {
                ClientMessage::Refused(kind, why) => {
                    assert_eq!(kind, about);
                    assert!(why.contains(words), "{text}: {why}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
        for text in ["", "{", "[]", "3", "{}", r#"{"type":3}"#, r#"{"type":"x"}"#] {
            assert!(matches!(parse(text), ClientMessage::Unknown(_)), "{text}");
        }
        let deep = "[".repeat(4000);
        assert!(matches!(parse(&deep), ClientMessage::Unknown(_)));
    }
}

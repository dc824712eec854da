//! Messages from the service: the full frame on connection, and a state frame for each message.
//!
//! The parser reads both versions of the interface, 3.1 and 3.5, and ignores unknown fields. A known field with an
//! invalid value is rejected, and the error names it.

use std::fmt;

use palpate_device::Vector;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Largest accepted position coordinate `[m]`. The arm reaches less than half a metre, but an application may have
/// offset the frame by its mount.
pub const FARTHEST: f64 = 2.0;

/// Largest accepted velocity coordinate `[m/s]`.
pub const FASTEST: f64 = 50.0;

/// One frame of the simulation channel.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Frame {
    /// Number of the session, if the frame contains it.
    #[serde(default)]
    pub session_id: Option<u64>,
    #[serde(default)]
    inverse3: Devices,
}

/// One Inverse3 in a frame.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct DeviceFrame {
    /// Name that addresses the device in commands.
    pub device_id: String,
    /// Configuration; in the first frame only.
    #[serde(default)]
    pub config: Option<Config>,
    /// Position and control mode.
    #[serde(default)]
    pub state: State,
    /// Readiness.
    #[serde(default)]
    pub status: Status,
}

/// Device configuration, reduced to the fields used here.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Config {
    #[serde(default, rename = "type")]
    kind: Option<Model>,
    #[serde(default)]
    device_info: Option<DeviceInfo>,
    /// Present if the field has its 3.5 name.
    #[serde(default)]
    basis: Option<IgnoredAny>,
    /// Present if the field has its 3.1 name.
    #[serde(default)]
    coordinate_system: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
struct DeviceInfo {
    #[serde(default, alias = "model")]
    device_type: Option<Model>,
}

/// Device model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// Inverse3: 4, or `inverse3`.
    Inverse3,
    /// Inverse3x.
    Inverse3x,
    /// Minverse: 6, or `minverse`.
    Minverse,
    /// Another model, with the service's name for it.
    Other(String),
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Inverse3 => "inverse3",
            Self::Inverse3x => "inverse3x",
            Self::Minverse => "minverse",
            Self::Other(name) => name,
        })
    }
}

impl<'de> Deserialize<'de> for Model {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrNumber;
        impl Visitor<'_> for NameOrNumber {
            type Value = Model;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a device type, by name or number")
            }

            fn visit_str<E>(self, name: &str) -> Result<Model, E> {
                Ok(match name {
                    "inverse3" => Model::Inverse3,
                    "inverse3x" => Model::Inverse3x,
                    "minverse" => Model::Minverse,
                    other => Model::Other(other.to_owned()),
                })
            }

            fn visit_u64<E>(self, number: u64) -> Result<Model, E> {
                Ok(match number {
                    4 => Model::Inverse3,
                    6 => Model::Minverse,
                    other => Model::Other(format!("type {other}")),
                })
            }
        }
        deserializer.deserialize_any(NameOrNumber)
    }
}

/// State of a device.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct State {
    #[serde(default)]
    cursor_position: Option<Xyz>,
    #[serde(default)]
    cursor_velocity: Option<Xyz>,
    #[serde(default)]
    current_cursor_force: Option<Xyz>,
    /// Control mode in the 3.1 interface: idle, position, angular.
    #[serde(default)]
    pub mode: Option<String>,
    /// Controlled coordinates in the 3.5 interface: undefined, cartesian, angular.
    #[serde(default)]
    pub control_domain: Option<String>,
    /// Control mode in the 3.5 interface: idle, position, force.
    #[serde(default)]
    pub control_mode: Option<String>,
}

/// Readiness of a device; `None` if the frame does not contain the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct Status {
    /// The position of the arms is calibrated.
    #[serde(default)]
    pub calibrated: Option<bool>,
    /// A program commands the device.
    #[serde(default)]
    pub in_use: Option<bool>,
    /// The motors have power.
    #[serde(default)]
    pub power_supply: Option<bool>,
    /// The device accepts commands.
    #[serde(default)]
    pub ready: Option<bool>,
    /// The service has started the device.
    #[serde(default)]
    pub started: Option<bool>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

impl From<Xyz> for Vector {
    fn from(Xyz { x, y, z }: Xyz) -> Self {
        [x, y, z]
    }
}

/// State of a device at the time of the service's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position of the cursor `[m]`.
    pub position: Vector,
    /// Velocity of the cursor estimated by the service `[m/s]`, if the frame contains it.
    pub velocity: Option<Vector>,
    /// Force on the cursor applied by the service `[N]`, if the frame contains it.
    pub force: Option<Vector>,
}

/// Reason for rejecting a frame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The text is not JSON or is incomplete.
    #[error("not a frame of the service: {0}")]
    NotJson(String),
    /// A field has an invalid value.
    #[error("{field}: {what}")]
    Field {
        /// Path of the field from the top level.
        field: String,
        /// Description of the error.
        what: String,
    },
    /// A required field of a device is missing.
    #[error("device {device}: {field} is missing")]
    Missing {
        /// Device id.
        device: String,
        /// Field name.
        field: &'static str,
    },
    /// A value that no such device can reach.
    #[error("device {device}: {field} is {value}; allowed: {allowed}")]
    Absurd {
        /// Device id.
        device: String,
        /// Field name.
        field: &'static str,
        /// Received value.
        value: f64,
        /// Accepted range.
        allowed: &'static str,
    },
    /// Two devices with the same name; the target of a command would be ambiguous.
    #[error("device {0} is in the frame twice")]
    Twice(String),
}

impl Frame {
    /// Parses a frame.
    ///
    /// # Errors
    /// The text is not JSON, a field has an invalid value, or a device occurs twice.
    pub fn parse(text: &str) -> Result<Self, FrameError> {
        let mut json = serde_json::Deserializer::from_str(text);
        let frame: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            let field = error.path().to_string();
            let inner = error.into_inner();
            match inner.classify() {
                serde_json::error::Category::Data => FrameError::Field {
                    field,
                    what: inner.to_string(),
                },
                _ => FrameError::NotJson(inner.to_string()),
            }
        })?;
        json.end()
            .map_err(|error| FrameError::NotJson(error.to_string()))?;
        let devices = frame.devices();
        for (index, device) in devices.iter().enumerate() {
            let named = |other: &DeviceFrame| other.device_id == device.device_id;
            if devices.iter().skip(index + 1).any(named) {
                return Err(FrameError::Twice(device.device_id.clone()));
            }
        }
        Ok(frame)
    }

    /// Returns every Inverse3 in the frame.
    #[must_use]
    pub fn devices(&self) -> &[DeviceFrame] {
        &self.inverse3.0
    }

    /// Returns the device with this name.
    #[must_use]
    pub fn device(&self, id: &str) -> Option<&DeviceFrame> {
        self.devices().iter().find(|device| device.device_id == id)
    }
}

impl DeviceFrame {
    /// Returns the device model, if the frame contains it.
    #[must_use]
    pub fn model(&self) -> Option<&Model> {
        let config = self.config.as_ref()?;
        let info = config.device_info.as_ref();
        config
            .kind
            .as_ref()
            .or(info.and_then(|info| info.device_type.as_ref()))
    }

    /// Returns whether the service speaks the 3.5 interface, in which some fields have new names.
    #[must_use]
    pub fn is_of_3_5(&self) -> bool {
        let config = self.config.as_ref();
        self.state.control_mode.is_some() || config.is_some_and(|config| config.basis.is_some())
    }

    /// Returns the position, and velocity and force if present.
    ///
    /// # Errors
    /// The position is missing, or a number is not finite or exceeds the range of the device.
    pub fn sample(&self) -> Result<Sample, FrameError> {
        let missing = FrameError::Missing {
            device: self.device_id.clone(),
            field: "state.cursor_position",
        };
        let position = self.state.cursor_position.ok_or(missing)?.into();
        self.believe("state.cursor_position", position, FARTHEST, "within 2 m")?;
        let velocity = self.state.cursor_velocity.map(Vector::from);
        if let Some(velocity) = velocity {
            self.believe("state.cursor_velocity", velocity, FASTEST, "within 50 m/s")?;
        }
        let force = self.state.current_cursor_force.map(Vector::from);
        if let Some(force) = force {
            self.believe("state.current_cursor_force", force, f64::MAX, "finite")?;
        }
        Ok(Sample {
            position,
            velocity,
            force,
        })
    }

    fn believe(
        &self,
        field: &'static str,
        vector: Vector,
        most: f64,
        allowed: &'static str,
    ) -> Result<(), FrameError> {
        // False for NaN.
        let is_believed = |value: &f64| value.abs() <= most;
        match vector.iter().find(|value| !is_believed(value)) {
            None => Ok(()),
            Some(value) => Err(FrameError::Absurd {
                device: self.device_id.clone(),
                field,
                value: *value,
                allowed,
            }),
        }
    }
}

/// A list of devices, empty if absent.
#[derive(Clone, Debug, Default, PartialEq)]
struct Devices(Vec<DeviceFrame>);

impl<'de> Deserialize<'de> for Devices {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct List;
        impl<'de> Visitor<'de> for List {
            type Value = Devices;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of devices")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Devices, A::Error> {
                let mut devices = Vec::new();
                while let Some(device) = list.next_element()? {
                    devices.push(device);
                }
                Ok(Devices(devices))
            }

            fn visit_map<A: MapAccess<'de>>(self, _: A) -> Result<Devices, A::Error> {
                Err(A::Error::custom(
                    "devices are keyed by name, as in interface 3.0; version 3.1 or later is required, on port \
                     10001",
                ))
            }

            fn visit_unit<E>(self) -> Result<Devices, E> {
                Ok(Devices::default())
            }
        }
        deserializer.deserialize_any(List)
    }
}

//! What the service sends: the full frame on connect, and a state frame for each message.
//!
//! Both forms of the interface are read, 3.1 and 3.5, and whatever is not known is passed over. A
//! field that is known and cannot be what it says is refused by its name.

use std::fmt;

use palpate_device::Vector;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Largest coordinate of a position that is believed `[m]`. The arm reaches less than half a metre;
/// an application may have moved the frame by its mount.
pub const FARTHEST: f64 = 2.0;

/// Largest coordinate of a velocity that is believed `[m/s]`.
pub const FASTEST: f64 = 50.0;

/// One frame of the simulation channel.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Frame {
    /// Number of the session, where the frame says it.
    #[serde(default)]
    pub session_id: Option<u64>,
    #[serde(default)]
    inverse3: Devices,
}

/// One Inverse3 in a frame.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct DeviceFrame {
    /// The name by which commands address it.
    pub device_id: String,
    /// What it is; in the first frame only.
    #[serde(default)]
    pub config: Option<Config>,
    /// Where it is, and what it does.
    #[serde(default)]
    pub state: State,
    /// Whether it can be used.
    #[serde(default)]
    pub status: Status,
}

/// What a device is, as far as it matters here.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Config {
    #[serde(default, rename = "type")]
    kind: Option<Model>,
    #[serde(default)]
    device_info: Option<DeviceInfo>,
    /// Whether the field has its 3.5 name.
    #[serde(default)]
    basis: Option<IgnoredAny>,
    /// Whether the field has its 3.1 name.
    #[serde(default)]
    coordinate_system: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
struct DeviceInfo {
    #[serde(default, alias = "model")]
    device_type: Option<Model>,
}

/// Which device it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// Inverse3: 4, or `inverse3`.
    Inverse3,
    /// Inverse3x.
    Inverse3x,
    /// Minverse: 6, or `minverse`.
    Minverse,
    /// Another one, as the service calls it.
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

/// Where a device is, and what it does.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct State {
    #[serde(default)]
    cursor_position: Option<Xyz>,
    #[serde(default)]
    cursor_velocity: Option<Xyz>,
    #[serde(default)]
    current_cursor_force: Option<Xyz>,
    /// What it does, as the 3.1 form says it: idle, position, angular.
    #[serde(default)]
    pub mode: Option<String>,
    /// What is controlled, as the 3.5 form says it: undefined, cartesian, angular.
    #[serde(default)]
    pub control_domain: Option<String>,
    /// How, as the 3.5 form says it: idle, position, force.
    #[serde(default)]
    pub control_mode: Option<String>,
}

/// Whether a device can be used; what the frame does not say is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct Status {
    /// It knows where its arms are.
    #[serde(default)]
    pub calibrated: Option<bool>,
    /// A program commands it.
    #[serde(default)]
    pub in_use: Option<bool>,
    /// Its motors have power.
    #[serde(default)]
    pub power_supply: Option<bool>,
    /// It takes commands.
    #[serde(default)]
    pub ready: Option<bool>,
    /// The service talks to it.
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

/// Where a device was when the service answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position of the cursor `[m]`.
    pub position: Vector,
    /// Velocity of the cursor as the service has it `[m/s]`, where the frame says it.
    pub velocity: Option<Vector>,
    /// Force on the cursor that the service applies `[N]`, where the frame says it.
    pub force: Option<Vector>,
}

/// A frame that is not believed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// It is not JSON, or not all of it is there.
    #[error("not a frame of the service: {0}")]
    NotJson(String),
    /// A field is not what it has to be.
    #[error("{field}: {what}")]
    Field {
        /// Which, from the top.
        field: String,
        /// What is wrong with it.
        what: String,
    },
    /// A field of a device that has to be there is not.
    #[error("device {device}: {field} is missing")]
    Missing {
        /// Whose.
        device: String,
        /// Which.
        field: &'static str,
    },
    /// A number that no such device can reach.
    #[error("device {device}: {field} is {value}; believed: {allowed}")]
    Absurd {
        /// Whose.
        device: String,
        /// Which.
        field: &'static str,
        /// What it said.
        value: f64,
        /// What is believed.
        allowed: &'static str,
    },
    /// Two devices of one name: nobody knows which of them a command would move.
    #[error("device {0} is in the frame twice")]
    Twice(String),
}

impl Frame {
    /// Reads a frame.
    ///
    /// # Errors
    /// It is not JSON; a field is not what it has to be; a device is in it twice.
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

    /// Every Inverse3 in it.
    #[must_use]
    pub fn devices(&self) -> &[DeviceFrame] {
        &self.inverse3.0
    }

    /// The device of this name.
    #[must_use]
    pub fn device(&self, id: &str) -> Option<&DeviceFrame> {
        self.devices().iter().find(|device| device.device_id == id)
    }
}

impl DeviceFrame {
    /// Which device it is, where the frame says it.
    #[must_use]
    pub fn model(&self) -> Option<&Model> {
        let config = self.config.as_ref()?;
        let info = config.device_info.as_ref();
        config
            .kind
            .as_ref()
            .or(info.and_then(|info| info.device_type.as_ref()))
    }

    /// Whether the service speaks the 3.5 form: some fields have new names.
    #[must_use]
    pub fn is_of_3_5(&self) -> bool {
        let config = self.config.as_ref();
        self.state.control_mode.is_some() || config.is_some_and(|config| config.basis.is_some())
    }

    /// Where it is.
    ///
    /// # Errors
    /// The position is missing; a number is not finite, or farther or faster than any such device.
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
        // Not a number is not within anything.
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

/// A list of devices that may be absent.
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
                    "devices by name are the interface of 3.0; this one needs 3.1 or later, \
                     which answers on port 10001",
                ))
            }

            fn visit_unit<E>(self) -> Result<Devices, E> {
                Ok(Devices::default())
            }
        }
        deserializer.deserialize_any(List)
    }
}

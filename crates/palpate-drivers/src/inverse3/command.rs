//! Messages to the service: the force of one device, or a position request.

use palpate_device::Vector;
use serde_json::{Value, json};

/// Version of the service's interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// 3.1: a force is given by `values`.
    V31,
    /// 3.5: a force is given by `vector`, and the session has a profile.
    V35,
}

/// Name of this program's session in the service, if the interface has one.
pub const PROFILE: &str = "org.palpate:palpate";

/// Messages to one device in one session. Only the first message contains the session's configuration; otherwise the
/// service would reconfigure itself with every force.
#[derive(Clone, Debug)]
pub struct Commands {
    device_id: String,
    form: Form,
    configured: bool,
}

/// Rejected force.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("force on axis {axis} is {value}; allowed: finite [N]")]
#[non_exhaustive]
pub struct CommandError {
    /// x, y or z.
    pub axis: char,
    /// Rejected value.
    pub value: f64,
}

impl Commands {
    /// Creates messages to the device with this name.
    #[must_use]
    pub fn new(device_id: &str, form: Form) -> Self {
        Self {
            device_id: device_id.to_owned(),
            form,
            configured: form == Form::V31,
        }
    }

    /// Returns the device id.
    #[must_use]
    pub fn device_id(&self) -> &str {
        &self.device_id
    }

    /// Returns the interface version.
    #[must_use]
    pub fn form(&self) -> Form {
        self.form
    }

    /// Returns the message that commands `force` on the cursor `[N]`, in the configured frame of the service.
    ///
    /// # Errors
    /// `force` is not finite. JSON cannot represent it, and the service would read no number at all.
    pub fn force(&mut self, force: Vector) -> Result<String, CommandError> {
        for (axis, value) in ['x', 'y', 'z'].into_iter().zip(force) {
            if !value.is_finite() {
                return Err(CommandError { axis, value });
            }
        }
        let [x, y, z] = force;
        let vector = json!({ "x": x, "y": y, "z": z });
        Ok(self.message(&match self.form {
            Form::V31 => json!({ "set_cursor_force": { "values": vector } }),
            Form::V35 => json!({ "set_cursor_force": { "vector": vector, "execute": true } }),
        }))
    }

    /// Returns a message that requests the position and commands nothing.
    pub fn probe(&mut self) -> String {
        self.message(&json!({ "probe_position": {} }))
    }

    fn message(&mut self, commands: &Value) -> String {
        let mut message = json!({
            "inverse3": [{ "device_id": self.device_id, "commands": commands }],
        });
        if !self.configured {
            self.configured = true;
            message["session"] = json!({ "configure": { "profile": { "name": PROFILE } } });
        }
        message.to_string()
    }
}

//! What is sent to the service: one device's force, or the wish to know where it is.

use palpate_device::Vector;
use serde_json::{Value, json};

/// Which form of the interface is spoken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// 3.1: a force is its `values`.
    V31,
    /// 3.5: a force is its `vector`, and the session has a profile.
    V35,
}

/// Name of this program's session in the service, where it has one.
pub const PROFILE: &str = "org.palpate:palpate";

/// Messages to one device in one session. The session's configuration goes with the first of them,
/// and never again: the service would configure itself anew with every force.
#[derive(Clone, Debug)]
pub struct Commands {
    device_id: String,
    form: Form,
    configured: bool,
}

/// A force that is not sent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("force on axis {axis} is {value}; allowed: finite [N]")]
#[non_exhaustive]
pub struct CommandError {
    /// x, y or z.
    pub axis: char,
    /// What it was.
    pub value: f64,
}

impl Commands {
    /// Messages to the device of this name.
    #[must_use]
    pub fn new(device_id: &str, form: Form) -> Self {
        Self {
            device_id: device_id.to_owned(),
            form,
            configured: form == Form::V31,
        }
    }

    /// The device that is spoken to.
    #[must_use]
    pub fn device_id(&self) -> &str {
        &self.device_id
    }

    /// The form that is spoken.
    #[must_use]
    pub fn form(&self) -> Form {
        self.form
    }

    /// Commands `force` on the cursor `[N]`, in the frame that the service has been given.
    ///
    /// # Errors
    /// It is not finite. JSON has no word for that: the service would read no number at all.
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

    /// Asks where the device is, and commands nothing.
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

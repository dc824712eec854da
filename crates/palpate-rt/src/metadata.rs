//! Metadata of a recording besides its scene, as lines of `key = value` with the unit in the key.

use std::fmt::Write as _;

use palpate_device::{Capabilities, Vector};
use palpate_record::recording::{DEVICES, RecordingMetadata};

use crate::realtime::Request;
use crate::rendering::WorldFrame;
use crate::safety::SafetyParams;

/// Metadata entry with the real-time requests.
const REAL_TIME: &str = "real time";
/// Metadata entry with the frame of a device in its world.
const FRAME: &str = "frame";

/// Returns the metadata of a recording by version `version` of a program, without the scene.
#[must_use]
pub fn metadata(
    version: &str,
    device: &Capabilities,
    limits: &SafetyParams,
    request: &Request,
) -> RecordingMetadata {
    RecordingMetadata::new(version)
        .with("device", &of_device(device))
        .with("safety", &of_safety(limits))
        .with(REAL_TIME, &of_request(request))
}

/// A device of a loop that renders a world.
#[derive(Clone, Debug)]
pub struct OnDevice {
    /// Name of the device in the world.
    pub name: String,
    /// Capabilities of the device.
    pub capabilities: Capabilities,
    /// Safety limits of the device.
    pub limits: SafetyParams,
    /// Frame of the device in the world.
    pub frame: WorldFrame,
}

/// Returns the metadata of a loop that renders a world on these devices, without the world. Entries of several
/// devices are grouped under their names.
#[must_use]
pub fn metadata_of_devices(
    version: &str,
    devices: &[OnDevice],
    request: &Request,
) -> RecordingMetadata {
    let of_one = |of: &OnDevice| {
        let metadata = metadata(version, &of.capabilities, &of.limits, request);
        metadata.with(FRAME, &of.frame.to_string())
    };
    if let [of] = devices {
        return of_one(of);
    }
    // In the order of their indices.
    let names = devices.iter().map(|of| format!("{}\n", of.name));
    let mut all = RecordingMetadata::new(version).with(DEVICES, &names.collect::<String>());
    for of in devices {
        for (text, said) in of_one(of).texts {
            let is_of_the_loop = text == REAL_TIME;
            let text = if is_of_the_loop {
                text
            } else {
                format!("{text} {}", of.name)
            };
            all = all.with(&text, &said);
        }
    }
    all
}

/// Missing frame of a device in the metadata.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("its metadata lacks the frame of {device} in the world")]
pub struct NoFrame {
    /// Description of the device.
    pub device: String,
}

/// Returns the frames of the devices with these `names`, as written by [`metadata_of_devices`].
///
/// # Errors
/// A device without a frame in the metadata.
pub fn frames_of_devices(
    metadata: &RecordingMetadata,
    names: &[&str],
) -> Result<Vec<WorldFrame>, NoFrame> {
    let frame = |name: &&str| {
        let (text, device) = match names {
            [_] => (FRAME.to_owned(), "the device".to_owned()),
            _ => (format!("{FRAME} {name}"), format!("the device {name}")),
        };
        let said = metadata.texts.get(&text);
        said.and_then(|said| WorldFrame::read(said))
            .ok_or(NoFrame { device })
    };
    names.iter().map(frame).collect()
}

/// Lines of `key = value` in TOML syntax.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn put(&mut self, key: &str, value: impl std::fmt::Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{key} = {value}");
    }

    /// Writes `otherwise` for an unknown or unlimited value.
    fn put_or(&mut self, key: &str, value: Option<impl std::fmt::Display>, otherwise: &str) {
        match value {
            Some(value) => self.put(key, value),
            None => {
                let _ = writeln!(self.0, "# {key}: {otherwise}");
            }
        }
    }
}

fn of_device(device: &Capabilities) -> String {
    let mut lines = Lines::default();
    let unknown = "unknown";
    lines.put("name", format_args!("{:?}", device.name));
    lines.put("axes", device.axes);
    lines.put_or("largest_force_n", device.largest_force, unknown);
    lines.put_or(
        "largest_stiffness_n_per_m",
        device.largest_stiffness,
        unknown,
    );
    lines.put_or("largest_damping_n_s_per_m", device.largest_damping, unknown);
    lines.put_or("workspace_m", device.workspace.map(corners), unknown);
    lines.put_or("effective_mass_kg", device.effective_mass, unknown);
    lines.put_or("encoder_quantum_m", device.encoder_quantum, unknown);
    lines.put("holds_last_force", device.holds_last_force);
    lines.put("holds_lines", device.holds_lines);
    lines.0
}

fn of_safety(limits: &SafetyParams) -> String {
    let mut lines = Lines::default();
    lines.put("largest_force_n", limits.largest_force);
    lines.put("slew_limit_n_per_s", limits.slew_limit);
    lines.put_or("workspace_m", limits.workspace.map(corners), "not limited");
    let range = limits.range.map(|[from, to]| format!("[{from}, {to}]"));
    lines.put_or("range_m", range, "not limited");
    lines.put("largest_speed_m_per_s", limits.largest_speed);
    lines.put("stale_after_periods", limits.stale_after);
    lines.put("soft_start_s", limits.soft_start);
    lines.put("oscillation_energy_j", limits.oscillation.energy);
    lines.put("oscillation_window_s", limits.oscillation.window);
    lines.put("stall_after_periods", limits.stall_after_periods);
    lines.put("tolerated_lateness_s", limits.tolerated_lateness);
    lines.0
}

fn of_request(request: &Request) -> String {
    let mut lines = Lines::default();
    lines.put_or("priority", request.priority, "not requested");
    lines.put("lock_memory", request.lock_memory);
    lines.put_or("processor", request.processor, "any");
    lines.0
}

fn corners([lower, upper]: [Vector; 2]) -> String {
    let corner = |[x, y, z]: Vector| format!("[{x}, {y}, {z}]");
    format!("[{}, {}]", corner(lower), corner(upper))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rendering::WorldAxis;

    #[test]
    fn every_line_is_a_key_and_its_value_and_not_what_rust_prints() {
        let known = Capabilities {
            largest_force: Some(3.0),
            workspace: Some([[-0.1, 0.0, 0.0], [0.1, 0.2, 0.0]]),
            effective_mass: Some(0.2),
            ..Capabilities::unknown("a \"quoted\" device", 2)
        };
        for device in [known, Capabilities::unknown("another", 1)] {
            let limits = SafetyParams::for_device(&device);
            let metadata = metadata("1.2.3", &device, &limits, &Request::default());
            for (name, text) in &metadata.texts {
                assert!(!text.contains(['{', '}']), "{name}: {text}");
                assert!(!text.contains("Some("), "{name}: {text}");
                for line in text.lines().filter(|line| !line.starts_with("# ")) {
                    let (key, value) = line.split_once(" = ").unwrap_or_else(|| panic!("{line}"));
                    assert!(!value.is_empty(), "{line}");
                    let is_key = |c: char| c.is_ascii_lowercase() || c == '_';
                    assert!(key.chars().all(is_key), "{line}");
                }
            }
            let limits = &metadata.texts["safety"];
            assert!(limits.contains("slew_limit_n_per_s = inf\n"), "{limits}");
        }
        let named = of_device(&Capabilities::unknown("a \"quoted\" device", 2));
        assert!(
            named.starts_with("name = \"a \\\"quoted\\\" device\"\naxes = 2\n"),
            "{named}"
        );
    }

    #[test]
    fn where_devices_stand_is_read_back_by_their_names() {
        let capabilities = Capabilities::unknown("any", 1);
        let on = |name: &str, place: f64| OnDevice {
            name: name.to_owned(),
            limits: SafetyParams::for_device(&capabilities),
            capabilities: capabilities.clone(),
            frame: WorldFrame::new(
                [Some(WorldAxis::along(0)), None, None],
                [0.0; 3],
                [place, 0.0, 0.0],
            )
            .unwrap(),
        };
        let several = [on("left", 0.25), on("right", 0.5)];
        for devices in [&several[..1], &several] {
            let metadata = metadata_of_devices("1.2.3", devices, &Request::default());
            let names: Vec<_> = devices.iter().map(|on| on.name.as_str()).collect();
            let frames = frames_of_devices(&metadata, &names).unwrap();
            assert_eq!(
                frames,
                devices.iter().map(|on| on.frame).collect::<Vec<_>>()
            );
        }
        let metadata = metadata_of_devices("1.2.3", &several, &Request::default());
        let error = frames_of_devices(&metadata, &["left", "third"]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "its metadata lacks the frame of the device third in the world"
        );
    }
}

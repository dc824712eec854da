//! The session of a report: a short loop on a device, recorded as by `palpate run --record`.

use std::cell::Cell;
use std::path::Path;

use palpate_scene::ContactFile;

use super::ReportArguments;
use crate::arguments::{ActuationFlags, EditFlags, Flags, Given};
use crate::commands::run::{SessionArguments, run_session};
use crate::commands::simulate::read_scene;
use crate::failure::{Failure, tell};
use palpate_study::text::digits;

/// Default scene: a wall that a hand touches, and the hand of `--device simulated`.
const SCENE: &str = r#"
format = 2
title = "A wall, touched"

[loop]
period_s = 0.001

[[device]]
name = "device"
axes = ["x"]
mass_kg = 0.25
position_m = [-0.01, 0.0, 0.0]
quantum_m = 1e-05

[device.drivetrain]
viscous_friction_n_s_per_m = 2

[device.hand]
force_n = [1.5, 0.0, 0.0]

[[body]]
name = "wall"
fixed = true
position_m = [0.0, 0.0, 0.0]
shape = { half_space = { normal = [-1.0, 0.0, 0.0] } }

[[contact]]
between = ["device", "wall"]
stiffness_n_per_m = 300

[render]
method = "coupled"

[measure]
duration_s = 1
"#;

/// Records a session and returns its outcome, which includes failures of the running loop.
///
/// # Errors
/// The session could not begin.
pub fn record(
    arguments: &ReportArguments,
    recording: &Path,
) -> Result<Result<(), Failure>, Failure> {
    let (file, path) = match &arguments.scene {
        Some(path) => (read_scene(path, &EditFlags::default())?, path.as_path()),
        None => {
            let name = "the built-in scene";
            let file = ContactFile::parse(name, SCENE).map_err(Failure::inputs)?;
            (file, Path::new(name))
        }
    };
    let session = SessionArguments {
        duration: arguments.duration,
        fast: arguments.fast,
        json: false,
        device: arguments.device.arguments.clone(),
        realtime: arguments.realtime.clone(),
        safety: arguments.safety.clone(),
        flags: Flags {
            stiffness: arguments.stiffness,
            period: arguments.period,
            actuation: ActuationFlags {
                device_file: arguments.device_file.clone(),
                ..ActuationFlags::default()
            },
            ..Flags::default()
        },
        given: Given::default(),
    };
    let scene = &file.scene;
    tell(format_args!(
        "session of {} s: move the device into `{}`, {} N/m from {} m on; ctrl-C ends it",
        arguments.duration,
        scene.title,
        digits(arguments.stiffness.unwrap_or(scene.contact.stiffness)),
        scene.object.position
    ));
    let has_run = Cell::new(false);
    let outcome = run_session(&file, (path, Some(recording)), &session, &|report| {
        has_run.set(true);
        tell(report.to_string().trim_end());
        Ok(())
    });
    match outcome {
        Err(error) if !has_run.get() => Err(error),
        outcome => Ok(outcome),
    }
}

//! Calibration of a device that this program opens itself: a loop like that of `run`, with the safety layer, a
//! supervisor and a watchdog process between the excitation and the motor.

use std::sync::Arc;
use std::thread::Builder;

use crate::devices::Watched;
use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_rt::StopFlag;
use palpate_rt::realtime::Request;
use palpate_rt::safety::{Heartbeat, SafetyParams};
use palpate_scene::{ContactFile, Scene};
use palpate_study::calibrate::ExcitationParams;
use palpate_study::calibration::ExcitedMotion;
use palpate_study::device_loop::{ShakeError, Shaker};

use super::CalibrateArguments;
use crate::arguments::EditFlags;
use crate::commands::run::request;
use crate::commands::simulate::read_scene;
use crate::devices::{Opened, open};
use crate::failure::{Failure, tell};
use crate::reports::Guarding;
use crate::values::duration;

/// Default device and hand of `--device simulated`.
const SCENE: &str = r#"
format = 2
title = "A device in a hand"

[loop]
period_s = 0.001

[[device]]
name = "device"
axes = ["x"]
mass_kg = 0.25
quantum_m = 1e-05

[device.hand]
force_n = [0.0, 0.0, 0.0]

[[body]]
name = "wall"
fixed = true
position_m = [1.0, 0.0, 0.0]
shape = { half_space = { normal = [-1.0, 0.0, 0.0] } }

[[contact]]
between = ["device", "wall"]
stiffness_n_per_m = 1000

[measure]
duration_s = 1
"#;

/// Excites the device selected by the arguments until the excitation is complete.
///
/// # Errors
/// The device cannot be opened or is lost, safety or the excitation stopped it, or a signal arrived.
pub fn excite(
    arguments: &CalibrateArguments,
    params: ExcitationParams,
) -> Result<ExcitedMotion, Failure> {
    let mut scene = match &arguments.scene {
        Some(path) => read_scene(path, &EditFlags::default())?.scene,
        None => {
            ContactFile::parse("the built-in scene", SCENE)
                .map_err(Failure::inputs)?
                .scene
        }
    };
    scene.loop_params.period = params.period;
    if arguments.fast {
        on(
            arguments,
            params,
            &scene,
            &SteppedClock::new(),
            Request::nothing(),
        )
    } else {
        let spin = duration("--spin", arguments.realtime.spin)?;
        let clock = MonotonicClock::new().with_spin(spin);
        on(
            arguments,
            params,
            &scene,
            &clock,
            request(&arguments.realtime),
        )
    }
}

fn on<C: Clock>(
    arguments: &CalibrateArguments,
    params: ExcitationParams,
    scene: &Scene,
    clock: &C,
    request: Request,
) -> Result<ExcitedMotion, Failure> {
    let period = duration("--period", params.period)?;
    let wait = arguments.wait()?;
    let stall_limit = SafetyParams::default().stall_after(period);
    let guarding = Guarding::new(stall_limit);
    let Opened { mut device, axis } = open(&arguments.device, scene, clock, &guarding)?;
    let heartbeat = Arc::new(Heartbeat::default());
    let watched = Watched::start(device.as_mut(), &heartbeat, clock, &request, stall_limit)
        .map_err(|error| Failure::System(format!("cannot start the supervisor: {error}")))?;
    let timed = (clock.clone(), period);
    let shaker = Shaker::new((device, axis), timed, params, heartbeat, stall_limit)
        .map_err(refused)?
        .waiting(wait);
    if let Some(wait) = wait {
        tell(format_args!(
            "move the device to its calibration position and hold it still: the force begins after 0.5 s without \
             motion, in {:.1} s at the earliest",
            wait.as_secs_f64()
        ));
    }
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let thread = Builder::new()
        .name("palpate calibrate".to_owned())
        .spawn(move || {
            for answer in request.ask().iter().filter(|answer| !answer.is_granted()) {
                tell(format_args!("warning: {answer}"));
            }
            shaker.run(&stop)
        })
        .map_err(|error| Failure::System(format!("cannot start the loop: {error}")))?;
    let ended = thread
        .join()
        .map_err(|_| Failure::System("internal error: the loop panicked".into()));
    watched.end();
    ended?.map_err(refused)
}

/// Converts a failed excitation to an exit code.
fn refused(error: ShakeError) -> Failure {
    let message = error.to_string();
    match error {
        ShakeError::Params(_) | ShakeError::Safety(_) => Failure::Arguments(message),
        ShakeError::Lost(_) => Failure::System(message),
        ShakeError::Signalled => Failure::Interrupted(message),
        ShakeError::Declined(_) => Failure::Declined(message),
    }
}

//! `palpate pipe`: a renderer between standard input and standard output.

mod answering;
mod arguments;
mod world;

use std::f64::consts::PI;
use std::io;

use crate::pipe::{Changeable, Columns, Format, Memory, PipeSummary, Stream, rendering};
use palpate_core::{Difficulty, Hold, LARGEST_DELAY, Mass};
use palpate_rt::safety::{Safety, SafetyParams};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, SceneFile};
use palpate_study::advise::too_coarse;
use palpate_study::sim::replay::ReplaySetup;
use palpate_study::text::digits;

pub use arguments::PipeArguments;

use super::simulate::read_any;
use crate::arguments::Flags;
use crate::failure::Failure;
use crate::setup::{check_contact, wrong_rendered, wrong_setup};
use answering::{MISTAKES, answer, messages};

/// Answers every line of standard input until it ends or a signal arrives.
pub fn run(arguments: &PipeArguments) -> Result<(), Failure> {
    let path = arguments.scene.as_ref().or(arguments.file.as_ref());
    let scene = path
        .map(|path| read_any(path, &arguments.flags.edits))
        .transpose()?;
    let scene = match (path, scene) {
        (Some(path), Some(SceneFile::World(file))) => return world::run(arguments, path, &file),
        (_, Some(SceneFile::Contact(file))) => Some(*file),
        (_, None) | (None, Some(_)) => None,
    };
    answer(|| set_up(arguments, scene), arguments.json)
}

/// Sets up the stream from the arguments, without any input or output.
fn set_up(arguments: &PipeArguments, scene: Option<ContactFile>) -> Result<Stream, Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(
        scene
            .as_ref()
            .map_or_else(MethodName::default, |file| file.scene.method),
    );
    let &[method] = methods.as_slice() else {
        return Err(Failure::Arguments(
            "pipe renders with one method; name it with --method".into(),
        ));
    };
    flags.check_settings(&methods)?;
    let motor_limit = scene
        .as_ref()
        .and_then(|file| file.scene.device.largest_force());
    let (mut setup, settings) = match scene {
        Some(file) => flags.live_setup(file.scene, method)?,
        None => (flags.replay_setup("pipe")?, flags.settings()),
    };
    let defaults = SafetyParams::default();
    let is_limit_given = limit_force(flags, &mut setup, motor_limit, &defaults);
    check_slope(setup.loop_params.actuation.hold, &arguments.stream.columns)?;
    let force_limit = setup.loop_params.force_limit;
    let soft_start = soft_start(arguments, &defaults)?;
    let period = setup.loop_params.period;
    flags
        .actuation
        .check_delay(setup.delay().time(period), period, LARGEST_DELAY)?;
    // Check contact and loop first: their errors do not depend on the method.
    check_contact(&setup)?;
    let rendering = rendering(&setup, method, &settings).map_err(|error| wrong_setup(&error))?;
    let slew_limit = rendering.loop_params.slew_limit.unwrap_or(f64::INFINITY);
    let (parameters, rendered) =
        palpate_rt::parameters(rendering).map_err(|error| wrong_rendered(&error))?;
    let safety = Safety::new(
        SafetyParams::bounding(force_limit, None, soft_start),
        setup.loop_params.period,
    )
    .map_err(|error| Failure::Arguments(error.to_string()))?
    .rendering(&rendering.loop_params.actuation, slew_limit);
    let mut stream = Stream {
        rendered,
        safety,
        changeable: Changeable {
            parameters,
            setup,
            method,
            settings,
        },
        format: Format {
            time: arguments.stream.time,
            unit: arguments.stream.unit.unwrap_or_default(),
            is_unit_given: arguments.stream.unit.is_some(),
            virtual_force: false,
        },
        columns: arguments.stream.columns.clone(),
        is_header_asked: arguments.stream.header,
        output: Box::new(io::stdout()),
        messages: Some(messages()?),
        mistakes: MISTAKES,
        summary: PipeSummary::new(force_limit, soft_start),
        memory: Memory::default(),
    };
    if let Some(doubt) = doubt_of_period(&setup) {
        stream.tell(format_args!("warning: {doubt}"));
    }
    if let Some(limits) = limits_in_words(
        force_limit.filter(|_| !is_limit_given),
        Some(soft_start).filter(|_| arguments.stream.soft_start.is_none()),
    ) {
        stream.tell(limits);
    }
    Ok(stream)
}

/// K T²/m + K T²/M above which a collision, half an oscillation, lasts less than a period.
const COLLISION_IN_A_PERIOD: f64 = PI * PI;

/// Returns the doubt whether a held force can follow the contact, in the words of `advise`. A device of unknown mass
/// counts as immovable.
fn doubt_of_period(setup: &ReplaySetup) -> Option<String> {
    let (stiffness, period) = (setup.contact.stiffness, setup.loop_params.period);
    let object_mass = match setup.contact.object_mass {
        Mass::Finite(mass) => mass,
        Mass::Infinite => f64::INFINITY,
    };
    let device_mass = setup.device_mass.unwrap_or(f64::INFINITY);
    let Difficulty {
        kappa,
        object_kappa,
    } = Difficulty::new(stiffness, device_mass, object_mass, period).ok()?;
    (kappa + object_kappa > COLLISION_IN_A_PERIOD).then(|| {
        format!(
            "the period is too long: at {stiffness} N/m (kappa {}, Kc {}) {}",
            digits(kappa),
            digits(object_kappa),
            too_coarse(period)
        )
    })
}

/// Limits the force of `setup` by that of the motors `[N]` and by default, unless a limit is given. Returns whether one
/// is given.
fn limit_force(
    flags: &Flags,
    setup: &mut ReplaySetup,
    motor_limit: Option<f64>,
    defaults: &SafetyParams,
) -> bool {
    let is_limit_given = flags.force_limit.is_some() || setup.loop_params.force_limit.is_some();
    if !is_limit_given {
        let least = motor_limit.unwrap_or(f64::INFINITY);
        setup.loop_params.force_limit = Some(defaults.largest_force.min(least));
    }
    is_limit_given
}

/// Rejects a line hold without the column of its slope, and that column without a line hold.
fn check_slope(hold: Hold, columns: &Columns) -> Result<(), Failure> {
    match (hold, columns.have_slope()) {
        (Hold::Line, false) => Err(Failure::Arguments(
            "loop.hold is \"line\", so a command is a force and a slope: print both, for example with --columns \
             force,slope; or set loop.hold to \"constant\""
                .into(),
        )),
        (Hold::Constant, true) => Err(Failure::Arguments(
            "--columns names slope, but loop.hold is \"constant\", whose slope is always 0; set loop.hold = \"line\" in \
             a scene, for an actuator that holds lines"
                .into(),
        )),
        _ => Ok(()),
    }
}

/// Returns the duration of the soft start `[s]`.
fn soft_start(arguments: &PipeArguments, defaults: &SafetyParams) -> Result<f64, Failure> {
    let seconds = arguments.stream.soft_start.unwrap_or(defaults.soft_start);
    if (0.0..=60.0).contains(&seconds) {
        return Ok(seconds);
    }
    Err(Failure::Arguments(format!(
        "--soft-start is {seconds} s, but must be 0 to 60"
    )))
}

/// Describes default limits of the force, if there are any.
fn limits_in_words(force: Option<f64>, soft_start: Option<f64>) -> Option<String> {
    let comes_in = |seconds| {
        format!("in contact at the start or after a recovery, the force ramps up over {seconds} s")
    };
    match (force, soft_start) {
        (Some(force), Some(seconds)) => Some(format!(
            "forces are limited to {force} N; {}; --force-limit inf and --soft-start 0 disable this",
            comes_in(seconds)
        )),
        (Some(force), None) => Some(format!(
            "forces are limited to {force} N; --force-limit inf disables this"
        )),
        (None, Some(seconds)) => Some(format!(
            "{}; --soft-start 0 disables this",
            comes_in(seconds)
        )),
        (None, None) => None,
    }
}

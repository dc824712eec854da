//! `replay`: a recording of a loop with a device, rendered with another force.

use std::path::PathBuf;

use palpate_core::{Contact, Parameter};
use palpate_plot::RunsFigure;
use palpate_record::recording::{Recording, RecordingError};
use palpate_record::trace::Part;
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Delay, GuardBounds, Scene, SceneParameter, SetupError};
use palpate_study::device_loop::RecordedWorld;
use palpate_study::hand_replay::{HandReplayError, HandReplayStep};
use palpate_study::recording::{
    NoScene, RecordingReplay, RecordingReplayError, ReplayOf, ReplayedRecording, StatedHand,
    TicksError, scene_of, shortcomings,
};
use palpate_study::sim::closed_loop::LoopError;
use palpate_study::sim::hand_replay::{HandError, HandModel, REACH};
use palpate_study::sim::replay::ReplayError;
use palpate_study::text::digits;
use palpate_testbed::reference::ReferenceError;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::of_ideal;
use crate::fields::named;
use crate::figures::drawn;
use crate::interrupt::{Stop, interruptible};
use crate::methods::{chosen, settings};
use crate::names::{refused, wrong_on_bench, wrong_replay};
use crate::render::{Rendered, RenderedInPython};
use crate::setup::{check_fact, check_hand, guard_named, side_named};
use crate::simulate_world::{Evaluated, replay_world};

/// Changes to the recording's scene; `None` keeps the recorded value.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Changes {
    stiffness: Option<f64>,
    mass: Option<f64>,
    force: Option<f64>,
    object_position: Option<f64>,
    object_velocity: Option<f64>,
    side: Option<String>,
    unilateral: Option<bool>,
    period: Option<f64>,
    force_limit: Option<f64>,
    slew_limit: Option<f64>,
    speed_limit: Option<f64>,
    largest_gap: Option<f64>,
    guard: Option<String>,
    guard_speed: Option<f64>,
    guard_allowance: Option<f64>,
    guard_acceleration: Option<f64>,
    guard_hand_force: Option<f64>,
    guard_mass: Option<f64>,
    guard_learn_mass: Option<bool>,
    guard_recovery: Option<f64>,
    delay: Option<f64>,
    delay_deviation: Option<f64>,
    lag: Option<f64>,
    lag_deviation: Option<f64>,
    gain: Option<f64>,
    gain_deviation: Option<f64>,
    device_mass: Option<f64>,
    model_device_mass: Option<f64>,
    encoder_quantum: Option<f64>,
}

impl Changes {
    /// Rejects impossible values, whether or not a method uses them.
    fn check(&self) -> PyResult<()> {
        for (parameter, value) in [
            (Parameter::VirtualForce, self.force),
            (Parameter::DeviceMass, self.device_mass),
            (Parameter::EncoderQuantum, self.encoder_quantum),
            (Parameter::Delay, self.delay),
            (Parameter::DelayDeviation, self.delay_deviation),
            (Parameter::Lag, self.lag),
            (Parameter::LagDeviation, self.lag_deviation),
            (Parameter::Gain, self.gain),
            (Parameter::GainDeviation, self.gain_deviation),
        ] {
            check_fact(parameter, value)?;
        }
        if let Some(mass) = self.model_device_mass
            && !(mass.is_finite() && mass > 0.0)
        {
            return Err(refused(format!(
                "model_device_mass is {mass} kg, but must be finite and greater than 0"
            )));
        }
        let bounds = self.guard_bounds();
        let GuardBounds {
            speed,
            allowance,
            acceleration,
            hand_force,
            least_mass: _,
            learns_mass: _,
            recovery,
        } = bounds;
        let given = [speed, allowance, acceleration, hand_force, recovery];
        if self.guard.is_none() && given.iter().any(Option::is_some) {
            return Err(refused(
                "guard_speed, guard_allowance, guard_acceleration, guard_hand_force and guard_recovery need a guard; give guard",
            ));
        }
        check_hand(&bounds)
    }

    fn guard_bounds(&self) -> GuardBounds {
        GuardBounds {
            speed: self.guard_speed,
            allowance: self.guard_allowance,
            acceleration: self.guard_acceleration,
            hand_force: self.guard_hand_force,
            least_mass: self.guard_mass,
            learns_mass: self.guard_learn_mass.unwrap_or(false),
            recovery: self.guard_recovery,
        }
    }

    /// Applies the changes to a scene.
    fn change(&self, scene: &mut Scene) -> PyResult<()> {
        self.check()?;
        let stiffness = self.stiffness.unwrap_or(scene.contact.stiffness);
        scene.contact.stiffness = stiffness;
        if let Some(mass) = self.mass {
            scene.contact.object_mass = Contact::object(stiffness, mass).object_mass;
        }
        if let Some(side) = &self.side {
            scene.contact.side = side_named(side)?;
        }
        scene.contact.unilateral = self.unilateral.unwrap_or(scene.contact.unilateral);
        scene.virtual_force = self.force.unwrap_or(scene.virtual_force);
        let object = &mut scene.object;
        object.position = self.object_position.unwrap_or(object.position);
        object.velocity = self.object_velocity.unwrap_or(object.velocity);
        let limits = &mut scene.loop_params;
        limits.period = self.period.unwrap_or(limits.period);
        limits.largest_gap = self.largest_gap.or(limits.largest_gap);
        limits.speed_limit = self.speed_limit.or(limits.speed_limit);
        limits.slew_limit = self.slew_limit.or(limits.slew_limit);
        if let Some(limit) = self.force_limit {
            // An infinite limit means no limit.
            limits.force_limit = (limit != f64::INFINITY).then_some(limit);
        }
        if let Some(guard) = &self.guard {
            limits.guard = guard_named(guard)?.guard(self.guard_bounds());
        }
        self.change_actuator(scene);
        scene.model_device_mass = self.model_device_mass.or(scene.model_device_mass);
        if let Some(given) = self.device_mass {
            let mass = scene.device.mass_mut().ok_or_else(|| {
                refused("device_mass cannot change: the recorded hand has the mass of its device")
            })?;
            *mass = given;
        }
        if let Some(quantum) = self.encoder_quantum {
            *scene.device.encoder_quantum_mut() = quantum;
            scene.model.sensor_quantum = None;
        }
        Ok(())
    }

    /// Applies changes of the actuator to the true values and to the model values.
    fn change_actuator(&self, scene: &mut Scene) {
        let period = scene.loop_params.period;
        let model = &mut scene.model;
        if let Some(delay) = self.delay {
            model.delay = None;
            scene.delay = Delay::from_seconds(delay, period);
        }
        if let Some(lag) = self.lag {
            model.lag = None;
            scene.actuator.lag = lag;
        }
        if let Some(gain) = self.gain {
            model.gain = None;
            scene.actuator.gain = gain;
        }
        model.delay_deviation = self.delay_deviation.or(model.delay_deviation);
        model.lag_deviation = self.lag_deviation.or(model.lag_deviation);
        model.gain_deviation = self.gain_deviation.or(model.gain_deviation);
    }

    /// Whether a parameter was given as an argument.
    fn gives(&self, parameter: SceneParameter) -> bool {
        let rendered = match parameter {
            SceneParameter::Rendered(rendered) => rendered,
            SceneParameter::DelaySamples | SceneParameter::DelaySeconds => Parameter::Delay,
            SceneParameter::Lag => Parameter::Lag,
            SceneParameter::Gain => Parameter::Gain,
            _ => return false,
        };
        match rendered {
            Parameter::Stiffness => self.stiffness.is_some(),
            Parameter::ObjectMass => self.mass.is_some(),
            Parameter::VirtualForce => self.force.is_some(),
            Parameter::ObjectPosition => self.object_position.is_some(),
            Parameter::ObjectVelocity => self.object_velocity.is_some(),
            Parameter::Period => self.period.is_some(),
            Parameter::Delay => self.delay.is_some(),
            Parameter::DelayDeviation => self.delay_deviation.is_some(),
            Parameter::ForceLimit => self.force_limit.is_some(),
            Parameter::SlewLimit => self.slew_limit.is_some(),
            Parameter::SpeedLimit => self.speed_limit.is_some(),
            Parameter::LargestGap => self.largest_gap.is_some(),
            Parameter::GuardSpeed => self.guard_speed.is_some(),
            Parameter::GuardAllowance => self.guard_allowance.is_some(),
            Parameter::GuardAcceleration => self.guard_acceleration.is_some(),
            Parameter::GuardHandForce => self.guard_hand_force.is_some(),
            Parameter::GuardMass => self.guard_mass.is_some(),
            Parameter::GuardRecovery => self.guard_recovery.is_some(),
            Parameter::DeviceMass => self.device_mass.is_some(),
            Parameter::EncoderQuantum | Parameter::NoiseBound | Parameter::GuardQuantum => {
                self.encoder_quantum.is_some()
            }
            Parameter::Lag => self.lag.is_some(),
            Parameter::LagDeviation => self.lag_deviation.is_some(),
            Parameter::Gain => self.gain.is_some(),
            Parameter::GainDeviation => self.gain_deviation.is_some(),
            _ => false,
        }
    }
}

/// Replay mode and the part to replay, as passed by the Python files.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct OfARecording {
    replay: String,
    begin: Option<f64>,
    end: Option<f64>,
    hand_bandwidth: Option<f64>,
    hand_stiffness: Option<f64>,
    hand_damping: Option<f64>,
}

impl OfARecording {
    fn part(&self) -> PyResult<Part> {
        let part = Part {
            from: self.begin.unwrap_or(Part::WHOLE.from),
            to: self.end.unwrap_or(Part::WHOLE.to),
            longest: f64::INFINITY,
        };
        if part.from < part.to {
            return Ok(part);
        }
        Err(refused(format!(
            "begin is {} s and end is {} s, but the part must begin before it ends",
            part.from, part.to
        )))
    }

    fn of(&self) -> PyResult<ReplayOf> {
        let stated = StatedHand {
            bandwidth: self.hand_bandwidth,
            stiffness: self.hand_stiffness,
            damping: self.hand_damping,
        };
        match self.replay.as_str() {
            "hand" => Ok(ReplayOf::Hand(stated)),
            "motion" => {
                let of_a_hand = [
                    ("hand_bandwidth", stated.bandwidth),
                    ("hand_stiffness", stated.stiffness),
                    ("hand_damping", stated.damping),
                ];
                let given = of_a_hand
                    .into_iter()
                    .find_map(|(name, value)| value.map(|_| name));
                given.map_or(Ok(ReplayOf::Motion), |name| {
                    Err(refused(format!(
                        "{name} is for replay=\"hand\"; replay=\"motion\" has no hand model"
                    )))
                })
            }
            other => Err(refused(format!(
                "replay is \"{other}\", but must be \"motion\" or \"hand\""
            ))),
        }
    }
}

/// An open recording and the replay to run.
struct Replaying {
    recording: Recording,
    file: ContactFile,
    scene: Scene,
    methods: Vec<MethodName>,
    part: Part,
    of: ReplayOf,
    changes: Changes,
    explains_settings: bool,
}

impl Replaying {
    /// Checks the arguments against an open recording.
    fn new(
        recording: Recording,
        method: Option<&Bound<'_, PyAny>>,
        (of, changes, settings_given): Given<'_, '_>,
    ) -> PyResult<Self> {
        let of: OfARecording = of.extract().map_err(|error| named(of, error))?;
        let changes: Changes = changes.extract().map_err(|error| named(changes, error))?;
        let (part, of) = (of.part()?, of.of()?);
        let file = scene_of(&recording).map_err(|error| match error {
            NoScene::Invalid(faults) => refused(faults),
            other => refused(other),
        })?;
        let methods = method.map_or_else(|| Ok(vec![file.scene.method]), chosen)?;
        let settings = settings(settings_given, &methods)?;
        let mut scene = file.scene.clone();
        changes.change(&mut scene)?;
        for &method in &methods {
            let own = scene.settings.entry(method).or_default();
            *own = settings.or(*own);
        }
        Ok(Self {
            recording,
            file,
            scene,
            methods,
            part,
            of,
            changes,
            explains_settings: !settings_given.is_empty(),
        })
    }

    /// Replays the recording by each method.
    fn run(&self, stop: &Stop) -> Result<ReplayedRecording, RecordingReplayError> {
        let changes = &self.changes;
        let replay = RecordingReplay {
            recording: &self.recording,
            recorded: &self.file.scene,
            scene: &self.scene,
            object_as_in_scene: changes
                .object_position
                .or(changes.object_velocity)
                .is_some(),
            part: self.part,
            of: self.of,
        };
        replay.by(&self.methods, |step| {
            if step != HandReplayStep::Done {
                stop.leave_if_raised();
            }
        })
    }

    fn wrong(&self, error: RecordingReplayError) -> PyErr {
        let name = self.recording.path().display();
        match error {
            RecordingReplayError::Ticks(error) => wrong_ticks(error),
            RecordingReplayError::Motion(method, error) => self.wrong_replay(method, &error),
            RecordingReplayError::Hand(error) => match error {
                HandReplayError::Hand(HandError::Model(error)) => refused(format!(
                    "{} is {}, but must be {}",
                    error.name, error.value, error.allowed
                )),
                HandReplayError::Hand(error) => refused(format!("{name}: {error}")),
                HandReplayError::Loop(method, LoopError::Setup(setup)) => {
                    self.wrong_replay(method, &ReplayError::Setup(setup))
                }
                HandReplayError::Loop(
                    _,
                    LoopError::Bench(error) | LoopError::Ideal(ReferenceError::Scene(error)),
                ) => wrong_on_bench(&error),
                HandReplayError::Loop(_, error) => refused(format!("{name}: {error}")),
                HandReplayError::OutOfReach { model, departure } => refused(format!(
                    "{name}: held by a hand of {} N/m and {} N s/m, the device leaves the recorded motion by {} m \
                     even under the ideal force, farther than an arm reaches ({REACH} m); use a stiffer hand \
                     (default: hand_stiffness={}, hand_damping={}), or a contact, weight and device_mass that it \
                     can hold",
                    model.stiffness,
                    model.damping,
                    digits(departure),
                    HandModel::USUAL_STIFFNESS,
                    HandModel::USUAL_DAMPING,
                )),
            },
        }
    }

    /// Returns the error in terms of an argument if one set the value, or else of the recording's scene.
    fn wrong_replay(&self, method: MethodName, error: &ReplayError) -> PyErr {
        match error {
            ReplayError::Setup(SetupError::Parameter(parameter))
                if self.changes.gives(parameter.parameter) =>
            {
                wrong_replay(error)
            }
            ReplayError::Setup(_) if self.explains_settings => wrong_replay(error),
            ReplayError::Setup(setup) => refused(self.file.locate(method, setup)),
            ReplayError::Bench(_) => wrong_replay(error),
            ReplayError::TooLong(periods) => refused(format!(
                "{}: the recording has {periods} periods; at most {} fit, so take a part of it with begin and end [s]",
                self.recording.path().display(),
                palpate_study::sim::run::MAX_PERIODS,
            )),
            other => refused(format!("{}: {other}", self.recording.path().display())),
        }
    }

    /// Returns warnings in addition to the report: shortcomings of the recording, and runs beyond a hand's reach.
    fn warnings(&self, beyond_reach: &[(MethodName, f64)]) -> Vec<String> {
        let beyond = beyond_reach.iter().map(|(method, departure)| {
            format!(
                "{method}: the device leaves the recorded motion by {} m, farther than an arm reaches ({REACH} m); \
                 the values in its row are not those of a hand",
                digits(*departure)
            )
        });
        beyond.chain(lacking(&self.recording)).collect()
    }
}

/// Returns the shortcomings of a recording.
pub fn lacking(recording: &Recording) -> impl Iterator<Item = String> {
    let name = recording.path().display().to_string();
    let lacks = shortcomings(recording).into_iter();
    lacks.map(move |words| format!("{name}: {words}"))
}

/// Returns the error for a recording that cannot be read.
pub fn unread(error: RecordingError) -> PyErr {
    match error {
        RecordingError::Unreadable { .. } => PyOSError::new_err(error.to_string()),
        RecordingError::Invalid { .. } => refused(error),
    }
}

/// Returns the error for ticks that cannot be replayed, in terms of the arguments that selected them.
fn wrong_ticks(error: TicksError) -> PyErr {
    match error {
        TicksError::Recording(error) => unread(error),
        TicksError::Part { name, ticks, ends } => refused(format!(
            "{name}: the part between begin and end has {ticks}, but needs at least 2{ends}"
        )),
        TicksError::Gap {
            name,
            from,
            to,
            longest,
        } => refused(format!(
            "{name}: no position between tick {} at {} s and tick {} at {} s; a hand is estimated across at most \
             {longest} s: pass a longer largest_gap, or replay the motion with replay=\"motion\"",
            from.0, from.1, to.0, to.1
        )),
        TicksError::NoForce(name) => refused(format!(
            "{name}: no tick contains the sent force, so the hand's force cannot be separated from the motor's; \
             replay=\"motion\" needs no force"
        )),
        other => refused(other),
    }
}

/// Replay mode, changes, and settings of methods.
type Given<'a, 'py> = (
    &'a Bound<'py, PyDict>,
    &'a Bound<'py, PyDict>,
    &'a Bound<'py, PyDict>,
);

/// Replay of one contact or of a world, and warnings.
type Replayed<'py> = (
    Option<RenderedInPython<'py>>,
    Option<Evaluated<'py>>,
    Vec<String>,
);

/// Replays a recording by each method.
#[pyfunction]
#[pyo3(signature = (path, method, of, changes, settings_given))]
pub fn replay<'py>(
    py: Python<'py>,
    path: PathBuf,
    method: Option<&Bound<'py, PyAny>>,
    of: &Bound<'py, PyDict>,
    changes: &Bound<'py, PyDict>,
    settings_given: &Bound<'py, PyDict>,
) -> PyResult<Replayed<'py>> {
    let given = (of, changes, settings_given);
    let recording = open(py, path)?;
    if recording.metadata.texts.contains_key(RecordedWorld::TEXT) {
        only_a_method(&recording, given)?;
        let (evaluated, warnings) = replay_world(py, recording, method)?;
        return Ok((None, Some(evaluated), warnings));
    }
    let replaying = Replaying::new(recording, method, given)?;
    let (rendered, warnings) = interruptible(py, move |stop| match replaying.run(stop) {
        Ok(replayed) => {
            let ideal = of_ideal(&replayed.reference);
            let warnings = replaying.warnings(&replayed.beyond_reach);
            let rendered = Rendered::of(&replayed.report, ideal, replayed.runs);
            Ok((rendered, warnings))
        }
        Err(error) => Err(replaying.wrong(error)),
    })??;
    Ok((Some(rendered.into_python(py)?), None, warnings))
}

/// Returns the figure of a replay of one contact, with the recorded forces.
#[pyfunction]
#[pyo3(signature = (path, method, of, changes, settings_given))]
pub fn replay_figure(
    py: Python<'_>,
    path: PathBuf,
    method: Option<&Bound<'_, PyAny>>,
    of: &Bound<'_, PyDict>,
    changes: &Bound<'_, PyDict>,
    settings_given: &Bound<'_, PyDict>,
) -> PyResult<String> {
    let recording = open(py, path)?;
    let replaying = Replaying::new(recording, method, (of, changes, settings_given))?;
    interruptible(py, move |stop| {
        let ReplayedRecording {
            title,
            reference,
            runs,
            replayed,
            curves,
            ..
        } = replaying
            .run(stop)
            .map_err(|error| replaying.wrong(error))?;
        let figure = RunsFigure::of_replay(&replayed, &title, (&reference, &runs), Some(&curves));
        drawn(&figure.sheet()).map_err(refused)
    })?
}

fn open(py: Python<'_>, path: PathBuf) -> PyResult<Recording> {
    interruptible(py, move |_| Recording::open(&path))?.map_err(unread)
}

/// Rejects arguments that do not apply to a world, because its file determines them.
fn only_a_method(recording: &Recording, (of, changes, settings): Given<'_, '_>) -> PyResult<()> {
    let all = of.iter().chain(changes.iter()).chain(settings.iter());
    for (name, value) in all {
        let name: String = name.extract()?;
        let is_default = value.is_none() || (name == "replay" && value.eq("motion")?);
        if !is_default {
            return Err(refused(format!(
                "{name}: {} is a recording of a world, whose file has all parameters; only method can be given",
                recording.path().display()
            )));
        }
    }
    Ok(())
}

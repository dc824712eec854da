//! `palpate live`: a loop with a live page.

mod arguments;
mod device;
mod serving;
mod world;

use std::path::{Path, PathBuf};

use palpate_device::clock::MonotonicClock;
use palpate_live::{Home, LaneEnd, Session, Setup, Written};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Scene, SceneFile, Source, beside};

pub use arguments::LiveArguments;
use device::{Named, most_lanes};
use serving::{listen, serve};

use super::run::{Asked, guarding, limits, outcome, request, tell_what_a_loop_has_not};
use super::simulate::read_any;
use crate::devices::{DeviceName, replayed};
use crate::failure::{Failure, tell};
use crate::recorded::{open as open_recording, whole_or_said};
use crate::reports::{RunReport, Subject, WatchdogReport};
use crate::results::print;
use crate::values::duration;
use palpate_study::recording::{in_a_line, put_scene};

/// Default scene and its methods.
const SCENE: &str = include_str!("../../../experiments/live.toml");
const METHODS: [MethodName; 2] = [MethodName::Basic, MethodName::Coupled];

/// Runs a loop, serves its live page, and reports the outcome at the end.
pub fn run(arguments: &LiveArguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.scene
        && let SceneFile::World(file) = read_any(path, &arguments.flags.edits)?
    {
        return world::run(arguments, path, &file);
    }
    let (scene, path, methods) = read(arguments)?;
    let listening = listen(arguments)?;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    let guarding = guarding(&arguments.safety, scene.loop_params.period)?;
    let devices = Named::new(&arguments.device, &scene, &clock, &guarding)?;
    let lasts = (arguments.duration < f64::INFINITY)
        .then(|| duration("--duration", arguments.duration))
        .transpose()?;
    let request = request(&arguments.realtime);
    let (safety, model) = (arguments.safety.clone(), arguments.safety.clone());
    let scene_path = path.clone();
    let setup = Setup {
        methods,
        hand: devices.hand(),
        devices: Box::new(devices),
        clock,
        request,
        limits: Box::new(move |device| limits(device, &safety)),
        duration: lasts,
        metadata: Box::new(move |scene, device| {
            let version = env!("CARGO_PKG_VERSION");
            let metadata = palpate_rt::metadata(version, device, &limits(device, &model), &request);
            put_scene(metadata, scene, &scene_path).map_err(|error| Failure::from(error).message())
        }),
        folder: folder(arguments.record.as_deref()),
        record: arguments.record.clone(),
        scene,
    };
    let end = serve(listening, Home::Contact, path.as_path(), |stop| {
        Session::start(setup, stop)
    })?;
    let asked = Asked {
        duration: arguments.duration,
        // A recorded motion ends by itself.
        device_may_end: arguments.device.kind() == DeviceName::Replay,
        lost: "the device was lost before the end",
    };
    let mut ended = Ok(());
    for lane in end.lanes {
        let watchdog = guarding.report(arguments.device.is_guarded(), &lane.capabilities);
        add(&mut ended, report(lane, watchdog, &asked));
    }
    for written in end.recordings {
        add(&mut ended, report_recording(written));
    }
    add(&mut ended, replayed::whole_or_said(&arguments.device));
    let failed = end
        .failed
        .map(|text| Failure::System(format!("no loop ran at the end: {text}")));
    add(&mut ended, failed.map_or(Ok(()), Err));
    ended
}

/// Reports every failure: the caller reports the first one, this function the others.
fn add(ended: &mut Result<(), Failure>, next: Result<(), Failure>) {
    match next {
        Err(failure) if ended.is_err() => tell(failure.message()),
        Err(failure) => *ended = Err(failure),
        Ok(()) => {}
    }
}

/// Returns the scene, its origin, and a method for each loop.
fn read(arguments: &LiveArguments) -> Result<(Scene, PathBuf, Vec<MethodName>), Failure> {
    let most = most_lanes(arguments.device.kind());
    let (file, path, usual) = match &arguments.scene {
        Some(path) => {
            let file = super::simulate::read_scene(path, &arguments.flags.edits)?;
            let usual = vec![file.scene.method];
            (file, path.clone(), usual)
        }
        None => {
            let name = "live.toml";
            let source = Source::new(name, SCENE).edited(&arguments.flags.edits.set);
            let file = ContactFile::parse_edited(&source, &mut beside(Path::new(name)));
            let mut file = file.map_err(Failure::inputs)?;
            arguments.flags.edits.retitle(&mut file.scene.title);
            // One loop renders the recommended method.
            let first = METHODS.len().saturating_sub(most);
            (file, PathBuf::from(name), METHODS[first..].to_vec())
        }
    };
    let flags = &arguments.flags;
    let given = flags.method.is_some() || arguments.scene.is_some();
    let methods = if given {
        flags.methods(usual[0])
    } else {
        usual
    };
    if methods.len() > most {
        let allowed = match most {
            1 => "one, since this device can be in one loop only",
            _ => "one, or two side by side",
        };
        return Err(Failure::Arguments(format!(
            "--method: {} methods; allowed: {allowed}",
            methods.len()
        )));
    }
    flags.check_settings(&methods)?;
    let mut scene = file.scene;
    flags.change(&mut scene, &methods)?;
    scene.method = methods[0];
    for method in &methods {
        scene.rendering(*method).map_err(Failure::input)?;
    }
    tell_what_a_loop_has_not(&scene.timing, scene.delay);
    if arguments.device.kind() == DeviceName::Pointer
        && (scene.device.grip().is_some()
            || scene.device.pantograph().is_some()
            || scene.device.tremor().is_some())
    {
        tell(
            "note: the device `pointer` replaces the scene's hand by yours and its linkage by a point mass; --device \
             simulated keeps both",
        );
    }
    Ok((scene, path, methods))
}

/// Returns the folder of recordings started on the page.
fn folder(record: Option<&Path>) -> PathBuf {
    let beside = record
        .and_then(Path::parent)
        .filter(|folder| !folder.as_os_str().is_empty());
    beside.unwrap_or(Path::new(".")).to_path_buf()
}

/// Describes a recording that ended before its loop.
fn report_recording(written: Written) -> Result<(), Failure> {
    if let Err(error) = written.ticks {
        return Err(Failure::System(error.to_string()));
    }
    let recording = open_recording(&written.path)?;
    print(&format!("{}\n", in_a_line(&recording)))?;
    whole_or_said(&recording)
}

/// Reports the outcome of a loop.
fn report(lane: LaneEnd, watchdog: Option<WatchdogReport>, asked: &Asked) -> Result<(), Failure> {
    let (recording, unwritten) = match lane.recording {
        Some(Written {
            path, ticks: Ok(_), ..
        }) => (Some(open_recording(&path)?), None),
        Some(Written {
            ticks: Err(error), ..
        }) => (None, Some(Failure::System(error.to_string()))),
        None => (None, None),
    };
    let report = RunReport::new(
        Subject {
            title: &lane.scene.title,
            method: lane.scene.method.name(),
            period: lane.scene.loop_params.period,
        },
        &lane.capabilities,
        &lane.end,
        &lane.answers,
        &lane.account,
        recording.as_ref(),
    )
    .guarded(watchdog);
    print(&format!("\n{report}"))?;
    outcome::of(
        &lane.end,
        asked,
        &lane.account,
        unwritten,
        recording.as_ref(),
    )
}

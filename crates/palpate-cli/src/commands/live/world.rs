//! `palpate live` with a world of one or several devices; its page shows the world in three dimensions.

use std::path::Path;

use palpate_device::clock::MonotonicClock;
use palpate_live::{
    Home, MAX_LANES, Session, WorldLane, WorldLaneEnd, WorldSessionEnd, WorldSetup,
};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::device_loop::{NotRendered, lacking_axes};
use palpate_study::sim::device::SpatialHand;

use super::super::run::world::{known_flags, on_devices};
use super::super::run::{Asked, guarding, outcome, request, tell_what_a_loop_has_not};
use super::serving::{listen, serve};
use super::{LiveArguments, add};
use crate::devices::{DeviceName, kinds, names, open_for_world};
use crate::failure::{Failure, tell};
use crate::reports::{Energies, Guarding, RunReport, Subject, WatchdogReport};
use crate::results::print;
use crate::values::duration;
use crate::worlds::{self, wrong_world};

/// Runs one or two loops on the world of `file`, which is at `path`, and serves their live page.
pub fn run(arguments: &LiveArguments, path: &Path, file: &WorldFile) -> Result<(), Failure> {
    let mut known = known_flags();
    known.retain(|flag| !["record", "fast", "json"].contains(flag));
    known.extend(["stall_after_periods", "listen", "allow_host"]);
    worlds::only(&arguments.given, &known, path)?;
    let file = &worlds::guarded(&arguments.flags, file);
    let scene = &file.scene;
    let kinds = kinds(&arguments.device, &arguments.given, scene)?;
    let methods = check_methods(arguments, file, &kinds)?;
    let period = scene.timing.period;
    tell_what_a_loop_has_not(&scene.timing.imperfections, scene.timing.delay);
    let listening = listen(arguments)?;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    let guarding = guarding(&arguments.safety, period)?;
    let lasts = (arguments.duration < f64::INFINITY)
        .then(|| duration("--duration", arguments.duration))
        .transpose()?;
    let hands = kinds.iter().zip(&scene.devices).map(|(kind, device)| {
        (*kind == DeviceName::Pointer).then(|| SpatialHand::at(device.position))
    });
    let hands: Vec<Option<SpatialHand>> = hands.collect();
    let opener = lane_opener(arguments, file, &methods, clock, &guarding, &hands);
    // Report errors of the first devices at once, with their exit code.
    let mut first = Some(opener(0)?);
    let setup = WorldSetup {
        scene: scene.clone(),
        methods: methods.clone(),
        open: Box::new(move |number| match first.take().filter(|_| number == 0) {
            Some(opened) => Ok(opened),
            None => opener(number).map_err(|failure| failure.message()),
        }),
        hands,
        clock,
        request: request(&arguments.realtime),
        duration: lasts,
    };
    let end = serve(listening, Home::World, path, |stop| {
        Session::of_world(setup, stop)
    })?;
    report_end(end, scene, arguments, &guarding)
}

/// Returns the names of the methods, or rejects their number or a method that cannot render the world.
fn check_methods(
    arguments: &LiveArguments,
    file: &WorldFile,
    kinds: &[DeviceName],
) -> Result<Vec<&'static str>, Failure> {
    let scene = &file.scene;
    let methods = worlds::methods(&arguments.flags, scene);
    let is_virtual =
        |kind: &DeviceName| matches!(kind, DeviceName::Pointer | DeviceName::Simulated);
    let is_virtual = kinds.iter().all(is_virtual);
    let most = if is_virtual { MAX_LANES } else { 1 };
    if methods.is_empty() || methods.len() > most {
        return Err(Failure::Arguments(format!(
            "--method: {} methods; allowed: one{}",
            methods.len(),
            if is_virtual {
                ", or two side by side"
            } else {
                ", since a device with motors can be in one loop only"
            }
        )));
    }
    let methods: Vec<&'static str> = methods.into_iter().map(worlds::known).collect();
    for method in &methods {
        scene
            .renderer(method)
            .map_err(|faults| wrong_world(&arguments.flags, file, &faults))?;
    }
    Ok(methods)
}

/// Returns a function that opens the devices and the world of a lane, by its number.
fn lane_opener(
    arguments: &LiveArguments,
    file: &WorldFile,
    methods: &[&'static str],
    clock: MonotonicClock,
    guarding: &Guarding,
    hands: &[Option<SpatialHand>],
) -> impl Fn(usize) -> Result<WorldLane, Failure> + Send + use<> {
    let (device, safety) = (arguments.device.clone(), arguments.safety.clone());
    let (file, hands, guarding) = (file.clone(), hands.to_vec(), guarding.clone());
    let (given, methods) = (arguments.given.clone(), methods.to_vec());
    move |number: usize| -> Result<WorldLane, Failure> {
        let method = methods.get(number).copied().unwrap_or("coupled");
        let opened = open_for_world(&device, &given, &file.scene, &clock, &guarding, &hands)?;
        let (on, world) = on_devices((&file, method), &opened, &safety);
        if number == 0 {
            lacking_axes(&file.scene, &on).iter().for_each(tell);
        }
        let world = world.map_err(|error| match error {
            NotRendered::World(faults) => Failure::input(faults.first()),
            NotRendered::Devices(error) => Failure::input(error),
        })?;
        let limits = on.iter().map(|on| on.limits);
        let devices = opened.into_iter().map(|opened| opened.device).zip(limits);
        Ok(WorldLane {
            devices: devices.collect(),
            world,
        })
    }
}

/// Reports the outcomes of all loops.
fn report_end(
    end: WorldSessionEnd,
    scene: &WorldScene,
    arguments: &LiveArguments,
    guarding: &Guarding,
) -> Result<(), Failure> {
    let asked = Asked {
        duration: arguments.duration,
        device_may_end: false,
        lost: "the device was lost before the end",
    };
    let mut ended = Ok(());
    for lane in end.lanes {
        let capabilities: Vec<_> = lane.capabilities.iter().collect();
        let watchdog = guarding.report_of(arguments.device.are_guarded(), &capabilities);
        add(&mut ended, report(&lane, scene, watchdog, &asked));
    }
    let failed = end
        .failed
        .map(|text| Failure::System(format!("no loop ran at the end: {text}")));
    add(&mut ended, failed.map_or(Ok(()), Err));
    ended
}

/// Reports the outcome of a loop.
fn report(
    lane: &WorldLaneEnd,
    scene: &WorldScene,
    watchdog: Option<WatchdogReport>,
    asked: &Asked,
) -> Result<(), Failure> {
    let ledger = lane.end.control.rendered().state().ledger();
    let subject = Subject {
        title: &scene.title,
        method: lane.method,
        period: scene.timing.period,
    };
    let capabilities: Vec<_> = lane.capabilities.iter().collect();
    let report = RunReport::of_devices(
        subject,
        &capabilities,
        &names(scene),
        &lane.end,
        &lane.answers,
        &lane.account,
        None,
    )
    .with_energies(Energies::of_world(&lane.end, ledger))
    .guarded(watchdog);
    print(&format!("\n{report}"))?;
    let outcome = outcome::of(&lane.end, asked, &lane.account, None, None);
    outcome::by_device(outcome, &lane.end, &names(scene))
}

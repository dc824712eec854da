//! `palpate live` with a world: its page shows it in three dimensions.

use std::path::Path;

use palpate_device::clock::MonotonicClock;
use palpate_scene::world::WorldFile;
use palpate_scope::{Home, MOST_LANES, Session, WorldLane, WorldLaneEnd, WorldSetup};
use palpate_session::{Energies, GuardianReport, RunReport, Subject};
use palpate_sim::device::SpatialHand;

use super::super::run::world::{OnDevice, known_flags, rendered, tell_of_axes};
use super::super::run::{Asked, guarding, limits, outcome, request};
use super::serving::{listen, serve};
use super::{LiveArguments, add};
use crate::devices::{DeviceName, OpenedInWorld, open_in_world_with};
use crate::failure::Failure;
use crate::results::print;
use crate::values::duration;
use crate::worlds::{self, wrong_world};

/// Runs one loop or two on the world of `file`, which is at `path`, and serves a page on them.
pub fn run(arguments: &LiveArguments, path: &Path, file: &WorldFile) -> Result<(), Failure> {
    let mut known = known_flags();
    known.retain(|flag| !["record", "fast", "json"].contains(flag));
    known.extend(["stall_after", "listen", "allow_host"]);
    worlds::only(&arguments.given, &known, path)?;
    let file = &worlds::guarded(&arguments.flags, file);
    let scene = &file.scene;
    let methods = worlds::methods(&arguments.flags, scene);
    let is_virtual = matches!(
        arguments.device.kind(),
        DeviceName::Pointer | DeviceName::Simulated
    );
    let most = if is_virtual { MOST_LANES } else { 1 };
    if methods.is_empty() || methods.len() > most {
        return Err(Failure::Arguments(format!(
            "--method: {} methods; allowed: one{}",
            methods.len(),
            if is_virtual {
                ", or two side by side"
            } else {
                ", since this device can be in one loop only"
            }
        )));
    }
    let methods: Vec<&'static str> = methods.into_iter().map(worlds::known).collect();
    for method in &methods {
        scene
            .renderer(method)
            .map_err(|faults| wrong_world(&arguments.flags, file, &faults))?;
    }
    let period = scene.timing.period;
    let listening = listen(arguments)?;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    let guarding = guarding(&arguments.safety, period)?;
    let lasts = (arguments.duration < f64::INFINITY)
        .then(|| duration("--duration", arguments.duration))
        .transpose()?;
    let hand = (arguments.device.kind() == DeviceName::Pointer)
        .then(|| scene.devices.first())
        .flatten()
        .map(|device| SpatialHand::at(device.position));
    let opener = {
        let (device, safety) = (arguments.device.clone(), arguments.safety.clone());
        let (file, hand, guarding) = (file.clone(), hand.clone(), guarding.clone());
        let methods = methods.clone();
        move |number: usize| -> Result<WorldLane, Failure> {
            let method = methods.get(number).copied().unwrap_or("coupled");
            let OpenedInWorld { device, frame, .. } =
                open_in_world_with(&device, &file.scene, &clock, &guarding, hand.as_ref())?;
            let limits = limits(device.capabilities(), &safety);
            let on = OnDevice {
                frame,
                capabilities: device.capabilities().clone(),
                limits,
            };
            let on = [on];
            if number == 0 {
                tell_of_axes(&file.scene, &on);
            }
            let world = rendered(&file, method, &on)
                .map_err(|faults| Failure::input(&faults[0]))?
                .map_err(Failure::input)?;
            Ok(WorldLane {
                device,
                world,
                limits,
            })
        }
    };
    // What is wrong with the first device is said at once, with its exit code.
    let mut first = Some(opener(0)?);
    let setup = WorldSetup {
        scene: scene.clone(),
        methods: methods.clone(),
        open: Box::new(move |number| match first.take().filter(|_| number == 0) {
            Some(opened) => Ok(opened),
            None => opener(number).map_err(|failure| failure.message()),
        }),
        hand,
        clock,
        request: request(&arguments.realtime),
        duration: lasts,
    };
    let end = serve(listening, Home::World, path, |stop| {
        Session::of_world(setup, stop)
    })?;
    let asked = Asked {
        duration: arguments.duration,
        device_may_end: false,
        lost: "the device was lost before the end",
    };
    let mut ended = Ok(());
    for lane in end.lanes {
        let guardian = guarding.report(arguments.device.is_guarded(), &lane.capabilities);
        add(
            &mut ended,
            report(&lane, (&scene.title, period), guardian, &asked),
        );
    }
    let failed = end
        .failed
        .map(|text| Failure::System(format!("no loop ran at the end: {text}")));
    add(&mut ended, failed.map_or(Ok(()), Err));
    ended
}

/// Says how a lane went.
fn report(
    lane: &WorldLaneEnd,
    (title, period): (&str, f64),
    guardian: Option<GuardianReport>,
    asked: &Asked,
) -> Result<(), Failure> {
    let books = lane.end.control.rendered().state().books();
    let subject = Subject {
        title,
        method: lane.method,
        period,
    };
    let report = RunReport::new(
        subject,
        &lane.capabilities,
        &lane.end,
        &lane.answers,
        &lane.account,
        None,
    )
    .with_energies(Energies::of_world(&lane.end, books))
    .guarded(guardian);
    print(&format!("\n{report}"))?;
    outcome::of(&lane.end, asked, None, None)
}

//! Loops on devices that hold lines.

use std::time::Duration;

use palpate_core::Hold;
use palpate_device::clock::SteppedClock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Line, Pose, ScriptedDevice, Step, Wrench,
};
use palpate_record::recording::{Row, Tick};
use palpate_rt::safety::{Rendered, Safety, SafetyParams, SafetyStop};
use palpate_rt::{
    BoundedWorld, ControlLoop, DeviceSample, DeviceSamples, RenderedWorld, Renders, SetupError,
    WorldFrame, changing_world,
};
use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{Delay, Scene};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::device::{SimulatedDevice, SpatialDevice};
use palpate_study::sim::world::WorldBench;
use palpate_world::Sample;

use crate::{at, scene, simulated, wide};

fn line_scene(name: &str) -> Scene {
    let mut scene = scene(name);
    scene.method = MethodName::Coupled;
    scene.loop_params.actuation.hold = Hold::Line;
    scene
}

/// Returns the larger end of the held line of a tick `[N]`.
fn larger_end(tick: &Tick, period: f64) -> f64 {
    tick.delivered_force[0].abs() + 0.5 * period * tick.delivered_slope[0].abs()
}

#[test]
fn it_is_the_loop_of_the_simulator_with_delays_too() {
    for name in ["fig2.toml", "experiment1.toml", "experiment2.toml"] {
        for delay in [0.0, 1.0, 0.4] {
            let mut scene = line_scene(name);
            if delay == 1.0 {
                scene.delay = Delay::samples(1);
            } else if delay > 0.0 {
                scene.delay = Delay::Seconds(delay * scene.loop_params.period);
            }
            let bench = Bench::new(&scene).unwrap();
            let expected = bench.run(MethodName::Coupled).unwrap();
            let (mut control, _) = simulated(&scene, MethodName::Coupled, wide());
            let scale = expected.force.peak_force;
            let (mut sloped, mut last) = (0, None);
            for expected in &expected.ticks {
                let Row { tick, contact, .. } = control.tick();
                let off = contact.force_on_object - expected.output.force_on_object;
                assert!(
                    off.abs() < 1e-6 * scale,
                    "{name} {delay}: {off} N at {} s",
                    expected.time
                );
                if delay == 0.0 {
                    let slope = tick.delivered_slope[0] - expected.output.slope_on_device;
                    assert!(slope.abs() * scene.loop_params.period < 1e-6 * scale);
                    sloped += u32::from(tick.delivered_slope[0] != 0.0);
                }
                last = Some((contact, expected.ledger));
            }
            let (contact, ledger) = last.unwrap();
            assert!((contact.port_work - ledger.port_work).abs() < 1e-6 * ledger.port_work.abs());
            assert!(delay > 0.0 || sloped > 10, "{sloped}");
        }
    }
}

#[test]
fn limits_of_the_safety_and_of_the_motor_bound_both_ends() {
    let period = scene("experiment2.toml").loop_params.period;
    let limited = |motor: Option<f64>, safety: f64| {
        let mut scene = line_scene("experiment2.toml");
        scene.device.point_mass_mut().unwrap().largest_force = motor;
        let limits = SafetyParams {
            largest_force: safety,
            ..wide()
        };
        let (mut control, _) = simulated(&scene, MethodName::Coupled, limits);
        let ticks = (0..60).map(|_| control.tick().tick);
        let ticks: Vec<Tick> = ticks.collect();
        let sloped = ticks.iter().filter(|tick| tick.delivered_slope[0] != 0.0);
        assert!(sloped.count() > 5);
        let ends = ticks.iter().map(|tick| larger_end(tick, period));
        ends.fold(0.0, f64::max)
    };
    let free = limited(None, 1e6);
    let by_motor = limited(Some(4.0), 1e6);
    let by_safety = limited(None, 4.0);
    println!(
        "largest end {free} N, limited by the motor {by_motor} N, by the safety {by_safety} N"
    );
    assert!(free > 5.0);
    for limited in [by_motor, by_safety] {
        assert!(limited <= 4.0 * (1.0 + 1e-12) && limited > 3.9);
    }
}

/// Mean and slope that a safety commands for each of many random lines.
#[test]
fn a_safety_bounds_length_and_rate_of_every_line() {
    const PERIOD: f64 = 0.001;
    let mut state = 1_u64;
    let mut random = |size: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        size * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    for (limit, slew) in [(3.0, f64::INFINITY), (3.0, 800.0), (1e3, 2000.0)] {
        let limits = SafetyParams {
            largest_force: limit,
            slew_limit: slew,
            soft_start: 0.02,
            largest_speed: f64::INFINITY,
            ..SafetyParams::default()
        };
        let mut safety = Safety::new(limits, PERIOD).unwrap();
        let (mut end, mut kept, mut cut) = ([0.0; 3], 0, 0);
        for number in 0..2000 {
            let huge = if number % 50 == 7 { 1e150 } else { 1.0 };
            let rendered = Rendered {
                elapsed: Some(PERIOD),
                position: [0.0; 3],
                coordinate: 0.0,
                wrench: [end[0] + random(1.0), end[1] + random(1.0), 0.0].into(),
                slope: [huge * random(1e3), huge * random(1e3), 0.0],
                created_energy: 0.0,
                refused: false,
                stalled: false,
            };
            let verdict = safety.evaluate(&rendered);
            let to = |half: f64| {
                let ends = verdict.wrench.force.iter().zip(verdict.slope);
                let mut ends = ends.map(|(force, slope)| force + half * PERIOD * slope);
                [(); 3].map(|()| ends.next().unwrap())
            };
            let length = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            let begin = to(-0.5);
            let jump = length([begin[0] - end[0], begin[1] - end[1], 0.0]);
            assert!(jump <= slew * PERIOD * (1.0 + 1e-9), "{jump} {verdict:?}");
            assert!(length(verdict.slope) <= slew * (1.0 + 1e-9), "{verdict:?}");
            end = to(0.5);
            assert!(
                length(begin).max(length(end)) <= limit * (1.0 + 1e-9),
                "{verdict:?}"
            );
            kept += u32::from(verdict.slope == rendered.slope);
            cut += u32::from(verdict.slope != rendered.slope && verdict.slope != [0.0; 3]);
        }
        println!("{limit} N, {slew} N/s: {kept} lines unchanged, {cut} gentler");
        assert!(kept > 20 && (cut > 20 || slew < 1e4), "{kept} {cut}");
    }
    let mut safety = Safety::new(wide(), PERIOD).unwrap();
    let verdict = safety.evaluate(&Rendered {
        elapsed: Some(PERIOD),
        position: [0.0; 3],
        coordinate: 0.0,
        wrench: Wrench::NONE,
        slope: [f64::NAN, 0.0, 0.0],
        created_energy: 0.0,
        refused: false,
        stalled: false,
    });
    assert_eq!(
        (verdict.slope, verdict.stopped),
        ([0.0; 3], Some(SafetyStop::NotANumber))
    );
}

/// A line ends with its period: a late loop finds the device as if the line's last value had been held from then on.
#[test]
fn a_missed_deadline_leaves_the_end_of_the_line() {
    let scene = line_scene("experiment1.toml");
    let period = scene.loop_params.period;
    let (mut control, clock) = simulated(&scene, MethodName::Coupled, wide());
    let mut before = control.tick();
    // The force rises in contact.
    while before.tick.delivered_slope[0].abs() * period < 0.3 {
        before = control.tick();
    }
    let (position, velocity) = {
        let device = control.device().device();
        (device.position(), device.velocity())
    };
    let late = 2.5 * period;
    clock.advance(Duration::from_secs_f64(late));
    let after = control.tick();
    let (mass, push) = (scene.device.mass(), scene.device.hand_force());
    let (mean, slope) = (
        before.tick.delivered_force[0],
        before.tick.delivered_slope[0],
    );
    let end = mean + 0.5 * period * slope;
    let speed = velocity + (push + mean) / mass * period;
    let place = position + (velocity + 0.5 * (push + mean) / mass * period) * period
        - slope * period.powi(3) / (12.0 * mass);
    let rest = late - period;
    let expected = place + (speed + 0.5 * (push + end) / mass * rest) * rest;
    let ran_on = 0.5 * slope * rest * rest * rest / (3.0 * mass);
    let found = after.tick.device_axes[0];
    println!("{found} m, expected {expected} m; a line that ran on would be off by {ran_on} m");
    assert!((found - expected).abs() < 1e-9 && ran_on.abs() > 1e-6);
    // The ledger has the work of the held force.
    let done = -(control.device().device().position() - position);
    let work = before.contact.port_work - after.contact.port_work;
    assert!(work.abs() > 0.0 && work.abs() < 2.0 * end.abs() * done.abs());
}

/// A scripted device that holds lines and remembers what was commanded.
struct Remembers {
    device: ScriptedDevice<SteppedClock>,
    capabilities: Capabilities,
    lines: Vec<Line>,
}

impl Device for Remembers {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.device.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.lines.push(wrench.into());
        self.device.write(wrench)
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        self.lines.push(line);
        Ok(line)
    }
}

fn pressed() -> Scene {
    let mut pressed = line_scene("wall.toml");
    pressed.contact.stiffness = 1000.0;
    pressed.object.position = 0.0;
    pressed.loop_params.period = 0.01;
    pressed.loop_params.largest_gap = None;
    pressed.virtual_force = 0.0;
    pressed
}

fn remembering(
    pressed: &Scene,
    script: Vec<Step>,
    holds_lines: bool,
) -> Result<ControlLoop<Remembers, SteppedClock>, SetupError> {
    let clock = SteppedClock::new();
    let device = Remembers {
        device: ScriptedDevice::new(clock.clone(), 1, script),
        capabilities: Capabilities {
            holds_lines,
            ..Capabilities::unknown("scripted", 1)
        },
        lines: Vec::new(),
    };
    let rendering = pressed.rendering(MethodName::Coupled).unwrap();
    ControlLoop::new(device, clock, rendering, wide())
}

#[test]
fn without_a_sample_the_end_of_the_line_is_held_for_a_period_then_nothing() {
    let mut script = vec![at(-2.0), at(-1.0), at(0.0), at(1.0), at(2.0)];
    script.extend([Step::Fails(DeviceErrorKind::NothingNew); 3]);
    let mut control = remembering(&pressed(), script, true).unwrap();
    let ticks: Vec<Tick> = (0..7).map(|_| control.tick().tick).collect();
    let lines = &control.device().lines;
    let last = lines[4];
    println!("{lines:?}");
    assert!(!last.is_constant() && last.duration == Duration::from_millis(10));
    assert!(last.wrench.force[0] < -0.5);
    assert_eq!(lines[5], Line::from(last.end()));
    assert_eq!(lines[6], Line::NONE);
    // The recorded lines are the held ones.
    for (tick, line) in ticks.iter().zip(lines) {
        assert_eq!(tick.delivered_force, line.wrench.force);
        assert_eq!(tick.delivered_slope, line.slope);
    }
}

/// After a second missing sample there is no force, and the ledger knows it: a device that moves then does no work.
#[test]
fn a_force_cut_without_a_sample_does_no_work_in_the_ledger() {
    let work_of = |hold: Hold| {
        let mut script = vec![at(-2.0), at(-1.0), at(0.0), at(1.0), at(2.0)];
        script.extend([Step::Fails(DeviceErrorKind::NothingNew); 20]);
        script.push(at(12.0));
        let mut pressed = pressed();
        pressed.loop_params.actuation.hold = hold;
        pressed.loop_params.largest_gap = Some(1.0);
        // Not the measured force but the sent one, when it acts, is in the ledger.
        pressed.loop_params.actuation.delay = 0.4 * pressed.loop_params.period;
        let mut control = remembering(&pressed, script, true).unwrap();
        let rows: Vec<Row> = (0..26).map(|_| control.tick()).collect();
        let force = rows[4].contact.force_on_object;
        let work = rows[25].contact.port_work - rows[4].contact.port_work;
        (force, work)
    };
    let [(force, line), (_, constant)] = [Hold::Line, Hold::Constant].map(work_of);
    println!("work of a line {line} J, of a constant {constant} J");
    // 10 mm under the force of the last line.
    let not_cut = 0.01 * force.abs();
    assert!(
        line.abs() < 0.2 * not_cut && constant.abs() < 0.2 * not_cut,
        "{not_cut} J"
    );
}

/// The same for a world: after the cut, the device moves without work.
#[test]
fn a_force_of_a_world_cut_without_a_sample_does_no_work_in_the_ledger() {
    let scene = line_world("groove-90-rough.toml", "");
    let work_after = |cut: bool| {
        let renderer = scene.renderer("coupled").unwrap();
        let frame = WorldFrame::the_same();
        let mut world = RenderedWorld::new(&scene.world, renderer, "coupled", frame).unwrap();
        let mut asked = [Line::NONE];
        let mut step = |world: &mut RenderedWorld, elapsed, height| {
            let position = [0.0, 0.0, height];
            let sample = DeviceSample {
                position,
                ..DeviceSample::default()
            };
            let samples = DeviceSamples {
                elapsed,
                was_off: false,
                devices: &[sample],
            };
            assert_eq!(world.step(&samples, &mut asked).fault, None);
            asked[0]
        };
        let mut force: f64 = 0.0;
        for sample in 0..5 {
            let height = 0.0002 - 0.0004 * f64::from(sample);
            let line = step(&mut world, (sample > 0).then_some(0.001), height);
            force = line.wrench.force[2];
            world.report_written(0, line, None);
        }
        if cut {
            // No sample, and no force any more.
            world.report_written(0, Line::NONE, None);
        }
        let work = world.state().ledger().devices[0].port_work;
        step(&mut world, Some(0.004), 0.0);
        let done = world.state().ledger().devices[0].port_work - work;
        (done, force)
    };
    let [(kept, force), (cut, _)] = [false, true].map(work_after);
    println!("kept {kept} J, cut {cut} J under {force} N");
    assert!(force > 1.0 && cut.abs() < 0.1 * kept.abs(), "{kept} {cut}");
}

#[test]
fn a_line_is_cut_at_once() {
    let clock = SteppedClock::new();
    let mut device = SimulatedDevice::new(&scene("wall.toml"), clock.clone()).unwrap();
    let mut still = device.clone();
    let mut zero = device.zero_writer().unwrap();
    let line = Line {
        wrench: Wrench::of_force([-3.0, 0.0, 0.0]),
        slope: [100.0, 0.0, 0.0],
        duration: Duration::from_millis(10),
    };
    device.read().unwrap();
    device.write_line(line).unwrap();
    clock.advance(Duration::from_millis(4));
    zero.write_zero();
    clock.advance(Duration::from_millis(6));
    let cut = device.read().unwrap().position[0];
    // From a device that holds the line for 4 ms, then nothing.
    let clock = SteppedClock::new();
    let mut expected = SimulatedDevice::new(&scene("wall.toml"), clock.clone()).unwrap();
    expected.read().unwrap();
    expected.write_line(line).unwrap();
    clock.advance(Duration::from_millis(4));
    expected.write(Wrench::NONE).unwrap();
    clock.advance(Duration::from_millis(6));
    let expected = expected.read().unwrap().position[0];
    assert_eq!(cut, expected);
    let still = still.read().unwrap().position[0];
    assert!((cut - still).abs() > 1e-9);
}

#[test]
fn a_device_that_holds_constants_is_refused_with_the_way_out() {
    let error = remembering(&pressed(), vec![at(0.0)], false).err().unwrap();
    assert_eq!(error, SetupError::HoldsConstant);
    let message = error.to_string();
    assert!(message.contains("this device holds constants") && message.contains("loop.hold"));
    assert!(remembering(&pressed(), vec![at(0.0)], true).is_ok());
}

/// Loads a scene of `experiments/worlds` whose devices hold lines, with more keys of its loop.
fn line_world(name: &str, timing: &str) -> WorldScene {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/worlds");
    #[allow(clippy::disallowed_methods, reason = "set-up")]
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let line = format!("period_s = 0.001\nhold = \"line\"\n{timing}");
    let text = text.replacen("period_s = 0.001\n", &line, 1);
    WorldFile::parse(name, &text).unwrap().scene
}

#[test]
fn lines_of_a_world_are_those_of_the_simulator_with_delays_too() {
    for name in ["pushed-block.toml", "groove-90-rough.toml"] {
        for timing in ["", "delay_samples = 1\n", "delay_s = 0.0004\n"] {
            let scene = line_world(name, timing);
            let renderer = scene.renderer("coupled").unwrap();
            let expected = WorldBench::new(&scene).unwrap();
            let expected = expected.run("coupled", &renderer).unwrap();
            let clock = SteppedClock::new();
            let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
            assert!(device.capabilities().holds_lines);
            let frame = WorldFrame::the_same();
            let world = RenderedWorld::new(&scene.world, renderer, "coupled", frame).unwrap();
            let mut control = ControlLoop::of_world(device, clock, world, wide()).unwrap();
            let (mut force, mut slope, mut steepest): (f64, f64, f64) = (0.0, 0.0, 0.0);
            for sample in 0..150 {
                let tick = control.tick().tick;
                let place = control.device().position();
                for (axis, at) in place.into_iter().enumerate() {
                    let moved = at - expected.positions[sample][0][axis];
                    assert!(moved.abs() < 1e-6, "{name} {timing}: {moved} m");
                    let more = tick.commanded_force[axis] - expected.commanded[sample][0][axis];
                    force = force.max(more.abs());
                    if timing.is_empty() {
                        let wanted = expected.commanded_slopes[sample][0][axis];
                        slope = slope.max((tick.delivered_slope[axis] - wanted).abs());
                        steepest = steepest.max(wanted.abs());
                    }
                }
            }
            println!("{name} {timing:?}: {force} N, {slope} N/s of {steepest} N/s");
            assert!(force < 1e-4 && slope <= 0.01 * steepest, "{force} {slope}");
            assert!(!timing.is_empty() || steepest > 10.0, "{steepest}");
        }
    }
}

#[test]
fn a_bounded_world_gives_the_slopes_of_the_renderer_within_the_limit() {
    let scene = line_world("groove-90-rough.toml", "");
    let renderer = scene.renderer("coupled").unwrap();
    let limited = |largest_force: f64| {
        let limits = SafetyParams {
            largest_force,
            soft_start: 0.0,
            ..wide()
        };
        let mut world = BoundedWorld::new(renderer.clone(), limits).unwrap();
        let mut state = renderer.start();
        let (mut steepest, mut longest): (f64, f64) = (0.0, 0.0);
        for tick in 0..60 {
            let position = [
                0.002 - 2e-5 * f64::from(tick),
                0.0,
                0.004 - 1e-4 * f64::from(tick),
            ];
            let sample = Sample::at(std::slice::from_ref(&position));
            let held = world.step(&sample);
            let ([wrench], [slope]) = (held.wrenches, held.slopes) else {
                panic!("one device");
            };
            if largest_force > 1e3 {
                let output = renderer.step(&mut state, &sample);
                assert_eq!((wrench.force, *slope), (output.forces[0], output.slopes[0]));
            }
            for side in [-0.0005, 0.0005] {
                let end = (0..3).map(|axis| wrench.force[axis] + side * slope[axis]);
                longest = longest.max(end.map(|x| x * x).sum::<f64>().sqrt());
            }
            steepest = slope.iter().fold(steepest, |most, x| most.max(x.abs()));
        }
        (steepest, longest)
    };
    let (steepest, longest) = limited(1e6);
    assert!(steepest > 100.0 && longest > 4.0, "{steepest} {longest}");
    let (steepest, longest) = limited(3.0);
    assert!(steepest > 100.0, "{steepest}");
    assert!(longest <= 3.0 + 1e-9, "{longest}");
}

/// Returns the largest end `[N]` and slope `[N/s]` of the lines that a world gives a tool, which moves in a groove while
/// the contacts change.
fn largest_end_of_a_change(
    scene: &WorldScene,
    mut step: impl FnMut(Change<'_>) -> Line,
) -> (f64, f64) {
    let (mut longest, mut steepest): (f64, f64) = (0.0, 0.0);
    for tick in 0..900 {
        if tick % 150 == 60 {
            let mut other = scene.clone();
            for contact in &mut other.world.contacts {
                contact.law.stiffness *= if tick % 300 == 60 { 0.3 } else { 1.0 };
            }
            step(Change::World(&other));
        }
        let sway = (0.4 * f64::from(tick)).sin();
        let line = step(Change::Place([2e-4 * sway, 0.0, -2e-4 + 4e-4 * sway]));
        for side in [-0.5e-3, 0.5e-3] {
            let end = (0..3).map(|axis| line.wrench.force[axis] + side * line.slope[axis]);
            longest = longest.max(end.map(|x| x * x).sum::<f64>().sqrt());
        }
        steepest = line
            .slope
            .iter()
            .fold(steepest, |most, x| most.max(x.abs()));
    }
    (longest, steepest)
}

/// What happens to a world: a sample of its tool `[m]`, or a change of its contacts.
enum Change<'a> {
    Place([f64; 3]),
    World(&'a WorldScene),
}

#[test]
fn the_ends_of_the_lines_of_a_change_are_within_the_limit_of_the_world() {
    let mut scene = line_world("groove-90-rough.toml", "");
    const LIMIT: f64 = 2.0;
    scene.render.force_limit = Some(LIMIT);
    let renderer = scene.renderer("coupled").unwrap();
    let limits = SafetyParams {
        soft_start: 0.0,
        ..wide()
    };
    let mut bounded = BoundedWorld::new(renderer.clone(), limits).unwrap();
    let of_bounded = largest_end_of_a_change(&scene, |change| match change {
        Change::World(other) => {
            bounded.change(&other.world).unwrap();
            Line::NONE
        }
        Change::Place(position) => {
            let held = bounded.step(&Sample::at(&[position]));
            Line {
                slope: held.slopes[0],
                ..held.wrenches[0].into()
            }
        }
    });
    let frame = WorldFrame::the_same();
    let rendered = |scene: &WorldScene| {
        let renderer = scene.renderer("coupled").unwrap();
        RenderedWorld::new(&scene.world, renderer, "coupled", frame).unwrap()
    };
    let (mut worlds, mut changing) = changing_world(scene.world.clone(), rendered(&scene));
    let mut asked = [Line::NONE];
    let of_changing = largest_end_of_a_change(&scene, |change| {
        match change {
            Change::World(other) => {
                let world = rendered(other);
                worlds.change(other.world.clone(), world).unwrap();
                changing.take_other_world();
            }
            Change::Place(position) => {
                let sample = DeviceSample {
                    position,
                    ..DeviceSample::default()
                };
                let samples = DeviceSamples {
                    elapsed: Some(0.001),
                    was_off: false,
                    devices: &[sample],
                };
                changing.step(&samples, &mut asked);
                changing.report_written(0, asked[0], None);
            }
        }
        asked[0]
    });
    for (longest, steepest) in [of_bounded, of_changing] {
        println!("ends of {longest} N, {steepest} N/s");
        assert!(steepest > 100.0, "{steepest}");
        assert!(longest <= LIMIT + 1e-9, "{longest}");
    }
}

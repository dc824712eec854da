//! Copies of a host's bodies in a loop with late ticks: their positions equal those of the host's bodies.

use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{LocalContact, LocalParams, LocalProgress, LocalRenderer};
use palpate_world::{ContactLaw, CoupledParams, Sample, Shape, Tool, Vector, WorldLoop};

use crate::late_ticks::TICKS;

const PERIOD: f64 = 0.002;
const UP: Vector = [0.0, 0.0, 1.0];
/// Number of samples between models.
const EVERY: usize = 20;

fn renderer(radius: f64, device: f64) -> LocalRenderer {
    let tool = Tool::new("tool", Shape::Sphere { radius });
    let params = CoupledParams::new(vec![[device; 3]]);
    let room = LocalParams::new(1, 2);
    LocalRenderer::new(&[tool], room, WorldLoop::new(PERIOD), params).unwrap()
}

/// Source of the host's step length.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Clock {
    /// Tick time, as reported by the loop.
    Ticks,
    /// The host's own clock.
    Own,
}

/// A body without contacts moves at 0.3 m/s. Returns the largest distances of its copy from it `[m]`, by tick time
/// and by elapsed time.
fn passing(durations: fn(usize) -> f64, clock: Clock) -> [f64; 2] {
    const SPEED: f64 = 0.3;
    let renderer = renderer(0.005, 0.2);
    let mut state = renderer.start();
    let at = |time: f64| {
        let mut body = BodyNow::fixed([SPEED * time, 0.0, 1.0]);
        body.velocity[0] = SPEED;
        for axis in 0..3 {
            body.mobility[axis][axis] = 10.0;
        }
        body
    };
    let model = renderer.model(0, &[at(0.0)], &[]).unwrap();
    let mut coming = Some(model);
    // Due time of the end of the last sample's period.
    let (mut ends, mut elapsed) = (0.0, PERIOD);
    let mut off = [0.0_f64; 2];
    for sample in 0..2000 {
        ends += elapsed;
        let positions = [[0.0; 3]];
        let now = Sample::at(&positions).after(elapsed);
        let output = renderer.step(&mut state, &now, coming.take().as_ref());
        assert_eq!((output.fault, output.refusal), (None, None));
        let progress = state.progress();
        let by_ticks = progress.time_since(&LocalProgress::default());
        let copy = progress.copies[0][0];
        off[0] = off[0].max((copy - SPEED * by_ticks).abs());
        off[1] = off[1].max((copy - SPEED * ends).abs());
        if sample % EVERY == EVERY - 1 {
            let time = if clock == Clock::Own { ends } else { by_ticks };
            coming = Some(renderer.model(progress.tick, &[at(time)], &[]).unwrap());
        }
        elapsed = PERIOD * durations(sample);
    }
    off
}

#[test]
fn a_copy_stands_where_the_host_s_body_stands_after_a_late_tick() {
    // Displacement in one period at 0.3 m/s: 0.6 mm.
    const WAY: f64 = 0.3 * PERIOD;
    for clock in [Clock::Ticks, Clock::Own] {
        for ticks in &TICKS {
            let [by_ticks, by_time] = passing(ticks.durations, clock);
            println!(
                "{clock:?}, {}: {:.4} mm by ticks, {:.4} mm by time",
                ticks.name,
                1e3 * by_ticks,
                1e3 * by_time
            );
            if clock == Clock::Ticks {
                assert!(by_ticks < 1e-9, "{}: {by_ticks} m", ticks.name);
            }
            assert!(by_time < 1.001 * WAY, "{}: {by_time} m", ticks.name);
        }
    }
}

/// A hand presses a ball on a floor of the host from above, with late ticks. Returns the mean forces on the device
/// and on the ball over the last second `[N]`, and the largest distance of the copy from its equilibrium between
/// floor and hand `[m]`.
fn pressed(durations: fn(usize) -> f64) -> [f64; 3] {
    const MASS: f64 = 0.1;
    const DEVICE: f64 = 0.25;
    const RADIUS: f64 = 0.02;
    const FLOOR: f64 = 3000.0;
    const TOOL: f64 = 0.01;
    let law = ContactLaw::spring(400.0).with_damping(1.0);
    let floor = ContactLaw::spring(FLOOR).with_damping(10.0);
    let renderer = renderer(TOOL, DEVICE);
    let mut state = renderer.start();
    let mut body = BodyNow::fixed([0.0, 0.0, RADIUS]);
    body.acceleration[2] = -9.81;
    for axis in 0..3 {
        body.mobility[axis][axis] = 1.0 / MASS;
    }
    let publish = |body: &BodyNow, tick: u64| {
        let [x, y, z] = body.position;
        let of_tool =
            LocalContact::of_tool(0, Some(0), [x, y, z + RADIUS], UP, law).curved(1.0 / RADIUS);
        let sphere = (0, body.position, RADIUS);
        let of_floor = LocalContact::of_body(sphere, None, [x, y, 0.0], UP, floor);
        renderer
            .model(tick, &[*body], &[Some(of_tool), Some(of_floor)])
            .unwrap()
    };
    let mut taken = state.progress().clone();
    let mut coming = Some(publish(&body, 0));
    // The hand pulls the device with 2 N.
    let (mut position, mut velocity) = (2.0 * RADIUS + TOOL, 0.0);
    let (mut elapsed, mut time, mut sample) = (PERIOD, 0.0, 0);
    let [mut on_device, mut times, mut off] = [0.0, 0.0, 0.0_f64];
    let mut since: Option<LocalProgress> = None;
    while time < 6.0 {
        let positions = [[0.0, 0.0, position]];
        let now = Sample::at(&positions).after(elapsed);
        let output = renderer.step(&mut state, &now, coming.take().as_ref());
        assert_eq!((output.fault, output.refusal), (None, None));
        let force = output.forces[0][2];
        let progress = state.progress();
        elapsed = PERIOD * durations(sample);
        for _ in 0..50 {
            let h = elapsed / 50.0;
            velocity += h * (force - 2.0 - 8.0 * velocity) / DEVICE;
            position += h * velocity;
        }
        if sample % EVERY == EVERY - 1 {
            let step = progress.time_since(&taken);
            let pushed = progress.wrench_since(&taken, 0).force[2];
            for _ in 0..400 {
                let h = step / 400.0;
                let depth = (RADIUS - body.position[2]).max(0.0);
                let from_floor = (FLOOR * depth - 10.0 * body.velocity[2]).max(0.0);
                let push = if depth > 0.0 { from_floor } else { 0.0 };
                body.velocity[2] += h * (-9.81 + (pushed + push) / MASS);
                body.position[2] += h * body.velocity[2];
            }
            taken = progress.clone();
            coming = Some(publish(&body, taken.tick));
        }
        if time > 5.0 {
            since.get_or_insert_with(|| progress.clone());
            on_device += force * elapsed;
            times += elapsed;
            let depth = (2.0 + MASS * 9.81) / FLOOR;
            off = off.max((progress.copies[0][2] - (RADIUS - depth)).abs());
        }
        time += elapsed;
        sample += 1;
    }
    let impulses = [&since.unwrap(), state.progress()].map(|it| it.impulses[0].linear[2]);
    [on_device / times, (impulses[1] - impulses[0]) / times, off]
}

#[test]
fn ball_and_device_get_the_same_impulse_and_the_ball_stays_where_the_floor_holds_it() {
    for ticks in &TICKS {
        let [device, ball, off] = pressed(ticks.durations);
        println!("{}: {device} N, {ball} N, {off} m", ticks.name);
        assert!((device - 2.0).abs() < 0.02, "{}: {device} N", ticks.name);
        assert!((ball + 2.0).abs() < 0.02, "{}: {ball} N", ticks.name);
        assert!(off < 3e-6, "{}: {off} m", ticks.name);
    }
}
